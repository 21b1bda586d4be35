"""A Q-DAS file read: the n-th values of the characteristics of a part are one piece, and one inspection."""

import hashlib
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from datetime import datetime
from functools import lru_cache
from pathlib import Path
from typing import Final

from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, Stated, Unit
from trueloop.formats.inspections.qdas.fields import Column, Fields, fields_of
from trueloop.formats.inspections.qdas.sizes import MM, Size, sizes_of
from trueloop.formats.inspections.shared.checks import Said, filled_in
from trueloop.formats.inspections.shared.text import number_in, read_decoded

PLAN, VALUES = ".dfd", ".dfx"
PARTNER: Final = {PLAN: VALUES, VALUES: PLAN}
BEGINNING: Final = re.compile(rb"(?:\xef\xbb\xbf|\xff\xfe|\xfe\xff)?\s*K\d{4}(?:/\d+)?[ \t\r\n]")
VALID, EMPTY = "0", "255"
NO_TIME: Final = datetime(1970, 1, 1)
TIMES: Final = ("%d.%m.%Y/%H:%M:%S", "%d.%m.%y/%H:%M:%S", "%d.%m.%Y/%H:%M", "%d.%m.%Y %H:%M:%S", "%d.%m.%Y")


def read_qdas(path: Path, stated: Stated) -> MeasuredFile:
    """A `.dfq`, or the pair that a `.dfd` or `.dfx` belongs to, in mm and degrees, one inspection for each piece.

    Raises MSR-COUNTED for what is counted and not measured, MSR-UNIT for a length without a unit that nobody states,
    MSR-FILE, MSR-VALUE and MSR-NUMBER, each with the line.
    """
    files = _pair(path)
    texts = [read_decoded(each) for each in files]
    fields = fields_of(iter(zip(files, (text for text, _ in texts), strict=True)))
    sizes, remarks = sizes_of(fields, path, stated)
    said = Said()
    sha256 = hashlib.sha256(b"".join(each.read_bytes() for each in files)).hexdigest()
    inspections = tuple(_inspections(fields, sizes, files[-1], sha256, said))
    remarks += said.remarks()
    remarks += [Remark("fields of a value stand before any value: left out", line) for line in fields.unplaced[:1]]
    if fields.again:
        key, line = fields.again[0]
        remarks.append(Remark(f"{len(fields.again)} fields are stated twice, first {key}: the last counts", line))
    return MeasuredFile(
        path,
        "Q-DAS (AQDEF)",
        texts[0][1],
        _unit(fields, sizes, stated),
        inspections,
        tuple(size.characteristic for size in sizes.values() if size.characteristic is not None),
        (*remarks, *filled_in(inspections)),
    )


def _pair(path: Path) -> tuple[Path, ...]:
    """Plan and values, whichever of them is named, in whatever case; another file is whole."""
    suffix = PARTNER.get(path.suffix.lower())
    if suffix is None:
        return (path,)
    partner = next((one for one in _beside(path) if one.name.lower() == path.with_suffix(suffix).name.lower()), None)
    if partner is None:
        raise TrueloopError(
            Code.MSR_FILE,
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


def _unit(fields: Fields, sizes: Mapping[int, Size], stated: Stated) -> Unit | None:
    """The unit of all lengths, where they have one and it is mm or inch."""
    factors = {size.factor for index, size in sizes.items() if fields.of(index, "2142").lower() in MM}
    if len(factors) > 1:
        return None
    factor = next(iter(factors), None)
    return stated.unit if factor is None else "mm" if factor == 1.0 else "inch" if factor == MM["inch"] else None


def _inspections(
    fields: Fields, sizes: Mapping[int, Size], path: Path, sha256: str, said: Said
) -> Iterator[Inspection]:
    of_part: defaultdict[int, list[int]] = defaultdict(list)
    for index, part in fields.part_of.items():
        if index in sizes and index in fields.values:
            of_part[part].append(index)
    for part, indices in of_part.items():
        columns = [fields.values[index] for index in indices]
        count = max(len(column.values) for column in columns)
        if any(len(column.values) != count for column in columns):
            said.add("parts have characteristics with different counts of values: the n-th are one piece", None)
        name = fields.of_part(part, "1001") or fields.of_part(part, "1002")
        part_type = PartType(name, fields.of_part(part, "1004"))
        device, operator = fields.of_part(part, "1202"), fields.of_part(part, "1222")
        asked = [sizes[index] for index in indices]
        for number in range(count):
            readings = tuple(_readings(asked, columns, number, path, said))
            if readings:
                times = (one.measured_at for one in readings if one.measured_at is not None)
                yield Inspection(
                    Part(part_type, _serial(columns, number, said)),
                    "readings",
                    sha256,
                    len(readings),
                    readings,
                    device=device,
                    operator=operator,
                    measured_at=next(times, None),
                )


def _readings(sizes: list[Size], columns: list[Column], number: int, path: Path, said: Said) -> Iterator[Reading]:
    """The valid values of one piece."""
    for size, column in zip(sizes, columns, strict=True):
        if number >= len(column.values):
            continue
        value, attribute, line = column.values[number], column.attributes[number], column.lines[number]
        if attribute != VALID or not value:
            if attribute not in {VALID, EMPTY}:
                said.add(f"values with attribute {attribute} are not valid: left out", line)
            continue
        yield Reading(
            size.name,
            size.quantity,
            size.factor * number_in(value, path, line),
            size.nominal,
            size.lower_limit,
            size.upper_limit,
            measured_at=_time(column.times[number]),
            line=line,
        )


def _serial(columns: list[Column], number: int, said: Said) -> str:
    """That of a piece; empty where its values state none, or different ones."""
    serials = {column.serials[number] for column in columns if number < len(column.serials)} - {""}
    if len(serials) > 1:
        said.add("values of one piece have different serial numbers: it has none", None)
    return serials.pop() if len(serials) == 1 else ""


@lru_cache(maxsize=4096)
def _time(text: str) -> datetime | None:
    """A local time; None for none, for 01.01.1970, and for what is no time."""
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
