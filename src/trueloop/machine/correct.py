"""Corrections by the machine model: axis tables, set-ups, displaced points of programs."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import product
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.machine.model.chain import ZERO, Axis, AxisKind, Vector
from trueloop.machine.model.compiled import CompiledModel, compile_model
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Signals
from trueloop.machine.model.validity import ROUNDING_MM, check_signals, check_state, check_travel
from trueloop.machine.standards import PlanarField
from trueloop.nc.edit.edit import Edit, displace_word, insert_word
from trueloop.nc.field import FROM_REFERENCE, DisplaceInMachine, Field, looked_up, machine_field, require_offsets
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import CoordinateState
from trueloop.units import UM_PER_MM

CHECKS = 16
"""Points between two entries at which the table is compared with the model."""


@dataclass(frozen=True)
class AxisTable:
    """E along `output` at positions of `input_axis`, mm: (n,) forward and return. Between entries it is linear.

    `deviation_mm` is the largest difference to the model along the line of the table, all other axes at the base
    position, however they came there; elsewhere the model differs by what other axes do, up to `elsewhere_mm` over the
    corners of travel and their ways there.
    """

    input_axis: str
    output: str
    position_mm: Array
    forward_mm: Array
    reverse_mm: Array
    deviation_mm: float
    elsewhere_mm: float

    def error_mm(self, position_mm: Array, way: float) -> Array:
        """Returns the table's value, (n,); end values hold outside."""
        values = self.forward_mm if way > 0 else self.reverse_mm
        return np.interp(position_mm, self.position_mm, values)


def axis_table(
    model: MachineModel,
    input_axis: str,
    output: str,
    count: int,
    base: Mapping[str, float],
    signals: Signals | None = None,
    tool_mm: Vector = ZERO,
    extrapolate: Collection[str] = (),
) -> AxisTable:
    """Tabulates the error at `count` equal steps over the travel of `input_axis`; `base` holds the positions of the
    other axes.

    A table does not know from which side the other axes came to their positions: it holds the mean of both ways.
    Raises MCH-AXIS where `input_axis` and `output` are not linear axes of the machine, MCH-TRAVEL for an axis without
    travel and for others beyond theirs, MCH-RANGE for signals beyond the data that `extrapolate` does not name.
    """
    chain = model.machine.chain
    low, high = _linear(chain.axis(input_axis), "the table runs over").travel
    _linear(chain.axis(output), "the table corrects")
    for name, position in base.items():
        check_travel(chain.axis(name), np.array([position]))
    check_signals(model, signals or {}, extrapolate)
    if not np.isfinite([low, high]).all():
        raise Code.MCH_TRAVEL.refusal(
            f"{input_axis} travels from {low:g} to {high:g} mm: {count} entries have no places",
            hint=f"give [axes.{input_axis}] its travel_mm in the machine file and fit the model again",
            values={"axis": input_axis, "travel": [low, high], "unit": "mm"},
        )
    positions = np.linspace(low, high, count)
    dense = np.linspace(low, high, (count - 1) * CHECKS + 1)

    def error(at: Array, way: float, others: Mapping[str, float], ways: Mapping[str, float]) -> Array:
        placed = chain.positions({**others, input_axis: at})
        travel = np.array([{**ways, input_axis: way}.get(name, 0.0) for name in chain.order])
        state = State(placed, np.broadcast_to(travel, placed.shape), signals or {}, tool_mm)
        along: Array = model.error_mm(state)[:, "XYZ".index(output)]
        return along

    forward, reverse = error(positions, 1.0, base, {}), error(positions, -1.0, base, {})
    table = AxisTable(
        input_axis=input_axis,
        output=output,
        position_mm=positions,
        forward_mm=forward,
        reverse_mm=reverse,
        deviation_mm=0.0,
        elsewhere_mm=0.0,
    )

    def off(others: Mapping[str, float]) -> float:
        return max(
            float(np.abs(table.error_mm(dense, way) - error(dense, way, others, ways)).max())
            for way, ways in product((1.0, -1.0), _ways(model, input_axis))
        )

    here = off(base)
    return replace(table, deviation_mm=here, elsewhere_mm=max([here, *map(off, _corners(model, input_axis))]))


def _linear(axis: Axis, does: str, hint: str = "tables hold millimetres as a function of millimetres") -> Axis:
    if axis.kind is not AxisKind.LINEAR:
        raise Code.MCH_AXIS.refusal(f"{does} {axis.name}, which turns: 1 of X, Y, Z is wanted", hint=hint)
    return axis


def _ways(model: MachineModel, input_axis: str) -> list[dict[str, float]]:
    """Returns the ways of travel of those other axes for which it matters."""
    both = {term.name.axis for term in model.terms if term.both_ways} - {input_axis}
    return [dict(zip(sorted(both), ways, strict=True)) for ways in product((1.0, -1.0), repeat=len(both))]


def _corners(model: MachineModel, input_axis: str) -> list[dict[str, float]]:
    """Returns all combinations of ends of travel of the other axes; axes without end stand at 0."""
    ends = {axis.name: axis.travel for axis in model.machine.chain.axes if np.isfinite(axis.travel).all()}
    ends = {name: ends[name] for name in model.machine.chain.order if name in ends and name != input_axis}
    return [dict(zip(ends, corner, strict=True)) for corner in product(*ends.values())]


IN_NO_CASE: Final = frozenset({4.0, 68.0})
"""G codes whose X and Y are a time and the centre of a rotation: G4, G68."""

NO_POSITIONS: Final = IN_NO_CASE | {10.0, 28.0, 30.0, 52.0, 53.0, 92.0}
"""The codes without positions, and those that set a coordinate system or go to a place of the machine: G10, G28, G30,
G52, G53, G92."""

NOT_FOLLOWED: Final = {
    2.0: "an arc, whose centre would stay",
    3.0: "an arc, whose centre would stay",
    7.0: "diameter mode",
    16.0: "polar coordinates",
    51.0: "a scaled frame",
    51.1: "a mirrored frame",
}
"""G codes after which X and Y are not, or not only, points of the plane."""


TURNS: Final = {68.0: True, 68.2: True, 69.0: False}
OFFSETS: Final = frozenset({54.0, 55.0, 56.0, 57.0, 58.0, 59.0, 59.1, 59.2, 59.3, 54.1, 154.0})
SHIFTS: Final = frozenset({52.0, 92.0, 92.1, 92.2, 92.3})
SETS_OFFSETS: Final = frozenset({2.0, 20.0})
"""Values of L with which G10 sets work offsets."""

ROTARY: Final = frozenset("ABC")
MACRO_CALLS: Final = frozenset({65.0, 66.0, 66.1})
_UNITS: Final = {"mm": False, "inch": True}


@dataclass(frozen=True)
class TableField:
    """The error that a table of displacements undoes: E = −displacement. Raises MCH-PROGRAM for more than a plane."""

    field: Field

    def __post_init__(self) -> None:
        nodes = self.field.identity["nodes"]
        if isinstance(nodes, list) and nodes[2] > 1:
            raise Code.MCH_PROGRAM.refusal(
                f"the table has {nodes[2]} values of z_mm: points of a plane have none",
                hint="leave z_mm and dz out, or give the table to `trueloop nc map`",
            )

    def error_mm(self, point_mm: Array) -> Array:
        """Returns E at (n, 2) points. Raises NC-FIELD outside of the table."""
        moved = self.field.displacement_mm(np.column_stack([point_mm, np.zeros(len(point_mm))]))
        if np.any(moved[:, 2]):
            raise Code.MCH_PROGRAM.refusal(
                f"the table displaces Z by {UM_PER_MM * np.abs(moved[:, 2]).max():.1f} µm: points have X and Y only",
                hint="leave dz out, or give the table to `trueloop nc map`",
            )
        return -moved[:, :2]


@dataclass(frozen=True)
class Displaced:
    """A program's edits, where its points are to be (n, 2), the largest correction of X and of Y, and its byte."""

    edits: list[Edit]
    wanted_mm: Array
    largest_mm: tuple[float, float]
    largest_at: int


@dataclass(frozen=True)
class _Point:
    block: Block
    words: dict[str, Word]
    position: tuple[float, float]
    state: CoordinateState


def displace_points(program: Program, field: PlanarField, no_positions: frozenset[float] = NO_POSITIONS) -> Displaced:
    """Adds −E(x, y) to every programmed point. Blocks with a G code of `no_positions` are left alone.

    Words are as fine afterwards as the control resolves, or as the program itself writes them. The plane is that of the
    words. Raises MCH-PROGRAM for a dialect that is not a mill's, an incremental coordinate, one that is computed when
    the program runs, arcs, and frames that are not followed: points under G68, which would turn errors of the machine
    with the part, and points after a change of zero; not where `no_positions` has their words displaced as points.
    """
    if not program.dialect.plane_of_points:
        mills = sorted(name for name, dialect in DIALECTS.items() if dialect.plane_of_points)
        raise Code.MCH_PROGRAM.refusal(
            f"programs of the dialect {program.dialect.name} are not corrected point by point: {len(mills)} mills' are",
            hint=f"have it written for another control, or say which this is: --dialect {' or '.join(mills)}",
            place=program.place(0),
        )
    points = list(_points(program, no_positions))
    if not points:
        return Displaced([], np.empty((0, 2)), (0.0, 0.0), 0)
    at = -_error_mm(program, field, points)
    before = np.vstack([at[:1], at[:-1]])
    edits = [
        edit
        for point, correction, last in zip(points, at, before, strict=True)
        for edit in _edits(program, point, correction, last)
    ]
    size = np.abs(at)
    x, y = size.max(axis=0).tolist()
    worst = points[int(size.max(axis=1).argmax())]
    wanted = np.array([point.position for point in points]) + at
    return Displaced(edits, wanted, (x, y), min(word.start for word in worst.words.values()))


def off_mm(
    written: Program, wanted_mm: Array, no_positions: frozenset[float] = NO_POSITIONS
) -> list[tuple[int, float]]:
    """Compares the points of a written program with the intended ones: returns line and distance along X or Y of those
    that are further off than a step of the control; line 0 and infinity where there are more or fewer.
    """
    points = list(_points(written, no_positions))
    if len(points) != len(wanted_mm):
        return [(0, math.inf)]
    off = np.abs(np.array([point.position for point in points]).reshape(-1, 2) - wanted_mm).max(axis=1)
    step = [written.dialect.step_mm(point.state.inch) for point in points]
    return [(points[k].block.line, float(off[k])) for k in np.flatnonzero(off > step)]


def _error_mm(program: Program, field: PlanarField, points: Sequence[_Point]) -> Array:
    """Returns E at every point, (n, 2); a refusal of the field is raised for its block."""
    try:
        return field.error_mm(np.array([point.position for point in points]))
    except TrueloopError:
        for point in points:
            with in_file(program.file or "program", point.block.line):
                field.error_mm(np.array([point.position]))
        raise


def _edits(program: Program, point: _Point, correction: Array, before: Array) -> Iterator[Edit]:
    for k, letter in enumerate("XY"):
        word = point.words.get(letter)
        if word is not None:
            edit = displace_word(program, word, float(correction[k]), point.state)
        elif abs(correction[k] - before[k]) > 0.5 * program.dialect.step_mm(point.state.inch):
            value = point.position[k] + float(correction[k])
            edit = insert_word(program, point.block.index, letter, value, point.state)
        else:
            continue
        if edit is not None:
            yield edit


def _points(program: Program, no_positions: frozenset[float]) -> Iterator[_Point]:
    """Yields every block with an X or Y word, with the position it leads to in mm."""
    last: dict[str, float] = {}
    frame, at_first = _Zero(), None
    angles = {word.letter: math.nan for block in program.blocks for word in _rotary(block)}
    inch, incremental = _UNITS.get(program.unit or ""), False
    for block in program.blocks:
        codes = {word.value for word in block.words if word.letter == "G" and word.kind == "number"}
        for word in block.words:
            if word.letter == "G" and word.value in NOT_FOLLOWED:
                raise _no_point(program, word, NOT_FOLLOWED[word.value])
        inch = _unit(program, block, inch, first=not last)
        frame = frame.after(block)
        incremental = 91 in codes or (incremental and 90 not in codes)
        for word in _rotary(block):
            angles[word.letter] = word.value if word.kind == "number" and not incremental else math.nan
        words = {word.letter: word for word in block.words if word.letter in ("X", "Y")}
        if not words or codes & no_positions:
            continue
        first = next(iter(words.values()))
        at_first = at_first or frame
        if no_positions != IN_NO_CASE:
            _require_one_zero(program, first, frame, at_first)
        if inch is None:
            raise Code.NC_UNIT.refusal(
                f"the program does not state its unit before its first length, {first.text}: 1 is 1 mm or 25.4 mm",
                hint="write G20 or G21 before it, or say which unit is in force at the start: --unit mm or --unit inch",
                place=program.place(first.start),
            )
        for axis, angle in angles.items():
            if angle % 360.0 != 0.0:  # NaN as well
                raise _no_point(program, first, f"a point where {axis} does not stand at 0 degrees, or is not known to")
        state = CoordinateState(inch=inch, diameter=False)
        for word in words.values():
            if incremental or word.kind != "number":
                raise _no_point(program, word, "an increment" if incremental else "computed when the program runs")
        last |= {letter: word.value * state.unit_mm(letter) for letter, word in words.items()}
        if len(last) < 2:
            raise _no_point(program, next(iter(words.values())), "one of X and Y, and the other has no position yet")
        yield _Point(block, words, (last["X"], last["Y"]), state)


@dataclass(frozen=True)
class _Zero:
    """The statements read that place the program in the machine, and G68; `set`: work offsets by G10, which last."""

    offset: str = "G54"
    set: tuple[str, ...] = ()
    shift: Mapping[str, str] = field(default_factory=dict)
    turned: bool = False

    @property
    def words(self) -> str:
        return " ".join([self.offset, *self.set, *self.shift.values()])

    def after(self, block: Block) -> "_Zero":
        codes = {word.value for word in block.words if word.letter == "G" and word.kind == "number"}
        values = {word.letter: word for word in block.words if word.letter in "XYLP"}
        said = " ".join(word.text for word in values.values())
        found = self
        if codes & OFFSETS:
            found = replace(
                found, offset=f"G{min(codes & OFFSETS):g} {values['P'].text if 'P' in values else ''}".strip()
            )
        if "L" in values and 10.0 in codes and values["L"].value in SETS_OFFSETS:
            found = replace(found, set=(*found.set, f"G10 {said}"))
        if codes & SHIFTS:
            named = {letter: values[letter] for letter in "XY" if letter in values}
            shift = {**found.shift, **{letter: f"G52 {word.text}" for letter, word in named.items()}}
            shift = {letter: text for letter, text in shift.items() if letter not in named or named[letter].value != 0}
            found = replace(found, shift=shift if 52.0 in codes else {**found.shift, "": f"G92 {said}"})
        for code in codes & TURNS.keys():
            found = replace(found, turned=TURNS[code])
        return found


def _require_one_zero(program: Program, word: Word, now: _Zero, first: _Zero) -> None:
    """Raises MCH-PROGRAM for a point, by its first word, where a table of the machine is not that of the words."""
    if now.turned:
        what = "under G68: errors of the machine do not turn with the part"
    elif now != first:
        what = f"counted from another zero ({now.words}) than the first point ({first.words}): elsewhere in the machine"
    else:
        return
    raise Code.MCH_PROGRAM.refusal(
        f"{word.text} in block {word.block + 1} is {what}",
        hint="write one program for each zero and angle, or map it in machine coordinates: `trueloop nc map … --frame "
        "machine --offsets FILE`",
        place=program.place(word.start),
    )


def _rotary(block: Block) -> list[Word]:
    """Words of rotary axes; in a block that calls a macro these letters are its arguments."""
    words = [word for word in block.words if word.letter in ROTARY and word.kind in ("number", "expression")]
    calls = words and any(word.letter == "G" and word.value in MACRO_CALLS for word in block.words)
    return [] if calls else words


def _unit(program: Program, block: Block, inch: bool | None, *, first: bool) -> bool | None:
    """Returns whether the unit is the inch after the codes of a block; None while no code states it.

    Raises NC-UNIT where the block states, before the first point, another unit than the one given.
    """
    stated = [word for word in block.words if word.letter == "G" and word.kind == "number" and word.value in (20, 21)]
    if not stated or block.skipped:
        return inch
    now = stated[-1].value == 20
    if first and inch is not None and program.unit is not None and now is not inch:
        raise Code.NC_UNIT.refusal(
            f"{stated[-1].text} states {'inch' if now else 'mm'}, and the unit was given as {program.unit}",
            hint="leave --unit out: the program states its unit itself",
            place=program.place(stated[-1].start),
        )
    return now


def _no_point(program: Program, word: Word, why: str) -> TrueloopError:
    return Code.MCH_PROGRAM.refusal(
        f"{word.text} in block {word.block + 1} is {why}: positions are not known from the words",
        hint="write the points as numbers in absolute coordinates (G90); paths are for `trueloop nc map`",
        place=program.place(word.start),
    )


AXES: Final = "XYZ"
ROTARY_AXES: Final = "ABC"
ANY_TOOL: Final = -1
HINT: Final = (
    "the model lives in machine coordinates: give --work-zero 1=X,Y,Z for G54, --tool T=X,Y,Z, or a file of --offsets"
)


@dataclass(frozen=True)
class Setup:
    """The facts that a program does not state: where its zero lies, how long its tools are, how warm the machine is.

    `work_zero_mm`: machine coordinates of the program's zero by number of the work offset (1 is G54), for a tool of
    no length. `tool_mm`: tool point from the frame of the last axis, by T number; under −1 for every other tool.
    `fixed`: where rotary axes stand, rad, until the program itself positions them. `table`: the
    control's tool table, where it is given: a tool that is not in `tool_mm` has its point at minus the offset that the
    program brings into force, because machine = program + work zero + offset. `zero_signals` are those of the moment
    when the work zero was set, where what had drifted by then lies in it. `reference_mm`: where axes stand in the
    machine at the start and after a return to the reference point (G28), by their names. `tool_point`: whether tool
    point control is in force at the program's start; None: it is off, and a LinuxCNC program has to state it itself.

    >>> setup = trueloop.Setup({1: (250.0, 0.0, -150.0)}, signals={"T1": 25.0})
    >>> setup.tool_mm[-1]  # every tool: its point is at the frame of the last axis
    (0.0, 0.0, 0.0)
    """

    work_zero_mm: Mapping[int, Vector]
    tool_mm: Mapping[int, Vector] = field(default_factory=lambda: {ANY_TOOL: (0.0, 0.0, 0.0)})
    signals: Signals = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)
    table: Sequence[CutterTool] | None = None
    zero_signals: Signals | None = None
    reference_mm: Mapping[str, float] = field(default_factory=dict)
    tool_point: bool | None = None


def references_mm(model: MachineModel, setup: Setup) -> dict[str, float]:
    """Returns where each linear axis with backlash stands at the start and after G28, by its name, machine coordinates.

    That is what the set-up states, else the machine's zero where it is an end of travel: from there the axis can come
    one way only. An axis whose travel lies on both sides of it has none.
    """
    for name in setup.reference_mm:
        _linear(
            model.machine.chain.axis(name), "a reference point is stated of", "state that of X, Y, Z: --reference Y=0"
        )
    both, known = {term.name.axis for term in model.terms if term.both_ways}, dict[str, float]()
    for axis in model.machine.chain.axes:
        if axis.name not in both or axis.name not in AXES:
            continue
        low, high = axis.travel
        if axis.name in setup.reference_mm:
            known[axis.name] = setup.reference_mm[axis.name]
        elif low >= -ROUNDING_MM or high <= ROUNDING_MM:
            known[axis.name] = 0.0
    return known


def compensation_field(
    model: MachineModel, setup: Setup, identity: dict[str, object], extrapolate: Collection[str] = ()
) -> Field:
    """Returns COMP_MTG = −E at every point of a program, along the program's X, Y, Z, for `map_program`.

    An axis that the machine does not have is not displaced; rotary axes are followed to where the program positions
    them. Evaluated at a point it raises MCH-FRAME (an unknown work offset or tool, a rotary axis whose position is not
    stated, a turned head), MCH-TRAVEL and MCH-RANGE.
    """
    rotary = frozenset(axis.name for axis in model.machine.chain.axes if axis.kind is AxisKind.ROTARY)
    backlash = any(term.both_ways for term in model.terms)
    return machine_field(
        _displacement(model, setup, extrapolate),
        identity,
        knows_travel=backlash,
        follows=rotary,
        tools=setup.table,
        work_mm=setup.work_zero_mm,
    )


def state_at(
    model: MachineModel, setup: Setup, points_mm: Array, work: Integers, tool: Integers, travel: Array
) -> State:
    """Axis positions at program points (n, 3): point + work zero − tool vector; travel (n, 3) along X, Y, Z.

    No tool offsets are in force. Raises MCH-FRAME for unknown tools and work offsets.
    """
    axes = points_mm + looked_up(work, setup.work_zero_mm, "work offset", HINT)
    tool_mm = _tool_points_mm(setup, tool, np.zeros((len(points_mm), 3)))
    return _state(model, setup, axes - tool_mm, setup.fixed, travel, tool_mm)


def _state(
    model: MachineModel,
    setup: Setup,
    axes: Array,
    rotary: Mapping[str, Array] | Mapping[str, float],
    travel: Array,
    tool_mm: Array,
) -> State:
    chain = model.machine.chain
    given: dict[str, Array | float] = dict(rotary)
    given |= {name: axes[:, k] for k, name in enumerate(AXES) if name in chain.order}
    ways = [travel[:, AXES.index(name)] if name in AXES else np.zeros(len(axes)) for name in chain.order]
    return State(chain.positions(given), np.stack(ways, axis=-1), setup.signals, tool_mm)


def _displacement(model: MachineModel, setup: Setup, extrapolate: Collection[str]) -> DisplaceInMachine:
    """Returns −E along the machine's own axes, which are the program's: a turned table carries no coordinates with
    it. Rotary axes stand where the program has positioned them, before that where the set-up states.
    """
    there = np.array([name in model.machine.chain.order for name in AXES])

    rotary = [name for name in model.machine.chain.order if name in ROTARY]
    references = references_mm(model, setup)

    @cache
    def compiled(tool_mm: Vector, angles: tuple[float, ...]) -> CompiledModel:
        return compile_model(model, setup.signals, tool_mm, dict(zip(rotary, angles, strict=True)))

    def displace(
        points_mm: Array,
        work: Integers,
        tool: Integers,
        travel: Array,
        offset_mm: Array,
        rotary_deg: Array,
        cuts: Flags,
    ) -> Array:
        tool_mm = _tool_points_mm(setup, tool, offset_mm)
        axes = points_mm + looked_up(work, setup.work_zero_mm, "work offset", HINT) - tool_mm
        stands = {name: _stands_rad(name, setup, rotary_deg[:, ROTARY_AXES.index(name)]) for name in rotary}
        _check_head_upright(model, stands)
        ways = _ways_of_travel(travel, axes, references)
        check_state(model, _state(model, setup, axes, stands, ways, tool_mm), extrapolate)
        places = np.column_stack([tool_mm, *stands.values()])

        def along(ways: Array, of: Flags) -> Array:
            compensation = np.zeros_like(axes)
            for place in np.unique(places[of], axis=0):
                own = of & (places == place).all(axis=1)
                x, y, z, *angles = place.tolist()
                error_mm = compiled((x, y, z), tuple(angles)).bed_error_mm(axes[own], ways[own])
                compensation[own] = np.where(there, -error_mm, 0.0)
            return compensation

        for k in np.flatnonzero((cuts[:, None] & (travel >= FROM_REFERENCE) & (ways == 0.0)).any(axis=0)):
            unknown = cuts & (travel[:, k] >= FROM_REFERENCE) & (ways[:, k] == 0.0)
            forth, back = (np.where(np.arange(3) == k, way, ways) for way in (1.0, -1.0))
            require_way(AXES[k], np.abs(along(forth, unknown) - along(back, unknown)).max())
        return along(ways, np.ones(len(axes), dtype=bool))

    return displace


UNKNOWN_WAY_MM: Final = 0.5e-3
"""A cut may have so much backlash, mm, of which the direction is not known: half of it, the error, is below 0.3 µm."""


def _ways_of_travel(travel: Array, axes_mm: Array, references_mm: Mapping[str, float]) -> Array:
    """Returns the way of travel (n, 3), +1, −1 or 0: from the reference point where the axis comes from there."""
    ways = np.where(np.abs(travel) > 1.0, 0.0, travel)
    for name, reference in references_mm.items():
        k = AXES.index(name)
        comes = travel[:, k] == FROM_REFERENCE
        ways[comes, k] = np.sign(np.round(axes_mm[comes, k] - reference, 6))
    return ways


def require_way(axis: str, backlash_mm: float) -> None:
    """Refuses a cut (MCH-FRAME) at a place to which an axis may have come from either side, with its backlash there."""
    if backlash_mm > UNKNOWN_WAY_MM:
        raise Code.MCH_FRAME.refusal(
            f"{axis} comes to this cut from a place that is not known: its direction of travel decides "
            f"{UM_PER_MM * backlash_mm:.1f} µm of backlash",
            hint=f"go to another position of {axis} first, then to this one; or, where it comes from the start or from "
            f"G28, state the machine coordinate of that place: --reference {axis}=MM",
        )


def _tool_points_mm(setup: Setup, tool: Integers, offset_mm: Array) -> Array:
    """Returns the tool points (n, 3) from the last axis' frame, mm. Raises MCH-FRAME for an unknown tool."""
    named = np.isin(tool, list(setup.tool_mm))
    if setup.table is None:
        return looked_up(np.where(named, tool, ANY_TOOL), setup.tool_mm, "tool", HINT)
    require_offsets(tool[~named], offset_mm[~named], HINT)
    points = -offset_mm
    points[named] = looked_up(tool[named], setup.tool_mm, "tool", HINT)
    return points


def _stands_rad(axis: str, setup: Setup, stated_deg: Array) -> Array:
    """Returns where a rotary axis stands, (n,), by the program or the set-up. Raises MCH-FRAME for neither."""
    if np.isinf(stated_deg).any():
        raise Code.MCH_FRAME.refusal(
            f"{axis} is at a place that is not known in {int(np.isinf(stated_deg).sum())} moves: after a reference "
            "point, an increment from an unknown place, or a shift of its own (G92, G52, TRANS)",
            hint=f"position {axis} by a number, absolute (G90), before the next move along X, Y, Z",
        )
    unstated = np.isnan(stated_deg)
    if unstated.any() and axis not in setup.fixed:
        raise Code.MCH_FRAME.refusal(
            f"rotary axis {axis} has no stated position in {int(unstated.sum())} moves",
            hint=f"state where it stands until the program positions it, in degrees: --at {axis}=0",
        )
    stands: Array = np.where(unstated, setup.fixed.get(axis, 0.0), np.radians(stated_deg))
    return stands


def _check_head_upright(model: MachineModel, stands: Mapping[str, Array]) -> None:
    """Refuses a turned head: work offsets are applied to the tool vectors of an upright head only."""
    for axis in model.machine.chain.tool:
        if np.any(turned := stands.get(axis.name, np.zeros(1))):
            raise Code.MCH_FRAME.refusal(
                f"{axis.name} turns the tool by {float(np.abs(turned).max()):g} rad: the place of its tip is not given",
                hint="only rotary axes that carry the work may stand away from 0",
            )
