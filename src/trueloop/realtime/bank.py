"""A machine model as a bank: the compiled model at reference signals, and what one unit of each signal adds to it.

E is linear in every signal (`machine/model/term.py`), so the difference of two compiled models is exact, and a servo
period needs no more than sums of products. Rotary axes stand at 0.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import AxisKind, Vector
from trueloop.machine.model.compiled import LINEAR, CompiledModel, compile_model
from trueloop.machine.model.compiled import Body as CompiledBody
from trueloop.machine.model.model import MachineModel
from trueloop.realtime.image import SIGNALS, Bank, Body, Signal

BODIES = 8
"""The largest number of carriers of errors: an axis, a place of a rotary axis, a spindle."""
MOST_STEPS = {"°C": 2.0}
"""The largest difference of two consecutive readings, by unit. Other signals may pass through their whole range."""


@dataclass(frozen=True)
class Stated:
    """The user's limits of signals, by name: the range in which the model holds, the largest step between readings."""

    ranges: Mapping[str, tuple[float, float]]
    steps: Mapping[str, float]


NOTHING = Stated({}, {})


def signals_of(model: MachineModel, stated: Stated = NOTHING) -> tuple[Signal, ...]:
    """Returns the signals that the model needs, lags among them, in the order of the bank.

    A range that is not stated is that of the data. Raises RTC-SIGNAL for a range that neither gives, for an empty one,
    for a stated signal that the model does not need, and for more signals than an image holds.
    """
    needs = model.needs()
    _check_stated(needs, stated)
    ranges = {**model.identified, **stated.ranges}
    unknown = [name for name in needs if not _inside(ranges.get(name))]
    if unknown:
        raise TrueloopError(
            Code.RTC_SIGNAL,
            f"no range is known of {len(unknown)} of the model's {len(needs)} signals: {', '.join(unknown)}",
            hint="give the lowest and the highest value at which the model holds",
            override=" ".join(f"--range {name}=LOW,HIGH" for name in unknown),
            values={"signals": unknown},
        )
    if len(needs) > SIGNALS:
        raise TrueloopError(
            Code.RTC_SIGNAL,
            f"the model needs {len(needs)} signals, an image holds {SIGNALS}: {', '.join(needs)}",
            hint="fit the model with fewer temperatures: `choose` in the machine's file takes those that matter",
            values={"signals": list(needs)},
        )
    return tuple(_signal(model, name, ranges[name], stated.steps.get(name)) for name in needs)


def _check_stated(needs: tuple[str, ...], stated: Stated) -> None:
    """Only signals that are needed, steps that are some."""
    other = sorted({*stated.ranges, *stated.steps} - set(needs))
    if other:
        raise TrueloopError(
            Code.RTC_SIGNAL,
            f"a range or a step is stated for {', '.join(other)}; the model needs {len(needs)} signals: "
            f"{', '.join(needs) or 'none'}",
            hint="write the names as the readings and the lags of the model have them",
            values={"signals": other},
        )
    bad = {name: step for name, step in stated.steps.items() if not 0 < step < math.inf}
    if bad:
        raise TrueloopError(
            Code.RTC_SIGNAL,
            f"steps between readings are above 0, not {', '.join(f'{name} {step:g}' for name, step in bad.items())}",
            hint="a sensor of temperature that works stays below 2 °C",
            values={"signals": list(bad)},
        )


def _inside(known: tuple[float, float] | None) -> bool:
    return known is not None and -math.inf < known[0] < known[1] < math.inf


def _signal(model: MachineModel, name: str, known: tuple[float, float], step: float | None) -> Signal:
    parts = [part for term in model.terms for part in term.parts if part.signal == name]
    unit = model.units.get(name, "")
    most = MOST_STEPS.get(unit, known[1] - known[0]) if step is None else step
    return Signal(name, unit, parts[0].reference, *known, most)


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
    """What a signal does not touch is the same to the last bit with it and without: those tables are left out."""
    per_unit = tuple((place, table) for place, table in enumerate(added) if table.any())
    return Body(body.axis, body.breaks, body.powers, per_unit, body.arm_mm, body.carries)


def _check_axes(model: MachineModel, standing: Collection[str]) -> None:
    chain = model.machine.chain
    for name in standing:
        chain.axis(name)
    moving = [a.name for a in chain.axes if a.kind is AxisKind.ROTARY and a.name not in standing]
    other = [a.name for a in chain.axes if a.kind is AxisKind.LINEAR and a.name not in LINEAR]
    if other:
        raise _too_much(model, f"{len(other)} axes are none of X, Y, Z", other)
    if moving:
        raise TrueloopError(
            Code.RTC_MODEL,
            f"the {len(moving)} rotary axes {', '.join(moving)} may turn, and the component in the servo thread "
            "would not know",
            hint="where they stand at 0 as long as the image is in use, say so",
            override=" ".join(f"--standing {name}" for name in moving),
            values={"axes": moving},
        )


def _too_much(model: MachineModel, message: str, axes: list[str] | None = None) -> TrueloopError:
    named = axes or [axis.name for axis in model.machine.chain.axes]
    return TrueloopError(
        Code.RTC_MODEL,
        f"{message}: {', '.join(named)}",
        hint="describe the machine by X, Y, Z and rotary axes that stand",
        values={"axes": named},
    )
