"""A series of parts diagnosed: what makes them wrong."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from trueloop.diagnosis.causes.candidate import Diagnosis
from trueloop.diagnosis.causes.judge import judge
from trueloop.diagnosis.causes.seen_part import SeenSeries
from trueloop.diagnosis.features.feature_place import FeaturePlace
from trueloop.errors import Code, Finding, TrueloopError
from trueloop.loops.diagnosis.inspected import Inspected
from trueloop.loops.diagnosis.repeats import repeats_of, require_stable

LEAST_PARTS = 2


@dataclass(frozen=True)
class SeriesDiagnosis:
    """Of one series."""

    series: SeenSeries
    causes: Diagnosis
    findings: tuple[Finding, ...]


def diagnose_series(
    parts: Sequence[Inspected], places: Mapping[str, FeaturePlace], accept: Collection[str] = ()
) -> SeriesDiagnosis:
    """Of parts in cutting order.

    Raises DIA-FEW for one part, DIA-UNSTABLE for a fixturing that does not hold, unless it is accepted: while it does
    not, nothing else is concluded [4773 §4.1].
    """
    cut = [one for one in parts if not one.made.standard]
    if len(cut) < LEAST_PARTS:
        raise TrueloopError(
            Code.DIA_FEW,
            f"{len(cut)} parts were inspected, {LEAST_PARTS} at least tell what repeats from part to part",
            hint="`trueloop diagnose part SERIAL` shows the errors of one part",
            values={"count": len(cut), "needed": LEAST_PARTS},
        )
    repeats = [
        (one.part.serial, r) for one in parts for points in one.points(places).values() for r in repeats_of(points)
    ]
    findings = require_stable(repeats, accept)
    series = SeenSeries(places, tuple(one.with_errors(places) for one in parts))
    found = judge(series)
    return SeriesDiagnosis(series, found, (*findings, *found.findings))
