"""A part as it was inspected, its errors of features, and what its repeats say of its fixturing."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.causes.seen_part import SeenBy, SeenPart
from trueloop.diagnosis.features.errors_of import errors_of
from trueloop.diagnosis.features.feature_place import FeaturePlace
from trueloop.diagnosis.features.fixturing import FEWEST, Fixturing, fixturing, unstable
from trueloop.diagnosis.features.seen_points import SeenPoints
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part
from trueloop.domain.standard_part import StandardPart
from trueloop.errors import Finding, Severity
from trueloop.loops.diagnosis.left_on_parts import BothSeen
from trueloop.loops.diagnosis.points_of import points_of

OVERRIDE = "--accept DIA-UNSTABLE"


@dataclass(frozen=True, eq=False)
class Inspected:
    """One part: how it was made, without errors; what each kind of device found; its calibration if it is standard.

    `both` is there where both devices saw the same points and the model of the machine is known.
    """

    part: Part
    made: SeenPart
    seen: Mapping[SeenBy, Inspection]
    standard: StandardPart | None = None
    both: BothSeen | None = None

    def points(self, places: Mapping[str, FeaturePlace]) -> dict[SeenBy, SeenPoints]:
        """By who saw them; of a standard part errors are actual less calibrated."""
        seen = {by: points_of(against_calibrated(one, self.standard), places) for by, one in self.seen.items()}
        return {by: points for by, points in seen.items() if points.feature}

    def with_errors(self, places: Mapping[str, FeaturePlace]) -> SeenPart:
        """As a diagnosis of causes takes it."""
        return replace(self.made, errors={by: errors_of(points, places) for by, points in self.points(places).items()})


def against_calibrated(one: Inspection, standard: StandardPart | None) -> Inspection:
    """An inspection whose readings have the calibrated values as nominal ones; others are left out."""
    if standard is None:
        return one
    known = {value.characteristic: value.actual for value in standard.values}
    values = tuple(
        replace(value, nominal=known[value.characteristic])
        for value in one.values
        if isinstance(value, Reading) and value.characteristic in known
    )
    return replace(one, values=values, count=len(values)) if values else one


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
    """Every point that was read often enough; `standard_u_mm` instead of the stated one."""
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
