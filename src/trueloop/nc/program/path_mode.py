"""Whether the control keeps to the programmed path through corners.

LinuxCNC starts in G64 without a tolerance unless its set-up says otherwise: it keeps up speed and rounds corners as far
as its accelerations ask, tenths of a millimetre at finishing feeds. A contour corrected by micrometres needs G61, or
G64 with P.
"""

from collections.abc import Iterator

import numpy as np

from trueloop.errors import Code, Finding, Place, Severity
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import Motion, ToolPath

EXACT, BLENDED = (61.0, 61.1), 64.0
HINT = "write G64 P0.0001 (inch) or G64 P0.002 (mm), or G61, before the first cut"


def path_mode_findings(program: Program, path: ToolPath) -> Iterator[Finding]:
    """NC-BLEND where the first cut runs without a bound on the rounding of corners: a note where the program names no
    path mode, a warning where it names one without a bound. Blocks are looked at in the order they are written.
    """
    cuts = path.line[np.isin(path.motion, [Motion.LINE, Motion.ARC])]
    if not program.dialect.blends_corners or not cuts.size:
        return
    named = [block for block in map(program.block, range(int(cuts[0]))) if _mode(block) is not None]
    if not named:
        message = "no path mode before the first cut: by its default LinuxCNC rounds corners without a bound"
        yield _finding(Severity.NOTE, message, Place(program.file, int(cuts[0]), 1))
    elif _mode(named[-1]) == BLENDED and not any(word.letter == "P" for word in named[-1].words):
        message = "G64 without P: corners are rounded as far as the machine's accelerations ask"
        yield _finding(Severity.WARNING, message, Place(program.file, named[-1].line, 1))


def _mode(block: Block) -> float | None:
    codes = [word.value for word in block.words if word.letter == "G" and not block.skipped]
    return next((code for code in codes if code in (*EXACT, BLENDED)), None)


def _finding(severity: Severity, message: str, place: Place) -> Finding:
    return Finding(severity, Code.NC_BLEND, message, HINT, place)
