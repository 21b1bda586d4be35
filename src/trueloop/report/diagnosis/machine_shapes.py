"""The shape of a diagnosis of a machine's model as JSON: `docs/diagnosis-machine.schema.json` is written from it."""

from typing import Literal

from trueloop.machine.model.model import Version
from trueloop.machine.refine.left import Change
from trueloop.machine.refine.refine import LeftOut, Refined
from trueloop.report.diagnosis.shapes import Words
from trueloop.report.series.values import FindingShape
from trueloop.report.shape import Shape, um
from trueloop.units import UM_PER_MM, URAD_PER_RAD


class SuspectShape(Shape):
    """One axis error of a set."""

    error: str
    """EXX, EBZ and so on; "nominal X": no error of an axis, but one in proportion to the size of the part."""
    follows: str
    """The signal with which it changes; empty: it is the same at all times."""
    probability: float
    """That this one is wrong."""


class TermSetShape(Shape):
    """Axis errors that the data cannot separate, of which the model has one wrong."""

    errors: list[SuspectShape]
    """Likeliest first."""
    probability: float
    """That what is wrong is among them."""
    at_least: int
    """So many of them are wrong."""
    separated_by: list[Words]
    """The tool, position or temperature that would divide them, the best first."""


class ResidualShape(Shape):
    """The model's residual at one gauging point of one part."""

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
    """Errors that both models leave on parts, or part types, unseen by the refined one."""

    of: Literal["parts", "part types"]
    """The part or type that was left out."""
    groups: int
    """How often some were left out."""
    points: int
    """Gauging points."""
    before_um: float
    """Root mean square of ERROR_MTG,RESID with the model in force."""
    after_um: float
    """That of the refined model."""
    better_um: float
    """By how much it is less."""
    standard_u_um: float
    """Of that."""


class ChangeShape(Shape):
    """Change of one axis error at one place in a refined model."""

    error: str
    """Its name."""
    unit: str
    """µm or µrad."""
    at: float | None
    """Position of its axis, mm or rad; null: it has none."""
    signals: dict[str, float]
    """Temperatures there."""
    old: float
    """As the model in force has it."""
    new: float
    """As the refined one has it."""
    standard_u: float
    """Of the new one."""


class RefinementShape(Shape):
    """A refined model, and what it would have left of parts that it was not refined from."""

    version: int
    """Of the refined model, counted from the fitted one, which is 0."""
    parent: str
    """Hash of the file that it refines."""
    reason: Words
    """Why."""
    errors: list[str]
    """Axis errors that were guilty."""
    parts: int
    """From how many parts."""
    left_out: list[LeftOutShape]
    """The parts that it was judged on."""
    better: bool
    """It leaves less, beyond the uncertainty, and no more of part types left out."""
    changes: list[ChangeShape]
    """Its changes."""
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
    """The findings; empty: no error is more likely than not."""
    scatter_um: float
    """The scatter of single points."""
    by_error: dict[str, float]
    """Probability of each axis error that it is wrong, likeliest first."""
    residuals: list[ResidualShape]
    """At every point."""
    temperatures: dict[str, list[float]]
    """By signal, as many as residuals: at each point while it was probed."""
    frames: Words | None
    """How the part frames of machine and measuring machine lie to each other; null: one part."""
    own_way: list[CorrelationShape]
    """Result of testing one correlation after another."""
    refinement: RefinementShape | None
    """Null: none was made."""
    findings: list[FindingShape]
    """The findings."""


def refinement_shape(refined: Refined, version: Version) -> RefinementShape:
    """Makes the shape of a refined model with the version that it was given."""
    judged, by = refined.judged, version.accepted
    left = [_left_out("parts", judged.by_part)]
    if judged.by_type is not None:
        left.append(_left_out("part types", judged.by_type))
    return RefinementShape.from_values(
        *(refined, version, judged),
        version=version.number,
        parent=version.parent_sha256,
        left_out=left,
        changes=[_change(change) for change in refined.changes],
        accepted=None if by is None else f"{by.who} {by.at}",
    )


def _left_out(of: Literal["parts", "part types"], left_out: LeftOut) -> LeftOutShape:
    before_um, after_um, u_um = (
        um(value) for value in (left_out.rms_old_mm, left_out.rms_new_mm, left_out.u_better_mm)
    )
    return LeftOutShape.from_values(left_out, of=of, before_um=before_um, after_um=after_um, standard_u_um=u_um)


def _change(change: Change) -> ChangeShape:
    scale = URAD_PER_RAD if change.error.is_rotation else UM_PER_MM
    old, new, u = (round(value * scale, 4) + 0.0 for value in (change.old, change.new, change.u))
    return ChangeShape.from_values(
        change, error=str(change.error), unit=change.error.unit, old=old, new=new, standard_u=u
    )
