"""All causes of wrong features that are known, as data: process, fixture, probe, machine [4773 §4.1, §4.2, Fig. 11].

Roundness is not in the source: chuck and jaws are our own. So are the priors, which say how common a cause is beside
the others, and the loose tool, of which §4.1 says no more than that fixturing can be unstable.
"""

from typing import Final

from trueloop.diagnosis.causes.cause import Cause, Over, SeenBy, Sign
from trueloop.diagnosis.features.feature_error import ErrorKind
from trueloop.wording import wording

BOTH: Final = (SeenBy.MACHINE, SeenBy.CMM)
PROBE: Final = (SeenBy.MACHINE,)
OUTSIDE: Final = (SeenBy.CMM,)
"""Only a measuring machine or a gauge: the machine's own probing repeats the machine's error."""

FIXTURING: Final = (
    Cause(
        "fixturing-part",
        wording("unstable fixturing of the part"),
        (
            Sign(ErrorKind.LENGTH, BOTH, (Over.SCATTER, Over.STEP)),
            Sign(ErrorKind.SHAFT_TAPER, BOTH, (Over.SCATTER, Over.STEP), alike=True),
        ),
        0.02,
        wording("Clamp the part anew by hand and repeat readings of one point until they agree."),
        "4.1",
        wording(
            "Probe a point of the part ten times right after clamping: spread, drift or a step mean that it moves."
        ),
    ),
    Cause(
        "fixturing-tool-probe",
        wording("unstable fixturing of the tool probe"),
        (Sign(ErrorKind.RADIUS, BOTH, (Over.SETTING,), alike=True),),
        0.02,
        wording("Fix the tool probe by hand, then set all tools anew."),
        "4.1",
        wording("Set one tool ten times: spread, drift or a step say that the tool probe moves."),
    ),
    Cause(
        "fixturing-part-probe",
        wording("unstable fixturing of the part probe"),
        (Sign(ErrorKind.RADIUS, PROBE, (Over.SCATTER, Over.STEP), alike=True),),
        0.05,
        wording("Fix the part probe by hand, calibrate it anew and probe the last part again."),
        "4.1",
        wording("Probe one point ten times right after the probe is fixed, on a part or on the spindle."),
        on_standard_part=True,
    ),
    Cause(
        "tool-seat",
        wording("tool loose in its seat"),
        (
            Sign(ErrorKind.RADIUS, BOTH, (Over.SCATTER, Over.STEP), alike=True),
            Sign(ErrorKind.LENGTH, BOTH, (Over.SCATTER, Over.STEP), alike=True, needed=False),
        ),
        0.04,
        wording("Clamp the tool by hand, then set it anew."),
        "4.1",
        wording("Set the tool ten times, indexing the turret between: spread or a step say that it is loose."),
        of_tool=True,
    ),
)

OFFSETS: Final = (
    Cause(
        "tool-setting",
        wording("tool offset set wrongly"),
        (Sign(ErrorKind.RADIUS, BOTH, (Over.CONSTANT, Over.SETTING), alike=True),),
        0.15,
        wording("Correct the x offset of the tool in the control by a weighted share of the radius error."),
        "3.1, 4.2",
        wording("Set the tool anew and cut one more part: what changes with the setting is the setting's."),
        of_tool=True,
    ),
    Cause(
        "tool-wear",
        wording("tool wear"),
        (
            Sign(ErrorKind.RADIUS, BOTH, (Over.WEAR,), alike=True),
            Sign(ErrorKind.LENGTH, BOTH, (Over.WEAR,), needed=False),
        ),
        0.12,
        wording("Correct the tool offset by what wear adds a minute in cut, and change the edge in time."),
        "4.2",
        wording("Change the edge and cut one more part: wear begins again at nothing."),
        of_tool=True,
    ),
    Cause(
        "nose-form",
        wording("form of the tool's nose"),
        (Sign(ErrorKind.RADIUS, BOTH, (Over.CONSTANT,)),),
        0.08,
        wording("Correct the contour by the error of the nose, or change the insert."),
        "2.5",
        wording("Change the insert and cut one more part: what follows the contact angle is another form."),
        of_tool=True,
    ),
    Cause(
        "part-probe-offset",
        wording("offset of the part probe"),
        (Sign(ErrorKind.RADIUS, PROBE, (Over.CONSTANT,), alike=True),),
        0.10,
        wording("Correct the probe's offset, but only from a standard part under standard conditions."),
        "4.2",
        wording("Probe a standard part under standard conditions: there no tool and no cut is in the reading."),
        on_standard_part=True,
    ),
)

LENGTHS: Final = (
    Cause(
        "unequal-depth",
        wording("unequal depths of cut"),
        (Sign(ErrorKind.LENGTH, BOTH, (Over.DEPTH,)), Sign(ErrorKind.RADIUS, BOTH, (Over.DEPTH,), needed=False)),
        0.08,
        wording("Make the depths of semi-finish and finish cut equal on all features."),
        "4.2",
        wording("Cut one part with equal depths on both faces: the error of the length is gone if it was these."),
    ),
    Cause(
        "two-tools",
        wording("inconsistent z offsets of two tools"),
        (Sign(ErrorKind.LENGTH, BOTH, (Over.CONSTANT, Over.SETTING), alike=True),),
        0.10,
        wording("Correct the z offset of the tool that is used less."),
        "4.2",
        wording("Set both tools on one reference, or cut both faces of one part with one tool."),
        of_tool=True,
    ),
    Cause(
        "wear-between",
        wording("tool wear between two passes"),
        (
            Sign(ErrorKind.LENGTH, BOTH, (Over.CONSTANT, Over.WEAR), alike=True),
            Sign(ErrorKind.RADIUS, BOTH, (Over.CONSTANT, Over.WEAR), alike=True),
        ),
        0.04,
        wording("Inspect the tool by hand: it may be dull; change the edge before the finish cuts."),
        "4.2",
        wording("Cut the faces of one part in the opposite order: wear between the passes changes its sign."),
    ),
)

DEFLECTION: Final = (
    Cause(
        "part-deflection",
        wording("deflection of the part"),
        (
            Sign(ErrorKind.SHAFT_TAPER, BOTH, (Over.DEPTH,), alike=True),
            Sign(ErrorKind.RADIUS, BOTH, (Over.DEPTH,), alike=True),
            Sign(ErrorKind.STRAIGHTNESS, BOTH, (Over.DEPTH,), needed=False),
        ),
        0.10,
        wording("Change the slope of the tool path by the taper, reduce the depth of cut, or support the part."),
        "4.2",
        wording("Cut one part with half the depth: a taper by deflection halves too."),
    ),
    Cause(
        "tailstock",
        wording("alignment of the tailstock"),
        (Sign(ErrorKind.SHAFT_TAPER, BOTH, (Over.CONSTANT,), alike=True),),
        0.06,
        wording("True the tailstock, or change the slope of the tool path by the taper."),
        "-",
        wording("Cut one part without the tailstock, or true it: a taper by the tailstock is gone."),
    ),
    Cause(
        "tool-deflection",
        wording("deflection of the tool on a face"),
        (Sign(ErrorKind.FACE_TAPER, BOTH, (Over.DEPTH,)), Sign(ErrorKind.LENGTH, BOTH, (Over.DEPTH,), needed=False)),
        0.07,
        wording("Correct the path of the face, or reduce the depth of cut."),
        "4.2",
        wording("Cut one face with half the depth: a taper by deflection halves too, one by speed does not."),
    ),
    Cause(
        "constant-speed",
        wording("constant spindle speed over a large range of radii"),
        (
            Sign(ErrorKind.FACE_TAPER, BOTH, (Over.CONSTANT,)),
            Sign(ErrorKind.LENGTH, BOTH, (Over.CONSTANT,), needed=False),
        ),
        0.06,
        wording("Cut the face with constant cutting speed (G96); until then correct its path."),
        "4.2",
        wording("Cut one face with constant cutting speed: a taper by speed is gone."),
    ),
)

FORM: Final = (
    Cause(
        "chatter",
        wording("chatter"),
        (
            Sign(ErrorKind.WAVINESS, BOTH, (Over.SCATTER,)),
            Sign(ErrorKind.RADIUS, BOTH, (Over.SCATTER,), needed=False),
            Sign(ErrorKind.SHAFT_TAPER, BOTH, (Over.SCATTER,), needed=False),
            Sign(ErrorKind.STRAIGHTNESS, BOTH, (Over.SCATTER,), needed=False),
            Sign(ErrorKind.ECCENTRICITY, BOTH, (Over.SCATTER,), needed=False),
            Sign(ErrorKind.LOBING, BOTH, (Over.SCATTER,), needed=False),
        ),
        0.08,
        wording("Change spindle speed, feed or overhang, and watch the tool's vibration while it cuts."),
        "4.2",
        wording("Cut one part with a spindle speed changed by a tenth: marks of chatter change their distance."),
    ),
    Cause(
        "chuck",
        wording("eccentric chuck: one wave a turn"),
        (Sign(ErrorKind.ECCENTRICITY, BOTH, (Over.CONSTANT, Over.SCATTER), alike=True),),
        0.05,
        wording("Clean the chuck, true the jaws, and cut everything of a part in one clamping."),
        "-",
        wording("Clamp a ground bar and probe it around: one wave a turn is the chuck's."),
    ),
    Cause(
        "jaws",
        wording("clamping force of three jaws: three waves a turn"),
        (
            Sign(ErrorKind.LOBING, OUTSIDE, (Over.CONSTANT, Over.SCATTER)),
            Sign(ErrorKind.SHAFT_TAPER, OUTSIDE, (Over.CONSTANT,), needed=False),
            Sign(ErrorKind.STRAIGHTNESS, OUTSIDE, (Over.CONSTANT,), needed=False),
        ),
        0.05,
        wording("Clamp with less force for the finish cut, with soft jaws, or with more of them."),
        "-",
        wording("Probe one ring before and after the jaws have let go: what springs back is theirs."),
    ),
    Cause(
        "servo-lag",
        wording("servo lag at edges"),
        (Sign(ErrorKind.EDGE, (), (Over.CONSTANT,)),),
        0.0,
        wording("No correction here: an edge is rounded by tenths of a millimetre, which no touch probe sees."),
        "4.2",
        wording("Trace the edge with a stylus instrument: a touch probe would need readings too close to each other."),
    ),
)

MACHINE: Final = Cause(
    "machine",
    wording("the machine's error that its model left"),
    (
        Sign(ErrorKind.RADIUS, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE), alike=True),
        Sign(ErrorKind.RADIUS, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE)),
        Sign(ErrorKind.LENGTH, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE)),
        Sign(ErrorKind.SHAFT_TAPER, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE)),
        Sign(ErrorKind.FACE_TAPER, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE)),
        Sign(ErrorKind.STRAIGHTNESS, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE), needed=False),
    ),
    0.12,
    wording("Refine the model of the machine; correcting path or offsets would only mend parts of this type."),
    "3.3, 3.4, 4.2",
    wording("Measure parts cut with tools of other lengths and at other temperatures on a CMM."),
)

OTHER: Final = Cause(
    "other",
    wording("something that is not in the catalogue"),
    tuple(
        Sign(kind, seen_by, (Over.CONSTANT, Over.SCATTER), needed=False)
        for seen_by in (BOTH, PROBE, OUTSIDE)
        for kind in (ErrorKind.RADIUS, ErrorKind.LENGTH, ErrorKind.SHAFT_TAPER, ErrorKind.FACE_TAPER)
    ),
    0.10,
    wording("Look at the errors of the features that it acts on: no cause of the catalogue leaves them so."),
    "-",
    wording("Inspect one more part at more places of these features, on the machine and on a measuring machine."),
)

CAUSES: Final[tuple[Cause, ...]] = (*FIXTURING, *OFFSETS, *LENGTHS, *DEFLECTION, *FORM, MACHINE, OTHER)
