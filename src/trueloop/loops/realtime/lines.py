"""Checks that a program's lines determine the tool's position, and that the control keeps to the path of each.

The table is chosen by `motion.program-line`. A line that runs twice is two places. LinuxCNC's G64 with P makes one move
of straight moves that go on within a tolerance (Q; where it is not named, P) and reports the last of their lines; its P
is by how much corners may be rounded, and without one they are rounded as the accelerations ask.

The control's path along a finish pass: its moves, and which of them cut, lead in and lead out.

Without cutter compensation these are the program's moves. Under G41 and G42 the control's own: it shortens moves at
concave corners and turns the nose about convex ones, by an arc that belongs to the block after the corner.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.loops.turned.commanded import Commanded, Run
from trueloop.nc.program.along import BLENDED, lengths_mm, mode_of, points_along
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.units import MM_PER_INCH

PLANE = (0, 2)
SAME_MM = 1e-9


@dataclass(frozen=True)
class Driven:
    """The moves as the control makes them; `centre` is the path of the nose's centre, `controlled` of what it controls.

    `cut` says by move which of the cuts of `contour` it makes; `run_out` are moves that only lengthen the contour.
    """

    contour: Commanded
    centre: ToolPath
    controlled: ToolPath
    cut: Mapping[int, int]
    run_out: frozenset[int]

    @cached_property
    def length_mm(self) -> Array:
        """Returns the length of every move, (n,)."""
        return lengths_mm(self.centre)

    @property
    def first(self) -> int:
        """Returns the first move along the contour."""
        return min([*self.cut, *(move for move in self.run_out if move < min(self.cut))])

    @property
    def last(self) -> int:
        """Returns the last move along the contour."""
        return max([*self.cut, *(move for move in self.run_out if move > max(self.cut))])

    @property
    def lead(self) -> int | None:
        """Returns the move that leads to the contour; None: none does, in the frame of the contour."""
        before = [move for move in range(self.first) if self.length_mm[move] > SAME_MM]
        return before[-1] if before and self.in_frame(before[-1]) else None

    def is_rapid(self, move: int) -> bool:
        """Returns whether a move is not at feed."""
        return bool(self.centre.motion[move] == Motion.RAPID)

    def in_frame(self, move: int) -> bool:
        """Returns whether the program's zero and its tool are those of the contour at a move."""
        path, first = self.centre, self.first
        same = np.all(np.abs(path.origin_mm[move] - path.origin_mm[first]) < SAME_MM)
        return bool(same and np.array_equal(path.renamed[move], path.renamed[first]))

    def centre_mm(self, move: int, share: Array) -> Array:
        """Returns the commanded positions of the nose's centre, (n,) → (n, 2), in the program's coordinates."""
        return points_along(self.centre, np.intp(move), share)[:, PLANE]

    def controlled_mm(self, move: int, share: Array) -> Array:
        """Returns the commanded positions of the controlled point, (n,) → (n, 2)."""
        return points_along(self.controlled, np.intp(move), share)[:, PLANE]


def driven(program: Program, contour: Commanded, run: Run, nose_radius_mm: float, tip: int) -> Driven:
    """Returns the control's moves of a program whose contour was matched. `tip`: the controlled point."""
    if not contour.match.on_contour:
        cut = {one.move: k for k, one in enumerate(contour.cuts)}
        run_out = frozenset(move.index for move in contour.match.run_out)
        return Driven(contour, contour.path, contour.path, cut, run_out)
    centre, controlled = (_compensated(program, run, nose_radius_mm, point) for point in (0, tip))
    main = {int(block): move for move, block in enumerate(centre.block)}  # the last of a block: an arc comes before it
    blocks = contour.path.block
    cut = {main[int(blocks[one.move])]: k for k, one in enumerate(contour.cuts)}
    return Driven(
        contour, centre, controlled, cut, frozenset(main[int(blocks[move.index])] for move in contour.match.run_out)
    )


def _compensated(program: Program, run: Run, nose_radius_mm: float, tip: int) -> ToolPath:
    return program.run(
        run.parameters,
        skipped_blocks=run.execute_deleted_blocks,
        tools=[CutterTool(nose_radius_mm, tip=tip)],
        strict=False,
        roughing=False,
    )


def require_known_lines(path: ToolPath, moves: Driven, listed: Collection[int]) -> None:
    """Raises RTC-LINE for the first listed line that runs twice, or in a subprogram or cycle; `path` is traced."""
    times = np.bincount(path.executed[:, 0], minlength=1)
    for move in listed:
        block = int(moves.centre.block[move])
        count, calls = int(times[block]) if block < len(times) else 0, moves.centre.call_stack(move)
        if count == 1 and not calls:
            continue
        within = f", called by line {calls[-1]}" if calls else ""
        raise Code.RTC_LINE.refusal(
            f"line {block + 1} of the finish pass runs {count} times{within}: the control's line does not say where "
            "in the cut it is",
            hint="write the finish pass out in the main program, every block once, or run the corrected program",
            place=Place(line=block + 1),
            values={"line": block + 1, "times": count},
        )


@dataclass(frozen=True)
class Kept:
    """The tolerance within which the control keeps to its path: `named` is the block that states it; None: none does.

    `rounding_mm`: how far corners may be rounded; `merging_mm`: how far off a straight way ends of moves may lie that
    are made one with it, 0: none are.
    """

    named: Block | None = None
    rounding_mm: float = np.inf
    merging_mm: float = 0.0


def require_kept_path(program: Program, path: ToolPath, moves: Driven, listed: Collection[int], gate_mm: float) -> None:
    """Raises RTC-PATH-MODE where the control may leave a listed line's path by the gate, or make one of two lines."""
    # The path tolerances by block, in the order they were executed: the last execution counts
    kept, latest = dict[int, Kept](), Kept()
    for index, _, state in path.executed.tolist():
        block = program.block(index)
        latest = _named(block, bool(path.states["inch"][state])) or latest
        kept[index] = latest
    centre = moves.centre
    for move in sorted(listed):
        mode = kept[int(centre.block[move])]
        if mode.rounding_mm > gate_mm:
            raise _rounds(program, mode, int(centre.line[move]), gate_mm, bool(centre.inch[move]))
    for first, second in pairwise(range(len(centre))):
        merging_mm = kept[int(centre.block[second])].merging_mm
        if {first, second} & set(listed) and _are_merged(centre, first, second, merging_mm):
            raise _merges(program, kept[int(centre.block[second])], centre, first, second)


def _named(block: Block, inch: bool) -> Kept | None:
    code = mode_of(replace(block, skipped=False))
    if code is None:
        return None
    if code != BLENDED:
        return Kept(block, 0.0)
    unit_mm = MM_PER_INCH if inch else 1.0
    given = {word.letter: word.value * unit_mm for word in block.words if word.letter in "PQ"}
    rounding_mm = given.get("P", 0.0)
    merging_mm = given.get("Q", rounding_mm)
    if not rounding_mm > 0.0:  # none, or one that is computed
        return Kept(block, np.inf, 0.0 if merging_mm == 0.0 else np.inf)
    return Kept(block, rounding_mm, merging_mm if merging_mm >= 0.0 else np.inf)


def _are_merged(path: ToolPath, first: int, second: int, merging_mm: float) -> bool:
    """Returns whether LinuxCNC makes one move of two: straight, at feed, and the point between beside the way."""
    straight = path.motion[[first, second]] == Motion.LINE
    if merging_mm == 0.0 or not np.all(straight) or path.block[first] == path.block[second]:
        return False
    start, middle, end = (
        point[list(PLANE)] for point in (path.start_mm[first], path.start_mm[second], path.end_mm[second])
    )
    way = end - start
    squared = float(way @ way)
    if squared == 0.0:
        return False
    share = float((middle - start) @ way) / squared
    return 0.0 < share < 1.0 and float(np.linalg.norm(middle - start - share * way)) <= merging_mm


def _rounds(program: Program, mode: Kept, line: int, gate_mm: float, inch: bool) -> TrueloopError:
    write = f"write {_proposed(inch)} before the first cut"
    if mode.named is None:
        message = (
            f"no path mode is named before line {line}: by its default LinuxCNC rounds corners without a bound, and a "
            f"row of the table holds {gate_mm:g} mm about its path"
        )
        return _path_mode(program, line, message, write)
    how = "without a bound" if np.isinf(mode.rounding_mm) else f"by up to {mode.rounding_mm:.4f} mm"
    message = (
        f"line {mode.named.line} has corners rounded {how}; a row of the table holds {gate_mm:g} mm about its path"
    )
    return _path_mode(program, mode.named.line, message, write)


def _merges(program: Program, mode: Kept, path: ToolPath, first: int, second: int) -> TrueloopError:
    assert mode.named is not None  # else nothing is merged
    lines = int(path.line[first]), int(path.line[second])
    message = (
        f"lines {lines[0]} and {lines[1]} go straight on within {mode.merging_mm:.4f} mm: by the G64 of line "
        f"{mode.named.line} LinuxCNC makes one move of them and reports line {lines[1]} alone"
    )
    return _path_mode(
        program, mode.named.line, message, f"write {_proposed(bool(path.inch[first]))}: Q0 keeps blocks apart"
    )


def _proposed(inch: bool) -> str:
    return "G64 P0.0001 Q0" if inch else "G64 P0.002 Q0"


def _path_mode(program: Program, line: int, message: str, hint: str) -> TrueloopError:
    return Code.RTC_PATH_MODE.refusal(message, hint=hint, place=Place(program.file, line))
