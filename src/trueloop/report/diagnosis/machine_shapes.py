"""The shape of a diagnosis of a machine's model as JSON: `docs/diagnosis-machine.schema.json` is written from it."""

from trueloop.report.diagnosis.shapes import Words
from trueloop.report.series.shapes import FindingShape
from trueloop.report.shape import Shape


class TermSetShape(Shape):
    """Axis errors that the data cannot tell apart, one of which the model has wrong."""

    errors: list[str]
    """By their names, with the temperature that they may follow; none: nothing is wrong."""
    probability: float
    """That the wrong one is among them."""
    separated_by: list[Words]
    """The tool, position or temperature that would divide them."""


class ResidualShape(Shape):
    """What the model left at one gauging point of one part."""

    part: str
    """Its serial number or number."""
    position_mm: dict[str, float]
    """Of the axes."""
    residual_um: float
    """ERROR_MTG,RESID along the outward normal, positive where material is left on."""


class CorrelationShape(Shape):
    """One step of the source's own way: one correlation after another [NISTIR 4773 §3.3]."""

    error: str
    """The axis error found."""
    signal: str
    """With the temperature that it follows."""
    correlation: float
    """Of what was left till then."""


class LeftOutShape(Shape):
    """A part, or part type, that the refinement did not use."""

    name: str
    """Its name."""
    points: int
    """Gauging points."""
    before_um: float
    """Root mean square of ERROR_MTG,RESID with the model in force."""
    after_um: float
    """The same with the refined one."""
    standard_u_um: float | None
    """Of the change."""


class RefinementShape(Shape):
    """A refined model, and what it would have left of parts that it was not refined from."""

    version: str
    """Of the refined model."""
    parent: str
    """Of the model that it refines."""
    reason: Words
    """Why."""
    errors: list[str]
    """Axis errors whose parameters were updated."""
    parts_used: int
    """From how many parts."""
    left_out: list[LeftOutShape]
    """What it was judged on."""
    better: bool
    """It leaves less, beyond the uncertainty."""
    accepted: str | None
    """By whom and when; null: offered, not in force."""


class MachineDiagnosisShape(Shape):
    """Which axis errors the model of a machine has wrong, from what it left on many parts."""

    machine: str
    """Its name."""
    model: str
    """The model's version."""
    parts: int
    """How many parts."""
    points: int
    """Gauging points of all parts."""
    sound: float
    """Probability that nothing is wrong by as much as the residuals could show."""
    sets: list[TermSetShape]
    """Likeliest first."""
    by_error: dict[str, float]
    """Probability of each axis error that it is wrong, likeliest first."""
    residuals: list[ResidualShape]
    """At every point."""
    temperatures: dict[str, list[float]]
    """By signal, as many as residuals: at each point while it was cut."""
    own_way: list[CorrelationShape]
    """What one correlation after another would have named."""
    refinement: RefinementShape | None
    """Null: none was made."""
    findings: list[FindingShape]
    """What is odd."""
