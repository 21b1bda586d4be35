"""Inspections written as a Q-DAS file (`.dfq`): every inspection is a piece, a line of values."""

from collections.abc import Iterator, Sequence
from itertools import count
from typing import Final, TypeAlias

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import PartType
from trueloop.formats.inspections.qdas.fields import BETWEEN_PARTS, BETWEEN_VALUES

UNMEASURED: Final = BETWEEN_PARTS.join(("", "255"))
TIME: Final = "%d.%m.%Y/%H:%M:%S"
Asked: TypeAlias = tuple[str, Quantity, float | None, float | None, float | None, str]
Numbers: TypeAlias = dict[tuple[PartType, str, str], dict[Asked, int]]


def dfq_of(inspections: Sequence[Inspection]) -> bytes:
    """Returns a `.dfq` of the readings of inspections, UTF-8, in mm and degrees.

    A characteristic is one of its part type, device and operator, with its nominal and limits; K2003 has its quantity
    in a word, K2402 its device where an inspection has several. Times are kept to the second. What the format lacks is
    not written: points, names of features, places, uncertainties. Readings repeated within an inspection are pieces of
    their own, with its serial number.
    """
    numbers = _numbered(inspections)
    total = sum(map(len, numbers.values()))
    lines = [f"K0100 {total}", *_plan(numbers)]
    for inspection in inspections:
        for piece in _pieces(inspection):
            lines.extend(_values(inspection, piece, numbers[_group(inspection)], total))
    text = "".join(f"{line}\r\n" for line in lines)
    return text.encode("ascii" if text.isascii() else "utf-8-sig")


def _group(inspection: Inspection) -> tuple[PartType, str, str]:
    """The data that Q-DAS states once for all pieces of a part."""
    return inspection.part.part_type, "" if inspection.devices else inspection.device, inspection.operator


def _asked(inspection: Inspection, reading: Reading) -> Asked:
    """The fields of a characteristic that hold for all of its values; its device where the inspection has several."""
    by = inspection.devices.get(reading.characteristic, "")
    return reading.characteristic, reading.quantity, reading.nominal, reading.lower_limit, reading.upper_limit, by


def _numbered(inspections: Sequence[Inspection]) -> Numbers:
    """Characteristics by part, numbered through in the order in which the file states them."""
    found: Numbers = {}
    for inspection in inspections:
        asked = found.setdefault(_group(inspection), {})
        for reading in inspection.readings:
            asked.setdefault(_asked(inspection, reading), 0)
    number = count(1)
    return {group: {one: next(number) for one in asked} for group, asked in found.items()}


def _plan(numbers: Numbers) -> Iterator[str]:
    for part, ((part_type, device, operator), asked) in enumerate(numbers.items(), 1):
        stated = {"1001": part_type.name, "1004": part_type.revision, "1202": device, "1222": operator}
        yield from (f"K{key}/{part} {_clean(value)}" for key, value in stated.items() if value or key == "1001")
        for one, number in asked.items():
            yield from _characteristic(one, number)


def _characteristic(asked: Asked, number: int) -> Iterator[str]:
    name, quantity, nominal, lower, upper, device = asked
    unit = "°" if quantity is Quantity.ANGLE else "mm"
    for key, text in (("2002", name), ("2003", quantity.value), ("2004", "0"), ("2142", unit)):
        yield f"K{key}/{number} {_clean(text)}"
    if device:
        yield f"K2402/{number} {_clean(device)}"
    for key, value in (("2101", nominal), ("2110", lower), ("2111", upper)):
        if value is not None:
            yield f"K{key}/{number} {value!r}"


def _pieces(inspection: Inspection) -> Iterator[list[Reading]]:
    """Readings of different characteristics, in as many pieces as the most often repeated needs."""
    left = list(inspection.readings)
    while left:
        piece: dict[Asked, Reading] = {}
        rest = []
        for reading in left:
            if piece.setdefault(_asked(inspection, reading), reading) is not reading:
                rest.append(reading)
        yield list(piece.values())
        left = rest


def _values(inspection: Inspection, piece: Sequence[Reading], numbers: dict[Asked, int], total: int) -> Iterator[str]:
    values = [UNMEASURED] * total
    for reading in piece:
        time = "" if reading.measured_at is None else reading.measured_at.strftime(TIME)
        values[numbers[_asked(inspection, reading)] - 1] = BETWEEN_PARTS.join((repr(reading.actual), "0", time))
    yield BETWEEN_VALUES.join(values)
    if inspection.part.serial:
        yield f"K0014/0 {_clean(inspection.part.serial)}"


def _clean(text: str) -> str:
    """On one line, without the characters that separate values."""
    return "".join(one if one >= " " else " " for one in text)
