"""The path mode: how far the control keeps to the programmed path through corners.

LinuxCNC starts in G64 without a tolerance unless its set-up says otherwise: it keeps up speed and rounds corners as far
as its accelerations ask, tenths of a millimetre at finishing feeds. A contour corrected by micrometres needs G61, or
G64 with P.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from trueloop.errors import Code, Finding, Place, Severity
from trueloop.nc.program.parts import Lines
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import Motion, ToolPath

EXACT, BLENDED = (61.0, 61.1), 64.0
HINT = "write G64 P0.0001 (inch) or G64 P0.002 (mm), or G61, before the first cut"


@dataclass(frozen=True)
class PathMode:
    """The line of a program's first cut, None before it has come, and the last block before it that names a mode."""

    file: str | None = None
    cut: int | None = None
    named: Block | None = None

    def and_then(self, path: ToolPath, lines: Lines) -> "PathMode":
        """Returns the state after these lines and their moves; unchanged for a control that does not blend corners."""
        if self.cut is not None or not lines.program.dialect.blends_corners:
            return self
        cuts = path.line[np.isin(path.motion, [Motion.LINE, Motion.ARC])]
        cut = int(cuts[0]) if cuts.size else None
        before = range(lines.until if cut is None else cut - lines.first)
        named = [block for block in map(lines.program.block, before) if mode_of(block) is not None]
        last = replace(named[-1], line=lines.first + named[-1].line) if named else self.named
        return PathMode(lines.program.file, cut, last)

    def findings(self) -> Iterator[Finding]:
        """Yields NC-BLEND where the first cut runs without a bound on the rounding of corners: a note where the program
        names no path mode, a warning where it names one without a bound. Blocks count in the order they are written.
        """
        if self.cut is None:
            return
        if self.named is None:
            message = "no path mode before the first cut: by its default LinuxCNC rounds corners without a bound"
            yield _finding(Severity.NOTE, message, Place(self.file, self.cut, 1))
        elif mode_of(self.named) == BLENDED and not any(word.letter == "P" for word in self.named.words):
            message = "G64 without P: corners are rounded as far as the machine's accelerations ask"
            yield _finding(Severity.WARNING, message, Place(self.file, self.named.line, 1))


def path_mode_findings(program: Program, path: ToolPath) -> Iterator[Finding]:
    """Yields `PathMode.findings` of a whole program."""
    return PathMode().and_then(path, Lines(program, program.block_count, 0)).findings()


def mode_of(block: Block) -> float | None:
    """Returns the path mode that a block names: `BLENDED`, or one of `EXACT`; None: it names none, or is skipped."""
    codes = [word.value for word in block.words if word.letter == "G" and not block.skipped]
    return next((code for code in codes if code in (*EXACT, BLENDED)), None)


def _finding(severity: Severity, message: str, place: Place) -> Finding:
    return Finding(severity, Code.NC_BLEND, message, HINT, place)
