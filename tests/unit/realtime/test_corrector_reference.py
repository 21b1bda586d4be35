"""The corrector in Rust does in every period what a second one does that was written from docs/realtime-states.md."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support import corrector_reference as reference
from trueloop._core import RealTimeCore
from trueloop.arrays import Array
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.image import TRAVEL_TOLERANCE_MM, Bank, Block, Body, Identity, Image, RealTimeLimits, Signal

PERIOD_S = 2.0**-10
"""A number of the machine: sums of it are exact, and times between two of them are never met."""
LIMIT_MM = 0.1
END_MM = 30.0
BACKLASH_MM = 0.004
SLOPE = np.array([[1e-4, -2e-5, 0], [0, 0, 0], [3e-5, 0, -1e-3]])
"""What a millimetre of X, Y, Z adds to E."""
WARM = np.array([[[2e-5, 0, 0], [0, 0, 0], [0, 0, 1e-4]], [[0, 0, 0], [0, 0, 0], [5e-5, 0, 0]]])
LINE, ON_PATH_X, OFF_PATH_X = 7, 10.0, 12.0
ADDED = (0.006, -0.003)
RANGES = np.array([[10.0, 40.0, 1.0], [900.0, 1100.0, 20.0]])
REFERENCES = (20.0, 1000.0)
PINS: dict[str, Any] = {
    "enable": True,
    "homed": True,
    "machine_on": True,
    "tool_offset": np.zeros(3),
    "heartbeat": 0,
    "line": LINE,
    "program": 0,
    "motion_type": 2,
    "probing": False,
    "touch": False,
}
GOOD = PINS | {"T1": 20.0, "p": 1000.0, "age": 0.0, "beats": True}
DEFAULTS = {
    "limit_mm": 0.15,
    "slew_mm_per_s": 5.0,
    "resolution_mm": 0.0,
    "parts": 3,
    "probe_corrected": 0,
    "pause_program": 1,
}
TIMES = {"stale_s": 20.5, "freeze_s": 30.5, "leave_s": 40.5, "watchdog_s": 15.5, "off_path_s": 25.5}
"""In periods."""


def image() -> Image:
    """Slopes that two signals change, an error along X by the travel of Z, and one block of a table."""
    powers = np.zeros((3, 1, 1, 6))
    powers[:, 0, 0, 0] = (0, BACKLASH_MM, -BACKLASH_MM)
    body = Body(2, np.array([-END_MM, END_MM]), powers, (), np.zeros(3), np.zeros(3))
    signals = tuple(
        Signal(name, "", at, *row) for name, at, row in zip(("T1", "p"), REFERENCES, RANGES.tolist(), strict=True)
    )
    bank = Bank(signals, (body,), np.concatenate([SLOPE[None], WARM]))
    rows = np.array([[ON_PATH_X, 40.0, *ADDED], [ON_PATH_X, -40.0, *ADDED]])
    limits = RealTimeLimits(((-END_MM, END_MM),) * 3, LIMIT_MM, 0.1)
    identity = Identity("lathe", "1", model_sha256="ab" * 32, program="p.ngc", program_sha256="cd" * 32)
    return Image(identity, limits, bank, (Block(LINE, rows),))


def wanted(q: Array, travel: Array, signals: Array, line: int | None) -> tuple[Array, Array, bool, bool]:
    """What the image asks for, from its numbers."""
    slope = SLOPE + np.tensordot(signals - REFERENCES, WARM, axes=1)
    on_path = line == LINE and abs(q[0] - ON_PATH_X) < 0.1
    table = np.array([ADDED[0], 0, ADDED[1]]) if on_path else np.zeros(3)
    model = np.zeros(3)
    for _ in range(2):
        model = -((q + table + model) @ slope + np.array([BACKLASH_MM * travel[2], 0, 0]))
    return model, table, line == LINE, on_path


CHANGES: dict[str, st.SearchStrategy[Any]] = {
    "enable": st.booleans(),
    "homed": st.booleans(),
    "machine_on": st.booleans(),
    "probing": st.booleans(),
    "motion_type": st.sampled_from([2, 5]),
    "program": st.sampled_from([0, 1, 1, 2]),
    "touch": st.booleans(),
    "T1": st.sampled_from([20.0, 20.5, 21.25, 24.0, 9.0, 41.0, np.nan, np.inf]),
    "p": st.sampled_from([1000.0, 1015.0, 1040.0, 0.0]),
    "age": st.sampled_from([0.0, 3 * PERIOD_S, 19 * PERIOD_S, 1.0, -1.0, np.nan]),
    "beats": st.booleans(),
    "z_mm_per_s": st.sampled_from([0.0, 2.0, 50.0, -50.0, 200.0, -1000.0]),
    "x": st.sampled_from([ON_PATH_X, OFF_PATH_X, np.nan]),
}
"""What may change in a sequence: pins, or what stands behind them."""


@dataclass(frozen=True)
class Script:
    """Where Z and the pins begin, and what changes after how many periods."""

    z_mm: float
    begins: tuple[tuple[str, Any], ...]
    changes: tuple[tuple[int, str, Any], ...]


@st.composite
def scripts(draw: st.DrawFn) -> Script:
    """Everything in order for a while, then changes one after the other."""
    z = draw(st.sampled_from([0.0, -28.0, 28.0, 29.96]))
    begins = {"z_mm_per_s": draw(CHANGES["z_mm_per_s"]), "program": draw(st.sampled_from([0, 1]))}
    begins["x"] = draw(st.sampled_from([ON_PATH_X, OFF_PATH_X]))
    names = draw(st.lists(st.sampled_from(sorted(CHANGES)), min_size=1, max_size=12))
    periods = st.sampled_from([1, 2, 5, 20, 100])
    return Script(z, tuple(begins.items()), tuple((draw(periods), name, draw(CHANGES[name])) for name in names))


def played(script: Script) -> list[dict[str, Any]]:
    """Period by period; Z follows its speed with 4 m/s²."""
    state = GOOD | dict(script.begins)
    z, speed, periods = script.z_mm, 0.0, []
    for count, name, value in (*script.changes, (20, "enable", True)):
        for _ in range(count):
            speed += float(np.clip(state["z_mm_per_s"] - speed, -4.0, 4.0))
            z = float(np.clip(z + speed * PERIOD_S, -END_MM - 0.5, END_MM + 0.5))
            state["heartbeat"] += state["beats"]
            kept = {name: state[name] for name in PINS}
            place = {"position": np.array([state["x"], 1.0, z]), "period_s": PERIOD_S}
            signals = {"signal": np.array([state["T1"], state["p"]]), "age_s": np.array([state["age"], 0.0])}
            periods.append({**kept, **place, **signals})
        state[name] = value
    return periods


SETTINGS: dict[str, st.SearchStrategy[Any]] = {
    "limit_mm": st.sampled_from([0.2, 0.02]),
    "slew_mm_per_s": st.sampled_from([1.0, 50.0]),
    "resolution_mm": st.sampled_from([0.002, 0.005]),
    "parts": st.integers(0, 3),
    "probe_corrected": st.booleans(),
    "pause_program": st.booleans(),
    "freeze_s": st.sampled_from([0.0, 3.5 * PERIOD_S]),
    "leave_s": st.sampled_from([0.0, 2.5 * PERIOD_S]),
}
SENSELESS: dict[str, Any] = {"limit_mm": -1.0, "slew_mm_per_s": 0.0, "parts": 4, "stale_s": np.nan, "leave_s": np.inf}


@st.composite
def settings_of_scripts(draw: st.DrawFn) -> dict[str, float]:
    """Mostly sensible ones."""
    chosen = DEFAULTS | {name: count * PERIOD_S for name, count in TIMES.items()}
    for name in draw(st.lists(st.sampled_from(sorted(SETTINGS)), max_size=3)):
        chosen[name] = draw(SETTINGS[name])
    if draw(st.integers(0, 19)) == 19:
        name = draw(st.sampled_from(sorted(SENSELESS)))
        chosen[name] = SENSELESS[name]
    return chosen


@settings(max_examples=150, deadline=None)
@given(scripts(), settings_of_scripts())
def test_every_pin_in_every_period(script: Script, chosen: dict[str, float]) -> None:
    periods = played(script)
    core = RealTimeCore(image_to_bytes(image()))
    columns = {name: np.array([period[name] for period in periods], dtype=float) for name in periods[0]}
    shown = core.step(columns, {name: float(value) for name, value in chosen.items()})
    ranges = reference.Ranges(RANGES, LIMIT_MM, np.array([[-END_MM, END_MM]] * 3), has_table=True)
    memory = reference.Memory()
    expected = [reference.step(memory, period, chosen, ranges, wanted) for period in periods]
    for name in expected[0]:
        column = [period[name] for period in expected]
        np.testing.assert_allclose(shown[name], np.array(column, dtype=float), rtol=0, atol=1e-12, err_msg=name)


def test_a_command_may_be_outside_the_travel_by_the_tolerance_that_limits_are_compared_with() -> None:
    for share, phase, fault in ((0.9, 3, 0), (1.1, 6, 3)):
        for sign in (1.0, -1.0):
            core = RealTimeCore(image_to_bytes(replace(image(), bank=None)))
            place = {"position": np.array([[0.0, sign * (END_MM + share * TRAVEL_TOLERANCE_MM), 0.0]] * 3)}
            pins = {name: np.ones(3) for name in ("enable", "homed", "machine_on", "program")}
            shown = core.step({**place, **pins, "heartbeat": np.arange(3.0), "period_s": np.full(3, PERIOD_S)}, {})
            assert (shown["phase"][-1], shown["fault"][-1]) == (phase, fault)
