"""Repeats at one point right after fixturing, and what they refuse while they do not hold [4773 §4.1]."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.features.feature_error import SeenPoints
from trueloop.diagnosis.features.fixturing import FEWEST, Fixturing, fixturing, unstable
from trueloop.errors import Finding, Severity

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
