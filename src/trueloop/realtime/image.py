"""The image that the component in the servo thread loads: a model linear in its signals, a table by line, and limits.

Machine coordinates in mm, X of a lathe as a radius. The model gives E = actual − commanded; what is added is −E and the
table's rows. `formats/realtime/image_file.py` writes and reads the file.

A machine model as a bank: the compiled model at reference signals, and what one unit of each signal adds to it.

E is linear in every signal (`machine/model/term.py`), so the difference of two compiled models is exact, and a servo
period needs no more than sums of products. Rotary axes stand at 0.

Lags of a model while the machine runs: one step at a time, as exact as `lagged` (`machine/model/history.py`) is.

A lag follows from all readings of its sensor. What was before the first reading is not known: the lag begins in
equilibrium, and whatever that hides dies away with e^(−t/τ). It counts as known when `settle` time constants have
passed, or at once where an operator states that the machine was in equilibrium then.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import ZERO, AxisKind, Vector
from trueloop.machine.model.compiled import LINEAR, CompiledModel, compile_model
from trueloop.machine.model.compiled import Body as CompiledBody
from trueloop.machine.model.history import History, Lag
from trueloop.machine.model.model import MachineModel

SIGNALS = 16
"""Signals at most."""

TRAVEL_TOLERANCE_MM: Final = 1e-4
"""Distance outside the travel without a fault; `crates/rtec/src/corrector/travel.rs` states why."""


@dataclass(frozen=True)
class Identity:
    """Whose image it is. Hashes are hex digits; "" where there is no model, no table, no record."""

    machine: str
    serial: str
    model_sha256: str = ""
    program: str = ""
    program_sha256: str = ""
    record: str = ""


@dataclass(frozen=True)
class Signal:
    """One signal of the model: the value that the bank counts from, the range in which it holds, its largest step."""

    name: str
    unit: str
    reference: float
    low: float
    high: float
    most_step: float


@by_content
@dataclass(frozen=True)
class Body:
    """Six errors that act on one frame, as `machine.model.compiled.Body`, at the signals' reference values.

    `powers` (1 or 3, segments, powers, 6). `per_unit` holds what one unit of a signal adds, by the signal's place in
    the bank, in the same shape; signals that do not act on this frame are left out. `arm_mm` is that of a tool of no
    length: the tool's vector is added to it.
    """

    axis: int
    breaks: Array
    powers: Array
    per_unit: tuple[tuple[int, Array], ...]
    arm_mm: Array
    carries: Array


@by_content
@dataclass(frozen=True)
class Bank:
    """A machine model for all signals: E is linear in each. `slope` (1 + signals, 3, 3): at the references, per unit.

    `tool_mm` is the tool point from the frame of the last axis while the control's tool offset is zero; an offset in
    force is subtracted from it.
    """

    signals: tuple[Signal, ...]
    bodies: tuple[Body, ...]
    slope: Array
    tool_mm: Vector = ZERO


@by_content
@dataclass(frozen=True)
class Block:
    """The correction along one block of a program, whose first line is 1.

    `rows` (n, 4): x as a radius, z where the axes are commanded in machine coordinates, and what is added there; mm, in
    order of cutting.
    """

    line: int
    rows: Array


@dataclass(frozen=True)
class RealTimeLimits:
    """Limits that the component applies to every correction, whatever its pins are set to.

    `limit_mm`: the largest correction of an axis. `gate_mm`: how far off its path a row still holds. `travel_mm`:
    lowest and highest position of X, Y, Z that a drive may be sent to.
    """

    travel_mm: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    limit_mm: float = 0.150
    gate_mm: float = 0.1


@by_content
@dataclass(frozen=True)
class Image:
    """All that the component needs; `bank` None: a table alone; no blocks: a model alone."""

    identity: Identity
    limits: RealTimeLimits
    bank: Bank | None = None
    blocks: tuple[Block, ...] = ()


BODIES = 8
"""The largest number of carriers of errors: an axis, a place of a rotary axis, a spindle."""
MOST_STEPS = {"°C": 2.0}
"""The largest difference of two consecutive readings, by unit. Other signals may pass through their whole range."""


@dataclass(frozen=True)
class SignalLimits:
    """The user's limits of signals, by name: the range in which the model holds, the largest step between readings."""

    ranges: Mapping[str, tuple[float, float]]
    steps: Mapping[str, float]


NOTHING = SignalLimits({}, {})


def signals_of(model: MachineModel, stated: SignalLimits = NOTHING) -> tuple[Signal, ...]:
    """Returns the signals that the model needs, lags among them, in the order of the bank.

    A range that is not stated is that of the data. Raises RTC-SIGNAL for a range that neither gives, for an empty one,
    for a stated signal that the model does not need, and for more signals than an image holds.
    """
    needs = model.needs()
    _check_stated(needs, stated)
    ranges = {**model.identified, **stated.ranges}
    unknown = [name for name in needs if not _inside(ranges.get(name))]
    if unknown:
        raise Code.RTC_SIGNAL.refusal(
            f"no range is known of {len(unknown)} of the model's {len(needs)} signals: {', '.join(unknown)}",
            hint="give the lowest and the highest value at which the model holds",
            override=" ".join(f"--range {name}=LOW,HIGH" for name in unknown),
            values={"signals": unknown},
        )
    if len(needs) > SIGNALS:
        raise Code.RTC_SIGNAL.refusal(
            f"the model needs {len(needs)} signals, an image holds {SIGNALS}: {', '.join(needs)}",
            hint="fit the model with fewer temperatures: `term.choose` in the machine's file takes those that matter",
            values={"signals": list(needs)},
        )
    return tuple(_signal(model, name, ranges[name], stated.steps.get(name)) for name in needs)


def _check_stated(needs: tuple[str, ...], stated: SignalLimits) -> None:
    """Only signals that are needed, steps that are some."""
    other = sorted({*stated.ranges, *stated.steps} - set(needs))
    if other:
        raise Code.RTC_SIGNAL.refusal(
            f"a range or a step is stated for {', '.join(other)}; the model needs {len(needs)} signals: "
            f"{', '.join(needs) or 'none'}",
            hint="write the names as the readings and the lags of the model have them",
            values={"signals": other},
        )
    bad = {name: step for name, step in stated.steps.items() if not 0 < step < math.inf}
    if bad:
        raise Code.RTC_SIGNAL.refusal(
            f"steps between readings are above 0, not {', '.join(f'{name} {step:g}' for name, step in bad.items())}",
            hint="a sensor of temperature that works stays below 2 °C",
            values={"signals": list(bad)},
        )


def _inside(bounds: tuple[float, float] | None) -> bool:
    return bounds is not None and -math.inf < bounds[0] < bounds[1] < math.inf


def _signal(model: MachineModel, name: str, bounds: tuple[float, float], step: float | None) -> Signal:
    parts = [part for term in model.terms for part in term.parts if part.signal == name]
    unit = model.units.get(name, "")
    most = MOST_STEPS.get(unit, bounds[1] - bounds[0]) if step is None else step
    return Signal(name, unit, parts[0].reference, *bounds, most)


def bank_of(model: MachineModel, tool_mm: Vector, signals: tuple[Signal, ...], standing: Collection[str] = ()) -> Bank:
    """Compiles the model for all values of `signals` (`signals_of`). `tool_mm`: from the last axis' frame, no offset.

    `standing` names the rotary axes, which have to stand at 0 as long as the bank is used: nothing in it knows of them.
    Raises RTC-MODEL for a rotary axis not named there and for what a servo period has no time for, and MCH-STRUCTURE.
    """
    _check_axes(model, standing)
    reference = {signal.name: signal.reference for signal in signals}

    def at(moved: Signal) -> CompiledModel:
        """Compiles the model a whole range away: the effect of one unit of a signal may be lost in rounding."""
        return compile_model(model, {**reference, moved.name: moved.reference + moved.high - moved.low})

    base, others = compile_model(model, reference), [at(signal) for signal in signals]
    spans = [signal.high - signal.low for signal in signals]
    per_unit = [
        [(other.bodies[k].powers - body.powers) / span for other, span in zip(others, spans, strict=True)]
        for k, body in enumerate(base.bodies)
    ]
    bodies = tuple(_body(body, added) for body, added in zip(base.bodies, per_unit, strict=True))
    acting = tuple(body for body in bodies if body.powers.any() or body.per_unit)
    if len(acting) > BODIES:
        raise _too_much(model, f"{len(acting)} axes and spindles with errors are more than the {BODIES} of an image")
    slopes = [(other.slope - base.slope) / span for other, span in zip(others, spans, strict=True)]
    return Bank(signals, acting, np.array([base.slope, *slopes]), tool_mm)


def _body(body: CompiledBody, added: list[Array]) -> Body:
    """Leaves out tables that a signal does not affect: they are equal to the last bit with it and without."""
    per_unit = tuple((place, table) for place, table in enumerate(added) if table.any())
    return Body(
        axis=body.axis,
        breaks=body.breaks,
        powers=body.powers,
        per_unit=per_unit,
        arm_mm=body.arm_mm,
        carries=body.carries,
    )


def _check_axes(model: MachineModel, standing: Collection[str]) -> None:
    chain = model.machine.chain
    for name in standing:
        chain.axis(name)
    moving = [a.name for a in chain.axes if a.kind is AxisKind.ROTARY and a.name not in standing]
    other = [a.name for a in chain.axes if a.kind is AxisKind.LINEAR and a.name not in LINEAR]
    if other:
        raise _too_much(model, f"{len(other)} axes are none of X, Y, Z", other)
    if moving:
        raise Code.RTC_MODEL.refusal(
            f"the {len(moving)} rotary axes {', '.join(moving)} may turn, and the component in the servo thread "
            "would not know",
            hint="state it where they stay at 0 while the image is in use",
            override=" ".join(f"--standing {name}" for name in moving),
            values={"axes": moving},
        )


def _too_much(model: MachineModel, message: str, axes: list[str] | None = None) -> TrueloopError:
    named = axes or [axis.name for axis in model.machine.chain.axes]
    return Code.RTC_MODEL.refusal(
        f"{message}: {', '.join(named)}",
        hint="describe the machine by X, Y, Z and rotary axes that stand",
        values={"axes": named},
    )


@dataclass(frozen=True)
class LagRules:
    """Rules for when a lag is known. `settle` and `gap` count time constants, all else is in s.

    A pause of the sensor longer than `gap` τ, and than `least_gap_s`, begins the lag anew; through shorter ones it runs
    straight. `equilibrium_s`: when the machine was in equilibrium, on the clock of the readings; NaN: not stated.
    """

    settle: float = 5.0
    gap: float = 0.2
    least_gap_s: float = 3.0
    equilibrium_s: float = math.nan

    def gap_s(self, lag: Lag) -> float:
        """Returns the longest pause between two readings that does not begin the lag anew, s."""
        return max(self.gap * lag.constant_s, self.least_gap_s)


@dataclass(frozen=True)
class LagState:
    """A lag at `time_s`: `input`, its sensor's reading to its power, and `value`, in the same unit. `since_s`: when it
    was begun; `stated`: in equilibrium then, as an operator stated.
    """

    time_s: float
    input: float
    value: float
    since_s: float
    stated: bool

    def known(self, lag: Lag, rules: LagRules) -> bool:
        """Returns whether what was before the lag's beginning has died away."""
        return self.stated or self.known_in_s(lag, rules) <= 0

    def known_in_s(self, lag: Lag, rules: LagRules) -> float:
        """Returns the time until the lag is known, s, where readings go on."""
        return 0.0 if self.stated else self.since_s + rules.settle * lag.constant_s - self.time_s


def advanced(state: LagState | None, lag: Lag, rules: LagRules, time_s: float, reading: float) -> LagState:
    """Returns the lag one reading later, the sensor straight between; None: none. Earlier readings change nothing."""
    given = reading**lag.power
    stated = 0 <= time_s - rules.equilibrium_s <= rules.gap_s(lag)
    if state is None or (stated and state.time_s < rules.equilibrium_s):
        return LagState(time_s, given, given, time_s, stated)
    step_s = time_s - state.time_s
    if step_s <= 0:
        return state
    if step_s > rules.gap_s(lag):
        return LagState(time_s, given, given, time_s, stated=False)
    return replace(state, time_s=time_s, input=given, value=_stepped(state, lag, step_s, given))


def _stepped(state: LagState, lag: Lag, step_s: float, step: float) -> float:
    """Returns the solution of τ dy/dt + y = u after a step in which u runs straight."""
    tau = max(lag.constant_s, 1e-9)
    decay = math.exp(-step_s / tau)
    slope = (step - state.input) / step_s
    return decay * state.value + step - decay * state.input - tau * slope * (1 - decay)


def from_history(lag: Lag, rules: LagRules, history: History) -> LagState | None:
    """Returns the lag at the last row of a history; None where its sensor is not in it."""
    state = None
    for time_s, reading in zip(history.time_s.tolist(), history.signals.get(lag.of, ()), strict=False):
        state = advanced(state, lag, rules, time_s, float(reading))
    return state
