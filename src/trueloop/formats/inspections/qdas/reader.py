"""A Q-DAS file read: the n-th values of the characteristics of a part are one piece, and one inspection."""

import hashlib
import math
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import lru_cache
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts, Unit
from trueloop.formats.inspections.qdas.fields import Column, Fields, fields_of
from trueloop.formats.inspections.shared.checks import RemarkCounts, devices_of, filled_in
from trueloop.formats.inspections.shared.quantities import quantity_in
from trueloop.formats.inspections.shared.text import number_in, read_decoded

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


def sizes_of(fields: Fields, path: Path, stated: StatedFacts) -> tuple[Mapping[int, Size], list[Remark]]:
    """Returns the variable characteristics by number. Raises MSR-COUNTED where there are none, MSR-UNIT, MSR-NUMBER."""
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


def _size(fields: Fields, index: int, name: str, path: Path, stated: StatedFacts) -> Size:
    unit = fields.of(index, "2142").lower()
    quantity = _quantity(fields, index, name, unit)
    factor = DEGREES[unit] if quantity is Quantity.ANGLE else _mm(unit, path, fields, index, stated)
    numbers = {key: _number(fields, index, key, factor, path) for key in ("2101", "2110", "2111", "2112", "2113")}
    nominal = numbers["2101"]
    lower, upper = (
        None if fields.of(index, natural) == NATURAL else _limit(numbers[absolute], numbers[relative], nominal)
        for natural, absolute, relative in (("2120", "2110", "2112"), ("2121", "2111", "2113"))
    )
    asked = (
        None
        if nominal is None
        else Characteristic(
            name=name, quantity=quantity, feature="", nominal=nominal, lower_limit=lower, upper_limit=upper
        )
    )
    return Size(
        characteristic=asked,
        name=name,
        quantity=quantity,
        factor=factor,
        nominal=nominal,
        lower_limit=lower,
        upper_limit=upper,
    )


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


def _mm(unit: str, path: Path, fields: Fields, index: int, stated: StatedFacts) -> float:
    if unit:
        return MM[unit]
    if stated.unit is not None:
        return MM[stated.unit]
    raise Code.MSR_UNIT.refusal(
        f"characteristic {index} of {path.name!r} has no unit (K2142)",
        hint="state the unit: `--unit mm` or `--unit inch`",
        place=Place(str(path), fields.lines.get(("2101", index)) or fields.lines.get(("2001", index))),
    )


def _number(fields: Fields, index: int, key: str, factor: float, path: Path) -> float | None:
    text = fields.of(index, key)
    return factor * number_in(text, path, fields.lines.get((key, index), 1)) if text else None


def _counted(path: Path, line: int | None, name: str, kind: str) -> TrueloopError:
    return Code.MSR_COUNTED.refusal(
        f"{path.name!r} counts and measures no size: characteristic {name!r} has K2004 {kind}",
        hint="name a file of measured values: K2004 is 0, or missing",
        place=Place(str(path), line),
    )


PLAN, VALUES = ".dfd", ".dfx"
PARTNER: Final = {PLAN: VALUES, VALUES: PLAN}
BEGINNING: Final = re.compile(rb"(?:\xef\xbb\xbf|\xff\xfe|\xfe\xff)?\s*K\d{4}(?:/\d+)?[ \t\r\n]")
VALID, EMPTY = "0", "255"
NO_TIME: Final = datetime(1970, 1, 1)
TIMES: Final = ("%d.%m.%Y/%H:%M:%S", "%d.%m.%y/%H:%M:%S", "%d.%m.%Y/%H:%M", "%d.%m.%Y %H:%M:%S", "%d.%m.%Y")


def read_qdas(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads a `.dfq`, or the pair of a `.dfd` or `.dfx`, in mm and degrees, one inspection for each piece.

    Raises MSR-COUNTED for what is counted and not measured, MSR-UNIT for a length whose unit is not stated,
    MSR-FILE, MSR-VALUE and MSR-NUMBER, each with the line.
    """
    files = _pair(path)
    texts = [read_decoded(each) for each in files]
    fields = fields_of(iter(zip(files, (text for text, _ in texts), strict=True)))
    sizes, remarks = sizes_of(fields, path, stated)
    said = RemarkCounts()
    sha256 = hashlib.sha256(b"".join(each.read_bytes() for each in files)).hexdigest()
    inspections = tuple(_inspections(fields, sizes, files[-1], sha256, said))
    remarks += said.remarks()
    remarks += [Remark("fields of a value stand before any value: left out", line) for line in fields.unplaced[:1]]
    if fields.again:
        key, line = fields.again[0]
        remarks.append(Remark(f"{len(fields.again)} fields are stated twice, first {key}: the last counts", line))
    return MeasuredFile(
        path=path,
        format="Q-DAS (AQDEF)",
        encoding=texts[0][1],
        unit=_unit(fields, sizes, stated),
        inspections=inspections,
        characteristics=tuple(size.characteristic for size in sizes.values() if size.characteristic is not None),
        remarks=(*remarks, *filled_in(inspections)),
    )


def _pair(path: Path) -> tuple[Path, ...]:
    """Plan and values, whichever of them is named, in whatever case; another file is whole."""
    suffix = PARTNER.get(path.suffix.lower())
    if suffix is None:
        return (path,)
    partner = next((one for one in _beside(path) if one.name.lower() == path.with_suffix(suffix).name.lower()), None)
    if partner is None:
        raise Code.MSR_FILE.refusal(
            f"{path.name!r} is half of a pair: there is no {path.with_suffix(suffix).name!r} beside it",
            hint="put plan (.dfd) and values (.dfx) of one name into one folder",
            place=Place(str(path)),
        )
    return (path, partner) if suffix == VALUES else (partner, path)


def _beside(path: Path) -> list[Path]:
    try:
        return sorted(path.parent.iterdir())
    except OSError:
        return []


def _unit(fields: Fields, sizes: Mapping[int, Size], stated: StatedFacts) -> Unit | None:
    """The unit of all lengths, where they have one and it is mm or inch."""
    factors = {size.factor for index, size in sizes.items() if fields.of(index, "2142").lower() in MM}
    if len(factors) > 1:
        return None
    factor = next(iter(factors), None)
    return stated.unit if factor is None else "mm" if factor == 1.0 else "inch" if factor == MM["inch"] else None


def _inspections(
    fields: Fields, sizes: Mapping[int, Size], path: Path, sha256: str, remarks: RemarkCounts
) -> Iterator[Inspection]:
    of_part: defaultdict[int, list[int]] = defaultdict(list)
    for index, part in fields.part_of.items():
        if index in sizes and index in fields.values:
            of_part[part].append(index)
    for part, indices in of_part.items():
        columns = [fields.values[index] for index in indices]
        count = max(len(column.values) for column in columns)
        if any(len(column.values) != count for column in columns):
            remarks.add("parts have characteristics with different counts of values: the n-th are one piece", None)
        name = fields.of_part(part, "1001") or fields.of_part(part, "1002")
        part_type = PartType(name, fields.of_part(part, "1004"))
        of_all, operator = fields.of_part(part, "1202"), fields.of_part(part, "1222")
        own = {sizes[index].name: fields.of(index, "2402") for index in indices}
        by = {one: text.split(", ") if text else [of_all] for one, text in own.items()}
        asked = [sizes[index] for index in indices]
        for number in range(count):
            readings = tuple(_readings(asked, columns, number, path, remarks))
            if readings:
                measured = [
                    (reading.characteristic, name) for reading in readings for name in by[reading.characteristic]
                ]
                times = (reading.measured_at for reading in readings if reading.measured_at is not None)
                yield Inspection(
                    Part(part_type, _serial(columns, number, remarks)),
                    "readings",
                    sha256,
                    len(readings),
                    readings,
                    device=", ".join(dict.fromkeys(name for _, name in measured if name)),
                    devices=devices_of(measured),
                    operator=operator,
                    measured_at=next(times, None),
                )


def _readings(
    sizes: list[Size], columns: list[Column], number: int, path: Path, remarks: RemarkCounts
) -> Iterator[Reading]:
    """The valid values of one piece."""
    for size, column in zip(sizes, columns, strict=True):
        if number >= len(column.values):
            continue
        value, attribute, line = column.values[number], column.attributes[number], column.lines[number]
        if attribute != VALID or not value:
            if attribute not in {VALID, EMPTY}:
                remarks.add(f"values with attribute {attribute} are not valid: left out", line)
            continue
        yield Reading(
            characteristic=size.name,
            quantity=size.quantity,
            actual=size.factor * number_in(value, path, line),
            nominal=size.nominal,
            lower_limit=size.lower_limit,
            upper_limit=size.upper_limit,
            measured_at=_time(column.times[number]),
            line=line,
        )


def _serial(columns: list[Column], number: int, remarks: RemarkCounts) -> str:
    """That of a piece; empty where its values state none, or different ones."""
    serials = {column.serials[number] for column in columns if number < len(column.serials)} - {""}
    if len(serials) > 1:
        remarks.add("values of one piece have different serial numbers: it has none", None)
    return serials.pop() if len(serials) == 1 else ""


@lru_cache(maxsize=4096)
def _time(text: str) -> datetime | None:
    """A local time; None for none, for 01.01.1970, and for anything that is not a time."""
    for form in TIMES if text else ():
        try:
            found = datetime.strptime(text, form)
        except ValueError:
            continue
        return None if found == NO_TIME else found
    return None


def _recognises(path: Path, head: bytes) -> bool:
    """By a first line that is a K field; values apart from their plan by the name of their file."""
    return bool(BEGINNING.match(head.replace(b"\0", b""))) or path.suffix.lower() == VALUES


FORMAT: Final = Format("Q-DAS (AQDEF)", _recognises, read_qdas)
