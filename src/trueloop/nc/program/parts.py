"""A program run in parts, so that memory does not grow with its moves: some megabytes of whole lines at a time."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop._core import NcProgram, NcSession, nc_part, nc_written_decimals
from trueloop.errors import Code, Finding, Severity
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.dialect import Dialect, dialect_named
from trueloop.nc.program.program import BLOCK_LIMIT, Program, Unit, contradicted, read_program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.nc.program.understood import require_unit

PART: Final = 1 << 21
"""The size of a part in bytes; the rest of its last line is added."""
_MOST_FINDINGS: Final = 1000
"""So many or more are not all kept by a run of the whole program."""


@dataclass(frozen=True)
class Lines:
    """Whole lines, of which those from `until` on are only looked at; `first` is the number of lines before them. The
    program's dialect has the decimals of the whole program.
    """

    program: Program
    until: int
    first: int

    def located(self, findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
        """Returns the findings up to line `until`, with the lines of the whole program."""
        return tuple(
            replace(found, place=replace(found.place, line=self.first + found.place.line))
            for found in findings
            if found.place.line is not None and found.place.line <= self.until
        )


@dataclass(frozen=True)
class Part:
    """The moves of some lines, and what was noticed in them as text and in their run. Lines of moves and findings are
    those of the whole program; `ToolPath.word` counts from the part's own first word, `ToolPath.calls` is empty.
    """

    path: ToolPath
    of_text: tuple[Finding, ...]
    lines: Lines


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
    """Yields the program's parts as `Program.run` has them, without tools. None, and nothing after it, where it must be
    run as a whole: it is one part, has a block that sends the run elsewhere, is larger than a run's limit, or has
    what a run refuses.
    """
    if len(source) <= size:
        yield None
        return
    rotary, count, decimals, known = "", 0, 0, dialect_named(dialect)
    for lines in _lines(source, known, file, unit, size):
        jumps, letters = nc_part(lines.program.core)
        rotary, count = "".join(sorted({*rotary, *letters})), count + lines.until
        decimals = max(decimals, nc_written_decimals(lines.program.core))
        if jumps or count > BLOCK_LIMIT:
            yield None
            return
    inch = None if unit is None else unit == "inch"
    offsets = list((work_offsets_mm or {}).items())
    try:
        session = NcSession(dialect, list(parameters.items()), skipped_blocks, offsets, inch, rotary)
    except ValueError:  # a name that is not a parameter's: the run of the whole program says which
        yield None
        return
    noticed = moves = 0
    for lines in _lines(source, known.with_decimals(decimals), file, unit, size):
        part = _run(session, lines, unit)
        noticed, moves = noticed + len(part.of_text) + len(part.path.findings), moves + len(part.path)
        if noticed >= _MOST_FINDINGS or moves > BLOCK_LIMIT or any(map(_refuses, part.path.findings)):
            yield None
            return
        yield part


@dataclass(frozen=True)
class Stretch:
    """The moves of a path from `first` on, and what was noticed in the program so far, as text and in its run."""

    path: ToolPath
    first: int
    of_text: tuple[Finding, ...]
    of_run: tuple[Finding, ...]

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Returns the findings of the text, then those of the run."""
        return (*self.of_text, *self.of_run)


def stretches(
    source: bytes,
    dialect: str,
    file: str | None,
    unit: Unit | None,
    parameters: Mapping[str, float],
    *,
    skipped_blocks: bool = False,
    tools: Sequence[CutterTool] = (),
    work_offsets_mm: Mapping[int, tuple[float, float, float]] | None = None,
    size: int = PART,
) -> Iterator[Stretch]:
    """Yields the path as `Program.run` has it when it is not strict, stretch by stretch: a part each, or, from
    where it must be run as a whole, the rest. Raises what `read_program` and `require_unit` do.
    """
    done = 0
    of_text: tuple[Finding, ...] = ()
    of_run: tuple[Finding, ...] = ()
    for part in [None] if tools else parts(
        source, dialect, file, unit, parameters,
        skipped_blocks=skipped_blocks, work_offsets_mm=work_offsets_mm, size=size,
    ):  # fmt: skip
        if part is None:
            break
        of_text, of_run = (*of_text, *part.of_text), (*of_run, *part.path.findings)
        yield Stretch(part.path, 0, of_text, of_run)
        done += len(part.path)
    else:
        return
    program = read_program(source, dialect, file, unit)
    path = program.run(
        parameters, skipped_blocks=skipped_blocks, tools=tools, work_offsets_mm=work_offsets_mm, strict=False
    )
    require_unit(path)
    yield Stretch(path, done, program.findings, path.findings)


def _refuses(finding: Finding) -> bool:
    return finding.severity is Severity.ERROR or finding.code is Code.NC_UNIT


def _lines(source: bytes, dialect: Dialect, file: str | None, unit: Unit | None, size: int) -> Iterator[Lines]:
    start = first = 0
    while start < len(source):
        end = (source.find(b"\n", start + size) + 1) or len(source)
        ahead = (source.find(b"\n", end) + 1) or len(source)
        core = NcProgram(source[start:ahead], dialect.name)
        until = core.block_at(end - start) if end < ahead else core.block_count
        yield Lines(Program(source[start:ahead], dialect, file, core, unit), until, first)
        start, first = end, first + until


def _run(session: NcSession, lines: Lines, unit: Unit | None) -> Part:
    moves, states, rows, stated = session.run(lines.program.core, lines.until)
    moves["block"] += lines.first
    stated = None if stated is None else (stated[0] + lines.first, stated[1])
    found = lines.located(lines.program.found(rows)) + contradicted(unit, stated, lines.program.file)
    path = ToolPath(findings=found, states=states, unit_stated=stated, **moves)
    return Part(path, lines.located(lines.program.findings), lines)
