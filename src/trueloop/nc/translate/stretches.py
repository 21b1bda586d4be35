"""Stretches of a program that do nothing but move straight: they are read in columns, not block by block."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Flags, Integers
from trueloop.nc.program.program import PLAIN_EMPTY, PLAIN_MOVES, UNCOMPENSATED
from trueloop.nc.program.tool_path import INVERSE_TIME, NO_COMPENSATION, PER_REVOLUTION, Motion
from trueloop.nc.translate.executed import Course, Source
from trueloop.nc.translate.statements import Compensation, Straights

STANDS_MM: Final = 1e-9
_KEPT: Final = ("inch", "diameter", "plane", "feed_mode", "spindle_mode", "spindle_speed")
"""What is said of the states in words of its own when it changes."""


@dataclass(frozen=True, eq=False)
class Stretches:
    """Of each executed block (m,): the first one from it on that is not of its stretch, itself where it is in none.

    `touched` (m, 3): axes that it names or moves; `uncompensated` (m,): whether it switches compensation off.
    """

    until: Integers
    touched: Flags
    uncompensated: Flags

    def end(self, row: int, course: Course) -> int:
        """The end of the stretch from that block on, before an axis that is not known or compensation that is new."""
        end = int(self.until[row])
        if end == row:
            return row
        unknown = [axis for axis in range(3) if axis not in course.known]
        new = self.touched[row:end, unknown].any(axis=1)
        if course.last.get("compensation") != Compensation(NO_COMPENSATION):
            new |= self.uncompensated[row:end]
        return row + int(new.argmax()) if new.any() else end


def stretches_of(source: Source) -> Stretches:
    """The stretches of a traced run: plain blocks in one state, of a rapid move, a line or no move each."""
    path, rows = source.path, len(source.path.executed)
    block, after, _ = path.executed.T
    before = np.concatenate([[0], after[:-1]])[:rows]
    said = source.program.plain[block]
    touched = np.zeros((rows, 3), dtype=np.bool_)
    alike = _is_written_alike(source)
    plain = (said >= PLAIN_EMPTY) & (after == before) & alike
    moves = np.flatnonzero((said >= PLAIN_MOVES) & (after - before == 1))
    move = before[moves]
    own = (path.block[move] == block[moves]) & np.isfinite(path.end_mm[move]).all(axis=1)
    plain[moves] = own & np.isin(path.motion[move], [Motion.RAPID, Motion.LINE]) & alike[moves]
    touched[moves] = named_axes(source, move)
    goes_on = plain & np.concatenate([[False], plain[:-1] & ~_changes(source)])[:rows]
    ends = np.where(goes_on, rows, np.arange(rows))
    following = np.minimum.accumulate(np.append(ends, rows)[::-1])[::-1][1:]
    until = np.where(plain, following, np.arange(rows))
    return Stretches(until, touched, said == UNCOMPENSATED)


def named_axes(source: Source, move: Integers | slice) -> Flags:
    """Along which axes some moves (n,) are named or move, (n, 3)."""
    path = source.path
    named: Flags = (path.word[move] >= 0) | (np.abs(path.end_mm[move] - path.start_mm[move]) > STANDS_MM)
    return named


def _is_written_alike(source: Source) -> Flags:
    """Whether the feed of each executed block is one that needs neither the move's length nor the spindle's speed."""
    mode = source.path.states["feed_mode"][source.path.executed[:, 2]]
    alike: Flags = mode != INVERSE_TIME
    return alike & (mode != PER_REVOLUTION) if source.target.tool_offset == "call" else alike


def _changes(source: Source) -> Flags:
    """Whether each executed block but the first has another state than the one before."""
    state = source.path.executed[:, 2]
    columns = (np.nan_to_num(source.path.states[name][state], nan=-1.0) for name in _KEPT)
    changes = np.zeros(max(len(state) - 1, 0), dtype=np.bool_)
    for column in columns:
        changes |= column[1:] != column[:-1]
    return changes


def straights(source: Source, course: Course, first: int, end: int) -> Straights:
    """The moves of the executed blocks `first` to before `end`, a stretch."""
    path, after = source.path, source.path.executed[:, 1]
    move = slice(int(after[first - 1]) if first else 0, int(after[end - 1]))
    rapid = path.rapid[move]
    end_mm = np.where(named_axes(source, move), path.end_mm[move] + np.array(course.shift_mm), np.nan)
    return Straights(end_mm, rapid, np.where(rapid, np.nan, path.feed[move]))
