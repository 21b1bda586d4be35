"""The shapes of a correction as JSON: `docs/correction.schema.json` is written from them.

Errors are positive where material is left on, in µm along the outward normal; lengths mm, x a radius; standard
uncertainties are one standard deviation, expanded ones hold 95 %.
"""

from typing import Literal

from trueloop.report.shape import Shape
from trueloop.report.turned.summary import Header


class JudgementShape(Shape):
    """One value of a characteristic held against its limits, in the characteristic's unit."""

    value: float
    """The value."""
    standard_u: float
    """Its standard uncertainty."""
    degrees_of_freedom: int | None
    """Of that; null: as good as infinite."""
    probability_in: float | None
    """Probability of being inside the limits; null: no limit."""
    margin: float | None
    """Distance to the nearer limit, negative outside; null: no limit."""
    verdict: Literal["in", "out", "undecided"] | None
    """By ISO 14253-1; null: no limit."""


class CharacteristicShape(Shape):
    """One size that the drawing asks for, judged."""

    name: str
    """Its name in the job."""
    quantity: str
    """diameter, radius, length, angle, runout, position, form or other."""
    feature: str
    """The feature it is of."""
    nominal: float
    """A diameter is a diameter."""
    lower_limit: float | None
    """Smallest size; null: no limit."""
    upper_limit: float | None
    """Largest size; null: no limit."""
    other: str
    """The feature from which a length counts; empty: from z = 0."""
    at_z_mm: float | None
    """Where along the feature it holds; null: everywhere."""
    tolerance: str
    """As the drawing says it."""
    unit: Literal["mm", "deg"]
    """Of all its values."""
    before: JudgementShape | None
    """As measured; null: the part was measured before its finish cut."""
    after: JudgementShape
    """As expected of the next cut."""


class SourceShape(Shape):
    """The share of one source in the error that a feature of the next cut would have, had nothing been corrected."""

    source: Literal["machine", "tool setting", "nose", "part", "next cut", "measuring"]
    """Measuring: by how much the feature's measured mean is off its error as all measurements show it."""
    mean_um: float
    """Mean over its measured places, or over the feature where there are none."""
    expanded_u_um: float
    """Of the mean."""
    low_um: float
    """The least along the feature."""
    high_um: float
    """The largest along it."""


class FeatureShape(Shape):
    """One feature: errors at its touches before and as predicted, and what to expect of it."""

    feature: str
    """Its name."""
    touches: int
    """How many."""
    correction: str
    """How it is corrected, in words."""
    before_rms_um: float | None
    """Measured errors, root mean square."""
    before_worst_um: float | None
    """The one of largest size."""
    predicted_rms_um: float | None
    """Predicted errors, root mean square."""
    predicted_worst_um: float | None
    """The one of largest size; of a feature without a touch, along it."""
    predicted_expanded_u_um: float | None
    """The largest expanded uncertainty."""
    left_out_rms_um: float | None
    """Each touch predicted from all others, root mean square."""
    expected: str
    """The prediction, in words."""
    standard_u_um: dict[str, float]
    """The uncertainty's components, by cause."""
    sources: list[SourceShape]
    """Where its error comes from."""


class TouchShape(Shape):
    """One touch: measured, fitted, predicted."""

    feature: str
    """The feature it is on."""
    point: str
    """Its name."""
    nominal_x_mm: float
    """Nominal point, a radius."""
    nominal_z_mm: float
    """Nominal point."""
    arc_length_mm: float
    """Along the feature from its chuck end."""
    error_before_um: float
    """Measured."""
    commanded_um: float
    """Share of it that the semi-finish program commanded."""
    gauging_standard_u_um: float
    """Standard uncertainty of gauging."""
    fitted_um: float
    """The error curve there."""
    predicted_after_um: float
    """Predicted after the corrected cut."""
    leave_one_out_um: float | None
    """Predicted after the corrected cut, with the touch left out of the fit."""
    predicted_standard_u_um: float
    """Standard uncertainty of the prediction."""
    weight: float
    """In the fit, 0 or 1."""
    probability_bad: float | None
    """Of a touch that others contradict."""


class LeftShape(Shape):
    """Error that the tool offset alone would leave at a feature's touches."""

    feature: str
    """Its name."""
    rms_um: float
    """Root mean square."""
    worst_um: float
    """The error of largest size."""


class OffsetShape(Shape):
    """The tool offset as numbers to enter at the control."""

    tool: int
    """Number of the offset."""
    x: float
    """To be added, in `unit`."""
    x_is: Literal["radius", "diameter"]
    """How the control counts it."""
    z: float
    """To be added, in `unit`."""
    unit: str
    """mm or inch."""
    x_expanded_u: float | None
    """Expanded uncertainty of `x` (95 %), in `unit`; null: what was measured does not determine it."""
    z_expanded_u: float | None
    """That of `z`."""
    words: str
    """The offset in words."""
    blocks: list[str]
    """Blocks that add it, in the control's words."""
    leaves: list[LeftShape]
    """The errors that it would leave."""


class ToolShape(Shape):
    """The offset of one tool."""

    tool: int
    """Number of its offset."""
    answer: Literal["offset", "none", "not measured"]
    """An offset, none, or its cut was not measured."""


class BeyondShape(Shape):
    """The most that the contour would take out beyond the offset."""

    um: float
    """Signed as a correction."""
    feature: str
    """Where."""
    x_radius_mm: float
    """Place on it."""
    z_mm: float
    """Place on it."""


class MovedShape(Shape):
    """Effect of the offset on a feature that its tool cuts, along the outward normal: + leaves more on."""

    feature: str
    """Its name."""
    moved_low_um: float
    """The least that it is moved by."""
    moved_high_um: float
    """The most."""
    own_correction_um: float
    """The contour's own correction where the two differ most."""
    moved_there_um: float
    """The offset's there."""
    touched: bool
    """True if it was measured; else its own correction is an estimate."""
    against: bool
    """True if the offset moves it the other way than its own correction would."""


class ByToolShape(Shape):
    """The answer by tool."""

    words: str
    """In one line."""
    comes_first: bool
    """The offset makes the correction, or would do most of it."""
    tools: list[ToolShape]
    """The corrected tool first."""
    share: float
    """Of the correction's size that the offset takes out."""
    beyond: BeyondShape
    """The errors that it leaves."""
    features: list[MovedShape]
    """From the chuck end to the free end."""


class AxesShape(Shape):
    """Why an offset or the contour carries the correction, in words."""

    x: str
    """Along X."""
    z: str
    """Along Z."""
    readings: str = ""
    """The decision on readings that no offset changes; empty without such readings."""


class SuspectShape(Shape):
    """A touch that the others contradict."""

    point: str
    """Its name."""
    feature: str
    """The feature it is on."""
    error_um: float
    """Its error."""
    expected_um: float
    """The error that the others predict there."""
    standard_u_um: float
    """Standard uncertainty of a good touch about that."""
    probability_bad: float
    """Of being bad."""
    weight: float
    """In the fit; 0: left out."""


class ComponentShape(Shape):
    """Shares of machine and process in a correction at one touch: of the whole one, what was in force among it."""

    feature: str
    """The feature it is on."""
    point: str
    """Its name."""
    comp_mtg_um: float
    """Of the machine."""
    comp_proc_um: float
    """Of the process."""
    composed_um: float
    """Both."""


class JunctionShape(Shape):
    """Where two features meet, or the profile ends."""

    before: str | None
    """The feature that ends there; null at the profile's start."""
    after: str | None
    """The feature that starts there; null at the profile's end."""
    kind: str | None
    """corner or tangent; null at the ends of the profile."""
    error_before_um: float | None
    """The fitted error of the one at its end."""
    error_after_um: float | None
    """The fitted error of the other at its start."""
    displacement_x_um: float
    """Where both curves meet, seen from the nominal junction."""
    displacement_z_um: float
    """Where both curves meet, along z."""
    note: str
    """The correction, in words."""


class LineShape(Shape):
    """One line of a program's diff."""

    kind: Literal["same", "old", "new"]
    """In both, in the source alone, in the corrected program alone."""
    number: int
    """Its number: of a new line in the corrected program, of others in the source."""
    text: str
    """The line."""


class ProgramShape(Shape):
    """A written program beside its source."""

    name: str
    """Its file."""
    lines_gone: int
    """Lines of the source that are gone or changed."""
    lines_new: int
    """Lines in their place."""
    diff: list[list[LineShape]]
    """The places that changed, each with a line around it."""


class MemorySharesShape(Shape):
    """How much of one arc's correction came from earlier parts of the edge."""

    feature: str
    """The arc."""
    from_memory_percent: float
    """Share of the correction that there would be without a touch of this part."""


class MemoryTouchShape(Shape):
    """Correction at one touch of an arc that earlier parts predict."""

    feature: str
    """The arc."""
    point: str
    """The touch."""
    taken_off_um: float
    """By the correction."""
    from_memory_um: float
    """Of it what came from earlier parts; the rest from today's touches."""


class MemoryShape(Shape):
    """The arcs' errors by earlier parts of the edge."""

    edge: str
    """The edge."""
    use: str
    """How earlier parts were to take part."""
    applied: bool
    """True if the correction is by them."""
    inspected_parts: int
    """How many of them were inspected after their finish cut."""
    touches_used: int
    """Of this part, that took part."""
    enough_touches: int | None
    """So many of them would have been enough; null where nothing was predicted."""
    points_to_keep: list[str]
    """Touches that are enough for the next part and for judging it."""
    gain: float
    """The machine's response to a correction of 1."""
    features: list[MemorySharesShape]
    """The arcs that earlier parts tell."""
    touches: list[MemoryTouchShape]
    """Touches of these."""
    alarms: list[str]
    """How this part's touches contradict earlier parts."""
    words: list[str]
    """All of it in words."""


class CutWithShape(Shape):
    """The cut of the measured part. Offsets: how far the tool stood off the path of the program that ran."""

    words: str
    """The cut in words."""
    ran: str
    """corrected, offsets, wear or as-programmed: which program ran, or that the offset was entered at the control."""
    correction: str
    """Id of the correction in force; empty: none."""
    program_sha256: str
    """Of the program that ran; empty: not known."""
    offset_x_um: float
    """In force in all; a radius."""
    offset_z_um: float
    """In force in all."""
    wear_x_um: float
    """Of it what stands in the control's wear table and stays in force; a radius."""
    wear_z_um: float
    """Its part in the control's wear table, along Z."""


class CorrectionShape(Shape):
    """Everything that the page of one correction says."""

    schema_version: Literal[1] = 1
    """Of this shape; keys may be added to it."""
    header: Header
    """The corrected object: part, machine, tool, gauge, program."""
    part: str
    """Name of the part."""
    record_id: str
    """Id of the record."""
    program_to_run: str
    """The file to finish with."""
    carried_out_by: str
    """corrected, offsets or wear: corrected contour, program with tool offsets, offset to be entered at the control."""
    cut_with: CutWithShape | None
    """The cut of the measured finished part; null: the part was measured before its finish cut."""
    headline: str
    """The prediction, in words."""
    characteristics: list[CharacteristicShape]
    """The drawing's characteristics, in or out."""
    features: list[FeatureShape]
    """From the chuck end to the free end."""
    predicted_is: str
    """The meaning of predictions."""
    between_cuts: str
    """The assumed difference of two cuts, in words."""
    components: list[ComponentShape]
    """Of a correction of machine and process; else empty."""
    by_tool: ByToolShape | None
    """Which tool gets which offset; null where a machine model takes part."""
    tool_offset: OffsetShape
    """As numbers to enter, whatever else is written."""
    decision: AxesShape
    """Offset or contour, and why."""
    suspect_touches: list[SuspectShape]
    """Touches that others contradict."""
    notes: list[str]
    """Remarks to read before the program is run."""
    model_notes: list[str]
    """How the error curves came about."""
    scatter_um: float
    """Of a touch about its curve, one standard deviation."""
    degrees_of_freedom: int
    """Of that; 0: no touch is spare."""
    coverage_factor: float
    """k of the expanded uncertainties of what is fitted."""
    touches: list[TouchShape]
    """In order along the profile."""
    junctions: list[JunctionShape]
    """From the chuck end to the free end."""
    programs: list[ProgramShape]
    """Those that were written."""
    inputs_sha256: dict[str, str]
    """Hashes of the files that were read, by the names the job gives them."""
    options: dict[str, object]
    """How it was corrected; lengths in mm."""
    memory: MemoryShape | None
    """The memory of earlier parts of the edge; null without any."""
