"""A program written in another dialect, by its tool path: the motion subset, with what is lost said.

The source is run, so loops, subprograms and parameters come out written out. Moves are absolute positions in the unit
of the source (Klartext: mm); shifts of coordinates (G52, TRANS, G43.1) are added to them, work offsets (G54 …) and the
position register (G92) stay words. Cutter compensation stays too: what is written is the programmed contour.
"""

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from trueloop._core import nc_written_decimals
from trueloop.errors import Code, Finding, Place, TrueloopError
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.program import Program, Word
from trueloop.nc.translate import gcode, klartext
from trueloop.nc.translate.controls import CONTROLS
from trueloop.nc.translate.executed import Said, Source
from trueloop.nc.translate.in_force import InForce, Target, Writing
from trueloop.nc.translate.in_force import decimals as places
from trueloop.nc.translate.kind import require_same_kind
from trueloop.nc.translate.source import statements
from trueloop.nc.translate.statements import Lost, Remark
from trueloop.nc.translate.tool_rows import rows_of_tools

MOST_DECIMALS: Final = 9
KLARTEXT: Final = "heidenhain"
HINT: Final = "write it by hand in the new program, or leave it out of the old one"
ACTIVE_COMMENT: Final = re.compile(r"\s*(MSG|DEBUG|PRINT|LOG\w*|PROBE\w*|PY|PYRUN|ABORT)\s*,", re.IGNORECASE)
"""LinuxCNC acts on these."""


@dataclass(frozen=True)
class Translation:
    """The program in the other dialect.

    `losses`: NC-LOST, an error where the machine would move otherwise, a warning where it would not cut as before, a
    note otherwise. `rounded_mm` is the largest distance along an axis (X a radius) by which a position was rounded.
    """

    source: bytes
    dialect: str
    losses: tuple[Finding, ...]
    blocks: int
    moves: int
    decimals: int
    rounded_mm: float


def translate(
    program: Program,
    to: str,
    parameters: Mapping[str, float] | None = None,
    *,
    skipped_blocks: bool = False,
    decimals: int | None = None,
) -> Translation:
    """Writes a program in the dialect `to`; `decimals` of coordinates, without it those of the control's resolution,
    or of the source's coordinates where these are more.

    Raises NC-DIALECT, NC-LOST (a turning program for a mill or the other way round, an arc or a thread that cannot be
    written), NC-LIMIT (a negative number of decimals or more than 9) and what running the program raises.

    >>> made = trueloop.translate(trueloop.read_program(trueloop.example("linuxcnc/finish.ngc")), "fanuc-lathe")
    >>> made.moves, made.decimals, [loss.severity.value for loss in made.losses]
    (14, 5, ['note', 'warning', 'warning'])
    >>> for block in made.source.decode().splitlines()[:4]:
    ...     print(block)
    %
    O0001
    (translated from linuxcnc by trueloop: run it without a part first)
    (source sha256 4ce29f6f9352e5c9e696729125dc7b6e4a4f73dfdcec7804a36c49d113f2a0db)
    """
    target = Target(dialect_named(to).with_decimals(nc_written_decimals(program.core)), CONTROLS[to], decimals)
    if decimals is not None and not 0 <= decimals <= MOST_DECIMALS:
        raise TrueloopError(Code.NC_LIMIT, f"{decimals} decimals: 0 to 9 can be written", hint="leave --decimals out")
    path = program.run(parameters, skipped_blocks=skipped_blocks, trace=True)
    if True not in target.control.inch and path.inch.any():
        raise TrueloopError(
            Code.NC_LOST,
            f"this turning program is in inch, and one of {to} does not say its unit: it is taken for millimetres",
            hint="write it in millimetres first",
        )
    from_control, same = CONTROLS[program.dialect.name], program.dialect.name == to
    words = [word for block in program.other_blocks for word in block.words if word.letter in ("M", "T")]
    by_m6 = any(word.letter == "M" and word.value == 6 for word in words)
    names_tools = any(word.letter == "T" and '"' in word.text for word in words)
    source = Source(program, path, from_control, target.control, same, by_m6, names_tools)
    require_same_kind(source, to)
    if target.control.tool_offset in ("D", "call"):
        target = replace(target, rows=rows_of_tools(said for _, said in statements(source)))
    lines, losses, state = _written(target, _headed(source, to), program.file)
    lines = _framed(source, target, lines)
    text = "\n".join(lines) + "\n"
    return Translation(
        text.encode("latin-1", "replace"), to, losses, len(lines), len(path), places(target, state), state.rounded_mm
    )


def _headed(source: Source, to: str) -> Iterator[Said]:
    """Where the program comes from, then all that it says."""
    digest = hashlib.sha256(source.program.source).hexdigest()
    yield None, Remark(f"translated from {source.program.dialect.name} by trueloop: run it without a part first")
    yield None, Remark(f"source sha256 {digest}")
    for word, said in statements(source):
        active = isinstance(said, Remark) and to == "linuxcnc" and ACTIVE_COMMENT.match(said.text)
        yield word, Remark(f"- {said.text}") if active and isinstance(said, Remark) else said


def _written(target: Target, said: Iterable[Said], file: str | None) -> tuple[list[str], tuple[Finding, ...], InForce]:
    """Blocks, losses in the order of the source, and what is in force at the end."""
    write = klartext.write if target.dialect.name == KLARTEXT else gcode.write
    state = InForce(words={"spindle": "G97"} if target.control.kind == "milling" else {})
    lines: list[str] = []
    losses: dict[tuple[Place, str], Finding] = {}
    for word, statement in said:
        items: list[str | Lost] = []
        if isinstance(statement, Lost):
            items.append(statement)
        else:
            state = _collected(write(target, state, statement), items)
        lines += [item for item in items if isinstance(item, str) and item]
        for item in items:
            if isinstance(item, Lost):
                loss = _finding(item, word, file)
                losses.setdefault((loss.place, loss.message), loss)
    return lines, tuple(sorted(losses.values(), key=_place)), state


def _collected(writing: Writing, items: list[str | Lost]) -> InForce:
    """What is in force after the blocks and losses, which are added to the items."""
    while True:
        try:
            items.append(next(writing))
        except StopIteration as done:
            state: InForce = done.value
            return state


def _place(loss: Finding) -> tuple[int, int]:
    return loss.place.line or 0, loss.place.column or 0


def _finding(lost: Lost, word: Word | None, file: str | None) -> Finding:
    place = Place(file, word.line, word.column) if word else Place(file)
    message = f'"{word.text.strip()}": {lost.what}' if word else lost.what
    if lost.refuses:
        raise TrueloopError(Code.NC_LOST, f"{message}: it cannot be written", hint=HINT, place=place)
    return Finding(lost.severity, Code.NC_LOST, message, HINT, place)


def _framed(source: Source, target: Target, lines: list[str]) -> list[str]:
    """With what a program of the control begins and ends with, under the source's number."""
    numbers = (
        w.value for block in source.program.other_blocks for w in block.words if w.letter == "O" and w.kind == "number"
    )
    found = next(numbers, 1.0)
    number = int(found) if 0 < found < 10_000 else 1
    if target.dialect.name == KLARTEXT:
        return klartext.numbered(lines, f"O{number:04d}")
    control = target.control
    return [*(line.format(number=number) for line in control.begin), *lines, *control.end]
