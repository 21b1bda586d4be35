"""The K fields of a Q-DAS file, sorted into parts, characteristics and measured values.

`K2002/3 Bore` is a field of the third characteristic, counted over all parts; `/0` or no number is one of all. Values
stand in lines of their own, one a characteristic, separated by 0x0F, their parts by 0x14: value, attribute, time and
others that are not read; or in `K0001/3`. A field K00xx belongs to the value of its characteristic before it.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place

FIELD: Final = re.compile(r"K(\d{4})(?:/(\d{1,6}))?(?:/\d+)?(?:[ \t](.*))?")
BETWEEN_VALUES, BETWEEN_PARTS = "\x0f", "\x14"
VALUE, ATTRIBUTE, TIME, SERIAL = "0001", "0002", "0004", "0014"


@dataclass(slots=True)
class Column:
    """The values of one characteristic as text, in order, with what was said of each; attribute 0 is valid.

    Lists of texts, not a list of values: a file has 100 000 of them.
    """

    lines: list[int] = field(default_factory=list)
    values: list[str] = field(default_factory=list)
    attributes: list[str] = field(default_factory=list)
    times: list[str] = field(default_factory=list)
    serials: list[str] = field(default_factory=list)

    def add(self, line: int, value: str, attribute: str = "0", time: str = "") -> None:
        """Adds a value."""
        self.lines.append(line)
        self.values.append(value)
        self.attributes.append(attribute)
        self.times.append(time)
        self.serials.append("")

    def of(self, key: str) -> list[str]:
        """Returns the column's list for a field of a value: attributes, times or serial numbers."""
        return {ATTRIBUTE: self.attributes, TIME: self.times, SERIAL: self.serials}[key]


@dataclass
class Fields:
    """A file: fields by number of part or characteristic (0: of all), and the values of each characteristic in order.

    `part_of` has the part after which a characteristic stands, `lines` those of fields. `unplaced` are lines of fields
    of a value that stand before any, `again` fields that are stated twice, the last of which counts.
    """

    parts: defaultdict[int, dict[str, str]] = field(default_factory=lambda: defaultdict(dict))
    characteristics: defaultdict[int, dict[str, str]] = field(default_factory=lambda: defaultdict(dict))
    lines: dict[tuple[str, int], int] = field(default_factory=dict)
    part_of: dict[int, int] = field(default_factory=dict)
    values: defaultdict[int, Column] = field(default_factory=lambda: defaultdict(Column))
    unplaced: list[int] = field(default_factory=list)
    again: list[tuple[str, int]] = field(default_factory=list)

    def of_part(self, part: int, key: str) -> str:
        """Returns a field K1xxx; empty where it is not stated."""
        return self.parts[part].get(key) or self.parts[0].get(key, "")

    def of(self, characteristic: int, key: str) -> str:
        """Returns a field K2xxx; empty where it is not stated."""
        return self.characteristics[characteristic].get(key) or self.characteristics[0].get(key, "")


def fields_of(texts: Iterator[tuple[Path, str]]) -> Fields:
    """Reads the fields of one file, or of plan and then values. Raises MSR-FILE for a line that is neither."""
    found, part = Fields(), 0
    for path, text in texts:
        for number, raw in enumerate(text.split("\n"), 1):
            line = raw.rstrip("\r\x1a")
            if not line.strip():
                continue
            match = FIELD.fullmatch(line) if line[0] == "K" else None
            if match is not None:
                part = _take(found, match, part, number)
            elif line[0].isalpha() or not found.characteristics:
                raise Code.MSR_FILE.refusal(
                    f"{line[:60]!r} is neither a K field nor a line of values",
                    hint="a field is K, four digits and the number of its characteristic: K2101/1 25.000",
                    place=Place(str(path), number),
                )
            else:
                _take_values(found, line, path, number)
    return found


def _take(fields: Fields, match: re.Match[str], part: int, line: int) -> int:
    """A field goes where its number says; returns the part that characteristics after it belong to."""
    key, index, value = match[1], int(match[2] or 0), (match[3] or "").strip()
    if key.startswith("1"):
        fields.parts[index][key] = value
        fields.lines.setdefault((key, index), line)
        return index
    if key.startswith("2"):
        if key in fields.characteristics[index]:
            fields.again.append((f"K{key}/{index}", line))
        fields.characteristics[index][key] = value
        fields.lines.setdefault((key, index), line)
        if index:
            fields.part_of.setdefault(index, part)
    elif key == VALUE:
        for each in fields.part_of if index == 0 else (index,):
            fields.values[each].add(line, value)
    elif key in {ATTRIBUTE, TIME, SERIAL}:
        _add(fields, key, index, value, line)
    return part


def _add(fields: Fields, key: str, index: int, value: str, line: int) -> None:
    """To the last value of its characteristic, or of all."""
    columns = [fields.values[each] for each in (fields.part_of if index == 0 else (index,)) if each in fields.values]
    if not columns:
        fields.unplaced.append(line)
    for column in columns:
        column.of(key)[-1] = value


def _take_values(fields: Fields, line: str, path: Path, number: int) -> None:
    values = line.split(BETWEEN_VALUES)
    count = max(fields.characteristics)
    if len(values) > count:
        raise Code.MSR_VALUE.refusal(
            f"the line has {len(values)} values, the file {count} characteristics",
            hint="plan and values may not belong together: name the pair that was written together",
            place=Place(str(path), number),
        )
    for index in fields.part_of:
        parts = values[index - 1].split(BETWEEN_PARTS, 3) if index <= len(values) else [""]
        value, attribute, time = (*parts, "", "")[:3]
        fields.values[index].add(number, value.strip(), attribute.strip() or "0", time.strip())
