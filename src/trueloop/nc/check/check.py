"""Findings about a program: in its text, in its run, and in its geometry. Nothing here refuses the program."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from trueloop.errors import Code, Finding
from trueloop.nc.check.geometry import Geometry
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.parts import PART, Lines, parts
from trueloop.nc.program.program import BLOCK_LIMIT, Program, Unit

_ENDLESS_BLOCKS = 10_000
"""Of a program that does not end so many blocks are looked at as geometry, or twice as many as it has."""


@dataclass(frozen=True)
class ProgramCheck:
    """The findings of a program, in order of place, and the number of its blocks."""

    findings: list[Finding]
    block_count: int


def check(
    program: Program,
    parameters: Mapping[str, float] | None = None,
    *,
    skipped_blocks: bool = False,
    tools: Sequence[CutterTool] = (),
    arc_tolerance_mm: float | None = None,
    block_limit: int = BLOCK_LIMIT,
) -> list[Finding]:
    """Returns every finding, in order of place.

    Text: NC-WORD, NC-CODE, NC-DUPLICATE, NC-NUMBER. Run: NC-DUPLICATE and NC-FEED (two codes of one group, a feed or
    speed below zero), NC-PARAMETER (every parameter without a value), NC-EXPRESSION, NC-FLOW, NC-LIMIT, NC-UNIT,
    NC-DIAMETER, NC-MISPLACED, NC-OPAQUE, NC-ARC; with `tools`, what keeps them from the contour under G41 and G42:
    NC-TOOL, NC-ENTRY, NC-GOUGE. Geometry, of the programmed contour:
    NC-ARC-FIT (an arc whose end is not on the circle about its centre, or whose chord is longer than its diameter, by
    more than `arc_tolerance_mm`; without it, by more than the rounding of the program's own decimals explains),
    NC-TANGENT (a joint of an arc that is neither tangent nor a corner: a jump of direction of 0.1° to 5°, beyond what
    rounding makes of short moves), NC-FEED (a cut without a feed), NC-RAPID (a rapid move through material, on a
    lathe), NC-BLEND (the control may round corners without a bound).

    >>> program = trueloop.read_program(trueloop.example("linuxcnc/finish.ngc"))
    >>> for finding in trueloop.check(program):
    ...     print(finding.severity, finding.code, finding.message)
    note NC-OPAQUE G43: the tool table's length offset is taken as zero
    """
    path = program.run(parameters, skipped_blocks=skipped_blocks, block_limit=block_limit, strict=False)
    driven = program.run(
        parameters, skipped_blocks=skipped_blocks, block_limit=block_limit, tools=tools, strict=False
    ) if tools else path  # fmt: skip
    if any(finding.code is Code.NC_LIMIT for finding in driven.findings):  # endless: every turn is odd alike
        once_round = min(block_limit, max(2 * program.block_count, _ENDLESS_BLOCKS))
        path = program.run(parameters, skipped_blocks=skipped_blocks, block_limit=once_round, strict=False)
    of_moves = Geometry(program.source, arc_tolerance_mm).and_then(path, Lines(program, program.block_count, 0))
    of_run = [found for found in driven.findings if arc_tolerance_mm is None or found.code is not Code.NC_ARC_FIT]
    return _in_order([*program.findings, *of_run], of_moves, program.file)


def check_in_parts(
    source: bytes,
    dialect: str,
    file: str | None,
    unit: Unit | None,
    parameters: Mapping[str, float],
    *,
    skipped_blocks: bool = False,
    size: int = PART,
) -> ProgramCheck | None:
    """Checks a long program in parts of `size` bytes, without tools; None where it must be run as a whole."""
    of_text: list[Finding] = []
    of_run: list[Finding] = []
    of_moves, count = Geometry(source), 0
    for part in parts(source, dialect, file, unit, parameters, skipped_blocks=skipped_blocks, size=size):
        if part is None:
            return None
        of_text += part.of_text
        of_run += part.path.findings
        of_moves, count = of_moves.and_then(part.path, part.lines), count + part.lines.until
    return ProgramCheck(_in_order([*of_text, *of_run], of_moves, file), count)


def _in_order(findings: Sequence[Finding], of_moves: Geometry, file: str | None) -> list[Finding]:
    located = (finding.in_file(file) for finding in of_moves.findings())
    once = {
        (finding.place, finding.code): finding for finding in reversed([*findings, *located])
    }  # a loop comes by often
    return sorted(once.values(), key=lambda finding: (finding.place.line or 0, finding.place.column or 0))
