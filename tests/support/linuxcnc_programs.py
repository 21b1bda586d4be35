"""The programs that Debian installs with LinuxCNC, each run by its own interpreter and by ours."""

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from tests.support.linuxcnc import Move, ProgramRefusedError, Tool, interpret
from tests.support.nc_judge import assert_same_moves, kind_of, leading_somewhere
from trueloop.errors import Severity
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

FOLDER: Final = Path("/usr/share/linuxcnc/ncfiles")
STARTUP: Final = "G17 G21 G40 G90 G94"
RADIUS_MM: Final = 0.5
"""Of every tool, in the table of both."""
CENTRE: Final = 9
"""The tip's orientation: the controlled point is the nose's centre, as a milling cutter's."""
TOOLS: Final = [Tool(number, RADIUS_MM, CENTRE) for number in range(1, 100)]
SAME: Final = "the same moves to 1e-9 in"
STANDS: Final = "with a straight move of no length before each tool change"
CHANGE: Final = re.compile(r"^(.*\bm6\b)", re.IGNORECASE | re.MULTILINE)
NO_CUT: Final = "no cut: a subroutine, or a program that only sets things"
OTHER: Final = "other moves"
REFUSED: Final = "refused by LinuxCNC's interpreter as it stands here"
HEADING: Final = "| Program | Outcome | Why |\n|---|---|---|"


@dataclass(frozen=True)
class Outcome:
    """What became of one program. `why` is empty where both make the same moves."""

    name: str
    outcome: str
    why: str = ""

    @property
    def is_motion_program(self) -> bool:
        """Whether LinuxCNC itself makes cuts of it."""
        return self.outcome not in (NO_CUT, REFUSED)


def outcomes() -> list[Outcome]:
    """Every program in the folder, by name. Those in folders below it are subroutines for a configured machine."""
    return [_outcome(file) for file in sorted(FOLDER.glob("*.ngc"))]


def _outcome(file: Path) -> Outcome:
    name = file.name
    try:
        judged = interpret(file, tools=TOOLS, startup=STARTUP)
    except ProgramRefusedError as refused:
        return Outcome(name, REFUSED, refused.message)
    except RuntimeError as ended:
        return Outcome(name, REFUSED, str(ended).splitlines()[-1].split("/")[-1])
    if not any(move.kind in ("line", "arc") for move in judged):
        return Outcome(name, NO_CUT)
    program = read_program(file.read_bytes(), "linuxcnc", name)
    path = _path(program)
    try:
        assert_same_moves(path, judged)
    except AssertionError:
        if _same_with_a_move_before_tool_changes(file):
            return Outcome(name, SAME, STANDS)
        told = [finding for finding in (*program.findings, *path.findings) if finding.severity is not Severity.NOTE]
        said = sorted(told, key=lambda finding: finding.severity is not Severity.ERROR)
        why = f"line {said[0].place.line}: {said[0].message}" if said else _first_difference(path, judged)
        return Outcome(name, OTHER, why)
    return Outcome(name, SAME)


def _path(program: Program) -> ToolPath:
    return program.run(inch=False, plane=17, strict=False, tools=[CutterTool(RADIUS_MM, CENTRE)])


def _same_with_a_move_before_tool_changes(file: Path) -> bool:
    """After a tool change the interpreter asks where the tool stands. The module that answers here does not note where
    an arc ended; and where G40 left the tool beside its programmed place the program's own idea of it is another.
    A straight move of no length before the change makes both agree."""
    text, changes = CHANGE.subn(r"g91 g1 x0 y0 z0\ng90\n\1", file.read_text(encoding="latin-1"))
    if not changes:
        return False
    with TemporaryDirectory() as folder:
        mended = Path(folder) / file.name
        mended.write_text(text, encoding="latin-1")
        try:
            judged = interpret(mended, tools=TOOLS, startup=STARTUP)
            assert_same_moves(_path(read_program(mended.read_bytes(), "linuxcnc")), judged)
        except (ProgramRefusedError, AssertionError):
            return False
    return True


def _first_difference(path: ToolPath, judged: Sequence[Move]) -> str:
    """Where nothing was said: our own fault, or a move of another kind."""
    ours, theirs = leading_somewhere(path, judged)
    for kind, line, end, move in zip(path.motion[ours], path.line[ours], path.end_mm[ours], theirs, strict=False):
        if kind_of(kind) != move.kind:
            return f"line {line}: a {Motion(kind).name.lower()} move here, a {move.kind} move there"
        if (off_mm := math.dist(end, move.end_mm)) > 1e-6:
            return f"line {line}: its end is {off_mm:.6f} mm from there"
    return f"{len(path)} moves here, {len(judged)} there"


def table(found: list[Outcome]) -> str:
    """The counts, then a row a motion program: those that differ first."""
    motion = [row for row in found if row.is_motion_program]
    same = sum(row.outcome == SAME for row in motion)
    refused = Counter(row.why for row in found if row.outcome == REFUSED)
    reasons = "; ".join(
        f"{count} × {why}" for why, count in sorted(refused.items(), key=lambda item: (-item[1], item[0]))
    )
    rows = [f"| `{row.name}` | {row.outcome} | {row.why.replace('|', '/')} |" for row in motion]
    return "\n".join(
        [
            f"Of {len(motion)} motion programs {same} give {SAME}.",
            "",
            HEADING,
            *sorted(rows, key=lambda row: SAME in row),
            "",
            f"Of the other {len(found) - len(motion)} programs {sum(refused.values())} are {REFUSED}",
            f"({reasons}); the rest make no cut.",
        ]
    )
