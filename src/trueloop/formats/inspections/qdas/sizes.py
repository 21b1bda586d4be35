"""What the characteristics of a Q-DAS file are: quantity, unit, nominal and limits."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Remark, Stated
from trueloop.formats.inspections.qdas.fields import Fields
from trueloop.formats.inspections.shared.quantities import quantity_in
from trueloop.formats.inspections.shared.text import number_in

MM: Final = {
    **dict.fromkeys(("mm", "millimeter", "millimetre"), 1.0),
    **dict.fromkeys(("cm", "zentimeter", "centimeter"), 10.0),
    **dict.fromkeys(("m", "meter"), 1000.0),
    **dict.fromkeys(("µm", "μm", "um", "mikrometer", "micrometer", "my"), 0.001),
    **dict.fromkeys(("inch", "in", '"', "zoll", "''"), 25.4),
    "mil": 0.0254,
}
"""Millimetres in the units of length of K2142."""
DEGREES: Final = {
    **dict.fromkeys(("°", "deg", "degree", "degrees", "grad", "º"), 1.0),
    **dict.fromkeys(("'", "min", "′"), 1.0 / 60.0),
    "rad": math.degrees(1.0),
    "gon": 0.9,
}
DIAMETER: Final = "202"
"""K2009 of a diameter, as in files that say so in words too; other numbers of that field are not relied on."""
NATURAL: Final = "2"


@dataclass(frozen=True, slots=True)
class Size:
    """One characteristic; `factor` takes its numbers to mm or degrees."""

    characteristic: Characteristic | None
    name: str
    quantity: Quantity
    factor: float
    nominal: float | None
    lower_limit: float | None
    upper_limit: float | None


def sizes_of(fields: Fields, path: Path, stated: Stated) -> tuple[Mapping[int, Size], list[Remark]]:
    """The variable characteristics by their numbers. Raises MSR-COUNTED where there are none, MSR-UNIT, MSR-NUMBER."""
    sizes, remarks, counted = {}, list[Remark](), []
    for index in sorted(fields.part_of):
        line = fields.lines.get(("2002", index), fields.lines.get(("2001", index)))
        name = fields.of(index, "2002") or fields.of(index, "2001") or f"characteristic {index}"
        if (kind := fields.of(index, "2004") or "0") != "0":
            counted.append((index, name, kind))
            continue
        unit = fields.of(index, "2142")
        if unit and unit.lower() not in MM and unit.lower() not in DEGREES:
            remarks.append(Remark(f"{name!r} is in {unit!r}, no length or angle: left out", line))
            continue
        sizes[index] = _size(fields, index, name, path, stated)
    for index, name, kind in counted:
        place = fields.lines.get(("2004", index))
        if not sizes:
            raise _counted(path, place, name, kind)
        remarks.append(Remark(f"{name!r} has K2004 {kind}: it counts, it measures no size: left out", place))
    return sizes, remarks


def _size(fields: Fields, index: int, name: str, path: Path, stated: Stated) -> Size:
    unit = fields.of(index, "2142").lower()
    quantity = _quantity(fields, index, name, unit)
    factor = DEGREES[unit] if quantity is Quantity.ANGLE else _mm(unit, path, fields, index, stated)
    numbers = {key: _number(fields, index, key, factor, path) for key in ("2101", "2110", "2111", "2112", "2113")}
    nominal = numbers["2101"]
    lower, upper = (
        None if fields.of(index, natural) == NATURAL else _limit(numbers[absolute], numbers[relative], nominal)
        for natural, absolute, relative in (("2120", "2110", "2112"), ("2121", "2111", "2113"))
    )
    asked = None if nominal is None else Characteristic(name, quantity, "", nominal, lower, upper)
    return Size(asked, name, quantity, factor, nominal, lower, upper)


def _limit(absolute: float | None, relative: float | None, nominal: float | None) -> float | None:
    """K2110 and K2111 are absolute, K2112 and K2113 are allowances on the nominal."""
    if absolute is not None or relative is None or nominal is None:
        return absolute
    return nominal + relative


def _quantity(fields: Fields, index: int, name: str, unit: str) -> Quantity:
    """By the unit, the short name where it is one of our words, the measured quantity, the name; else other."""
    if unit in DEGREES:
        return Quantity.ANGLE
    short = fields.of(index, "2003")
    if short in set(Quantity):
        return Quantity(short)
    if fields.of(index, "2009") == DIAMETER:
        return Quantity.DIAMETER
    said = (quantity for text in (name, short) if (quantity := quantity_in(text)) is not None)
    found = next(said, Quantity.OTHER)
    return Quantity.OTHER if found is Quantity.ANGLE else found  # in a unit of length


def _mm(unit: str, path: Path, fields: Fields, index: int, stated: Stated) -> float:
    if unit:
        return MM[unit]
    if stated.unit is not None:
        return MM[stated.unit]
    raise TrueloopError(
        Code.MSR_UNIT,
        f"characteristic {index} of {path.name!r} has no unit (K2142)",
        hint="state the unit: `--unit mm` or `--unit inch`",
        place=Place(str(path), fields.lines.get(("2101", index)) or fields.lines.get(("2001", index))),
        values={"file": path.name},
    )


def _number(fields: Fields, index: int, key: str, factor: float, path: Path) -> float | None:
    text = fields.of(index, key)
    return factor * number_in(text, path, fields.lines.get((key, index), 1)) if text else None


def _counted(path: Path, line: int | None, name: str, kind: str) -> TrueloopError:
    return TrueloopError(
        Code.MSR_COUNTED,
        f"{path.name!r} counts and measures no size: characteristic {name!r} has K2004 {kind}",
        hint="name a file of measured values: K2004 is 0, or missing",
        place=Place(str(path), line),
        values={"file": path.name},
    )
