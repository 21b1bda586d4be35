"""CALYPSO's tables: characteristics (`…_chr.txt`), and the header of the run (`…_hdr.txt`) that lies beside them.

Cells are separated by tabs, the last row says END. Tolerances are counted from the nominal value and have their sign. A
natural limit (2 in `natlowertolid`, `natuppertolid`) is none that a part can fail. Few tables name a unit, in
a column of it. Read in a table of a real run; the names of the columns of `_hdr` are those that programs around it use.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts, Unit
from trueloop.formats.inspections.shared.checks import by_reading, filled_in, half_digits, numbered, stated_deviations
from trueloop.formats.inspections.shared.quantities import AXES, characteristics_of, quantity_of, require_order
from trueloop.formats.inspections.shared.text import beginning, is_empty, moment, number_in, order_of, read_decoded
from trueloop.formats.inspections.tables.headings import LENGTH_MM, unit_named
from trueloop.units import MM_PER_INCH

UNITS: Final[Mapping[float, Unit]] = {1.0: "mm", MM_PER_INCH: "inch"}
NEEDED: Final = ("id", "actual", "nominal")
KIND: Final = re.compile(r"([_-])(chr|hdr|fet)(?=\.\w+$)", re.IGNORECASE)
SYMBOLS: Final = (
    (re.compile(r"gdt\w*run|runout", re.I), Quantity.RUNOUT),
    (re.compile(r"gdt|^form|^sigma|roundness", re.I), Quantity.FORM),
    (re.compile(r"diameter", re.I), Quantity.DIAMETER),
    (re.compile(r"^radius", re.I), Quantity.RADIUS),
    (re.compile(r"angle", re.I), Quantity.ANGLE),
    (re.compile(r"distance", re.I), Quantity.LENGTH),
    (re.compile(r"^[xyz]_?(value|pos|nominal)?$", re.I), Quantity.POSITION),
)
"""Quantities by `idsymbol`; `type` has them in the language of the person who measured."""
USED: Final = frozenset(
    [
        *(*NEEDED, "planid", "partnb", "type", "idsymbol", "unit", "uppertol", "lowertol", "deviation", "featureid"),
        *("natuppertolid", "natlowertolid", "featureposx", "featureposy", "featureposz"),
    ]
)
Row = Mapping[str, str]


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether the first line has names of columns that no other program writes."""
    names = beginning(head).split("\n", 1)[0].lower().strip().split("\t")
    return {"planid", "partnb"} <= set(names) or {*NEEDED, "uppertol", "lowertol"} <= set(names)


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads the parts of a table of characteristics. Raises MSR-UNIT, as the table names no unit, MSR-NUMBER,
    MSR-EXCHANGED, and MSR-MEANING for the header or the features alone.
    """
    text, encoding = read_decoded(path)
    listed = list(_rows(text, USED))
    rows = [(line, row) for line, row in listed if not is_empty(row.get("actual", ""))]
    if not listed or not set(NEEDED) <= listed[0][1].keys():
        beside = KIND.sub(r"\1chr", path.name)
        raise Code.MSR_MEANING.refusal(
            f"{path.name!r} holds no characteristics: {len(listed)} rows without id, actual and nominal",
            hint=f"name the table of characteristics, {beside!r}",
            place=Place(str(path), 1),
        )
    named = {factor for _, row in listed if (factor := LENGTH_MM.get(unit_named(row.get("unit", ""))))}
    unit = UNITS.get(next(iter(named))) if len(named) == 1 else None
    overruled = unit is not None and stated.unit not in (None, unit)
    unit = unit or stated.unit
    if unit is None:
        raise Code.MSR_UNIT.refusal(
            f"CALYPSO's tables name no unit: is {path.name!r} in mm or inch?",
            hint="state it: --unit mm or --unit inch",
            place=Place(str(path), 1),
        )
    factor = MM_PER_INCH if unit == "inch" else 1.0
    header, remarks = _header(path)
    if overruled:
        remarks.append(Remark(f"its column 'unit' has {unit}: that is read"))
    at, said = _time(header, path)
    if empty := [(line, row["id"]) for line, row in listed if is_empty(row["actual"])]:
        said.append(Remark(f"{len(empty)} of {len(listed)} values are not measured: {empty[0][1]!r}", empty[0][0]))
    readings = [_reading(row, line, path, factor, at) for line, row in rows]
    deviations = [
        (reading, number_in(row["deviation"], path, line) * _factor(reading.quantity, factor), _rounding(row) * factor)
        for reading, (line, row) in zip(readings, rows, strict=True)
        if row.get("deviation")
    ]
    inspections = tuple(_inspections(path, rows, readings, header, at))
    return MeasuredFile(
        path=path,
        format="CALYPSO",
        encoding=encoding,
        unit=unit,
        inspections=inspections,
        characteristics=characteristics_of(readings),
        remarks=(*remarks, *said, *stated_deviations(deviations), *filled_in(inspections)),
        deviations=by_reading(deviation for deviation in deviations if deviation[0].nominal is None),
    )


def _rows(text: str, only: frozenset[str] | None = None) -> Iterator[tuple[int, Row]]:
    """The rows with their lines, by the names in the first; up to END."""
    first, *lines = text.splitlines() or [""]
    names = [cell.strip().lower() for cell in first.split("\t")]
    used = [(place, name) for place, name in enumerate(names) if only is None or name in only]
    for line, content in enumerate(lines, 2):
        if content.strip().upper() == "END":
            return
        if content.strip():
            cells = content.split("\t")
            cells += [""] * (len(names) - len(cells))
            yield line, {name: cells[place].strip() for place, name in used}


def _reading(row: Row, line: int, path: Path, factor: float, at: datetime | None) -> Reading:
    def number(name: str) -> float | None:
        return number_in(row[name], path, line) if row.get(name) else None

    symbol = row.get("idsymbol", "")
    quantity = next((found for words, found in SYMBOLS if words.search(symbol)), None)
    quantity = quantity or quantity_of(row.get("type", "")) or Quantity.OTHER
    scale = _factor(quantity, factor)
    actual, nominal = number("actual") or 0.0, number("nominal")
    low = None if row.get("natlowertolid") == "2" else number("lowertol")
    low = None if low == 0 == nominal and quantity in (Quantity.FORM, Quantity.RUNOUT) else low
    high = None if row.get("natuppertolid") == "2" else number("uppertol")
    feature, _, other = row.get("featureid", "").partition(",")
    place = [number(name) for name in ("featureposx", "featureposy", "featureposz")]
    reading = Reading(
        characteristic=row["id"],
        quantity=quantity,
        actual=actual * scale,
        nominal=None if nominal is None else nominal * scale,
        lower_limit=None if nominal is None or low is None else (nominal + low) * scale,
        upper_limit=None if nominal is None or high is None else (nominal + high) * scale,
        feature=feature.strip(),
        other=other.strip(),
        axis=AXES.get(symbol[:1].lower(), "") if quantity is Quantity.POSITION else "",
        place_mm=tuple(one * factor for one in place if one is not None) if None not in place else (),
        measured_at=at,
        line=line,
    )
    require_order(reading, path)
    return reading


def _factor(quantity: Quantity, factor: float) -> float:
    return 1.0 if quantity is Quantity.ANGLE else factor


def _rounding(row: Row) -> float:
    return half_digits(row["actual"], row["nominal"], row["deviation"])


def _inspections(
    path: Path, rows: Sequence[tuple[int, Row]], readings: Sequence[Reading], header: Row, at: datetime | None
) -> Iterator[Inspection]:
    """One for each plan and number of a part, in the file's order."""
    parts: dict[tuple[str, str], list[Reading]] = {}
    for reading, row in zip(readings, [row for _, row in rows], strict=True):
        parts.setdefault((row.get("planid", ""), row.get("partnb", "")), []).append(reading)
    sha256 = sha256_of(path.read_bytes())
    for (plan, number), values in parts.items():
        yield Inspection(
            part=Part(PartType(plan, drawing=header.get("drawingno", "")), header.get("partsn") or number),
            measured="readings",
            sha256=sha256,
            count=len(values),
            values=numbered(values),
            device=" ".join(filter(None, (header.get("dmeid"), header.get("dmesn")))),
            operator=header.get("operid", ""),
            measured_at=at,
        )


def _header(path: Path) -> tuple[Row, list[Remark]]:
    """The header's only row, where `_hdr` lies beside; what lies there else is reported."""
    if not KIND.search(path.name):
        return {}, []
    beside = {kind: path.with_name(KIND.sub(rf"\1{kind}", path.name)) for kind in ("hdr", "fet")}
    remarks = [Remark(f"{beside['fet'].name!r} lies beside: features' own values are not read")]
    header: Row = {}
    if beside["hdr"].is_file():
        header = next((row for _, row in _rows(read_decoded(beside["hdr"])[0])), {})
    if order := header.get("order"):
        remarks.append(Remark(f"order {order!r}"))
    return header, remarks if beside["fet"].is_file() else remarks[1:]


def _time(header: Row, path: Path) -> tuple[datetime | None, list[Remark]]:
    """Date and time of the header: as ISO 8601 where a column has it so, else local ones where they can be one only."""
    place = Place(str(path.with_name(KIND.sub(r"\1hdr", path.name))), 2)
    texts = [text for name, text in header.items() if "date" in name or "time" in name]
    dated = next((text for text in texts if re.match(r"\d{4}-\d\d-\d\d[T ]\d", text)), None)
    date, time = header.get("date", ""), header.get("time", "")
    text = dated or f"{date} {time}".strip()
    try:
        return moment(text, order_of([text], place), place), []
    except TrueloopError as error:
        return None, [Remark(f"no time: {error.message}", place.line)]


FORMAT: Final = Format("CALYPSO", recognises, read)
