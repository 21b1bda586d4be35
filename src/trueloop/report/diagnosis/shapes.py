"""The shapes of diagnoses of parts, series and fixtures as JSON: `docs/diagnosis-*.schema.json` are written from them.

Errors are in µm along the outward normal, positive where material is left on; of a length, positive where it is too
long. `standard_u` is one standard deviation. Probabilities are from 0 to 1.
"""

from typing import Literal

from pydantic import SkipValidation

from trueloop.report.series.values import FindingShape
from trueloop.report.shape import Shape

Words = SkipValidation[str]
"""A sentence, which a page says in its own language."""


class FeatureErrorShape(Shape):
    """One error of one feature of one part."""

    feature: str
    """Its name."""
    kind: str
    """radius, length, taper of a shaft, taper of a face, edge, straightness, waviness, eccentricity, lobing."""
    value_um: float | None
    """Signed for radius, length and tapers; a size for the others."""
    standard_u_um: float | None
    """Its standard uncertainty."""
    points: int
    """How many points it is from."""
    degrees_of_freedom: int | None
    """Of the uncertainty; null: it is known."""
    other: str
    """Of a length, the nearer face."""
    more: dict[str, float]
    """Further numbers; names end with their unit."""


class SeenPartShape(Shape):
    """A part with its errors by who saw them."""

    serial: str
    """Its serial number."""
    order: int
    """Among the parts as they were cut."""
    at: str | None
    """When it was cut."""
    standard: bool
    """A calibrated part, on which nothing was cut."""
    tool_set: list[str]
    """Tools that were set since the part before."""
    temperatures: dict[str, float]
    """While it was cut."""
    errors: dict[str, list[FeatureErrorShape]]
    """By "machine", the machine's own probe, and "CMM", a measuring machine or gauge."""


class MeanShape(Shape):
    """The mean over the parts of one error, as one device saw it."""

    parts: int
    """How many parts."""
    mean_um: float
    """Their mean."""
    standard_u_um: float | None
    """Of the mean; null from one part without a known uncertainty."""
    scatter_um: float | None
    """Standard deviation from part to part; null with one part."""
    one_part_u_um: float | None
    """Standard uncertainty of the value of one part, root mean square over the parts."""


class FeatureMeansShape(Shape):
    """One error of one feature over all parts but standard parts."""

    feature: str
    """Its name."""
    other: str
    """Of a length, the nearer face."""
    kind: str
    """As of a feature error."""
    machine: MeanShape | None
    """As the machine's probe saw it: what the process did."""
    cmm: MeanShape | None
    """As the CMM saw it: process, and what the model of the machine left."""
    difference: MeanShape | None
    """CMM less machine, of parts that both saw: what the model of the machine left."""


class CandidateShape(Shape):
    """One cause with its probability."""

    key: str
    """Its name without spaces."""
    name: Words
    """Its name for people."""
    tool: str
    """The tool that it concerns; empty: none alone."""
    features: list[str]
    """On which features it acts."""
    probability: float
    """That it acts."""
    size_um: float | None
    """Its effect, if it acts."""
    standard_u_um: float | None
    """Of that."""
    supports: list[Words]
    """Evidence for it."""
    contradicts: list[Words]
    """Evidence against it."""
    remedy: Words
    """The remedy."""
    section: str
    """Where the source says it."""
    decided_by: Words
    """The measurement that would separate it from others."""


class HypothesisShape(Shape):
    """A set of causes that act together."""

    causes: list[str]
    """Their keys; none: nothing acts."""
    probability: float
    """Of exactly these."""


class CausesShape(Shape):
    """Causes that act on a part or a series."""

    sound: float
    """Probability that nothing acts."""
    candidates: list[CandidateShape]
    """Likeliest first."""
    hypotheses: list[HypothesisShape]
    """Likeliest first."""
    decide: list[Words]
    """Measurements that would separate the causes left."""
    gain: float
    """How often the recorded corrections arrived: 1, or what the parts show instead."""


class UnexplainedShape(Shape):
    """An error beyond its uncertainty that no probable cause acts on."""

    feature: str
    """Its name."""
    other: str
    """Of a length, the nearer face."""
    kind: str
    """As of a feature error."""
    device: str
    """Who saw it: machine or CMM."""
    shows: Literal["mean", "scatter"]
    """A mean over the parts, or that the parts differ."""
    size_um: float
    """The mean, or the standard deviation from part to part."""
    standard_u_um: float
    """Its standard uncertainty, by chance and the device."""


class PointShape(Shape):
    """Errors, compensations and surfaces at one gauging point [NISTIR 6876 §3], µm along the outward normal."""

    name: str
    """Its name."""
    error_pp_um: float
    """ERROR_PP: the detected surface, from NOMINALSURFACE_CMM."""
    error_mtg_um: float
    """ERROR_MTG of the machine without compensation."""
    error_mtg_resid_um: float
    """ERROR_MTG,RESID: what the model of the machine left; NOMINALSURFACE_MT, from NOMINALSURFACE_CMM."""
    error_proc_um: float
    """ERROR_PROC of the process without compensation."""
    error_proc_resid_um: float
    """ERROR_PROC,RESID: what is left of it, as on-machine inspection finds it."""
    comp_mtg_um: float
    """COMP_MTG(T_CUTTING) as applied; 0 where nothing was."""
    comp_proc_um: float
    """COMP_PROC as applied."""
    u_error_pp_um: float
    """Standard uncertainty of ERROR_PP."""
    u_error_mtg_um: float
    """Of ERROR_MTG and of its residual."""
    u_error_proc_um: float
    """Of ERROR_PROC and of its residual."""


class FrameShape(Shape):
    """Removed difference of the part frames of CMM and machine."""

    shift_um: list[float]
    """Along x, y, z."""
    turn_urad: list[float]
    """About x, y, z."""
    rms_before_um: float
    """CMM less machine along the normals."""
    rms_after_um: float
    """The error without the difference of the frames."""


class PartDiagnosisShape(Shape):
    """One part: its feature errors, their causes as far as one part tells, and components at gauging points."""

    part_type: str
    """Its name."""
    part: SeenPartShape
    """Its errors."""
    causes: CausesShape | None
    """Null: one part does not show it."""
    frame: FrameShape | None
    """Null: none was looked for."""
    points: list[PointShape]
    """Where both devices measured the same points."""
    findings: list[FindingShape]
    """The findings."""


class PointMeansShape(Shape):
    """The errors at one gauging point over all parts but standard parts [6811 Tables 2–11]."""

    feature: str
    """On which it lies."""
    x_mm: float
    """Its nominal place: a radius."""
    z_mm: float
    """In the part's frame."""
    machine: MeanShape | None
    """As the machine's probe saw it."""
    cmm: MeanShape | None
    """As the CMM or a gauge saw it."""
    machine_um: dict[str, float]
    """Its error on each part, by serial number, as the machine's probe saw it: + where material is left on."""
    cmm_um: dict[str, float]
    """The error as measured by the CMM or a gauge."""


class SeriesDiagnosisShape(Shape):
    """Parts of one type in cutting order, and what makes them wrong."""

    part_type: str
    """Its name."""
    causes: CausesShape | None
    """Null: nothing is concluded, and the findings say why."""
    means: list[FeatureMeansShape]
    """Each error over the parts."""
    points: list[PointMeansShape]
    """Each gauging point over the parts."""
    unexplained: list[UnexplainedShape]
    """Errors beyond their uncertainty that no probable cause acts on, furthest first."""
    parts: list[SeenPartShape]
    """As they were cut."""
    findings: list[FindingShape]
    """The findings."""


class JudgedShape(Shape):
    """One property of repeats."""

    value_um: float
    """A spread is a standard deviation; a drift is from the first to the last; a step, after less before."""
    standard_u_um: float
    """Its standard uncertainty."""
    significant: bool
    """Beyond what chance explains."""


class FixturingShape(Shape):
    """Repeats at one point right after fixturing."""

    name: str
    """The fixed object: the part, the tool probe, the part probe, or as named."""
    values_um: list[float]
    """As read, less their mean."""
    standard_u_um: float
    """Of one reading."""
    limit_um: float | None
    """The variation allowed."""
    spread: JudgedShape
    """From one to the next."""
    drift: JudgedShape
    """Over all."""
    step: JudgedShape
    """At one place."""
    step_after: int | None
    """After which reading; null: none."""
    stable: bool
    """Nothing else is concluded while it is not [NISTIR 4773 §4.1]."""


class FixtureDiagnosisShape(Shape):
    """Fixturing of part, tool probe and part probe."""

    machine: str
    """Its name."""
    fixturings: list[FixturingShape]
    """One for each."""
    findings: list[FindingShape]
    """The findings."""
