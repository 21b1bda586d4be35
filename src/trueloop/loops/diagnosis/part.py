"""Diagnoses of one part and of a series: feature errors by device, components at points, fixturing, causes."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.causes.cause import Diagnosis, SeenBy, SeenPart, SeenSeries
from trueloop.diagnosis.causes.judge import judge
from trueloop.diagnosis.components import Components, FrameDiscrepancy
from trueloop.diagnosis.features.errors_of import errors_of, undetermined
from trueloop.diagnosis.features.feature_error import FeaturePlace, SeenPoints
from trueloop.diagnosis.features.fixturing import FEWEST, Fixturing, fixturing, unstable
from trueloop.domain.inspection import Inspection, Reading, StandardPart
from trueloop.domain.life import Ran
from trueloop.domain.part import Part
from trueloop.errors import Code, Finding, Severity
from trueloop.loops.diagnosis.left_on_parts import BothSeen
from trueloop.loops.diagnosis.points_of import by_machine_mm, points_of, taken_off_mm
from trueloop.loops.turned.correction import Correction
from trueloop.machine.model.model import MachineModel

OVERRIDE: Final = "--accept DIA-UNSTABLE"


@dataclass(frozen=True)
class Repeats:
    """Readings of one point in their order, (n,) mm, and what they show."""

    what: str
    values_mm: Array
    standard_u_mm: float
    found: Fixturing


def repeats_of(
    points: SeenPoints, standard_u_mm: float | None = None, limit_mm: float | None = None
) -> Iterator[Repeats]:
    """Yields every point that was read often enough; `standard_u_mm` replaces the stated one."""
    groups: dict[tuple[str, tuple[float, ...]], list[int]] = {}
    for k, name in enumerate(points.feature):
        place = np.round([*points.nominal_mm[k], *points.normal[k], points.spindle_rad[k]], 6)
        groups.setdefault((name, tuple(np.nan_to_num(place).tolist())), []).append(k)
    for (name, _), rows in groups.items():
        if len(rows) >= FEWEST and len(set(points.repeat[rows].tolist())) == len(rows):
            order = sorted(rows, key=lambda k: int(points.repeat[k]))
            values = points.error_mm[order]
            u = float(np.median(points.standard_u_mm[order])) if standard_u_mm is None else standard_u_mm
            if u > 0.0:
                yield Repeats(name, values, u, fixturing(values, u, limit_mm))


def require_stable(repeats: Sequence[tuple[str, Repeats]], accept: Collection[str] = ()) -> list[Finding]:
    """Refuses what does not hold (DIA-UNSTABLE) unless that is accepted: then it is a warning. `repeats` with parts."""
    findings = []
    for of, one in repeats:
        found = unstable(f"{of}, {one.what}" if of else one.what, one.found)
        if found is None:
            continue
        if found.code not in accept:
            refusal = found.as_error()
            refusal.override = OVERRIDE
            raise refusal
        findings.append(replace(found, severity=Severity.WARNING))
    return findings


@dataclass(frozen=True, eq=False)
class InspectedPart:
    """One part: how it was made, without errors; the readings of each kind of device; its calibration if it is
    standard.

    `both` is there where both devices saw the same points and the model of the machine is known. `cut_with`: the
    correction that it was cut with, and by which of its ways; None: none. `corrected`: by device the correction that
    was made from its readings, which knows what the machine did to them.
    """

    part: Part
    made: SeenPart
    seen: Mapping[SeenBy, Inspection]
    standard: StandardPart | None = None
    both: BothSeen | None = None
    cut_with: tuple[Correction, Ran] | None = None
    corrected: Mapping[SeenBy, Correction] = field(default_factory=dict)

    def points(self, places: Mapping[str, FeaturePlace]) -> dict[SeenBy, SeenPoints]:
        """Returns points by the device that measured them; of a standard part errors are actual less calibrated. What
        the machine's probe reported is corrected by E(T_probing), where that is known.
        """
        seen = {
            by: points_of(against_calibrated(inspection, self.standard), places) for by, inspection in self.seen.items()
        }
        for by, correction in self.corrected.items():
            probed_mm, _ = by_machine_mm(seen[by], correction)
            seen[by] = replace(seen[by], error_mm=seen[by].error_mm + probed_mm)
        return {by: points for by, points in seen.items() if points.feature}

    def with_errors(self, places: Mapping[str, FeaturePlace]) -> SeenPart:
        """Returns the part as a diagnosis of causes takes it."""
        points = self.points(places)
        errors = {by: errors_of(some, places) for by, some in points.items()}
        cut = self.cut_with
        taken = {} if cut is None else {by: taken_off_mm(some, *cut) for by, some in points.items()}
        known = {by: correction for by, correction in self.corrected.items() if by in points}
        carried = {by: by_machine_mm(points[by], correction)[1] for by, correction in known.items()}
        return replace(self.made, errors=errors, points=points, taken_off_mm=taken, carried_mm=carried)


def against_calibrated(inspection: Inspection, standard: StandardPart | None) -> Inspection:
    """Returns an inspection whose readings are off nominal by as much as they are off their calibrated values.

    Errors count from the nominal shape: a calibrated part is not nominal itself. Readings without a calibrated value,
    or of which neither has the nominal one, are left out.
    """
    if standard is None:
        return inspection
    known = {value.characteristic: value for value in standard.values}
    values = []
    for value in inspection.values:
        if isinstance(value, Reading) and (calibrated := known.get(value.characteristic)) is not None:
            nominal = calibrated.nominal if value.nominal is None else value.nominal
            if nominal is not None:
                actual = value.actual - calibrated.actual + nominal
                values.append(replace(value, actual=actual, nominal=nominal))
    return replace(inspection, values=tuple(values), count=len(values))


@dataclass(frozen=True, eq=False)
class PartDiagnosis:
    """The diagnosis of a part. `causes` None: nothing is concluded; `components`: where both devices saw its points."""

    part: SeenPart
    causes: Diagnosis | None
    findings: tuple[Finding, ...]
    points: tuple[str, ...] = ()
    components: Components | None = None
    frame: FrameDiscrepancy | None = None


def diagnose_part(
    inspected: InspectedPart,
    others: Collection[InspectedPart],
    places: Mapping[str, FeaturePlace],
    model: MachineModel | None = None,
    accept: Collection[str] = (),
) -> PartDiagnosis:
    """Diagnoses a part among the others of its series. Raises DIA-UNSTABLE for repeats that do not hold."""
    seen = inspected.points(places)
    findings = require_stable(
        [(inspected.part.serial, r) for points in seen.values() for r in repeats_of(points)], accept
    )
    for points in seen.values():
        findings += undetermined(points, places)
    part = inspected.with_errors(places)
    causes = None
    if len(others) > 1:
        series = SeenSeries(places, tuple(other.with_errors(places) for other in others))
        causes = of_part(judge(series), part)
        findings += causes.findings
    else:
        findings.append(ALONE)
    if inspected.both is None or model is None:
        return PartDiagnosis(part, causes, tuple(findings))
    components, frame = inspected.both.components(model)
    return PartDiagnosis(
        part=part,
        causes=causes,
        findings=tuple(findings),
        points=inspected.both.points,
        components=components,
        frame=frame,
    )


ALONE = Finding(
    Severity.NOTE,
    Code.DIA_FEW,
    "one part of its type was inspected: what repeats from part to part is not known, and no cause is named",
    "inspect more parts of the type; the errors of features stand",
    values={"count": 1, "needed": 2},
)


def of_part(diagnosis: Diagnosis, part: SeenPart) -> Diagnosis:
    """Returns the causes of a series that act on features which this part shows."""
    shown = {error.feature for errors in part.errors.values() for error in errors}
    own = tuple(
        candidate for candidate in diagnosis.candidates if not candidate.features or shown & set(candidate.features)
    )
    return replace(diagnosis, candidates=own)


LEAST_PARTS = 2


@dataclass(frozen=True)
class SeriesDiagnosis:
    """The diagnosis of one series."""

    series: SeenSeries
    causes: Diagnosis
    findings: tuple[Finding, ...]


def diagnose_series(
    parts: Sequence[InspectedPart], places: Mapping[str, FeaturePlace], accept: Collection[str] = ()
) -> SeriesDiagnosis:
    """Diagnoses parts in cutting order.

    Raises DIA-FEW for one part, DIA-UNSTABLE for a fixturing that does not hold, unless it is accepted: while it does
    not, nothing else is concluded [4773 §4.1].
    """
    cut = [part for part in parts if not part.made.standard]
    if len(cut) < LEAST_PARTS:
        raise Code.DIA_FEW.refusal(
            f"{len(cut)} parts were inspected, {LEAST_PARTS} at least are needed to separate what repeats from part "
            "to part",
            hint="`trueloop diagnose part SERIAL` shows the errors of one part",
            values={"count": len(cut), "needed": LEAST_PARTS},
        )
    repeats = [
        (part.part.serial, r) for part in parts for points in part.points(places).values() for r in repeats_of(points)
    ]
    findings = require_stable(repeats, accept)
    series = SeenSeries(places, tuple(part.with_errors(places) for part in parts))
    found = judge(series)
    return SeriesDiagnosis(series, found, (*findings, *found.findings))
