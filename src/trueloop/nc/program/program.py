"""An NC program: its bytes, and blocks and words as spans of them.

Nothing is normalised: `Program.source` is what was read, and an unedited program is written by writing it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import PurePath
from typing import Literal, TypeAlias

from trueloop._core import NcProgram, nc_writes_comma, nc_written_decimals
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError, Unseen
from trueloop.nc.program.called import CutterTool, tool_rows
from trueloop.nc.program.dialect import Dialect, dialect_named
from trueloop.nc.program.tool_path import ToolPath

BLOCK_LIMIT = 10_000_000
"""The most blocks that a run executes, every turn of a loop counted."""

Unit: TypeAlias = Literal["mm", "inch"]
"""The unit of a program's lengths."""


@dataclass(frozen=True)
class Word:
    """A word of a block. `start`, `end`, `value_start` are byte offsets; line and column count from 1, in bytes.

    `kind` is number, expression, assignment, statement, flow, name, label, call or unknown; `value` the number of a
    number word, otherwise NaN. `increment` is whether the word itself states an increment (True) or a position, as U
    or `X=IC(5)` do, whatever mode is in force; None where it does not.
    """

    index: int
    block: int
    letter: str
    kind: str
    start: int
    end: int
    value_start: int
    line: int
    column: int
    text: str
    value: float
    increment: bool | None = None

    @property
    def is_expression(self) -> bool:
        """Returns whether the value is computed when the program runs."""
        return self.kind == "expression"


@dataclass(frozen=True)
class Block:
    """A block: one line. `end` does not count the line's end; `number` is its N word; `skipped` says that it starts
    with a slash, so that it is run only when the operator asks for it.
    """

    index: int
    line: int
    start: int
    end: int
    number: int | None
    words: tuple[Word, ...]
    skipped: bool

    @property
    def data(self) -> tuple[Word, ...]:
        """Its words without its number and its label, which come first."""
        return tuple(word for word in self.words if word.letter != "N" and word.kind != "label")


@dataclass(frozen=True)
class OffsetStatement:
    """A tool offset update, `(UPD, tool, TOV(axis), value)`; the value in program units, its span in bytes."""

    tool: int
    axis: str
    value: float
    value_start: int
    value_end: int
    line: int


@dataclass(frozen=True)
class Program:
    """A program as read. Made by `read_program`.

    `unit`: the one in force when it starts, where the caller states it; `decimals`: how many are written at least.
    """

    source: bytes
    dialect: Dialect
    file: str | None
    core: NcProgram = field(repr=False, compare=False)
    unit: Unit | None = None
    decimals: int = 0

    def __reduce__(self) -> tuple[object, ...]:
        """Copies are read anew from the source: another process has its own core."""
        return read_program, (self.source, self.dialect.name, self.file, self.unit, self.decimals)

    def rewritten(self, source: bytes) -> "Program":
        """Reads another text of this program with its dialect, file and unit, never written coarser than this one."""
        decimals = max(self.decimals, nc_written_decimals(self.core))
        return read_program(source, self.dialect.name, self.file, self.unit, decimals)

    @property
    def file_name(self) -> str:
        """Returns the file's name without its folder; `program.nc` where it comes from no file."""
        return PurePath(self.file or "program.nc").name

    @property
    def block_count(self) -> int:
        """Returns the number of blocks: block i is line i + 1."""
        return self.core.block_count

    def block(self, index: int) -> Block:
        """Returns the block of that index, from 0."""
        start, end, first, after, skipped, _ = self.core.block(index)
        words = tuple(self.word(word) for word in range(first, after))
        number = next((int(word.value) for word in words if word.letter == "N" and word.kind == "number"), None)
        return Block(index=index, line=index + 1, start=start, end=end, number=number, words=words, skipped=skipped)

    @property
    def blocks(self) -> Iterator[Block]:
        """Yields all blocks in order."""
        return (self.block(index) for index in range(self.block_count))

    def word(self, index: int) -> Word:
        """Returns the word of that index, from 0 through the whole program."""
        letter, start, end, value_start, kind, value, block, increment = self.core.word(index)
        column = start - self.core.block(block)[0] + 1
        text = self.source[start:end].decode("latin-1")
        name = letter if letter != "\0" else ""
        return Word(
            index=index,
            block=block,
            letter=name,
            kind=kind,
            start=start,
            end=end,
            value_start=value_start,
            line=block + 1,
            column=column,
            text=text,
            value=value,
            increment=increment,
        )

    def place(self, offset: int) -> Place:
        """Returns line and column of a byte."""
        block = self.core.block_at(offset)
        start = self.core.block(block)[0] if self.block_count else 0
        return Place(self.file, block + 1, offset - start + 1)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Returns the findings that need no run: unknown words and codes, words twice in a block, odd numbers."""
        return self.found(self.core.findings())

    @cached_property
    def offset_statements(self) -> tuple[OffsetStatement, ...]:
        """Returns the tool offset updates whose value is a number, in order."""
        rows = self.core.offset_statements()
        return tuple(
            OffsetStatement(
                tool=tool, axis=axis, value=value, value_start=start, value_end=end, line=self.core.block_at(start) + 1
            )
            for tool, axis, value, start, end, _ in rows
        )

    def parameters_used(self) -> tuple[str, ...]:
        """Parameters that its expressions read (`P46`, `#1`, `#<depth>`), in order of first use."""
        return tuple(name for name, _ in self.core.parameters_used())

    def run(
        self,
        parameters: Mapping[str, float] | None = None,
        *,
        skipped_blocks: bool = False,
        position_mm: tuple[float, float, float] = (0.0, 0.0, 0.0),
        inch: bool | None = None,
        diameter: bool | None = None,
        plane: int | None = None,
        tools: Sequence[CutterTool] = (),
        work_offsets_mm: Mapping[int, tuple[float, float, float]] | None = None,
        block_limit: int = BLOCK_LIMIT,
        strict: bool = True,
        trace: bool = False,
        roughing: bool = True,
        placed: bool = True,
        roughed_contours: bool = False,
    ) -> ToolPath:
        """Runs the program and returns the tool path.

        parameters: values by name (`P46`, `#1`, `#<depth>`). skipped_blocks: run the blocks that start with a slash.
        position_mm: where the tool stands at the start, X a radius. inch, diameter, plane (17, 18, 19): the state at
        the start where it is not the program's `unit` and the dialect's own. tools: with them the path under G41 and
        G42 is that of the controlled point, without them the programmed contour; G43 takes their lengths, T0101 their
        offsets.
        work_offsets_mm: where the zeros of work offsets are in machine coordinates, X a radius, by number from 1 (G54);
        `offset_number` knows their names. trace: note the blocks executed and the state after each. roughing: take
        roughing cycles (G71 to G73) apart; without it their passes, which only follow the contour, are
        not in the path. placed: turned, mirrored and scaled coordinates are those of the work frame, otherwise those
        of the words. roughed_contours: run a contour that is roughed alone, too.
        block_limit: the most blocks or moves, never more than 3,000,000 beyond those of the program.
        strict: raise the first of NC-PARAMETER (a parameter without a value), NC-EXPRESSION, NC-FLOW, NC-LIMIT,
        NC-UNIT (a length before the unit is stated, or one stated against the one given), NC-DUPLICATE (two codes of
        one group), NC-FEED (one below zero) and, with tools, NC-TOOL (one that is
        not among them), NC-GOUGE (a corner it does not fit into) and NC-ENTRY (a way in that is too short); without it
        they are among the path's findings, with what could not be computed as NaN.
        """
        if inch is None and self.unit is not None:
            inch = self.unit == "inch"
        try:
            moves, states, rows, unit = self.core.run(
                list((parameters or {}).items()), skipped_blocks, position_mm, block_limit, inch, diameter, plane,
                tool_rows(tools), trace, list((work_offsets_mm or {}).items()), roughing, placed, roughed_contours,
            )  # fmt: skip
        except ValueError as refused:
            raise no_parameter(str(refused), self.dialect.name) from None
        findings = (*self.found(rows), *contradicted(self.unit, unit, self.file))
        if strict:
            _raise_first(findings)
        return ToolPath(findings=findings, states=states, unit_stated=unit, **moves)

    def found(self, rows: list[tuple[str, str, str, str, int, str]]) -> tuple[Finding, ...]:
        """Findings as the Rust core gives them, with their places."""
        return tuple(
            Finding(Severity(severity), Code(code), message, hint, self.place(at), unseen=Unseen(unseen))
            for severity, code, message, hint, at, unseen in rows
        )


def contradicted(unit: Unit | None, stated: tuple[int, bool] | None, file: str | None) -> tuple[Finding, ...]:
    """Returns NC-UNIT where the block `stated` (from 0) states before any length another unit than the one given."""
    if unit is None or stated is None or stated[1] is (unit == "inch"):
        return ()
    message = f"line {stated[0] + 1} states {'inch' if stated[1] else 'mm'}, and the unit was given as {unit}"
    hint = "leave --unit, in a job programs.unit, out: the program states its unit itself"
    return (Finding(Severity.ERROR, Code.NC_UNIT, message, hint, Place(file, stated[0] + 1, 1)),)


def no_parameter(name: str, dialect: str) -> TrueloopError:
    """Returns the error NC-PARAMETER of a name that is not a parameter's."""
    return Code.NC_PARAMETER.refusal(
        f"{name} names no parameter of the dialect {dialect}",
        hint="write P46=3.52 for ge2000t, #1=5 for fanuc and haas, #1=5 or #<depth>=2 for linuxcnc, "
        "R1=5 or LENGTH=30 for siemens, Q5=2 for heidenhain",
    )


_RAISED = {
    *(Code.NC_PARAMETER, Code.NC_EXPRESSION, Code.NC_FLOW, Code.NC_LIMIT),
    *(Code.NC_DUPLICATE, Code.NC_FEED),
    *(Code.NC_TOOL, Code.NC_GOUGE, Code.NC_ENTRY),
}


def _raise_first(findings: tuple[Finding, ...]) -> None:
    for found in findings:
        if (found.severity == Severity.ERROR and found.code in _RAISED) or found.code is Code.NC_UNIT:
            raise found.as_error()


def read_program(
    source: bytes, dialect: str, file: str | None = None, unit: Unit | None = None, decimals: int = 0
) -> Program:
    """Reads a program: any bytes can be read. Raises NC-DIALECT (no such dialect), NC-LIMIT (2 GiB or more).

    unit: the one in force at its start. Coordinates are written with as many decimals as the control resolves, the
    program's own have, or `decimals` requests, whichever is most.
    """
    known = dialect_named(dialect)
    try:
        core = NcProgram(source, dialect)
    except OverflowError:
        raise Code.NC_LIMIT.refusal(
            f"a program of {len(source)} bytes is too large: 2147483647 is the most",
            hint="split the program",
            place=Place(file),
        ) from None
    as_written = known.with_decimals(max(decimals, nc_written_decimals(core)))
    return Program(
        source=source,
        dialect=replace(as_written, decimal_comma=nc_writes_comma(core)),
        file=file,
        core=core,
        unit=unit,
        decimals=decimals,
    )
