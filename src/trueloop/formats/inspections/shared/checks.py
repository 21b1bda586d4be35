"""Checks for all readers: values that an inspection file states twice agree, and every value was measured.

Each check gives one remark for all its cases, with the count and the line of the first.
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.errors import Code, Place
from trueloop.formats.inspections.measured_file import Remark

SLACK: Final = 1e-9
"""Below this two numbers are equal: what a decimal loses in binary, far below any gauge's resolution."""
ENOUGH: Final = 2
"""One diameter may be exactly nominal by chance."""


class RemarkCounts:
    """Remarks on a file, each once for all that it applies to: how often each text applies, and where first."""

    def __init__(self) -> None:
        """Starts without remarks."""
        self._texts: dict[str, tuple[int, int | None]] = {}

    def add(self, text: str, line: int | None, count: int = 1) -> None:
        """Counts further occurrences of a remark."""
        before, first = self._texts.get(text, (0, line))
        self._texts[text] = before + count, first

    def remarks(self) -> tuple[Remark, ...]:
        """Returns one remark for each text."""
        return tuple(Remark(f"{text} ({count} in all)", line) for text, (count, line) in self._texts.items())


def half_digits(*numbers: str) -> float:
    """Returns the deviation that rounding gives a sum of printed numbers at most: half of the last digit of each, of
    an empty one 0.

    >>> half_digits("4.530", "4,5")
    0.0505
    """
    return sum(float(f"5e{-_decimals(number) - 1}") for number in numbers if number)


def _decimals(number: str) -> int:
    mantissa, _, exponent = number.strip().lower().partition("e")
    places = len(mantissa.replace(",", ".").partition(".")[2])
    return places - (int(exponent) if exponent.lstrip("+-").isdecimal() else 0)


def devices_of(measured: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Returns the devices by characteristic, of pairs of both; nothing where all are measured by a single device."""
    found: defaultdict[str, dict[str, None]] = defaultdict(dict)
    for characteristic, device in measured:
        found[characteristic][device] = None
    of = {name: listed(devices) for name, devices in found.items()}
    return of if len(set(of.values())) > 1 else {}


def listed(names: Iterable[str]) -> str:
    """Returns the names that are stated, each once, with commas."""
    return ", ".join(filter(None, dict.fromkeys(names)))


def require_serials(serials: Sequence[str], place: Callable[[int], Place]) -> None:
    """Raises MSR-SERIAL where some readings state a serial number and others none: of which part these are is open."""
    stated = sorted(set(serials) - {""})
    without = [k for k, serial in enumerate(serials) if not serial]
    if stated and without:
        raise Code.MSR_SERIAL.refusal(
            f"{len(without)} of {len(serials)} readings state no serial number, the others {stated[0]!r}"
            + (f" and {len(stated) - 1} more" if len(stated) > 1 else ""),
            hint="write the serial number in every row, also where it is that of the row above",
            place=place(without[0]),
            values={"serials": stated[:20]},
        )


def stated_deviations(stated: Iterable[tuple[Reading, float, float]]) -> tuple[Remark, ...]:
    """Deviations as a file states them against actual − nominal: (reading, deviation, allowed rounding), mm or degrees.

    What is kept is the reading: a deviation that the file states otherwise is reported with how the two relate.
    """
    found: defaultdict[str, list[tuple[Reading, float]]] = defaultdict(list)
    count = 0
    for reading, deviation, rounding in stated:
        if reading.nominal is not None:
            count += 1
            if relation := _relation(reading, reading.actual - reading.nominal, deviation, rounding + SLACK):
                found[relation].append((reading, deviation))
    return tuple(_of_deviations(relation, cases, count) for relation, cases in found.items())


def by_reading(stated: Iterable[tuple[Reading, float, float]]) -> dict[tuple[int | None, str], tuple[float, float]]:
    """Returns stated deviations and their roundings by line and characteristic, to be compared on the part."""
    return {(reading.line, reading.characteristic): (deviation, rounding) for reading, deviation, rounding in stated}


def _relation(reading: Reading, computed: float, stated: float, rounding: float) -> str:
    """How a stated deviation differs from the computed one; empty: it does not."""
    if abs(stated - computed) <= rounding:
        return ""
    if abs(stated + computed) <= rounding:
        return "counted the other way, nominal − actual"
    if reading.quantity is Quantity.DIAMETER and abs(2.0 * stated - computed) <= 2.0 * rounding:
        return "half of it, that of the radius"
    return "not that"


def _of_deviations(relation: str, cases: Sequence[tuple[Reading, float]], count: int) -> Remark:
    reading, stated = cases[0]
    computed = reading.actual - (reading.nominal or 0.0)
    unit = reading.quantity.unit
    return Remark(
        f"{len(cases)} of {count} deviations are {relation}: {reading.characteristic!r} deviates by {computed:+.6g} "
        f"{unit}, the file states {stated:+.6g}; actual − nominal is taken",
        reading.line,
    )


def stated_verdicts(stated: Iterable[tuple[Reading, bool]]) -> tuple[Remark, ...]:
    """Verdicts as a file states them (true: within its limits) against those of its own values and limits."""
    wrong = [(reading, passed) for reading, passed in stated if within(reading) is (not passed)]
    if not wrong:
        return ()
    reading, passed = wrong[0]
    words = "inside" if passed else "outside"
    return (
        Remark(
            f"{len(wrong)} verdicts are not those of the values: {reading.characteristic!r} is stated as {words} its "
            f"limits, {reading.actual:.6g} in {_limits(reading)} {reading.quantity.unit}",
            reading.line,
        ),
    )


def within(reading: Reading) -> bool | None:
    """Returns whether a reading is within its limits, both included; None where it has none, or is signed with one."""
    if reading.lower_limit is None and (reading.upper_limit is None or _is_signed(reading)):
        return None
    above = reading.lower_limit is None or reading.actual >= reading.lower_limit - SLACK
    return above and (reading.upper_limit is None or reading.actual <= reading.upper_limit + SLACK)


def _limits(reading: Reading) -> str:
    lower, upper = ("" if limit is None else f"{limit:.6g}" for limit in (reading.lower_limit, reading.upper_limit))
    return f"[{lower}, {upper}]"


def numbered(readings: Iterable[Reading]) -> tuple[Reading, ...]:
    """Returns the readings of one part, those of one characteristic, feature and axis numbered by `repeat` from 1."""
    seen: Counter[tuple[str, str, str]] = Counter()
    out = []
    for reading in readings:
        key = reading.characteristic, reading.feature, reading.axis
        seen[key] += 1
        out.append(reading if reading.repeat == seen[key] else replace(reading, repeat=seen[key]))
    return tuple(out)


def filled_in(inspections: Sequence[Inspection]) -> tuple[Remark, ...]:
    """Parts of which every diameter, two or more, is exactly its nominal: filled in; and forms that are below 0."""
    remarks = [remark for inspection in inspections if (remark := _filled_in(inspection)) is not None]
    if signed := [reading for inspection in inspections for reading in inspection.readings if _is_signed(reading)]:
        text = f"{len(signed)} forms and runouts are below 0: {signed[0].characteristic!r} is {signed[0].actual:.6g} mm"
        remarks.append(Remark(f"{text}, a signed deviation, which an upper limit alone does not judge", signed[0].line))
    return tuple(remarks)


def _is_signed(reading: Reading) -> bool:
    """A profile's deviation towards the material is counted negative by some reports: it uses half of the zone."""
    return reading.quantity.is_zone and reading.actual < 0


def _filled_in(inspection: Inspection) -> Remark | None:
    diameters = 0
    for reading in inspection.readings:
        if reading.quantity is Quantity.DIAMETER and reading.nominal is not None:
            if reading.actual != reading.nominal:
                return None
            diameters += 1
    if diameters < ENOUGH:
        return None
    part = f"part {inspection.part.serial!r}" if inspection.part.serial else "one part"
    return Remark(
        f"filled in, not measured: all {diameters} diameters of {part} are exactly nominal", inspection.readings[0].line
    )
