"""Columns of text as numbers in mm and degrees, with the symbols and units that stand in the cells."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Unit
from trueloop.formats.inspections.shared.text import NUMBER, number_in
from trueloop.formats.inspections.tables.long import Long
from trueloop.formats.inspections.tables.roles import ANGLE_DEG, LENGTH_MM, Role, unit_named

PLAIN: Final = frozenset("0123456789+-.,eE")
DRESSED: Final = re.compile(rf"([ØøR⌀∅±n]?)\s*({NUMBER.pattern})\s*(\S*(?: \S+)?)")
BOTH: Final = re.compile(rf"\+?\s*({NUMBER.pattern})\s*[/|;]?\s*([-−+]\s*(?:{NUMBER.pattern})|0(?:[.,]0*)?)")
Where = Callable[[int], Place]


@dataclass(frozen=True)
class Numbers:
    """Numbers, (n,), nan where a cell states nothing; units and symbols that stood in cells, by row."""

    values: Array
    units: dict[int, str]
    symbols: dict[int, str]


def numbers_of(texts: Sequence[str], where: Where) -> Numbers:
    """Reads a column of numbers, each with a decimal point or comma. Raises MSR-NUMBER for a text that is none."""
    if set().union(*set(texts)) <= PLAIN:
        try:
            values = np.array([float(text.replace(",", ".")) if text else np.nan for text in texts])
            if not np.any(np.isinf(values)):
                return Numbers(values, {}, {})
        except ValueError:
            pass
    units: dict[int, str] = {}
    symbols: dict[int, str] = {}
    found = np.full(len(texts), np.nan)
    for row, text in enumerate(texts):
        if text:
            found[row] = _dressed(text.replace("−", "-"), row, where, units, symbols)
    return Numbers(found, units, symbols)


def _dressed(text: str, row: int, where: Where, units: dict[int, str], symbols: dict[int, str]) -> float:
    """A number with what stands before and after it."""
    match, place = DRESSED.fullmatch(text), where(row)
    number = text
    if match is not None and (not match[3] or unit_named(match[3])):
        number = match[2]
        if match[1]:
            symbols[row] = match[1]
        if match[3]:
            units[row] = unit_named(match[3])
    return number_in(number, Path(place.file or ""), place.line or 0, place.column)


def tolerances_of(texts: Sequence[str]) -> tuple[Array, Array, list[int]]:
    """Returns lower and upper tolerance of cells such as `±0.02`, `+0.02/-0.01`, (n,) each, and other cells' rows."""
    lower, upper = np.full(len(texts), np.nan), np.full(len(texts), np.nan)
    other = []
    for row, text in enumerate(texts):
        plus_minus = re.fullmatch(rf"(?:±|\+\s*/?\s*-)\s*({NUMBER.pattern})", text)
        both = BOTH.fullmatch(text)
        if plus_minus:
            upper[row] = _float(plus_minus[1])
            lower[row] = -upper[row]
        elif both:
            ends = _float(both[1]), _float(both[2])
            lower[row], upper[row] = min(ends), max(ends)
        elif text:
            other.append(row)
    return lower, upper, other


def _float(text: str) -> float:
    return float(text.replace(",", ".").replace("−", "-").replace(" ", ""))


def factor_of(unit: str, is_angle: bool) -> float | None:
    """Returns the factor from that unit to mm, or of an angle to degrees; None: no unit of it."""
    return ANGLE_DEG.get(unit, 1.0 if unit in LENGTH_MM else None) if is_angle else LENGTH_MM.get(unit)


def unit_refusal(file: str, why: str, place: Place) -> TrueloopError:
    """Returns the error MSR-UNIT."""
    return Code.MSR_UNIT.refusal(
        why,
        hint='state it: `--unit mm` or `--unit inch`, or unit = "mm" in the mapping',
        place=place,
        values={"file": file},
    )


def lengths_of(long: Long, role: Role, unit: Unit | None) -> Array:
    """Reads a column of lengths in mm, (n,), nan where not stated. Raises MSR-UNIT where its unit is stated nowhere."""
    numbers = numbers_of(long.texts[role], long.where(role))
    return numbers.values * length_factor(long, role, numbers, unit)


def length_factor(long: Long, role: Role, numbers: Numbers, unit: Unit | None) -> float:
    """Millimetres in the unit of a column of lengths."""
    own = long.units.get(role) or unit_of_cells(long, role, numbers) or unit
    factor = LENGTH_MM.get(own or "")
    if factor is None:
        raise no_unit(long, role, 0, own or "")
    return factor


def unit_of_cells(long: Long, role: Role, numbers: Numbers) -> str:
    """Returns the unit in the cells of a column, empty without one. Raises MSR-UNIT for several."""
    found = sorted(set(numbers.units.values()))
    if len(found) > 1:
        row = next(iter(numbers.units))
        why = f"the {role} is in {' and '.join(found)} in one column"
        raise unit_refusal(long.grid.path.name, why, long.place(role, row))
    return found[0] if found else ""


def no_unit(long: Long, role: Role, row: int, own: str) -> TrueloopError:
    """Returns the refusal MSR-UNIT of a column whose unit is not known."""
    name = long.grid.path.name
    why = f"{own!r} is no unit of length" if own else f"the unit of {role} is stated nowhere in {name!r}"
    return unit_refusal(name, why, long.place(role, row))
