"""A program run in parts, so that memory does not grow with its moves: some megabytes of whole lines at a time."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from trueloop._core import NcProgram, NcSession, nc_part
from trueloop.errors import Code, Finding, Severity
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.program import BLOCK_LIMIT, Program, Unit, contradicted
from trueloop.nc.program.tool_path import ToolPath

PART: Final = 1 << 21
"""Bytes of a part, to which the rest of their last line comes."""
_MOST_FINDINGS: Final = 1000
"""So many or more are not all kept by a run of the whole program."""


@dataclass(frozen=True)
class Part:
    """The moves of some lines, and what was noticed in them as text and in their run. Lines are those of the whole
    program; `ToolPath.word` counts from the part's own first word, `ToolPath.calls` is empty.
    """

    path: ToolPath
    of_text: tuple[Finding, ...]


@dataclass(frozen=True)
class _Lines:
    """Whole lines, of which those from `until` on are only looked at; `first` is the number of lines before them."""

    program: Program
    until: int
    first: int

    def located(self, findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
        """The findings before `until`, with the lines of the whole program."""
        return tuple(
            replace(found, place=replace(found.place, line=self.first + found.place.line))
            for found in findings
            if found.place.line is not None and found.place.line <= self.until
        )


def parts(
    source: bytes,
    dialect: str,
    file: str | None,
    unit: Unit | None,
    parameters: Mapping[str, float],
    *,
    skipped_blocks: bool = False,
    work_offsets_mm: Mapping[int, tuple[float, float, float]] | None = None,
    size: int = PART,
) -> Iterator[Part | None]:
    """The program's parts as `Program.run` has them, without tools. None, and nothing after it, where only the whole
    program tells: it is one part, has a block that sends the run elsewhere, is larger than a run's limit, or has what a
    run refuses.
    """
    if len(source) <= size:
        yield None
        return
    rotary, count = "", 0
    for lines in _lines(source, dialect, file, unit, size):
        jumps, letters = nc_part(lines.program.core)
        rotary, count = "".join(sorted({*rotary, *letters})), count + lines.until
        if jumps or count > BLOCK_LIMIT:
            yield None
            return
    inch = None if unit is None else unit == "inch"
    offsets = list((work_offsets_mm or {}).items())
    try:
        session = NcSession(dialect, list(parameters.items()), skipped_blocks, offsets, inch, rotary)
    except ValueError:  # a name that is none of a parameter: the run of the whole program says which
        yield None
        return
    noticed = moves = 0
    for lines in _lines(source, dialect, file, unit, size):
        part = _run(session, lines, unit)
        noticed, moves = noticed + len(part.of_text) + len(part.path.findings), moves + len(part.path)
        if noticed >= _MOST_FINDINGS or moves > BLOCK_LIMIT or any(map(_refuses, part.path.findings)):
            yield None
            return
        yield part


def _refuses(found: Finding) -> bool:
    return found.severity is Severity.ERROR or found.code is Code.NC_UNIT


def _lines(source: bytes, dialect: str, file: str | None, unit: Unit | None, size: int) -> Iterator[_Lines]:
    start = first = 0
    while start < len(source):
        end = (source.find(b"\n", start + size) + 1) or len(source)
        ahead = (source.find(b"\n", end) + 1) or len(source)
        core = NcProgram(source[start:ahead], dialect)
        until = core.block_at(end - start) if end < ahead else core.block_count
        yield _Lines(Program(source[start:ahead], dialect_named(dialect), file, core, unit), until, first)
        start, first = end, first + until


def _run(session: NcSession, lines: _Lines, unit: Unit | None) -> Part:
    moves, states, rows, stated = session.run(lines.program.core, lines.until)
    moves["block"] += lines.first
    stated = None if stated is None else (stated[0] + lines.first, stated[1])
    found = lines.located(lines.program.found(rows)) + contradicted(unit, stated, lines.program.file)
    path = ToolPath(findings=found, states=states, unit_stated=stated, **moves)
    return Part(path, lines.located(lines.program.findings))
