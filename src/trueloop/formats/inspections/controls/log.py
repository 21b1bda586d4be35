"""Logs of positions: LinuxCNC's nine numbers a line, `X… Z…` of DPRNT and of Siemens' WRITE, columns of Heidenhain.

LinuxCNC's X is a radius always [read in its manual]. The others write what the program says: whether X is a diameter,
and what numbers without letters are, is stated by a mapping. Blanks within a number's field are Fanuc's leading zeros;
Heidenhain writes decimal commas and points in one file [read in real files].
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Final, Literal, TypeAlias

from trueloop.domain.inspection import CmmPoint, Inspection, Vector
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.controls.meaning import (
    MM_PER,
    LogTable,
    Meaning,
    inspection_of,
    meaning_of,
    not_stated,
    unit_of,
)
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.shared.text import NUMBER, beginning, number_in, read_decoded

Kind: TypeAlias = Literal["linuxcnc", "words", "columns"]

LINUXCNC: Final = ("x", "y", "z", "-", "-", "-", "-", "-", "-")
"""X Y Z A B C U V W."""
FIELD: Final = r"[-+]?\s*(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:EX?[-+]?\d+)?"
WORD: Final = re.compile(rf"([A-Z])\s*({FIELD})", re.IGNORECASE)
WORDS: Final = re.compile(rf"\s*(?:[XYZ]\s*{FIELD}\s*){{2,3}}", re.IGNORECASE)
PASSED: Final = re.compile(r"\s*(?:%|MISSED|POPEN|PCLOS)?\s*", re.IGNORECASE)
WORDED: Final = 0.8
"""Share of the lines that are touches, above which the others are taken for touches that cannot be read."""
MISSED: Final = re.compile(r"\s*MISSED\s*", re.IGNORECASE)
BETWEEN_RUNS: Final = re.compile(r"\s*%\s*")
"""Fanuc sends it at POPEN and at PCLOS."""
LETTERS: Final = ("[log]", 'x_is = "diameter"')
COLUMNS: Final = ("[log]", 'columns = ["x", "y", "z"]', 'x_is = "radius"', "lines = [1, 20]")
HINT: Final = "name the lines that hold touches: `lines = [from, to]` in the mapping's table [log]"


@dataclass(frozen=True)
class _Row:
    """A touch: its position in mm, its line, and in which of the file's runs."""

    position_mm: Vector
    line: int
    run: int


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether its first lines are positions and nothing else."""
    return _kind(beginning(head).splitlines()[:100]) is not None


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads a log's touches as points, one inspection a run. Raises MSR-MEANING, MSR-UNIT, MSR-MAPPING, MSR-VALUE."""
    text, encoding = read_decoded(path)
    lines = text.splitlines()
    meaning = meaning_of(stated)
    kind, table = _kind(lines[:100]), meaning.log or LogTable()
    columns = LINUXCNC if kind == "linuxcnc" else table.columns
    if kind == "columns" and not columns:
        raise not_stated(path, f"what the numbers of its {len(lines)} lines are is not stated", COLUMNS, 1)
    if kind != "linuxcnc" and table.x_is is None:
        raise not_stated(path, f"whether X of its {len(lines)} lines is a diameter is not stated", LETTERS, 1)
    unit = unit_of(stated, meaning, path)
    scale = MM_PER[unit]
    x_scale = scale / 2 if kind != "linuxcnc" and table.x_is == "diameter" else scale
    rows = [
        replace(row, position_mm=(row.position_mm[0] * x_scale, row.position_mm[1] * scale, row.position_mm[2] * scale))
        for row in _rows(lines, columns, table, path)
    ]
    missed = [number for number, line in enumerate(lines, 1) if MISSED.fullmatch(line)]
    remarks = tuple(Remark("a touch was missed", number) for number in missed)
    parts = tuple(_inspections(path, meaning, rows, table.ball_radius * scale))
    return MeasuredFile(path, FORMAT.name, encoding, unit, parts, remarks=remarks)


FORMAT: Final = Format("log of positions of a control", recognises, read)


def _kind(lines: list[str]) -> Kind | None:
    spoken = [line for line in lines if not PASSED.fullmatch(line)]
    if spoken and sum(map(bool, map(WORDS.fullmatch, spoken))) > WORDED * len(spoken):
        return "words"
    counts = {len(words) for words in map(str.split, spoken) if all(map(NUMBER.fullmatch, words))} if spoken else set()
    bare = sum(all(map(NUMBER.fullmatch, line.split())) for line in spoken)
    if not spoken or bare < len(spoken) or len(counts) != 1:
        return None
    return "linuxcnc" if counts == {len(LINUXCNC)} else "columns" if counts <= {2, 3} else None


def _rows(lines: list[str], columns: tuple[str, ...], table: LogTable, path: Path) -> Iterator[_Row]:
    first, last = table.lines or (1, len(lines))
    run = 0
    for number, line in enumerate(lines, 1):
        run += bool(BETWEEN_RUNS.fullmatch(line))
        if first <= number <= last and not PASSED.fullmatch(line):
            at = _columns(line, columns, path, number) if columns else _words(line, path, number)
            yield _Row((at["x"], at.get("y", 0.0), at["z"]), number, run)


def _words(line: str, path: Path, number: int) -> dict[str, float]:
    """`X 12.345Z-3.000`, also with Siemens' exponent EX."""
    found = {match[1].lower(): "".join(match[2].upper().split()).replace("EX", "E") for match in WORD.finditer(line)}
    if not WORDS.fullmatch(line) or not {"x", "z"} <= set(found):
        raise _refusal(line, "no touch: it has not one X and one Z", path, number)
    return {axis: number_in(text, path, number) for axis, text in found.items()}


def _columns(line: str, columns: tuple[str, ...], path: Path, number: int) -> dict[str, float]:
    words = line.split()
    if len(words) != len(columns):
        raise _refusal(line, f"{len(words)} numbers, where {len(columns)} are expected", path, number)
    found = {axis: number_in(word, path, number) for axis, word in zip(columns, words, strict=True) if axis != "-"}
    if not {"x", "z"} <= set(found):
        raise _refusal(line, "the mapping's `columns` names no x or no z", path, number)
    return found


def _refusal(line: str, why: str, path: Path, number: int) -> TrueloopError:
    return Code.MSR_VALUE.refusal(
        f"{path.name!r}: {line.strip()[:60]!r}: {why}", hint=HINT, place=Place(str(path), number)
    )


def _inspections(path: Path, meaning: Meaning, rows: list[_Row], ball_mm: float) -> Iterator[Inspection]:
    for _, run in groupby(rows, key=lambda row: row.run):
        points = (CmmPoint(row.position_mm, name=str(k)) for k, row in enumerate(run, 1))
        yield inspection_of(path, meaning, points=points, ball_radius_mm=ball_mm)
