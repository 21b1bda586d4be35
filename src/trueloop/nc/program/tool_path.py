"""The tool path of a program: every move in mm with X as a radius, tied to the block and words that set it.

Positions are program coordinates of the work frame in force. A change of frame (G92, G54 …) changes what the position
is called, not where the tool is: the start of the next move is then not the end of the move before.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trueloop._core import nc_rows
from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Finding

NO_COMPENSATION: Final = 40
"""Neither G41 nor G42 is in force."""

INVERSE_TIME, PER_MINUTE, PER_REVOLUTION = 93, 94, 95
"""Feed modes, by the G code that calls them on a mill: an F word is 1/min of the whole move, mm/min, or mm/rev."""


class Motion(IntEnum):
    """The kind of a move. A probing move ends at its programmed point here, on the machine at the touch."""

    RAPID = 0
    LINE = 1
    ARC = 2
    PROBE = 3
    THREAD = 4


@dataclass(frozen=True)
class CoordinateState:
    """The form of a block's coordinates: program unit, X as a diameter, increments instead of positions.

    `radius_increments`: increments of X are radii where its positions are diameters (DIAM90 of a Sinumerik).
    """

    inch: bool
    diameter: bool
    incremental: bool = False
    radius_increments: bool = False

    def unit_mm(self, letter: str, increment: bool | None = None) -> float:
        """Millimetres of position (X a radius) in one unit of that word; I, J, K and R are radius values. `increment`:
        whether the word is one, whatever the block's are.
        """
        unit = 25.4 if self.inch else 1.0
        as_radius = self.radius_increments and (self.incremental if increment is None else increment)
        return unit / 2 if letter == "X" and self.diameter and not as_radius else unit


def _of_state(name: str) -> "cached_property[NDArray[Any]]":
    """Returns the property of a path that gives, of each move, that column of its states, (n,)."""
    return cached_property(lambda path: path.states[name][path.state])


@dataclass(frozen=True, eq=False)
class ToolPath:
    """The moves of a program, one an index (n of them).

    `motion` (n,) `Motion`. `start_mm`, `end_mm`, `centre_mm` (n, 3): X (radius), Y, Z; a centre is NaN without an arc.
    `sweep_rad` (n,): the angle turned, 0 without an arc; positive is clockwise (G02) looking against the third axis of
    the plane: G18 from +Y, z to the right and x up; G17 from +Z, x right and y up; G19 from +X, y right and z up. In
    G18 that is the sign of `geometry.feature.Arc.sweep_rad`. `programmed_radius_mm` (n,): the R word, NaN without.
    `block` (n,) from 0, `line` and `column` from 1: of the first word that set a coordinate. `word` (n, 3): index of
    the word that set X, Y, Z of the end, −1 when it was inherited or came from a cycle. `state` (n,) indexes the
    columns of `states`, reached through the properties below, each (n,).
    `call` (n,) indexes `calls` (k, 2): the block that calls, and the call that one is in itself, −1 outside any. Before
    move `dwell_before` (m,) the tool dwells for `dwell_s` (m,), NaN where the program counts revolutions.

    `milled_before` (m,): the move, the first of its own, before which a milling cycle of the control's cuts within
    `milled_mm` (m, 6), the lowest and the highest X, Y, Z; its passes are not moves of the path.

    `corner_move` (m,): the moves that are corners between two others; `corner_word` (m,): the words that ask for them,
    −1 where a word of an earlier block rounds every corner.

    `unit_stated`: the block, from 0, that states the unit before any length, and whether it is the inch.

    Of a traced run also the m blocks executed, in order: `executed` (m, 3), block, number of moves and state after it.
    Otherwise m is 0.
    """

    motion: Integers
    start_mm: Array
    end_mm: Array
    centre_mm: Array
    sweep_rad: Array
    programmed_radius_mm: Array
    block: Integers
    column: Integers
    word: Integers
    state: Integers
    call: Integers
    calls: Integers
    dwell_before: Integers
    dwell_s: Array
    unit_stated: tuple[int, bool] | None
    states: dict[str, NDArray[Any]]
    executed: Integers = field(default_factory=lambda: np.empty((0, 3), dtype=np.int32))
    findings: tuple[Finding, ...] = ()
    milled_before: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    milled_mm: Array = field(default_factory=lambda: np.empty((0, 6)))
    corner_move: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    corner_word: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int32))

    def __len__(self) -> int:
        return len(self.motion)

    @cached_property
    def corners(self) -> dict[int, int]:
        """Returns the word that asks for each move that is a corner."""
        return dict(zip(self.corner_move.tolist(), self.corner_word.tolist(), strict=True))

    @cached_property
    def corner_words(self) -> frozenset[int]:
        """Returns the words that ask for corners."""
        return frozenset(self.corners.values()) - {-1}

    @cached_property
    def line(self) -> Integers:
        """Returns the line of each move, from 1."""
        return self.block + 1

    @cached_property
    def rapid(self) -> Flags:
        """Returns whether each move is a rapid move."""
        return np.equal(self.motion, Motion.RAPID)

    plane = _of_state("plane")
    """The plane of arcs: 17 (XY), 18 (ZX), 19 (YZ)."""
    inch = _of_state("inch")
    """True where the program unit is the inch."""
    diameter = _of_state("diameter")
    """True where X words are diameters."""
    incremental = _of_state("incremental")
    """True where coordinates are increments."""
    feed = _of_state("feed")
    """The feed in the unit of `feed_mode`: mm/min (94), mm/rev (95), 1/min (93); NaN before the first F."""
    feed_mode = _of_state("feed_mode")
    """The feed mode: 93 inverse time, 94 mm/min, 95 mm/rev."""
    spindle_mode = _of_state("spindle_mode")
    """The spindle mode: 96 constant surface speed, 97 revolutions per minute."""
    spindle_speed = _of_state("spindle_speed")
    """The S word as programmed, NaN before the first."""
    spindle_limit = _of_state("spindle_limit")
    """The greatest speed under constant surface speed, 1/min, where programmed (G50 S, G92 S); else NaN."""
    tool = _of_state("tool")
    """The T word of the tool in use, −1 before the first: where M06 changes tools, the T word at the last change."""
    tool_offset = _of_state("tool_offset")
    """The number by which the tool offset in force was called: 13 of T0313, that of H, that of the tool; of a
    Sinumerik's T3 D2 3002. 0 for none, −1 where the block gave the offset itself.
    """
    tool_offset_subtracted = _of_state("tool_offset_subtracted")
    """True where the control subtracts the tool offset in force (G44)."""
    compensation = _of_state("compensation")
    """The cutter compensation in force: 40 none, 41 left, 42 right. The path is the programmed contour."""
    radius_offset = _of_state("radius_offset")
    """The number by which the radius of the compensation in force was called: D, the tool's, of a
    Sinumerik's T3 D2 3002; 0 for none, and where the program gives the radius.
    """
    work_offset = _of_state("work_offset")
    """The work offset in force, from 1 (G54)."""
    origin_mm = _of_state("origin_mm")
    """Machine less program position, (n, 3): work offset, G52, G92 or TRANS, and tool offset."""
    register_mm = _of_state("register_mm")
    """The part of `origin_mm` that G52, G92 or TRANS made, (n, 3)."""
    renamed = _of_state("renamed")
    """Count of the tools, tool offsets and work offsets that came into force so far, for X, Y, Z, (n, 3)."""
    turned = _of_state("turned")
    """The letter (as its code, 0 for none) of a rotary axis away from 0 or at an unknown position."""
    linear = _of_state("linear")
    """True where coordinates are turned, mirrored or scaled against the machine's axes."""

    def call_stack(self, move: int) -> tuple[int, ...]:
        """Lines of the calls in which that move is made, from 1, the outermost first."""
        lines: list[int] = []
        call = int(self.call[move])
        while call >= 0:
            block, call = (int(value) for value in self.calls[call])
            lines.insert(0, block + 1)
        return tuple(lines)

    def coordinate_state(self, move: int) -> CoordinateState:
        """Returns the form in which the coordinates of that move are written."""
        state = int(self.state[move])
        columns = self.states
        return CoordinateState(
            inch=bool(columns["inch"][state]),
            diameter=bool(columns["diameter"][state]),
            incremental=bool(columns["incremental"][state]),
            radius_increments=bool(columns["radius_increments"][state]),
        )


CSV_HEADER = (
    *("line", "column", "motion", "x_mm", "y_mm", "z_mm", "start_x_mm", "start_y_mm", "start_z_mm"),
    *("centre_x_mm", "centre_y_mm", "centre_z_mm", "sweep_rad", "feed", "feed_unit", "tool"),
)
"""Columns of `csv_text`: x is a radius; x, y, z the end of the move; centre and sweep empty except of arcs."""

_WORDS: Final = frozenset({"motion", "feed_unit"})
_WHOLE: Final = frozenset({"line", "column", "tool"})
"""Columns of words, and of whole numbers."""
_FEED_UNITS: Final = {INVERSE_TIME: "1/min", PER_MINUTE: "mm/min", PER_REVOLUTION: "mm/rev"}
_LENGTH_DECIMALS, _ANGLE_DECIMALS = 9, 12
_ROWS_AT_ONCE: Final = 20_000


def csv_text(path: ToolPath, first: int = 0) -> Iterator[str]:
    """Yields the moves from `first` on in the order of `CSV_HEADER`, a line each, some lines at a time; lengths to
    1e-9 mm, angles to 1e-12 rad, trailing zeros left out, unknown values empty. No cell has a comma or a quote.
    """
    for start in range(first, len(path), _ROWS_AT_ONCE):
        rows = slice(start, min(start + _ROWS_AT_ONCE, len(path)))
        yield nc_rows(_columns(path, rows), 0, rows.stop - start)


def _columns(path: ToolPath, rows: slice) -> list[tuple[Array, int] | tuple[NDArray[np.uint32], list[str]]]:
    """The columns of the CSV, of some moves."""
    motion, state = path.motion[rows], path.state[rows]
    arc = motion == Motion.ARC
    feed, feed_mode, tool = (path.states[name][state] for name in ("feed", "feed_mode", "tool"))
    return [
        (_numbers(path.block[rows] + 1), 0),
        (_numbers(path.column[rows]), 0),
        (motion.astype(np.uint32), [each.name.lower() for each in Motion]),
        *((_numbers(of_axis), _LENGTH_DECIMALS) for of_axis in path.end_mm[rows].T),
        *((_numbers(of_axis), _LENGTH_DECIMALS) for of_axis in path.start_mm[rows].T),
        *((_numbers(np.where(arc, of_axis, np.nan)), _LENGTH_DECIMALS) for of_axis in path.centre_mm[rows].T),
        (np.where(arc, path.sweep_rad[rows], np.nan), _ANGLE_DECIMALS),
        (np.where(motion == Motion.RAPID, np.nan, feed), _LENGTH_DECIMALS),
        ((feed_mode - INVERSE_TIME).astype(np.uint32), [_FEED_UNITS[mode] for mode in sorted(_FEED_UNITS)]),
        (_numbers(tool), 0),
    ]


def _numbers(values: NDArray[Any]) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def rows_of(path: ToolPath) -> list[dict[str, object]]:
    """Returns the rows of `csv_text` as objects: numbers as numbers, empty cells as None."""
    return [
        {name: _value(name, cell) for name, cell in zip(CSV_HEADER, row.split(","), strict=True)}
        for text in csv_text(path)
        for row in text.splitlines()
    ]


def _value(name: str, cell: str) -> object:
    if name in _WORDS:
        return cell
    if not cell:
        return None
    return int(cell) if name in _WHOLE else float(cell)
