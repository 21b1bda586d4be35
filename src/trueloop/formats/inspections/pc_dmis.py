"""PC-DMIS: the text of its reports and of its edit window."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.shared.checks import (
    by_reading,
    filled_in,
    half_digits,
    numbered,
    stated_deviations,
    stated_verdicts,
)
from trueloop.formats.inspections.shared.quantities import AXES, characteristics_of, quantity_in, require_order
from trueloop.formats.inspections.shared.text import NUMBER, beginning, moment, number_in, order_of, read_decoded
from trueloop.units import MM_PER_INCH

COLUMNS: Final = {
    "AX": "axis",
    "NOMINAL": "nominal",
    "NOM": "nominal",
    "+TOL": "plus",
    "-TOL": "minus",
    "BONUS": "bonus",
    "MEAS": "actual",
    "ACTUAL": "actual",
    "MEASURED": "actual",
    "MAX": "max",
    "MIN": "min",
    "DEV": "deviation",
    "DEVANG": "angle",
    "OUTTOL": "outside",
    "OUT-TOL": "outside",
}
"""Columns by the words of the heading; which there are, and in which order, is a setting."""
HEADING: Final = re.compile(r"\s*AX(?:IS)?\s+(?=.*(?:MEAS|ACTUAL|DEV))", re.IGNORECASE)
BLOCK: Final = re.compile(r"\s*DIM(?:ENSION)?\s+(\S+?)\s*=\s*(.+)", re.IGNORECASE)
LABEL: Final = re.compile(r"\W*(MM|IN|INCH|DEG)\b\s+(\S+)(?:\s+-\s+(.+))?\s*", re.IGNORECASE)
"""The line of a dimension's name in a printed report: `MM   LOC1 - CIR1`."""
ENDED: Final = re.compile(
    r"\s*END\s+OF\s+DIMENSION|\s*DIM(?:ENSION)?\s|\s*(?:PART NAME|SER NUMBER|REV NUMBER)\b", re.IGNORECASE
)
UNITS: Final = re.compile(r"\bUNITS\s*=\s*(MM|INCH|IN|DEG)\b", re.IGNORECASE)
FEATURE: Final = re.compile(r"\b(?:OF|FROM)\s+(?:SET\s+OF\s+)?(\w+)\s+([^\s,]+)", re.IGNORECASE)
OTHER: Final = re.compile(r"\bTO\s+(?:SET\s+OF\s+)?(\w+)\s+([^\s,]+)", re.IGNORECASE)
HEADER: Final = re.compile(
    r"\b(PART NAME|REV(?:ISION)? NUMBER|SER(?:IAL)? NUMBER|STATS COUNT|DATE|TIME|OPERATOR)\s*[:=]"
    r"\s*(.*?)(?=\s{2,}\S|\s*$|\s+TIME\s*[:=])",
    re.IGNORECASE,
)
GRAPH: Final = re.compile(r"[-#<>|*=]{3,}")


@dataclass(frozen=True)
class Line:
    """A row of a dimension: texts by column, empty ones left out."""

    cells: Mapping[str, str]
    line: int


@dataclass(frozen=True)
class Block:
    """A dimension: its name, what it is in words (`LOCATION OF CIRCLE CIR1`), unit as written, rows."""

    name: str
    what: str
    unit: str
    rows: tuple[Line, ...]
    line: int

    @property
    def feature(self) -> str:
        """Returns the feature that the block is a size of."""
        found = FEATURE.search(self.what)
        return found[2] if found else "" if " " in self.what else self.what

    @property
    def other(self) -> str:
        """Returns the feature from which a distance counts; empty for other sizes."""
        found = OTHER.search(self.what)
        return found[2] if found and "DISTANCE" in self.what.upper() else ""


@dataclass
class Run:
    """One run: what its header says, and its dimensions."""

    header: dict[str, str] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)
    not_understood: list[int] = field(default_factory=list)


def runs_in(text: str) -> list[Run]:
    """Returns the runs of a report in their order: each begins with the name of its part."""
    runs = [Run()]
    lines = _joined(text)
    for at, (line, content) in enumerate(lines):
        for key, value in HEADER.findall(content):
            name = " ".join(key.upper().split())
            if name == "PART NAME" and (runs[-1].header.get(name) or runs[-1].blocks):
                runs.append(Run())
            if value.strip():
                runs[-1].header.setdefault(name, value.strip())
        if HEADING.match(content):
            runs[-1].blocks.append(_block(lines, at, line, runs[-1]))
    return [run for run in runs if run.blocks or run.header]


def _joined(text: str) -> list[tuple[int, str]]:
    """Lines, those that end with $ together with the next one, unless that begins something of its own."""
    out: list[tuple[int, str]] = []
    begun = ""
    for line, content in enumerate(text.expandtabs().splitlines(), 1):
        if begun and (HEADING.match(content) or ENDED.match(content)):
            out.append((line - 1, begun))
            begun = ""
        if content.rstrip().endswith("$") and not HEADING.match(content):
            begun += content.rstrip()[:-1]
            continue
        out.append((line, begun + content.rstrip()))
        begun = ""
    return out


def _block(lines: Sequence[tuple[int, str]], at: int, line: int, run: Run) -> Block:
    """The dimension whose heading of columns stands there: its name is above, its rows below."""
    name, what, unit = "", "", ""
    for _, above in reversed(lines[max(0, at - 4) : at]):
        if block := BLOCK.match(above):
            name, what = block[1], block[2]
            unit = found[1] if (found := UNITS.search(what)) else ""
            break
        if label := LABEL.fullmatch(above):
            unit, name, what = label[1], label[2], label[3] or ""
            break
        if HEADING.match(above) or above.upper().lstrip().startswith("END OF"):
            break
    rows = tuple(_rows(lines, at, run))
    return Block(name, UNITS.sub("", what).strip(" ,"), unit.upper(), rows, line)


def _rows(lines: Sequence[tuple[int, str]], at: int, run: Run) -> Iterator[Line]:
    heading = [(found[0].upper(), found.end()) for found in re.finditer(r"\S+", lines[at][1])]
    columns = [(COLUMNS.get(word, word.lower()), end) for word, end in heading]
    for line, content in (lines[k] for k in range(at + 1, len(lines))):
        if not content.strip() or ENDED.match(content) or HEADING.match(content) or LABEL.fullmatch(content):
            if content.strip():
                return
            continue
        tokens = [(found[0], found.end()) for found in re.finditer(r"\S+", content) if not GRAPH.fullmatch(found[0])]
        cells = _cells(columns, tokens)
        if cells is None:
            run.not_understood.append(line)
            return
        yield Line(cells, line)


def _cells(columns: Sequence[tuple[str, int]], tokens: Sequence[tuple[str, int]]) -> dict[str, str] | None:
    """The words of a row under the headings: all of them in order, else each under the one that ends where it ends.

    None: two would stand under one heading, or the row does not belong to an axis.
    """
    if len(tokens) < 2 or not re.fullmatch(r"[A-Z]{1,3}\d?", tokens[0][0], re.IGNORECASE):
        return None
    if len(tokens) == len(columns):
        return {name: word for (name, _), (word, _) in zip(columns, tokens, strict=True)}
    found: dict[str, str] = {"axis": tokens[0][0]}
    for word, end in tokens[1:]:
        name, _ = min(columns[1:], key=lambda column: abs(column[1] - end))
        if name in found:
            return None
        found[name] = word
    return found


AXIS: Final = {
    **dict.fromkeys("XYZ", Quantity.POSITION),
    **dict.fromkeys(("D", "DF", "DD", "D1", "D2", "D3", "PD", "SD"), Quantity.DIAMETER),
    "R": Quantity.RADIUS,
    **dict.fromkeys(("A", "PA"), Quantity.ANGLE),
    **dict.fromkeys(("L", "H", "LD", "WD"), Quantity.LENGTH),
    **dict.fromkeys(("TP", "F"), Quantity.FORM),
}
"""`M` is the dimension's own size; `T`, `S`, `RT`, `RS` and `PR` are deviations along a vector or a polar radius."""
NOT_READ: Final = ("V",)
FACTOR: Final = {"MM": 1.0, "IN": MM_PER_INCH, "INCH": MM_PER_INCH, "DEG": 1.0}
ZONES: Final = (Quantity.FORM, Quantity.RUNOUT)


@dataclass(frozen=True)
class _Value:
    """A row as read: the reading, its deviation and what is outside, as the file states them. `from_deviation`: whether
    its nominal value is that of its deviation.
    """

    reading: Reading
    deviation: float | None
    from_deviation: bool
    outside: float | None
    rounding: float


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether the file has a heading of columns that begins with AX."""
    return any(HEADING.match(line) and len(line.split()) > 2 for line in beginning(head).splitlines())


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads the runs of a report. Raises MSR-UNIT where a dimension names no unit, MSR-NUMBER, MSR-EXCHANGED, and
    MSR-VALUE where the report has no value.
    """
    text, encoding = read_decoded(path)
    runs = runs_in(text)
    rows = [(block, row) for run in runs for block in run.blocks for row in block.rows]
    signed, said = _signed(rows, path)
    values = [[_value(block, row, path, stated, signed) for block, row in _rows_of(run)] for run in runs]
    found = [value for run in values for value in run]
    if not found:
        raise Code.MSR_VALUE.refusal(f"{path.name!r} has 0 values in {len(rows)} rows",
            hint="print it with NOMINAL and MEAS",
            place=Place(str(path), 1)
        )  # fmt: skip
    sha256 = sha256_of(path.read_bytes())
    remarks = [*said, *_remarks(runs), *_not_measured(rows)]
    inspections = []
    times, unknown = _times(runs, path)
    for run, some, at in zip(runs, values, times, strict=True):
        if some:
            inspections.append(_inspection(run, [value.reading for value in some], sha256, at))
    unit = next((block.unit for block, _ in rows if block.unit in ("MM", "IN", "INCH")), None)
    deviations = [(one, (one.reading, one.deviation, one.rounding)) for one in found if one.deviation is not None]
    verdicts = [(one.reading, one.outside <= one.rounding) for one in found if one.outside is not None]
    remarks += [
        *unknown,
        *stated_deviations(one for _, one in deviations),
        *stated_verdicts(verdicts),
        *filled_in(inspections),
    ]
    return MeasuredFile(
        path=path,
        format="PC-DMIS",
        encoding=encoding,
        unit=stated.unit if unit is None else "mm" if unit == "MM" else "inch",
        inspections=tuple(inspections),
        characteristics=characteristics_of([one.reading for one in found]),
        remarks=tuple(remarks),
        deviations=by_reading(one for value, one in deviations if value.from_deviation),
    )


def _rows_of(run: Run) -> Iterator[tuple[Block, Line]]:
    for block in run.blocks:
        for row in block.rows:
            if row.cells["axis"].upper() not in NOT_READ and _is_measured(row):
                yield block, row


def _is_measured(row: Line) -> bool:
    return not {"actual", "deviation"}.isdisjoint(row.cells)


def _number(row: Line, name: str, path: Path) -> float | None:
    """A cell's number; None for RFS, MMC and the like, and where there is none."""
    text = row.cells.get(name, "")
    return number_in(text, path, row.line) if NUMBER.match(text.lstrip("+-")) else None


def _value(block: Block, row: Line, path: Path, stated: StatedFacts, signed: bool) -> _Value:
    """Raises MSR-UNIT, MSR-NUMBER, MSR-EXCHANGED."""
    axis = row.cells["axis"].upper()
    quantity = AXIS.get(axis) or (quantity_in(block.what.split(" OF ")[0].split(" FROM ")[0]) if axis == "M" else None)
    quantity = quantity or Quantity.OTHER
    factor = 1.0 if quantity is Quantity.ANGLE else _factor(block, path, stated)
    nominal, actual, deviation, plus, minus, outside = (
        None if number is None else number * factor
        for number in (
            _number(row, name, path) for name in ("nominal", "actual", "deviation", "plus", "minus", "outside")
        )
    )
    zone = quantity in ZONES
    nominal = 0.0 if nominal is None and zone else nominal
    if actual is None and nominal is not None and deviation is not None:
        actual = nominal + deviation
    from_deviation = nominal is None and actual is not None and deviation is not None
    if actual is not None and deviation is not None:
        nominal = actual - deviation if nominal is None else nominal
    if actual is None:
        raise Code.MSR_VALUE.refusal(
            f"{block.name} {axis} has neither MEAS, nor NOMINAL and DEV",
            hint="print the report with the columns NOMINAL and MEAS",
            place=Place(str(path), row.line),
        )
    bonus = (_number(row, "bonus", path) or 0.0) * factor if zone else 0.0
    below = None if minus is None or zone else minus if signed or (minus < 0 and minus == -(plus or 0.0)) else -minus
    reading = Reading(
        characteristic=block.name if axis == "M" else f"{block.name}.{axis}",
        quantity=quantity,
        actual=actual,
        nominal=nominal,
        lower_limit=None if nominal is None or below is None else nominal + below,
        upper_limit=None if nominal is None or plus is None else nominal + plus + bonus,
        feature=block.feature,
        other=block.other,
        axis=AXES.get(axis.lower(), ""),
        line=row.line,
    )
    require_order(reading, path)
    printed = [row.cells.get(name, "0.0001") for name in ("actual", "nominal", "deviation")]
    rounding = half_digits(*(text for text in printed if NUMBER.fullmatch(text))) * factor
    return _Value(reading, None if zone else deviation, from_deviation, outside, rounding)


def _factor(block: Block, path: Path, stated: StatedFacts) -> float:
    unit = block.unit if block.unit in FACTOR and block.unit != "DEG" else (stated.unit or "").upper()
    if unit in FACTOR:
        return FACTOR[unit]
    raise Code.MSR_UNIT.refusal(
        f"dimension {block.name!r} names no unit of length",
        hint="state it: --unit mm or --unit inch",
        place=Place(str(path), block.line),
    )


def _signed(rows: Sequence[tuple[Block, Line]], path: Path) -> tuple[bool, list[Remark]]:
    """Returns whether -TOL is printed with its sign: where it is negative whenever it is not 0, and no row contradicts.

    One negative among positive ones is a lower limit above the nominal value, as the program prints it without signs;
    where the zone would have no width so, it is printed with its sign.
    """
    minus = np.array([number for _, row in rows if (number := _number(row, "minus", path)) is not None])
    below = minus[minus != 0]
    if not len(below) or np.any(below > 0):
        lines = [
            row.line
            for _, row in rows
            if (number := _number(row, "minus", path)) and number < 0 and number == -(_number(row, "plus", path) or 0.0)
        ]
        text = f"{len(lines)} -TOL are printed with their sign, unlike the others: their zones would have no width"
        return False, [Remark(text, lines[0])] if lines else []
    return True, [Remark("-TOL is printed with its sign: all that are not 0 are negative")]


def _inspection(run: Run, readings: Sequence[Reading], sha256: str, at: datetime | None) -> Inspection:
    header = run.header
    serial = header.get("SER NUMBER") or header.get("SERIAL NUMBER") or ""
    revision = header.get("REV NUMBER") or header.get("REVISION NUMBER") or ""
    values = numbered(readings)
    return Inspection(
        part=Part(PartType(header.get("PART NAME", ""), revision), serial),
        measured="readings",
        sha256=sha256,
        count=len(values),
        values=values,
        operator=header.get("OPERATOR", ""),
        measured_at=at,
    )


def _dated(run: Run) -> str:
    date = re.sub(r"^[A-Za-z]+,\s*", "", run.header.get("DATE", ""))
    return f"{date} {run.header.get('TIME', '')}".strip() if date else ""


def _times(runs: Sequence[Run], path: Path) -> tuple[list[datetime | None], list[Remark]]:
    """When each run was; a remark where day and month may be exchanged, or it is not a date."""
    texts, place = [_dated(run) for run in runs], Place(str(path))
    try:
        order = order_of(texts, place)
        return [moment(text, order, place) for text in texts], []
    except TrueloopError as error:
        return [None] * len(runs), [Remark(f"no time: {error.message}")]


def _remarks(runs: Sequence[Run]) -> Iterator[Remark]:
    lines = [line for run in runs for line in run.not_understood]
    if lines:
        yield Remark(f"{len(lines)} lines under headings are not understood", lines[0])


def _not_measured(rows: Sequence[tuple[Block, Line]]) -> Iterator[Remark]:
    empty = [(block, row) for block, row in rows if "nominal" in row.cells and not _is_measured(row)]
    if empty:
        (block, row), asked = empty[0], sum("nominal" in row.cells for _, row in rows)
        text = (
            f"{len(empty)} of {asked} values are not measured: {block.name} {row.cells['axis']} has no MEAS and no DEV"
        )
        yield Remark(text, row.line)


FORMAT: Final = Format("PC-DMIS", recognises, read)
