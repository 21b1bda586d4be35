"""The certificate of a part: measured values with their instruments, judged against limits, and the corrections in
force when it was cut.

A characteristic is certified where a value, a limit, its uncertainty and the device are known and ISO 14253-1 proves it
inside: the worst of its readings, and their mean with the spread. The part conforms where all requested characteristics
are certified; nothing that is not known is.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from math import hypot
from statistics import fmean, stdev
from typing import Final, Literal, TypeAlias

from trueloop.domain.characteristic import Judgement, Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part
from trueloop.errors import Code
from trueloop.tolerances.conformance import judge
from trueloop.wording import Um, wording

Outcome: TypeAlias = Literal["conforms", "does not conform", "not certified"]
STANDARD_C: Final = 20.0
"""At which sizes hold [ISO 1]."""
NEAR_K: Final = 1.0
"""The difference from it, K, beyond which a part is remarked on."""
COVERAGE: Final = 2.0
"""U = 2 u, as certificates state it."""


@dataclass(frozen=True)
class RequiredSize:
    """A characteristic that the part has to have. Limits in mm, of angles in degrees."""

    name: str
    quantity: Quantity
    nominal: float | None
    lower: float | None
    upper: float | None


@dataclass(frozen=True)
class PartInspection:
    """One inspection of the part; `released`: it had left the machine; None: that was not stated."""

    inspection: Inspection
    released: bool | None


@dataclass(frozen=True)
class CertifiedSize:
    """One characteristic: `judged` by ISO 14253-1, None where that is not known; `missing` says in words what is not.

    `actual` is the mean of `repeats` readings, `expanded_u` holds their spread. `by` is the inspection they are from.
    """

    asked: RequiredSize
    actual: float | None
    expanded_u: float | None
    judged: Judgement | None
    repeats: int
    by: PartInspection | None
    temperature_c: float | None
    missing: tuple[str, ...]
    remarks: tuple[str, ...]

    @property
    def proven(self) -> bool:
        """Returns whether it is inside the limits, and everything needed to state so is known."""
        return not self.missing and self.judged is not None and self.judged.verdict == "in"


@dataclass(frozen=True)
class InForce:
    """Something that was in force when the part was cut: what it is, its hash or id, what is known of it in words."""

    what: str
    identity: str
    words: str


@dataclass(frozen=True)
class Certificate:
    """The certificate of one part. `missing`: facts of its cutting that are not known."""

    part: Part
    values: tuple[CertifiedSize, ...]
    in_force: tuple[InForce, ...]
    missing: tuple[str, ...]
    cut_at: datetime | None = None

    @property
    def outcome(self) -> Outcome:
        """Returns the outcome of all characteristics together."""
        if any(size.judged is not None and size.judged.verdict == "out" for size in self.values):
            return "does not conform"
        return "conforms" if self.values and all(size.proven for size in self.values) else "not certified"


def certified(
    part: Part, sizes: Sequence[RequiredSize], seen: Sequence[PartInspection], stated_u: float | None
) -> tuple[CertifiedSize, ...]:
    """Certifies each requested characteristic, by the latest inspection that has it: of a released part, where there is
    one.

    `stated_u`, mm: the standard uncertainty of readings that state none. Raises MON-NONE where nothing was measured.
    """
    if not any(inspection.inspection.readings for inspection in seen):
        raise Code.MON_NONE.refusal(
            f"part {part.serial!r} has {len(seen)} inspections after its finish cut in the store, 0 of them with sizes",
            hint="`trueloop series add` takes inspection files; a certificate says nothing that was not measured",
            values={"characteristic": part.serial},
        )
    return tuple(_certified(size, seen, stated_u) for size in sizes)


def asked_of(inspections: Iterable[Inspection]) -> tuple[RequiredSize, ...]:
    """Returns the characteristics that all inspections of a part type request together: the latest nominal and limits
    of each.

    A coordinate without limits says where a feature was measured, and is not requested.
    """
    found: dict[str, RequiredSize] = {}
    for inspection in inspections:
        for reading in inspection.readings:
            limited = _limits(reading) != (None, None)
            if reading.characteristic and (
                limited or (reading.nominal is not None and reading.quantity is not Quantity.POSITION)
            ):
                found[reading.characteristic] = RequiredSize(
                    reading.characteristic, reading.quantity, reading.nominal, *_limits(reading)
                )
    return tuple(found.values())


def _limits(reading: Reading) -> tuple[float | None, float | None]:
    return reading.lower_limit, reading.upper_limit


def _certified(size: RequiredSize, inspections: Sequence[PartInspection], stated_u: float | None) -> CertifiedSize:
    by, readings = _latest(size.name, inspections)
    values = [reading.actual for reading in readings]
    actual = fmean(values) if values else None
    u = _standard_u(size, readings, stated_u)
    temperature = _temperature(readings, by)
    judged = None if u is None else _judged(size, values, u)
    missing = [*_missing(size, actual, u, by)]
    if size.quantity.is_zone and min(values, default=0.0) < 0 and size.lower is None:
        judged = judged if judged is not None and judged.verdict == "out" else None
        missing.append(wording("a {quantity} below 0 is a signed deviation: both limits are needed",
                               quantity=size.quantity.value))  # fmt: skip
    missing += _contradicted(size, inspections, by, stated_u)
    expanded = None if u is None or actual is None else COVERAGE * hypot(u, _spread(values))
    remarks = [*_remarks(size, by, temperature)] if readings else []
    if judged is not None and actual is not None and judged.value != actual:
        away = judged.value - actual
        shown = f"{away:+.4f}°" if size.quantity is Quantity.ANGLE else Um(away, "+.1f")
        remarks.append(
            wording("judged by the worst of {n} readings, {away} from their mean", n=len(values), away=shown)
        )
    return CertifiedSize(
        asked=size,
        actual=actual,
        expanded_u=expanded,
        judged=judged,
        repeats=len(values),
        by=by,
        temperature_c=temperature,
        missing=tuple(dict.fromkeys(missing)),
        remarks=tuple(remarks),
    )


def _standard_u(size: RequiredSize, readings: Sequence[Reading], stated_u: float | None) -> float | None:
    """Returns the standard uncertainty of one reading, in its unit."""
    own = max((reading.standard_u for reading in readings if reading.standard_u is not None), default=None)
    return stated_u if own is None and size.quantity is not Quantity.ANGLE else own


def _spread(values: Sequence[float]) -> float:
    return stdev(values) if len(values) > 1 else 0.0


def _judged(size: RequiredSize, values: Sequence[float], u: float) -> Judgement | None:
    """Judges the worst of readings by `u` of one; if inside, their mean by its spread too; None without limits."""
    if not values or (size.lower is None and size.upper is None):
        return None
    each = [judge(value, u, None, size.lower, size.upper) for value in values]
    worst = min(each, key=lambda judgement: 0.0 if judgement.margin is None else judgement.margin)
    if worst.verdict != "in":
        return worst
    return judge(fmean(values), hypot(u, _spread(values)), None, size.lower, size.upper)


def _contradicted(
    size: RequiredSize, inspections: Sequence[PartInspection], by: PartInspection | None, stated_u: float | None
) -> Iterator[str]:
    """Yields other measurements, of the same state of the part, that prove the characteristic outside its limits."""
    for inspection in inspections:
        if by is None or _is_same(inspection, by) or bool(inspection.released) != bool(by.released):
            continue
        readings = [each for each in inspection.inspection.readings if each.characteristic == size.name]
        u = _standard_u(size, readings, stated_u)
        judged = None if u is None else _judged(size, [each.actual for each in readings], u)
        if judged is not None and judged.verdict == "out":
            at = inspection.inspection.measured_at
            named = (inspection.inspection.device_of(size.name), "" if at is None else f"{at:%Y-%m-%d %H:%M}")
            yield wording("another measurement is outside the limits: {which}",
                          which=", ".join(filter(None, named)) or inspection.inspection.sha256[:12])  # fmt: skip


def _is_same(one: PartInspection, other: PartInspection) -> bool:
    """Returns whether both are of one measurement, as the shares of two edges in it."""
    inspection, beside = one.inspection, other.inspection
    return (inspection.sha256, inspection.measured_at) == (beside.sha256, beside.measured_at)


def _latest(name: str, inspections: Sequence[PartInspection]) -> tuple[PartInspection | None, tuple[Reading, ...]]:
    """Returns the readings of the latest inspection that has the characteristic: a released part's first."""
    ordered = sorted(inspections, key=lambda inspection: bool(inspection.released))  # stable: later ones stay later
    for inspection in reversed(ordered):
        own = tuple(each for each in inspection.inspection.readings if each.characteristic == name)
        if own:
            return inspection, own
    return None, ()


def _temperature(readings: Sequence[Reading], by: PartInspection | None) -> float | None:
    """Returns the part's temperature when measured: that of the readings, else of the inspection's only sensor."""
    own = [reading.temperature_c for reading in readings if reading.temperature_c is not None]
    if own:
        return fmean(own)
    of_all = () if by is None else tuple(by.inspection.temperatures.values())
    return of_all[0] if len(of_all) == 1 else None


def _missing(size: RequiredSize, actual: float | None, u: float | None, by: PartInspection | None) -> Iterator[str]:
    if actual is None:
        yield wording("it was not measured on this part")
        return
    if size.lower is None and size.upper is None:
        yield wording("no limit is stated")
    if u is None:
        yield wording("no uncertainty is stated")
    if by is not None and not by.inspection.device_of(size.name):
        yield wording("the device is not stated")


def on_the_machine(inspection: Inspection, characteristic: str = "") -> bool:
    """Returns whether the part, or a size of it, was measured by the machine's probe, in the machine's frame."""
    device = inspection.device_of(characteristic).casefold()
    by_probe = device.startswith("probe") if device else inspection.ball_radius_mm > 0.0
    return inspection.frame == "machine" or by_probe


def _remarks(size: RequiredSize, by: PartInspection | None, temperature: float | None) -> Iterator[str]:
    """Yields remarks that do not forbid a certificate, but that its reader has to know."""
    if temperature is None:
        yield wording("temperature not stated")
    elif abs(temperature - STANDARD_C) > NEAR_K:
        yield wording("measured at {t:.1f} °C, not at 20 °C", t=temperature)
    if by is not None and by.inspection.measured_at is None:
        yield wording("time of measuring not stated")
    if by is not None and by.released is False and on_the_machine(by.inspection, size.name):
        yield wording("measured on the machine that cut it, which does not see its own errors")
