"""Holds a tool path against the moves LinuxCNC commands for the same program."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import pytest

from tests.support.linuxcnc import Move
from trueloop.nc.program.tool_path import Motion, ToolPath

TOLERANCE_MM: Final = 25.4e-9
"""1e-9 in."""


def kind_of(motion: int) -> str:
    """The judge's word for a move; to it a line in step with the spindle is a line."""
    return "line" if motion == Motion.THREAD else Motion(motion).name.lower()


def leading_somewhere(path: ToolPath, judged: Sequence[Move]) -> tuple[list[int], list[Move]]:
    """Indices of our moves, and their moves, without those that lead nowhere."""
    theirs = [move for move in judged if move.kind == "arc" or math.dist(move.start_mm, move.end_mm) > 1e-9]
    travel_mm = np.linalg.norm(path.end_mm - path.start_mm, axis=1)
    return np.flatnonzero((travel_mm > 1e-9) | (path.motion == Motion.ARC)).tolist(), theirs


def assert_same_moves(
    path: ToolPath, judged: Sequence[Move], *, same_lines: bool = True, within_mm: float = TOLERANCE_MM
) -> None:
    """Kind, line (unless the programs are two), ends, centre and sweep of every move; those that lead nowhere left out.

    LinuxCNC makes a move that leads nowhere of a bare G0 and of G28, and says no line (−1) of a turning cycle's moves.
    Coordinates beyond 1 m are held to 1e-9 of their size.
    """
    ours, theirs = leading_somewhere(path, judged)
    assert [kind_of(path.motion[k]) for k in ours] == [move.kind for move in theirs]
    lines = [(k, move.line) for k, move in zip(ours, theirs, strict=True) if same_lines and move.line > 0]
    assert path.line[[k for k, _ in lines]].tolist() == [line for _, line in lines]
    for k, move in zip(ours, theirs, strict=True):
        tolerance_mm = within_mm * max(1.0, np.abs(move.end_mm).max() / 1000)
        assert path.start_mm[k] == pytest.approx(move.start_mm, abs=tolerance_mm)
        assert path.end_mm[k] == pytest.approx(move.end_mm, abs=tolerance_mm)
        if move.centre_mm is not None:
            assert path.centre_mm[k] == pytest.approx(move.centre_mm, abs=tolerance_mm)
            # Ends of a small arc that are within the tolerance turn its sweep by this much.
            turn_rad = 2 * tolerance_mm / math.dist(move.end_mm, move.centre_mm)
            assert path.sweep_rad[k] == pytest.approx(move.sweep_rad, abs=max(1e-8, turn_rad))
