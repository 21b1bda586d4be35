"""The assignments of a dump of variables: `#500=12.3456`, `R1=…`, `_OVR[4]=…`, `Q150=…`, `VC1=…`."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.controls.expression import value_of
from trueloop.formats.inspections.measured_file import Remark

START: Final = re.compile(r"((?:#|\b[RQ]|\bVC)\d+|\b_OV[RI]\[\d+\]|\bR\[\d+\])\s*=\s*", re.IGNORECASE)
NUMBERED: Final = re.compile(r"\s*/?(?:N\d+\s*)?", re.IGNORECASE)
COMMENT: Final = re.compile(r"\([^()]*\)|;.*")
EMPTY: Final = re.compile(r"#0|(?:DATA )?EMPTY|VACANT|NULL|\*+|", re.IGNORECASE)
SKIPPED: Final = re.compile(r"\s*(?:%.*|[O:]\d+|SETVN.*|M\d+|RET)?\s*", re.IGNORECASE)
"""Ends of a tape, the number of a program, names of variables, ends of a program."""


@dataclass(frozen=True)
class Variable:
    """A variable as it stands in a dump; None: it is empty, which is not 0."""

    name: str
    value: float | None
    line: int


def bare(line: str) -> str:
    """A line with blanks for its comments."""
    return COMMENT.sub(lambda found: " " * len(found[0]), line) if "(" in line or ";" in line else line


def is_skipped(line: str) -> bool:
    """Whether a bare line has nothing to read."""
    return SKIPPED.fullmatch(line) is not None


def is_assignment(line: str) -> bool:
    """Whether a bare line begins with an assignment."""
    at = NUMBERED.match(line)
    return START.match(line, at.end() if at else 0) is not None


def variables_in(text: str, path: Path) -> tuple[list[Variable], list[Remark]]:
    """All assignments in order, and the lines that are none. Raises MSR-NUMBER for a value that is no number."""
    found: list[Variable] = []
    remarks: list[Remark] = []
    for number, line in enumerate(text.splitlines(), 1):
        statement = bare(line)
        if is_assignment(statement):
            found += _assigned(statement, path, number)
        elif not is_skipped(statement):
            remarks.append(Remark(f"not understood: {line.strip()[:60]!r}", number))
    return found, remarks


def key_of(name: str) -> str:
    """A variable's name as a mapping may write it: `500` is `#500`, `R[1]` is `R1`."""
    plain = re.sub(r"\bR\[(\d+)\]", r"R\1", "".join(name.upper().split()))
    return f"#{plain}" if plain.isdigit() else plain


def _assigned(line: str, path: Path, number: int) -> Iterator[Variable]:
    starts = list(START.finditer(line))
    for start, following in zip(starts, [*(one.start() for one in starts[1:]), len(line)], strict=True):
        text = line[start.end() : following].strip()
        value = None if EMPTY.fullmatch(text) else value_of(text)
        if value is None and not EMPTY.fullmatch(text):
            raise TrueloopError(
                Code.MSR_NUMBER,
                f"{start[1]} is {text!r}: no number, and no expression of numbers, + - * / and [ ]",
                hint="is the file whole? Take the line out, or send the variables again",
                place=Place(str(path), number, start.end() + 1),
                values={"text": text},
            )
        yield Variable(start[1], value, number)
