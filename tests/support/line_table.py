"""A table by program line laid on a path by brute force, and paths of LinuxCNC's interpreter compared.

Nothing of this asks trueloop: rows are searched one by one, distances are those to segments and circles.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from tests.support.linuxcnc import LATHE_STARTUP, Move, Tool, interpret
from trueloop.arrays import Array, Flags, Integers
from trueloop.realtime.image import Block

XZ = (0, 2)
SAGITTA_MM = 2e-5
"""Places along an arc stand so near to each other that the straight way between two is no further off."""


@dataclass(frozen=True)
class Sent:
    """Places (n, 2) where a control sends what it controls, in machine coordinates, with the line of each (n,)."""

    at_mm: Array
    line: Integers
    rapid: Flags


def moves_of(source: bytes, folder: Path, tools: Sequence[Tool]) -> list[Move]:
    """The moves that LinuxCNC makes of a program, those without a way left out."""
    file = folder / "judged.ngc"
    file.write_bytes(source)
    moves = interpret(file, tools=tools, startup=LATHE_STARTUP)
    return [move for move in moves if not np.allclose(move.start_mm, move.end_mm, atol=1e-9)]


def sent_to(moves: Sequence[Move], origin_mm: tuple[float, float], step_mm: float) -> Sent:
    """Places along the moves; `step_mm` is that on straight ones."""
    parts = [_points(move, step_mm) + np.asarray(origin_mm) for move in moves]
    line = np.concatenate([np.full(len(part), move.line) for part, move in zip(parts, moves, strict=True)])
    rapid = np.concatenate([np.full(len(part), move.kind == "rapid") for part, move in zip(parts, moves, strict=True)])
    return Sent(np.concatenate(parts), line, rapid)


def _points(move: Move, step_mm: float) -> Array:
    start, end = _at(move.start_mm, move), _at(move.end_mm, move)
    if move.centre_mm is None:
        count = max(2, int(np.linalg.norm(end - start) / step_mm))
        return np.asarray(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))
    (angle, sweep), centre = _angles(move), _at(move.centre_mm, move)
    arm = start - centre
    count = 2 + int(abs(sweep) / np.sqrt(8 * SAGITTA_MM / np.hypot(*arm)))
    turned = angle + np.linspace(0.0, sweep, count)
    return np.asarray(centre + np.hypot(*arm) * np.stack([np.sin(turned), np.cos(turned)], axis=1))


def _angles(move: Move) -> tuple[float, float]:
    """From +z towards +x: where an arc starts, and by how much it goes on."""
    assert move.centre_mm is not None and move.sweep_rad is not None
    x, z = _at(move.start_mm, move) - _at(move.centre_mm, move)
    return float(np.arctan2(x, z)), -move.sweep_rad


def _at(point_mm: tuple[float, float, float], move: Move) -> Array:
    """With what the program itself adds to its coordinates there."""
    return np.add(point_mm, move.origin_mm)[list(XZ)]


def added_mm(blocks: Sequence[Block], sent: Sent, gate_mm: float = 0.1) -> tuple[Array, Array]:
    """What the table adds at each place, (n, 2), and how far its row is, (n,): inf where the line has none."""
    by_line = {block.line: block.rows for block in blocks}
    added, off = np.zeros_like(sent.at_mm), np.full(len(sent.at_mm), np.inf)
    for line in np.unique(sent.line):
        here = np.flatnonzero(sent.line == line)
        if int(line) in by_line:
            added[here], off[here] = _looked_up(by_line[int(line)], sent.at_mm[here])
    added[off > gate_mm] = 0.0
    return added, off


def _looked_up(rows: Array, points: Array) -> tuple[Array, Array]:
    """The nearest place between any two rows, and what stands there."""
    best, found = np.full(len(points), np.inf), np.zeros_like(points)
    for a, b in pairwise(rows):
        way = b[:2] - a[:2]
        share = np.clip((points - a[:2]) @ way / (way @ way), 0.0, 1.0)
        off = np.linalg.norm(points - a[:2] - share[:, None] * way, axis=1)
        nearer = off < best
        best[nearer] = off[nearer]
        found[nearer] = (a[2:] + share[:, None] * (b[2:] - a[2:]))[nearer]
    return found, best


def off_moves_mm(points: Array, moves: Sequence[Move], origin_mm: tuple[float, float]) -> Array:
    """Distance of points (n, 2) from the nearest place of some moves."""
    return np.asarray(np.min([_off(points - np.asarray(origin_mm), move) for move in moves], axis=0))


def _off(points: Array, move: Move) -> Array:
    start, end = _at(move.start_mm, move), _at(move.end_mm, move)
    ends = np.minimum(np.linalg.norm(points - start, axis=1), np.linalg.norm(points - end, axis=1))
    if move.centre_mm is None:
        way = end - start
        share = np.clip((points - start) @ way / (way @ way), 0.0, 1.0)
        return np.asarray(np.linalg.norm(points - start - share[:, None] * way, axis=1))
    (angle, sweep), centre = _angles(move), _at(move.centre_mm, move)
    arm = points - centre
    turned = np.sign(sweep) * (np.arctan2(arm[:, 0], arm[:, 1]) - angle) % (2 * np.pi)
    radius = np.hypot(*(start - centre))
    return np.asarray(np.where(turned <= abs(sweep), np.abs(np.hypot(arm[:, 0], arm[:, 1]) - radius), ends))


def off_places_mm(points: Array, places: Array) -> Array:
    """Distance of points (n, 2) from the way through places (m, 2) in their order."""
    best = np.full(len(points), np.inf)
    for a, b in pairwise(places):
        near = np.flatnonzero(np.linalg.norm(points - a, axis=1) < np.linalg.norm(b - a) + 0.5)
        way = b - a
        squared = max(float(way @ way), 1e-30)
        share = np.clip((points[near] - a) @ way / squared, 0.0, 1.0)
        best[near] = np.minimum(best[near], np.linalg.norm(points[near] - a - share[:, None] * way, axis=1))
    return best
