"""A simulated series of parts, corrected as memory proposes, uncorrected, and by simpler rules."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.part import PartType
from trueloop.loops.post_process.series import MadePart, Series
from trueloop.loops.post_process.tracked import RULES, Replay, replayed
from trueloop.memory.level.kalman import TURNING, LevelPrior, PartReading, Step, steps_as_they_come
from trueloop.report.series.values import SeriesShape, replay_shape
from trueloop.units import UM_PER_MM
from trueloop_lab.simulator.series import Event, Shop, What, draw
from trueloop_lab.simulator.series import Series as Drawn


def simulated(
    *,
    parts: int = 30,
    seed: int = 0,
    gain: float = 1.0,
    tool_changed_at: int | None = None,
    jump_at: int | None = None,
    jump_um: float = 20.0,
) -> SeriesShape:
    """Simulates a series, corrected as memory proposes. Parts count from 1; `jump_um` is an unknown offset on X (a
    radius) from the part `jump_at` on.
    """
    events = [] if jump_at is None else [Event(What.OFFSET, jump_at - 1, jump_um / UM_PER_MM)]
    shop = Shop(parts=parts, gain=gain, changed_at=None if tool_changed_at is None else tool_changed_at - 1)
    drawn = simulate(shop, np.random.default_rng(seed), events)
    return replay_shape(drawn.series.part_type.name, [drawn], parts, (), simulated=True)


CYLINDER: Final = np.array([np.pi / 2])
NAME: Final = "simulated radius"
NOMINAL_MM: Final = 12.0


def simulate(shop: Shop, rng: np.random.Generator, events: Sequence[Event] = (), prior: LevelPrior = TURNING) -> Replay:
    """Simulates a series cut with memory's proposals, uncorrected, and with each of the rules of `RULES`."""
    drawn = draw(replace(shop, angle_rad=CYLINDER), rng, events)
    made: list[MadePart] = []
    steps: list[Step] = []

    def readings() -> Iterator[PartReading]:
        for k in range(shop.parts):
            c_mm = steps[-1].correction_mm if steps else 0.0
            made.append(_made(drawn, k, c_mm))
            yield made[-1].reading

    for step in steps_as_they_come(readings(), prior):
        steps.append(step)  # one by one: the next reading asks for it
    parts = tuple(
        replace(replayed(one, one.correction_mm, step, k), measured_mm=_found_mm(drawn, k, 0.0))
        for k, (one, step) in enumerate(zip(made, steps, strict=True))
    )
    asked = Characteristic(NAME, Quantity.RADIUS, "cylinder", NOMINAL_MM)
    series = Series(PartType("simulated"), asked, tuple(made))
    return Replay(series, parts, {name: _by_rule(drawn, shop.parts, rule) for name, rule in RULES.items()})


def _found_mm(drawn: Drawn, part: int, correction_mm: float) -> float:
    return float(drawn.inspected_mm(part, correction_mm)[0])


def _made(drawn: Drawn, part: int, correction_mm: float) -> MadePart:
    new_edge = part > 0 and drawn.edge[part] != drawn.edge[part - 1]
    serial, error_mm = str(part + 1), _found_mm(drawn, part, correction_mm)
    return MadePart(serial, error_mm, correction_mm, bool(new_edge), True, (serial,))


def _by_rule(drawn: Drawn, parts: int, rule: Callable[[Array], float]) -> tuple[float, ...]:
    """Returns the errors left by a rule that takes corrections as arrived: its own add to the measured error."""
    believed: list[float] = []
    left: list[float] = []
    for k in range(parts):
        c_mm = rule(np.array(believed)) if believed else 0.0
        left.append(_found_mm(drawn, k, c_mm))
        believed.append(left[-1] + c_mm)
    return tuple(left)
