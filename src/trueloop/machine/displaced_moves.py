"""What a program's moves become when −E is added to every point of them: pieces, as few as the tolerance allows."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from trueloop.geometry.feature import Array
from trueloop.machine.commanded_path import CommandedPath, Indices
from trueloop.machine.pieces import Piece, arc_pieces, straight_pieces
from trueloop.nc.tool_path import Motion

PLANES = {17: (0, 1), 18: (2, 0), 19: (1, 2)}
"""Axis numbers of the plane of arcs, first the one that I, K or J belongs to."""


@dataclass(frozen=True)
class DisplacedMove:
    """One move: where it now starts, and its pieces in order."""

    move: int
    start_mm: Array
    pieces: list[Piece]


def displaced_moves(placed: CommandedPath, moves: Indices, tolerance_mm: float) -> Iterator[DisplacedMove]:
    """The moves of those indices. Rapids go straight to the displaced end; feeds follow the displaced path."""
    path = placed.path
    starts = path.start_mm[moves] - placed.error_mm(path.start_mm[moves], moves)
    ends = path.end_mm[moves] - placed.error_mm(path.end_mm[moves], moves)
    counts = _straight_counts(placed, moves, starts, ends, tolerance_mm)
    for k, move in enumerate(int(m) for m in moves):
        motion = path.motion[move]
        start = starts[k]
        if motion == Motion.ARC:
            start = _on_arc(placed, move, _cuts(placed, move)[:2])[0]
            pieces = _arc(placed, move, tolerance_mm)
        elif counts[k] > 1:
            pieces = straight_pieces(partial(_on_line, placed, move), tolerance_mm, int(counts[k]))
        else:
            pieces = [Piece(ends[k])]
        yield DisplacedMove(move, start, pieces)


def _straight_counts(placed: CommandedPath, moves: Indices, starts: Array, ends: Array, tolerance_mm: float) -> Indices:
    """A first guess of the pieces of each straight feed, from the sag at quarters: it falls with their square."""
    path = placed.path
    sag = np.zeros(len(moves))
    for share in (0.25, 0.5, 0.75):
        points = path.start_mm[moves] + share * (path.end_mm[moves] - path.start_mm[moves])
        between = starts + share * (ends - starts)
        sag = np.maximum(sag, np.linalg.norm(points - placed.error_mm(points, moves) - between, axis=1))
    counts = np.ceil(np.sqrt(sag / tolerance_mm))
    feeds = path.motion[moves] == Motion.LINE
    several: Indices = np.where(feeds & (sag > tolerance_mm), np.maximum(counts, 2), 1).astype(np.int64)
    return several


def _on_line(placed: CommandedPath, move: int, share: Array) -> Array:
    path = placed.path
    points = path.start_mm[move] + share[:, None] * (path.end_mm[move] - path.start_mm[move])
    displaced: Array = points - placed.error_mm(points, np.full(len(share), move))
    return displaced


def _arc(placed: CommandedPath, move: int, tolerance_mm: float) -> list[Piece]:
    path = placed.path
    plane = PLANES[int(path.plane[move])]
    return arc_pieces(partial(_on_arc, placed, move), plane, tolerance_mm, _cuts(placed, move))


def _on_arc(placed: CommandedPath, move: int, share: Array) -> Array:
    """Travel is that of the middle: between two cuts no axis turns round, at a cut one stands still."""
    points, _ = arc_points(placed, move, share)
    _, tangent = arc_points(placed, move, np.array([0.5 * (share[0] + share[-1])]))
    displaced: Array = points - placed.error_mm(points, np.full(len(share), move), np.tile(tangent, (len(share), 1)))
    return displaced


def arc_points(placed: CommandedPath, move: int, share: Array) -> tuple[Array, Array]:
    """Points of the programmed arc and its direction there, (m, 3) each; the third axis changes linearly.

    A positive sweep is clockwise looking against the third axis: angles of the plane fall.
    """
    path = placed.path
    first, second = PLANES[int(path.plane[move])]
    across, centre = 3 - first - second, path.centre_mm[move]
    start, end = path.start_mm[move], path.end_mm[move]
    spoke = start - centre
    angle = np.arctan2(spoke[second], spoke[first]) - path.sweep_rad[move] * share
    radius = np.hypot(spoke[first], spoke[second])
    points = np.empty((len(share), 3))
    points[:, first] = centre[first] + radius * np.cos(angle)
    points[:, second] = centre[second] + radius * np.sin(angle)
    points[:, across] = start[across] + share * (end[across] - start[across])
    tangent = np.zeros_like(points)
    way = -np.sign(path.sweep_rad[move])
    tangent[:, first], tangent[:, second] = -way * np.sin(angle), way * np.cos(angle)
    tangent[:, across] = np.sign(end[across] - start[across])
    return points, tangent


def _cuts(placed: CommandedPath, move: int) -> Array:
    """Where an arc has to be cut: its ends, and its quadrants when the error depends on the way of travel."""
    if not any(term.both_ways for term in placed.model.terms):
        return np.array([0.0, 1.0])
    path = placed.path
    first, second = PLANES[int(path.plane[move])]
    spoke = path.start_mm[move] - path.centre_mm[move]
    start = np.arctan2(spoke[second], spoke[first])
    sweep = -path.sweep_rad[move]
    turns = np.sort((np.arange(-12, 13) * np.pi / 2 - start) / sweep)
    inside = turns[(turns > 1e-6) & (turns < 1 - 1e-6)]
    return np.concatenate([[0.0], inside, [1.0]])
