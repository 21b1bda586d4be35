"""The certificate of a part: measured values with their instruments, judged against limits, and the corrections in
force when it was cut.

A characteristic is certified where a value, a limit, its uncertainty and the device are known and ISO 14253-1 proves it
inside. The part conforms where all requested characteristics are certified; nothing that is not known is.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from statistics import fmean
from typing import Final, Literal, TypeAlias

from trueloop.domain.characteristic import Judgement, Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part
from trueloop.errors import Code
from trueloop.tolerances.conformance import judge
from trueloop.wording import wording

Outcome: TypeAlias = Literal["conforms", "does not conform", "not certified"]
STANDARD_C: Final = 20.0
"""At which sizes hold [ISO 1]."""
NEAR_K: Final = 1.0
"""The difference from it, K, beyond which a part is remarked on."""
COVERAGE: Final = 2.0
"""U = 2 u, as certificates state it."""


@dataclass(frozen=True)
class Asked:
    """A characteristic that the part has to have. Limits in mm, of angles in degrees."""

    name: str
    quantity: Quantity
    nominal: float | None
    lower: float | None
    upper: float | None


@dataclass(frozen=True)
class Seen:
    """One inspection of the part; `released`: it had left the machine; None: that was not stated."""

    inspection: Inspection
    released: bool | None


@dataclass(frozen=True)
class Certified:
    """One characteristic: `judged` by ISO 14253-1, None where that is not known; `missing` says in words what is not.

    `repeats` readings were averaged. `by` is the inspection that it is from.
    """

    asked: Asked
    actual: float | None
    expanded_u: float | None
    judged: Judgement | None
    repeats: int
    by: Seen | None
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
    values: tuple[Certified, ...]
    in_force: tuple[InForce, ...]
    missing: tuple[str, ...]
    cut_at: datetime | None = None

    @property
    def outcome(self) -> Outcome:
        """Returns the outcome of all characteristics together."""
        if any(one.judged is not None and one.judged.verdict == "out" for one in self.values):
            return "does not conform"
        return "conforms" if self.values and all(one.proven for one in self.values) else "not certified"


def certified(
    part: Part, asked: Sequence[Asked], seen: Sequence[Seen], stated_u: float | None
) -> tuple[Certified, ...]:
    """Certifies each requested characteristic, by the latest inspection that has it: of a released part, where there is
    one.

    `stated_u`, mm: the standard uncertainty of readings that state none. Raises MON-NONE where nothing was measured.
    """
    if not any(one.inspection.readings for one in seen):
        raise Code.MON_NONE.refusal(
            f"part {part.serial!r} has {len(seen)} inspections after its finish cut in the store, 0 of them with sizes",
            hint="`trueloop series add` takes inspection files; a certificate says nothing that was not measured",
            values={"characteristic": part.serial},
        )
    return tuple(_certified(one, seen, stated_u) for one in asked)


def asked_of(inspections: Iterable[Inspection]) -> tuple[Asked, ...]:
    """Returns the characteristics that all inspections of a part type request together: the latest nominal and limits
    of each.

    A coordinate without limits says where a feature was measured, and is not requested.
    """
    found: dict[str, Asked] = {}
    for inspection in inspections:
        for one in inspection.readings:
            limited = _limits(one) != (None, None)
            if one.characteristic and (limited or (one.nominal is not None and one.quantity is not Quantity.POSITION)):
                found[one.characteristic] = Asked(one.characteristic, one.quantity, one.nominal, *_limits(one))
    return tuple(found.values())


def _limits(one: Reading) -> tuple[float | None, float | None]:
    return one.lower_limit, one.upper_limit


def _certified(asked: Asked, seen: Sequence[Seen], stated_u: float | None) -> Certified:
    by, readings = _latest(asked.name, seen)
    actual = fmean(one.actual for one in readings) if readings else None
    u = max((one.standard_u for one in readings if one.standard_u is not None), default=None)
    if u is None and asked.quantity is not Quantity.ANGLE:
        u = stated_u
    temperature = _temperature(readings, by)
    missing = tuple(_missing(asked, actual, u, by))
    unlimited = asked.lower is None and asked.upper is None
    judged = None if actual is None or u is None or unlimited else judge(actual, u, None, asked.lower, asked.upper)
    expanded = None if u is None or actual is None else COVERAGE * u
    remarks = tuple(_remarks(by, temperature)) if readings else ()
    return Certified(asked, actual, expanded, judged, len(readings), by, temperature, missing, remarks)


def _latest(name: str, seen: Sequence[Seen]) -> tuple[Seen | None, tuple[Reading, ...]]:
    """Returns the readings of the latest inspection that has the characteristic: a released part's first."""
    ordered = sorted(seen, key=lambda one: bool(one.released))  # stable: later ones stay later
    for one in reversed(ordered):
        own = tuple(each for each in one.inspection.readings if each.characteristic == name)
        if own:
            return one, own
    return None, ()


def _temperature(readings: Sequence[Reading], by: Seen | None) -> float | None:
    """Returns the part's temperature when measured: that of the readings, else of the inspection's only sensor."""
    own = [one.temperature_c for one in readings if one.temperature_c is not None]
    if own:
        return fmean(own)
    of_all = () if by is None else tuple(by.inspection.temperatures.values())
    return of_all[0] if len(of_all) == 1 else None


def _missing(asked: Asked, actual: float | None, u: float | None, by: Seen | None) -> Iterator[str]:
    if actual is None:
        yield wording("it was not measured on this part")
        return
    if asked.lower is None and asked.upper is None:
        yield wording("no limit is stated")
    if u is None:
        yield wording("no uncertainty is stated")
    if by is not None and not by.inspection.device:
        yield wording("the device is not stated")


def on_the_machine(inspection: Inspection) -> bool:
    """Returns whether the part was measured by the probe of the machine: in the machine's frame, by a device named so,
    or by touches of an unnamed ball.
    """
    device = inspection.device.casefold()
    by_probe = device.startswith("probe") if device else inspection.ball_radius_mm > 0.0
    return inspection.frame == "machine" or by_probe


def _remarks(by: Seen | None, temperature: float | None) -> Iterator[str]:
    """Yields remarks that do not forbid a certificate, but that its reader has to know."""
    if temperature is None:
        yield wording("temperature not stated")
    elif abs(temperature - STANDARD_C) > NEAR_K:
        yield wording("measured at {t:.1f} °C, not at 20 °C", t=temperature)
    if by is not None and by.inspection.measured_at is None:
        yield wording("time of measuring not stated")
    if by is not None and by.released is False and on_the_machine(by.inspection):
        yield wording("measured on the machine that cut it, which does not see its own errors")
