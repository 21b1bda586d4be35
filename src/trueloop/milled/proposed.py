"""Features that a program alone shows: circles and drilled holes, walls of contours under compensation, and levels.

A contour under G41 or G42 is the wall, or with a cutter whose D holds wear alone, a radius of it away. A circle or
plunge of the cutter's centre needs the cutter's radius; which side of a circle it is on shows where the tool came down.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Point
from trueloop.milled.feature import ROUND, Kind, MilledFeature
from trueloop.milled.passes import LEFT, MATCH_MM, SAME_MM, Called, Circle, Passes
from trueloop.nc.program.tool_path import NO_COMPENSATION, Motion

OVERLAP: Final = 0.5
"""Two walls belong together where they face each other along this share of the shorter."""
PARALLEL: Final = 1.0 - 1e-9
MOST_NOTED: Final = 5
ALLOWANCE_MM: Final = 2.0
"""A pass leaves at most so much on a wall for a later one."""


@dataclass(frozen=True)
class Wall:
    """A straight wall that a compensated move cuts: its ends (x, y), the normal out of the material, its lowest z.

    `onto`: the move begins without compensation, on the way to a wall.
    """

    run: int
    line: int
    called: Called
    onto: bool
    start: Array
    end: Array
    air: Array
    low_mm: float


def proposed_features(
    passes: Passes, radius_mm: Mapping[int, float], wear: bool
) -> tuple[list[MilledFeature], list[str]]:
    """Returns features with names, in the order of round ones, walls and faces, and notes on what is not plain.

    `wear`: D holds wear alone. Tops are the highest level that the program faces, else z 0.
    """
    notes = dict[str, None]()
    faces = list(_faces(passes, radius_mm))
    top = max((z for _, z in faces), default=0.0)
    features = [*_round(passes, radius_mm, wear, top, notes)]
    features += _holes(passes, radius_mm, top, features, notes)
    features += _pairs(list(_walls(passes, radius_mm, wear)), top, notes)
    features += [_feature("face", (x, y, z), 0.0, 0.0) for (x, y), z in faces]
    counts = dict[Kind, int]()
    named = list[MilledFeature]()
    for feature in features:
        counts[feature.kind] = counts.get(feature.kind, 0) + 1
        named.append(replace(feature, name=f"{feature.kind}{counts[feature.kind]}"))
    return named, list(notes)


def _feature(
    kind: Kind, place_mm: tuple[float, float, float], size_mm: float, depth_mm: float, direction: Point | None = None
) -> MilledFeature:
    level = (0.0, 0.0, 1.0) if direction is None else (*direction, 0.0)
    return MilledFeature(
        name="",
        kind=kind,
        place_mm=place_mm,
        tool=0,
        work_offset="",
        size_mm=size_mm,
        direction=level,
        depth_mm=depth_mm,
    )


def _round(
    passes: Passes, radius_mm: Mapping[int, float], wear: bool, top: float, notes: dict[str, None]
) -> Iterator[MilledFeature]:
    """Yields bores and bosses by full circles: of those about one centre and down to one depth, the last wall."""
    walls, unsure = list[tuple[Kind, Circle, float]](), list[Circle]()
    for circle in passes.circles:
        called, compensated = passes.called(circle.move), passes.compensated(circle.move)
        radius = radius_mm.get(called.tool)
        inside = _inside(passes, circle)
        at_centre = wear or not compensated
        if inside is None or (at_centre and radius is None):
            unsure.append(circle)
            continue
        away = (radius or 0.0) if at_centre else 0.0
        size = circle.radius_mm + (away if inside else -away)
        if size > SAME_MM and circle.low_mm < top - SAME_MM:
            walls.append(("bore" if inside else "boss", circle, size))
    for circle in unsure:  # a roughing pass where the wall itself is known needs no answer
        if not any(math.dist(circle.centre_mm, wall.centre_mm) <= MATCH_MM for _, wall, _ in walls):
            x, y, line = *circle.centre_mm, int(passes.path.line[circle.move])
            tool = passes.called(circle.move).tool
            notes[f"line {line}: a circle about x {x:.3f}, y {y:.3f} mm by tool {tool}: state its radius"] = None
    kept = dict[tuple[object, ...], tuple[Kind, Circle, float]]()
    for kind, circle, size in walls:
        outwards = 1.0 if kind == "bore" else -1.0
        covered = any(
            kind == other_kind
            and math.dist(circle.centre_mm, other.centre_mm) <= MATCH_MM
            and outwards * (other_size - size) > MATCH_MM
            and other.low_mm <= circle.low_mm + MATCH_MM
            for other_kind, other, other_size in walls
        )
        key = (kind, *(round(value, 2) for value in (*circle.centre_mm, size)))
        if not covered and (key not in kept or circle.low_mm < kept[key][1].low_mm):
            kept[key] = (kind, circle, size)
    for kind, circle, size in kept.values():
        yield _feature(kind, (*circle.centre_mm, top), 2.0 * size, top - circle.low_mm)


def _inside(passes: Passes, circle: Circle) -> bool | None:
    """Returns whether the tool is inside of a circle; None where it came down on it."""
    if passes.compensated(circle.move):
        return bool((passes.path.compensation[circle.move] == LEFT) == circle.counterclockwise)
    move = circle.move
    while (move > 0 and passes.end_mm[move, 2] <= passes.start_mm[move, 2] - SAME_MM) or move == circle.move:
        move -= 1
    while move > 0 and abs(passes.end_mm[move, 2] - passes.start_mm[move, 2]) <= SAME_MM:
        move -= 1
    off = math.dist(passes.end_mm[move, :2].tolist(), circle.centre_mm) - circle.radius_mm
    return None if abs(off) <= MATCH_MM else off < 0.0


def _holes(
    passes: Passes, radius_mm: Mapping[int, float], top: float, others: Sequence[MilledFeature], notes: dict[str, None]
) -> Iterator[MilledFeature]:
    """Yields bores by plunges that are followed by no cut at depth: of those at one place, the last of the deep."""
    path = passes.path
    found = dict[tuple[float, float], int]()
    for move in passes.plunges.tolist():
        following = move + 1
        cut_at_depth = following < len(path) and path.motion[following] != Motion.RAPID
        if cut_at_depth and passes.end_mm[following, 2] <= passes.end_mm[move, 2] + SAME_MM:
            continue
        x, y, low = passes.end_mm[move].tolist()
        key = (round(x, 2), round(y, 2))
        before = found.get(key)
        if before is None or 2.0 * (top - low) >= top - float(passes.end_mm[before, 2]):
            found[key] = move
    for (x, y), move in found.items():
        low, tool = float(passes.end_mm[move, 2]), passes.called(move).tool
        milled = any(
            feature.kind in ROUND and math.dist(feature.place_mm[:2], (x, y)) <= MATCH_MM for feature in others
        )
        if milled or low >= top:
            continue
        if tool not in radius_mm:
            notes[f"holes by tool {tool}: state its radius"] = None
            continue
        yield _feature("bore", (x, y, top), 2.0 * radius_mm[tool], top - low)


def _walls(passes: Passes, radius_mm: Mapping[int, float], wear: bool) -> Iterator[Wall]:
    """Yields the straight walls under compensation; moves of one `run` follow each other without a rapid."""
    run, before = 0, -2
    moves = passes.contour.tolist()
    for move in moves:
        if move != before + 1 or passes.called(move) != passes.called(before):
            run += 1
        before = move
        if passes.path.motion[move] != Motion.LINE:
            continue
        start, end = passes.start_mm[move], passes.end_mm[move]
        way = (end - start)[:2]
        length = float(np.linalg.norm(way))
        if length <= SAME_MM:
            continue
        left = 1.0 if passes.path.compensation[move] == LEFT else -1.0
        air = left * np.array([-way[1], way[0]]) / length
        away = radius_mm.get(passes.called(move).tool, 0.0) * air if wear else np.zeros(2)
        yield Wall(
            run=run,
            line=int(passes.path.line[move]),
            called=passes.called(move),
            onto=move == 0 or passes.path.compensation[move - 1] == NO_COMPENSATION,
            start=start[:2] - away,
            end=end[:2] - away,
            air=air,
            low_mm=float(max(start[2], end[2])),
        )


def _pairs(walls: Sequence[Wall], top: float, notes: dict[str, None]) -> Iterator[MilledFeature]:
    """Yields slots and ribs: walls of one run that face each other, or stand back to back, each with its nearest, and
    of those between two planes the longest; passes at several depths count once. Walls without one in their run are of
    a pair with those of other runs, and what is left of them is noted.
    """
    runs = dict[tuple[object, ...], tuple[float, MilledFeature]]()
    alone = [
        wall
        for wall, others in _beside(walls, -1.0)
        if not _add_pair(runs, wall, [other for other in others if other.run == wall.run], top) and not wall.onto
    ]
    alone = [wall for wall, others in _beside(alone, 1.0) if not any(_behind(wall, other) for other in others)]
    left = dict[tuple[float, ...], Wall]()  # passes at several depths are of one wall
    for wall, others in _beside(alone, -1.0):
        if not _add_pair(runs, wall, [other for other in others if other.called == wall.called], top):
            left.setdefault(tuple(round(value, 2) for value in (*wall.air, float(wall.air @ wall.start))), wall)
    for wall in list(left.values())[:MOST_NOTED]:
        (x, y), (i, j) = (0.5 * (wall.start + wall.end)).tolist(), (wall.air + 0.0).tolist()
        notes[
            f"line {wall.line}: a straight wall at x {x:.3f}, y {y:.3f} mm without one opposite: "
            f"state a face with direction = [{i:.6g}, {j:.6g}, 0.0]"
        ] = None
    if len(left) > MOST_NOTED:
        notes[f"{len(left) - MOST_NOTED} more straight walls without one opposite"] = None
    found = dict[tuple[object, ...], MilledFeature]()
    for _, feature in runs.values():
        key = (feature.kind, *(round(value, 2) for value in (*feature.place_mm[:2], *feature.direction[:2])))
        key = (*key, round(feature.size_mm, 2))
        if feature.depth_mm > SAME_MM and (key not in found or feature.depth_mm > found[key].depth_mm):
            found[key] = feature
    yield from found.values()


def _add_pair(
    runs: dict[tuple[object, ...], tuple[float, MilledFeature]], one: Wall, others: Sequence[Wall], top: float
) -> bool:
    """Returns whether a wall has an opposite; adds the pair with the nearest one, the longest between planes."""
    pairs = [(other, *_between(one, other)) for other in others if other.low_mm == one.low_mm]
    near = [(abs(gap), overlap, gap, middle) for _, gap, overlap, middle in pairs if overlap > 0.0 and gap != 0.0]
    if not near:
        return False
    size, overlap, gap, (x, y) = min(near, key=lambda pair: pair[0])
    i, j = max(tuple(one.air.tolist()), tuple((-one.air).tolist()))
    kind: Kind = "slot" if gap > 0.0 else "rib"
    key = (one.run, kind, *(round(value, 2) for value in (i, j, i * x + j * y, size)))
    if key not in runs or overlap > runs[key][0]:
        runs[key] = overlap, _feature(kind, (x, y, top), size, top - one.low_mm, (i + 0.0, j + 0.0))
    return True


def _beside(walls: Sequence[Wall], sense: float) -> Iterator[tuple[Wall, list[Wall]]]:
    """Yields each wall with those whose normal has its direction, `sense` 1, or the opposite one, −1."""
    airs = np.array([wall.air for wall in walls]).reshape(-1, 2)
    for wall in walls:
        yield wall, [walls[k] for k in np.flatnonzero(sense * (airs @ wall.air) >= PARALLEL).tolist()]


def _behind(wall: Wall, other: Wall) -> bool:
    """Returns whether another pass cuts a wall again, by a roughing pass' allowance further into the material."""
    gap, overlap, _ = _between(wall, other)
    return other.low_mm <= wall.low_mm + SAME_MM and overlap > 0.0 and -ALLOWANCE_MM <= gap < 0.0


def _between(wall: Wall, other: Wall) -> tuple[float, float, Point]:
    """Returns how far another wall lies from one along its normal into the air, along which length they are beside
    each other, 0 where that is little, and the middle (x, y) between them.
    """
    way = wall.end - wall.start
    length = float(np.linalg.norm(way))
    way = way / length
    its = sorted((float((other.start - wall.start) @ way), float((other.end - wall.start) @ way)))
    low, high = max(0.0, its[0]), min(length, its[1])
    gap = float((other.start - wall.start) @ wall.air)
    x, y = (wall.start + 0.5 * (low + high) * way + 0.5 * gap * wall.air).tolist()
    enough = high - low >= OVERLAP * min(length, its[1] - its[0])
    return gap if abs(gap) > SAME_MM else 0.0, high - low if enough else 0.0, (x, y)


def _faces(passes: Passes, radius_mm: Mapping[int, float]) -> Iterator[tuple[Point, float]]:
    """Yields (x, y) and z of each level that straight moves of a cutter cut, none below; ways to walls are none."""
    path, run = passes.path, np.cumsum(passes.path.rapid)
    of_walls = {int(run[move]) for move in (*passes.contour.tolist(), *(circle.move for circle in passes.circles))}
    moves = [m for m in passes.level.tolist() if path.motion[m] == Motion.LINE and int(run[m]) not in of_walls]
    levels = sorted({round(float(passes.end_mm[move, 2]), 4) for move in moves}, reverse=True)
    for z in levels:
        own = [move for move in moves if abs(float(passes.end_mm[move, 2]) - z) <= SAME_MM]
        below = [move for move in moves if float(passes.end_mm[move, 2]) < z - SAME_MM]
        own.sort(key=lambda move: -float(np.linalg.norm(passes.end_mm[move] - passes.start_mm[move])))
        for move in own:
            x, y = (0.5 * (passes.start_mm[move] + passes.end_mm[move]))[:2].tolist()
            reach = [radius_mm.get(passes.called(other).tool, 1.0) for other in below]
            if all(passes.distance_mm(other, (x, y)) > far for other, far in zip(below, reach, strict=True)):
                yield (x, y), z
                break
