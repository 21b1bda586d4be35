"""One part diagnosed: feature errors by device, components at its points, causes as far as one part tells."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from trueloop.diagnosis.causes.candidate import Diagnosis
from trueloop.diagnosis.causes.judge import judge
from trueloop.diagnosis.causes.seen_part import SeenPart, SeenSeries
from trueloop.diagnosis.components import Components
from trueloop.diagnosis.features.feature_place import FeaturePlace
from trueloop.diagnosis.features.undetermined import undetermined
from trueloop.diagnosis.part_frame import FrameDiscrepancy
from trueloop.errors import Code, Finding, Severity
from trueloop.loops.diagnosis.inspected import Inspected
from trueloop.loops.diagnosis.repeats import repeats_of, require_stable
from trueloop.machine.model.model import MachineModel


@dataclass(frozen=True, eq=False)
class PartDiagnosis:
    """Of one part. `causes` is None where nothing is concluded; `components` where both devices saw its points."""

    part: SeenPart
    causes: Diagnosis | None
    findings: tuple[Finding, ...]
    points: tuple[str, ...] = ()
    components: Components | None = None
    frame: FrameDiscrepancy | None = None


def diagnose_part(
    one: Inspected,
    others: Collection[Inspected],
    places: Mapping[str, FeaturePlace],
    model: MachineModel | None = None,
    accept: Collection[str] = (),
) -> PartDiagnosis:
    """The part among the others of its series, which say what one part alone cannot.

    Raises DIA-UNSTABLE for repeats that do not hold, unless it is accepted.
    """
    seen = one.points(places)
    findings = require_stable([(one.part.serial, r) for points in seen.values() for r in repeats_of(points)], accept)
    for points in seen.values():
        findings += undetermined(points, places)
    part = one.with_errors(places)
    causes = None
    if len(others) > 1:
        series = SeenSeries(places, tuple(other.with_errors(places) for other in others))
        causes = of_part(judge(series), part)
        findings += causes.findings
    else:
        findings.append(ALONE)
    if one.both is None or model is None:
        return PartDiagnosis(part, causes, tuple(findings))
    components, frame = one.both.components(model)
    return PartDiagnosis(part, causes, tuple(findings), one.both.points, components, frame)


ALONE = Finding(
    Severity.NOTE,
    Code.DIA_FEW,
    "one part of its type was inspected: what repeats from part to part is not known, and no cause is named",
    "inspect more parts of the type; the errors of features stand",
    values={"count": 1, "needed": 2},
)


def of_part(found: Diagnosis, part: SeenPart) -> Diagnosis:
    """The causes of a series that act on features which this part shows."""
    shown = {error.feature for errors in part.errors.values() for error in errors}
    own = tuple(one for one in found.candidates if not one.features or shown & set(one.features))
    return replace(found, candidates=own)
