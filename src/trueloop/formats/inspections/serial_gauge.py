"""Output of a Mitutoyo gauge or multiplexer on a serial line, kept in a file: `01A+00012.345`, a line a value.

Two digits name the channel, a letter the kind (A: a value as measured; others, such as the largest or the mean, are
left out with a remark). `911` after the channel means that no gauge is connected or that it sends nothing, `912` that
its data are wrong. A line names neither unit, nor part, nor characteristic: the unit is required, and channels are the
characteristics, whose quantities and features a mapping states as it does of a control's variables. Known from the
formats that loggers of it read, not from its manual.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place
from trueloop.formats.inspections.controls.meaning import VariableTable, meaning_of, reading_of
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts, Unit
from trueloop.formats.inspections.shared.checks import numbered
from trueloop.formats.inspections.shared.text import beginning, number_in, read_decoded
from trueloop.units import MM_PER_INCH

LINE: Final = re.compile(r"(\d{2}|0[A-Z])([A-Z1-9])\s*([-+]\s*\d{1,8}(?:[.,]\d{1,6})?)\s*(mm|in|inch)?")
FAULT: Final = re.compile(r"(91[1-9])(\d{2}|0[A-Z])?([A-Z1-9])?|(\d{2})([A-Z])?\s*(91[1-9])")
UNKNOWN: Final = VariableTable(quantity=Quantity.OTHER)
FAULTS: Final = {"911": "no gauge is connected, or it sends nothing", "912": "its data are wrong"}


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether the first lines are all values or faults, one at least a value."""
    lines = [line.strip() for line in beginning(head).splitlines()[:20] if line.strip()]
    lines = lines[:-1] if len(lines) > 1 and len(head) >= 65_536 else lines
    known = [LINE.fullmatch(line) or FAULT.fullmatch(line) for line in lines]
    return any(LINE.fullmatch(line) for line in lines) and all(known)


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads the values of each channel, in order. Raises MSR-UNIT, MSR-NUMBER, MSR-MAPPING, and MSR-VALUE where none is
    left or the mapping names a channel that the file has not.
    """
    meaning = meaning_of(stated)
    text, encoding = read_decoded(path)
    lines = [(line, content.strip()) for line, content in enumerate(text.splitlines(), 1) if content.strip()]
    values = [(line, found) for line, content in lines if (found := LINE.fullmatch(content))]
    units: set[Unit] = {"inch" if found[4].startswith("in") else "mm" for _, found in values if found[4]}
    unit = next(iter(units), stated.unit or meaning.unit) if len(units) < 2 else None
    if unit is None:
        said = f"in {' and '.join(sorted(units))}" if units else "without a unit"
        raise Code.MSR_UNIT.refusal(
            f"the {len(values)} values of {path.name!r} are {said}",
            hint="state it: --unit mm or --unit inch",
            place=Place(str(path), values[0][0] if values else 1),
        )
    factor = MM_PER_INCH if unit == "inch" else 1.0
    measured = [
        (found[1], number_in(found[3].replace(" ", ""), path, line), line)
        for line, found in values
        if found[2] == "A" or found[2].isdigit()
    ]
    tables = defaultdict(lambda: UNKNOWN, meaning.variables)
    readings = numbered(
        reading_of(name, tables[name], value, line, mm_per_unit=factor) for name, value, line in measured
    )
    if missing := sorted(meaning.variables.keys() - {name for name, _, _ in measured}):
        raise Code.MSR_VALUE.refusal(
            f"the mapping names the channel {missing[0]!r}, of which {path.name!r} has no value",
            hint=f"its channels are {', '.join(sorted({name for name, _, _ in measured}))}",
            place=Place(str(path)),
        )
    if not readings:
        raise Code.MSR_VALUE.refusal(
            f"{path.name!r} has 0 values among {len(lines)} lines",
            hint="connect the gauge and send again",
            place=Place(str(path), 1),
        )
    inspection = Inspection(
        Part(PartType(meaning.part), meaning.serial),
        "readings",
        sha256_of(path.read_bytes()),
        len(readings),
        readings,
        device="gauge, serial line",
    )
    return MeasuredFile(
        path=path,
        format="Mitutoyo, serial line",
        encoding=encoding,
        unit=unit,
        inspections=(inspection,),
        characteristics=(),
        remarks=tuple(_remarks(lines)),
    )


def _remarks(lines: list[tuple[int, str]]) -> Iterator[Remark]:
    for line, content in lines:
        found, fault = LINE.fullmatch(content), FAULT.fullmatch(content)
        if fault:
            code = fault[1] or fault[6]
            yield Remark(f"{code} of channel {fault[2] or fault[4] or '?'}: {FAULTS.get(code, 'a fault')}", line)
        elif found is None:
            yield Remark(f"not understood: {content[:40]!r}", line)
        elif not (found[2] == "A" or found[2].isdigit()):
            yield Remark(f"left out: {content!r} is a value of kind {found[2]}, not one as measured", line)


FORMAT: Final = Format("Mitutoyo, serial line", recognises, read)
