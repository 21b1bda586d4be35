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
        key="fixturing-part",
        name=wording("unstable fixturing of the part"),
        signs=(
            Sign(ErrorKind.LENGTH, BOTH, (Over.SCATTER, Over.STEP)),
            Sign(ErrorKind.SHAFT_TAPER, BOTH, (Over.SCATTER, Over.STEP), alike=True),
        ),
        prior=0.02,
        remedy=wording("Clamp the part anew by hand and repeat readings of one point until they agree."),
        section="4.1",
        decided_by=wording(
            "Probe a point of the part ten times right after clamping: spread, drift or a step mean that it moves."
        ),
    ),
    Cause(
        key="fixturing-tool-probe",
        name=wording("unstable fixturing of the tool probe"),
        signs=(Sign(ErrorKind.RADIUS, BOTH, (Over.SETTING,), alike=True),),
        prior=0.02,
        remedy=wording("Fix the tool probe by hand, then set all tools anew."),
        section="4.1",
        decided_by=wording("Set one tool ten times: spread, drift or a step mean that the tool probe moves."),
    ),
    Cause(
        key="fixturing-part-probe",
        name=wording("unstable fixturing of the part probe"),
        signs=(Sign(ErrorKind.RADIUS, PROBE, (Over.SCATTER, Over.STEP), alike=True),),
        prior=0.05,
        remedy=wording("Fix the part probe by hand, calibrate it anew and probe the last part again."),
        section="4.1",
        decided_by=wording("Probe one point ten times right after the probe is fixed, on a part or on the spindle."),
        on_standard_part=True,
    ),
    Cause(
        key="tool-seat",
        name=wording("tool loose in its seat"),
        signs=(
            Sign(ErrorKind.RADIUS, BOTH, (Over.SCATTER, Over.STEP), alike=True),
            Sign(ErrorKind.LENGTH, BOTH, (Over.SCATTER, Over.STEP), alike=True, needed=False),
        ),
        prior=0.04,
        remedy=wording("Clamp the tool by hand, then set it anew."),
        section="4.1",
        decided_by=wording(
            "Set the tool ten times, indexing the turret between: spread or a step mean that it is loose."
        ),
        of_tool=True,
    ),
)

OFFSETS: Final = (
    Cause(
        key="tool-setting",
        name=wording("tool offset set wrongly"),
        signs=(Sign(ErrorKind.RADIUS, BOTH, (Over.CONSTANT, Over.SETTING), alike=True),),
        prior=0.15,
        remedy=wording("Correct the x offset of the tool in the control by a weighted share of the radius error."),
        section="3.1, 4.2",
        decided_by=wording("Set the tool anew and cut one more part: what changes with the setting is the setting's."),
        of_tool=True,
    ),
    Cause(
        key="tool-wear",
        name=wording("tool wear"),
        signs=(
            Sign(ErrorKind.RADIUS, BOTH, (Over.WEAR,), alike=True),
            Sign(ErrorKind.LENGTH, BOTH, (Over.WEAR,), needed=False),
        ),
        prior=0.12,
        remedy=wording("Correct the tool offset by what wear adds a minute in cut, and change the edge in time."),
        section="4.2",
        decided_by=wording("Change the edge and cut one more part: wear begins again at nothing."),
        of_tool=True,
    ),
    Cause(
        key="nose-form",
        name=wording("form of the tool's nose"),
        signs=(Sign(ErrorKind.RADIUS, BOTH, (Over.CONSTANT,)),),
        prior=0.08,
        remedy=wording("Correct the contour by the error of the nose, or change the insert."),
        section="2.5",
        decided_by=wording("Change the insert and cut one more part: what follows the contact angle is another form."),
        of_tool=True,
    ),
    Cause(
        key="part-probe-offset",
        name=wording("offset of the part probe"),
        signs=(Sign(ErrorKind.RADIUS, PROBE, (Over.CONSTANT,), alike=True),),
        prior=0.10,
        remedy=wording("Correct the probe's offset, but only from a standard part under standard conditions."),
        section="4.2",
        decided_by=wording(
            "Probe a standard part under standard conditions: there no tool and no cut is in the reading."
        ),
        on_standard_part=True,
    ),
)

LENGTHS: Final = (
    Cause(
        key="unequal-depth",
        name=wording("unequal depths of cut"),
        signs=(Sign(ErrorKind.LENGTH, BOTH, (Over.DEPTH,)), Sign(ErrorKind.RADIUS, BOTH, (Over.DEPTH,), needed=False)),
        prior=0.08,
        remedy=wording("Make the depths of semi-finish and finish cut equal on all features."),
        section="4.2",
        decided_by=wording(
            "Cut one part with equal depths on both faces: the error of the length is gone if it was these."
        ),
    ),
    Cause(
        key="two-tools",
        name=wording("inconsistent z offsets of two tools"),
        signs=(Sign(ErrorKind.LENGTH, BOTH, (Over.CONSTANT, Over.SETTING), alike=True),),
        prior=0.10,
        remedy=wording("Correct the z offset of the tool that is used less."),
        section="4.2",
        decided_by=wording("Set both tools on one reference, or cut both faces of one part with one tool."),
        of_tool=True,
    ),
    Cause(
        key="wear-between",
        name=wording("tool wear between two passes"),
        signs=(
            Sign(ErrorKind.LENGTH, BOTH, (Over.CONSTANT, Over.WEAR), alike=True),
            Sign(ErrorKind.RADIUS, BOTH, (Over.CONSTANT, Over.WEAR), alike=True),
        ),
        prior=0.04,
        remedy=wording("Inspect the tool by hand: it may be dull; change the edge before the finish cuts."),
        section="4.2",
        decided_by=wording(
            "Cut the faces of one part in the opposite order: wear between the passes changes its sign."
        ),
    ),
)

DEFLECTION: Final = (
    Cause(
        key="part-deflection",
        name=wording("deflection of the part"),
        signs=(
            Sign(ErrorKind.SHAFT_TAPER, BOTH, (Over.DEPTH,), alike=True),
            Sign(ErrorKind.RADIUS, BOTH, (Over.DEPTH,), alike=True),
            Sign(ErrorKind.STRAIGHTNESS, BOTH, (Over.DEPTH,), needed=False),
        ),
        prior=0.10,
        remedy=wording("Change the slope of the tool path by the taper, reduce the depth of cut, or support the part."),
        section="4.2",
        decided_by=wording("Cut one part with half the depth: a taper by deflection halves too."),
    ),
    Cause(
        key="tailstock",
        name=wording("alignment of the tailstock"),
        signs=(Sign(ErrorKind.SHAFT_TAPER, BOTH, (Over.CONSTANT,), alike=True),),
        prior=0.06,
        remedy=wording("True the tailstock, or change the slope of the tool path by the taper."),
        section="-",
        decided_by=wording("Cut one part without the tailstock, or true it: a taper by the tailstock is gone."),
    ),
    Cause(
        key="tool-deflection",
        name=wording("deflection of the tool on a face"),
        signs=(
            Sign(ErrorKind.FACE_TAPER, BOTH, (Over.DEPTH,)),
            Sign(ErrorKind.LENGTH, BOTH, (Over.DEPTH,), needed=False),
        ),
        prior=0.07,
        remedy=wording("Correct the path of the face, or reduce the depth of cut."),
        section="4.2",
        decided_by=wording(
            "Cut one face with half the depth: a taper by deflection halves too, one by speed does not."
        ),
    ),
    Cause(
        key="constant-speed",
        name=wording("constant spindle speed over a large range of radii"),
        signs=(
            Sign(ErrorKind.FACE_TAPER, BOTH, (Over.CONSTANT,)),
            Sign(ErrorKind.LENGTH, BOTH, (Over.CONSTANT,), needed=False),
        ),
        prior=0.06,
        remedy=wording("Cut the face with constant cutting speed (G96); until then correct its path."),
        section="4.2",
        decided_by=wording("Cut one face with constant cutting speed: a taper by speed is gone."),
    ),
)

FORM: Final = (
    Cause(
        key="chatter",
        name=wording("chatter"),
        signs=(
            Sign(ErrorKind.WAVINESS, BOTH, (Over.SCATTER,)),
            Sign(ErrorKind.RADIUS, BOTH, (Over.SCATTER,), needed=False),
            Sign(ErrorKind.SHAFT_TAPER, BOTH, (Over.SCATTER,), needed=False),
            Sign(ErrorKind.STRAIGHTNESS, BOTH, (Over.SCATTER,), needed=False),
            Sign(ErrorKind.ECCENTRICITY, BOTH, (Over.SCATTER,), needed=False),
            Sign(ErrorKind.LOBING, BOTH, (Over.SCATTER,), needed=False),
        ),
        prior=0.08,
        remedy=wording("Change spindle speed, feed or overhang, and watch the tool's vibration while it cuts."),
        section="4.2",
        decided_by=wording(
            "Cut one part with a spindle speed changed by a tenth: marks of chatter change their distance."
        ),
    ),
    Cause(
        key="chuck",
        name=wording("eccentric chuck: one wave a turn"),
        signs=(Sign(ErrorKind.ECCENTRICITY, BOTH, (Over.CONSTANT, Over.SCATTER), alike=True),),
        prior=0.05,
        remedy=wording("Clean the chuck, true the jaws, and cut everything of a part in one clamping."),
        section="-",
        decided_by=wording("Clamp a ground bar and probe it around: one wave a turn is the chuck's."),
    ),
    Cause(
        key="jaws",
        name=wording("clamping force of three jaws: three waves a turn"),
        signs=(
            Sign(ErrorKind.LOBING, OUTSIDE, (Over.CONSTANT, Over.SCATTER)),
            Sign(ErrorKind.SHAFT_TAPER, OUTSIDE, (Over.CONSTANT,), needed=False),
            Sign(ErrorKind.STRAIGHTNESS, OUTSIDE, (Over.CONSTANT,), needed=False),
        ),
        prior=0.05,
        remedy=wording("Clamp with less force for the finish cut, with soft jaws, or with more of them."),
        section="-",
        decided_by=wording("Probe one ring before and after the jaws have let go: what springs back is theirs."),
    ),
    Cause(
        key="servo-lag",
        name=wording("servo lag at edges"),
        signs=(Sign(ErrorKind.EDGE, (), (Over.CONSTANT,)),),
        prior=0.0,
        remedy=wording("No correction here: an edge is rounded by tenths of a millimetre, which no touch probe sees."),
        section="4.2",
        decided_by=wording(
            "Trace the edge with a stylus instrument: a touch probe would need readings too close to each other."
        ),
    ),
)

MACHINE: Final = Cause(
    key="machine",
    name=wording("the machine's error, geometric or thermal"),
    signs=(
        Sign(ErrorKind.RADIUS, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE), alike=True),
        Sign(ErrorKind.RADIUS, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE)),
        Sign(ErrorKind.LENGTH, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE)),
        Sign(ErrorKind.SHAFT_TAPER, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE)),
        Sign(ErrorKind.FACE_TAPER, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE)),
        Sign(ErrorKind.STRAIGHTNESS, OUTSIDE, (Over.CONSTANT, Over.TEMPERATURE), needed=False),
    ),
    prior=0.12,
    remedy=wording(
        "Fit a model of the machine, or refine the one in use: correcting path or offsets would only mend parts of "
        "this type."
    ),
    section="3.3, 3.4, 4.2",
    decided_by=wording("Measure parts cut with tools of other lengths and at other temperatures on a CMM."),
)

OTHER: Final = Cause(
    key="other",
    name=wording("something that is not in the catalogue"),
    signs=tuple(
        Sign(kind, seen_by, (Over.CONSTANT, Over.SCATTER), needed=False)
        for seen_by in (BOTH, PROBE, OUTSIDE)
        for kind in (ErrorKind.RADIUS, ErrorKind.LENGTH, ErrorKind.SHAFT_TAPER, ErrorKind.FACE_TAPER)
    ),
    prior=0.10,
    remedy=wording("Look at the errors of the features that it acts on: no cause of the catalogue leaves them so."),
    section="-",
    decided_by=wording(
        "Inspect one more part at more places of these features, on the machine and on a measuring machine."
    ),
)

CAUSES: Final[tuple[Cause, ...]] = (*FIXTURING, *OFFSETS, *LENGTHS, *DEFLECTION, *FORM, MACHINE, OTHER)
