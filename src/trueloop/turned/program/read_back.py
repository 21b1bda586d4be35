"""The corrected program read back and run: it must do what was intended, and nothing else may have changed.

The correspondence of moves of a written program with those of its source: a block may have become several.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, Finding, Place
from trueloop.geometry.feature import Point
from trueloop.geometry.profile import Profile
from trueloop.nc.edit.changes import not_as_intended, verify_written
from trueloop.nc.edit.edit import Edit
from trueloop.nc.program.along import points_along
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.compensation.displaced import CentrePiece, reaches_mm
from trueloop.turned.compensation.moves import Move
from trueloop.units import UM_PER_MM

SAMPLES: Final = 401
SAMPLES_OF_MOVE: Final = 33
BESIDE: Final = 8
"""Moves about the place of one in the source that are looked at first."""

SAME_MM: Final = 1e-9

NO_CORNER_RAD: Final = 0.05
"""Turns below this are not a corner to a control that keeps the nose off the contour."""


@dataclass(frozen=True)
class SourceContour:
    """The source itself: its path, first and last move of the contour, and by feature its intended contour.

    Within `reach_mm` of where it leaves that (a way in that a control shortens), the written one may leave its own.
    """

    path: ToolPath
    span: tuple[int, int]
    meant: Mapping[str, CentrePiece]
    reach_mm: float

    def follows(self, feature: str, arc_length_mm: Array, tolerance_mm: float) -> Flags:
        """Returns whether it is there at places of a feature, (n,)."""
        moves = _cutting(self.path, self.span)
        off = _off(moves, self.meant[feature].shifted.centre_mm(arc_length_mm)) > tolerance_mm
        nearest_mm = np.min(np.abs(arc_length_mm[:, None] - np.where(off, arc_length_mm, np.inf)), axis=1)
        return np.asarray(nearest_mm > self.reach_mm)


def _cutting(path: ToolPath, span: tuple[int, int]) -> list[Move]:
    return [move_of(path, k) for k in range(span[0], span[1] + 1) if path.motion[k] != Motion.RAPID]


def check_contour(
    path: ToolPath,
    span: tuple[int, int],
    intended: Sequence[CentrePiece],
    tolerance_mm: float,
    source: SourceContour | None = None,
) -> None:
    """Refuses a program whose moves `span` are off the intended path by more than the tolerance, as `source` is not."""
    moves = _cutting(path, span)
    ends = [piece.shifted.feature.length_mm for piece in intended]
    starts = [0.0] * len(ends)  # a free end is where the centre's path passes it: on the axis, before a sloping error's
    starts[0] = max(0.0, reaches_mm(intended[0].shifted, 0.0, at_end=False))
    ends[-1] = min(ends[-1], reaches_mm(intended[-1].shifted, 0.0, at_end=True))
    for piece, start, end in zip(intended, starts, ends, strict=True):
        feature = piece.shifted.feature
        s = np.linspace(max(piece.start_mm, start), min(piece.end_mm, end), SAMPLES)
        points = piece.shifted.centre_mm(s)
        off = _off(moves, points)
        if source is not None:
            off = np.where(source.follows(feature.name, s, tolerance_mm), off, 0.0)
        if (worst := float(np.max(off))) > tolerance_mm:
            x, z = points[int(np.argmax(off))]
            raise not_as_intended(
                f"the written program deviates by {worst * UM_PER_MM:.2f} µm from the intended path on "
                f"{feature.name!r} at x {x:.4f} mm (radius), z {z:.4f} mm; {tolerance_mm * UM_PER_MM:.2f} µm is allowed"
            )


def check_way(before: ToolPath, after: ToolPath, moves: range, written: range, bound_mm: float) -> None:
    """Refuses `written` moves that go where none of the source's `moves` went, give or take the largest correction.

    `check_contour` sees a part of the contour that is missing; this sees a move too many and an arc turned the long way
    round.
    """
    was = [move_of(before, k) for k in moves]
    for place, k in enumerate(written):
        points = points_along(after, np.intp(k), np.linspace(0.0, 1.0, SAMPLES_OF_MOVE))[:, [0, 2]]
        beside = place * len(was) // len(written)
        near = was[max(beside - BESIDE, 0) : beside + BESIDE]
        if np.max(_off(near, points)) <= bound_mm:  # of hundreds of short lines few are near
            continue
        off = _off(was, points)
        if (worst := float(np.max(off))) > bound_mm:
            raise not_as_intended(
                f"the move of line {after.line[k]} goes {worst:.4f} mm away from every move of the source; corrections "
                f"and rounding explain {bound_mm:.4f} mm"
            )


def joins_mm(path: ToolPath, span: tuple[int, int], nose_radius_mm: float) -> float:
    """Returns how far the nose's centre may lie off after the moves `span` (first, last) turn into each other by
    little.

    Controls take a turn δ below `NO_CORNER_RAD` for none: the centre stays beside the end of the first move, which is
    R (1 − cos δ) off the second (as LinuxCNC 2.9 drives it).
    """
    moves = _cutting(path, span)
    turns = [_turn_rad(move, after) for move, after in pairwise(moves)]
    largest = max((turn for turn in turns if turn < NO_CORNER_RAD), default=0.0)
    return nose_radius_mm * (1.0 - math.cos(largest))


def _turn_rad(move: Move, after: Move) -> float:
    """Returns the angle between the end of a move and the beginning of the next."""
    u, v = _direction(move, move.end_mm), _direction(after, after.start_mm)
    return abs(math.atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]))


def _direction(move: Move, at_mm: Point) -> tuple[float, float]:
    """Returns the direction (x, z) of a move at one of its ends, of any length."""
    if move.centre_mm is None:
        return move.end_mm[0] - move.start_mm[0], move.end_mm[1] - move.start_mm[1]
    x, z = at_mm[0] - move.centre_mm[0], at_mm[1] - move.centre_mm[1]
    return (-z, x) if move.sweep_rad > 0 else (z, -x)


def farthest_mm(before: Sequence[CentrePiece], after: Sequence[CentrePiece]) -> float:
    """Returns how far a correction takes the nose's centre at the most, along all pieces."""
    along = [
        new.shifted.centre_mm(s) - old.shifted.centre_mm(s)
        for old, new in zip(before, after, strict=True)
        for s in [np.linspace(new.start_mm, new.end_mm, SAMPLES)]
    ]
    return float(np.max(np.linalg.norm(np.concatenate(along), axis=1)))


def check_rest(
    before: ToolPath, after: ToolPath, images: Sequence[range], moves: range, twins: Mapping[int, int]
) -> None:
    """Refuses a program in which a move outside the contour (`moves` of the source) is another than it was.

    `images` are the written moves of each of the source; `twins` the moves that blocks of the contour make again, each
    with the move of the contour that it repeats: what is written for both has to be the same.
    """
    rest = [old for old in range(len(images)) if old not in moves]
    for old in rest:
        if (twin := twins.get(old)) is not None:
            _require_alike(after, images[old], images[twin])
    kept = np.array([old for old in rest if old not in twins], dtype=np.intp)
    written = np.array([images[old].start for old in kept], dtype=np.intp)
    named = np.asarray(before.word[kept]) >= 0
    stands = before.end_mm[kept] == before.start_mm[kept]  # an increment of nothing (G28 U0) says nothing
    verify_written(before, after, (kept, written), before.end_mm[kept], named & ~stands, allowed_mm=SAME_MM)


def _require_alike(path: ToolPath, moves: range, others: range) -> None:
    """Refuses moves of the same blocks that end at two places."""
    for move, other in zip(moves, others, strict=True):
        off = float(np.max(np.abs(path.end_mm[move] - path.end_mm[other])))
        if off > SAME_MM or path.motion[move] != path.motion[other]:
            raise not_as_intended(
                f"line {path.line[move]} runs several times and ends {off * UM_PER_MM:.2f} µm apart, where the source "
                "ended at one place"
            )


def check_rapids(
    profile: Profile, before: ToolPath, after: ToolPath, images: Sequence[range], moves: range, follows_mm: float = 0.0
) -> None:
    """Refuses rapids outside of the contour (`moves` of the source) that come closer to the part than they did.

    Closeness is measured at the rapid's end: at its beginning the tool stands on the surface that it has just cut.

    follows_mm: by how much the first rapid behind the contour may, where its cycle works out from the contour where it
    ends: off the corrected one by as much as off the given one.
    """
    for old, image in enumerate(images):
        new = image[-1]
        stays = np.all(before.end_mm[old] == after.end_mm[new]) or np.all(after.start_mm[new] == after.end_mm[new])
        of_cycle = old < moves.start and np.all(before.word[old] < 0)  # which goes to the contour's beginning
        if old in moves or before.motion[old] != Motion.RAPID or stays or of_cycle:
            continue
        clearance = [clearance_mm(profile, path.end_mm[m]) for path, m in ((before, old), (after, new))]
        follows = follows_mm if old == moves.stop and np.all(before.word[old] < 0) else 0.0
        if clearance[1] < clearance[0] - follows - SAME_MM:
            raise Code.CMP_RAPID.refusal(
                f"the rapid of line {before.line[old]} would end {(clearance[0] - clearance[1]) * UM_PER_MM:.2f} µm "
                f"closer to the part, because it inherits a coordinate of the contour",
                hint="write both coordinates into that block",
                place=Place(line=int(before.line[old])),
                values={"closer_um": float(clearance[0] - clearance[1]) * UM_PER_MM},
            )


@dataclass(frozen=True)
class Unfit:
    """An obstacle that keeps a control from driving the nose along a contour, and the start of the move concerned."""

    found: Finding
    start_mm: Array


def unfit(driven: ToolPath, path: ToolPath) -> tuple[Unfit, ...]:
    """Returns all obstacles in a path as the control drives it; `path` is the same as programmed."""
    return tuple(
        Unfit(found, path.start_mm[int(np.flatnonzero(path.line == found.place.line)[0])])
        for found in driven.findings
        if found.code in (Code.NC_GOUGE, Code.NC_ENTRY) and found.place.line in path.line
    )


def require_nose_fits(
    obstacles: Sequence[Unfit], lines: Integers, accepted: Sequence[Unfit] = (), within_mm: float = 0.0
) -> tuple[int, ...]:
    """Raises NC-GOUGE or NC-ENTRY where the control cannot keep the nose off the contour of lines (first, last).

    A corner within `within_mm` of one of `accepted`, those of the source, is the source's own: the control that cuts it
    has a way of its own to, and its line there is returned.
    """
    own = []
    for obstacle in obstacles:
        line, code = obstacle.found.place.line or 0, obstacle.found.code
        if not lines[0] <= line <= lines[1]:
            continue
        near = [
            g.found.place.line or 0 for g in accepted if np.linalg.norm(g.start_mm - obstacle.start_mm) <= within_mm
        ]
        if code is not Code.NC_GOUGE or not near:
            where = f"line {line} of the corrected program: {obstacle.found.message}"
            place = Place(obstacle.found.place.file)
            raise code.refusal(where, hint=obstacle.found.hint, place=place, values=obstacle.found.values)
        own.append(near[0])
    return tuple(own)


def _off(moves: Sequence[Move], points: Array) -> Array:
    """Returns the distance of points from the nearest of some moves."""
    return np.asarray(np.min([move.gap_mm(points) for move in moves], axis=0))


def move_of(path: ToolPath, k: int) -> Move:
    """Returns a move of a program in the (x, z) plane; of a rapid the straight way."""
    centre = _point(path.centre_mm[k]) if path.motion[k] == Motion.ARC else None
    return Move(_point(path.start_mm[k]), _point(path.end_mm[k]), centre, float(path.sweep_rad[k]))


def _point(xyz: Array) -> Point:
    return float(xyz[0]), float(xyz[2])


def clearance_mm(profile: Profile, end_mm: Array) -> float:
    """Returns the distance of a point (x, y, z) from the part's profile, on either side of the axis."""
    point = np.array([abs(end_mm[0]), end_mm[2]])
    return float(np.abs(profile.locate(point).distance_mm[0]))


AT_ONE_PLACE_MM = 1e-6
"""Moves of one block whose ends lie nearer are the same move, made again."""


def aligned(
    program: Program, before: ToolPath, after: ToolPath, edits: Sequence[Edit], replaced: Iterable[int]
) -> tuple[range, ...]:
    """Returns for each move of `before` the moves of `after` that stand for it.

    `edits` of the program made `after`; `replaced` are the moves whose blocks became several. Raises CMP-READ-BACK
    where the numbers of moves do not go together.
    """
    # How many blocks more stand for a block
    more: dict[int, int] = {}
    for edit in edits:
        edited = (program.place(edit.start).line or 1) - 1
        new = edit.text.count("\n") - program.source[edit.start : edit.end].count(b"\n")
        more[edited] = more.get(edited, 0) + new
    motion_of = {int(before.block[move]): int(before.motion[move]) for move in replaced}
    images, at = [], 0
    for block, motion in zip(before.block.tolist(), before.motion.tolist(), strict=True):
        count = 1 + (more.get(block, 0) if motion_of.get(block) == motion else 0)
        images.append(range(at, at + count))
        at += count
    if at != len(after):
        raise not_as_intended(f"the written program has {len(after)} moves, where {at} are those of the source")
    return tuple(images)


def again(path: ToolPath, moves: range) -> dict[int, int]:
    """Moves outside of a range that one of its blocks makes again, at the same place, each with that of the range."""
    first: dict[tuple[int, int], list[int]] = {}
    for move in moves:
        first.setdefault((int(path.block[move]), int(path.motion[move])), []).append(move)
    found: dict[int, int] = {}
    for move in np.flatnonzero(np.isin(path.block, path.block[moves.start : moves.stop])).tolist():
        if move in moves:
            continue
        same = first.get((int(path.block[move]), int(path.motion[move])), [])
        twin = next((k for k in same if _ends_alike(path, k, move)), None)
        if twin is not None:
            found[move] = twin
    return found


def _ends_alike(path: ToolPath, block: int, other: int) -> bool:
    return bool(np.all(np.abs(path.end_mm[block] - path.end_mm[other]) <= AT_ONE_PLACE_MM))
