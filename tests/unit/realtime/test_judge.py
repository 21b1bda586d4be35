"""The judge of a run: runs made here by formulas, with what is wrong with them known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support import erring_lathe
from trueloop.arrays import Array
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import CONSTANT, Part, Term
from trueloop.realtime.image import Block
from trueloop.realtime.judge import DrivenRun, due, judge, travel_ways

PERIOD_S, SLEW = 1e-3, 5.0
LOST_MM = 0.012


def along_z_and_back(speed_mm_per_s: float = 50.0) -> Array:
    """Commands (n, 3): 40 mm along Z on an incline of X, and back on the same way."""
    z = np.arange(-150.0, -190.0, -speed_mm_per_s * PERIOD_S)
    there = np.column_stack([60.0 + 0.1 * (z + 150.0), 0 * z, z])
    return np.concatenate([there, there[::-1]])


def formula_mm(at_mm: Array, warm_degc: Array) -> Array:
    found = np.zeros_like(at_mm)
    for k in range(len(at_mm)):
        found[k, [0, 2]] = erring_lathe.error_mm(at_mm[k : k + 1, 0], at_mm[k : k + 1, 2], float(warm_degc[k]))[0]
    return found


def corrected_run(off_mm: Array | float = 0.0) -> DrivenRun:
    """Drives that stand, by the formula, where the tool is at the command: found by many steps."""
    command = along_z_and_back()
    warm = np.linspace(21.0, 28.0, len(command))
    drive = command.copy()
    for _ in range(8):
        drive = command - formula_mm(drive, warm)
    everywhere = np.ones(len(command), dtype=bool)
    line = np.zeros(len(command), dtype=np.intp)
    return DrivenRun(PERIOD_S, command, drive + off_mm, {"T1": warm}, line, everywhere)


def test_a_run_that_is_right_leaves_nothing() -> None:
    found = judge(corrected_run(), erring_lathe.model(), slew_mm_per_s=SLEW)
    assert found.rms_nm < 0.05 and found.worst_nm < 0.2
    assert found.judged.all() and found.reversals == 2
    assert found.uncorrected_um > 5.0 and found.within(2.0)


@pytest.mark.parametrize("axis", [0, 2])
def test_a_run_that_is_off_is_said_to_be_off_by_as_much(axis: int) -> None:
    off = np.zeros(3)
    off[axis] = 10e-6
    found = judge(corrected_run(off), erring_lathe.model())
    assert found.rms_nm == pytest.approx(10.0, rel=1e-3)
    assert not found.within(2.0) and found.within(11.0)
    assert found.residual_mm[:, axis].mean() == pytest.approx(10e-6, rel=1e-3)


def test_a_run_without_the_corrector_leaves_the_machines_error() -> None:
    run = corrected_run()
    bare = replace(run, drive_mm=run.command_mm)
    found = judge(bare, erring_lathe.model())
    error = formula_mm(run.command_mm, np.asarray(run.signals["T1"]))
    assert found.rms_nm == pytest.approx(1e6 * math.sqrt(np.mean(np.sum(error**2, axis=1))), rel=1e-6)


def test_a_wrong_signal_is_seen() -> None:
    run = corrected_run()
    late = replace(run, signals={"T1": np.asarray(run.signals["T1"]) - 0.1})
    assert judge(late, erring_lathe.model()).rms_nm == pytest.approx(1e6 * math.hypot(0.00015, 0.0001), rel=1e-3)


def with_lost_motion() -> MachineModel:
    """An error of Z alone: minus or plus half of the lost motion, by the way of travel."""
    model = erring_lathe.model()
    term = Term(error_name("EZZ"), (Part(CONSTANT),), both_ways=True)
    return replace(model, terms=(term,), coefficients=0.5 * LOST_MM * np.array([-1.0, 1.0]), covariance=np.eye(2))


def reversing_run(step_mm: float) -> DrivenRun:
    """The correction of the lost motion, going to its new value by so much a period."""
    command = along_z_and_back()
    turn, drive = len(command) // 2, command.copy()
    at = -0.5 * LOST_MM
    for k in range(len(command)):
        due = 0.5 * LOST_MM * (1.0 if k > turn else -1.0)
        at += min(max(due - at, -step_mm), step_mm)
        drive[k, 2] += at
    everywhere = np.ones(len(command), dtype=bool)
    everywhere[0] = False  # the way is not known before the first move
    return DrivenRun(PERIOD_S, command, drive, {"T1": np.zeros(1)}, np.zeros(len(command), dtype=np.intp), everywhere)


def test_a_reversal_takes_as_long_as_the_slew_needs() -> None:
    found = judge(reversing_run(SLEW * PERIOD_S), with_lost_motion(), slew_mm_per_s=SLEW)
    assert found.rms_nm < 1e-3 and found.behind_nm < 1e-3
    assert found.longest_limited_s == pytest.approx(2 * PERIOD_S)  # 12 µm at 5 µm a period: two on the way, then there
    assert found.within(0.1)


def test_a_step_beyond_the_slew_is_no_good_run() -> None:
    found = judge(reversing_run(2 * SLEW * PERIOD_S), with_lost_motion(), slew_mm_per_s=SLEW)
    assert not found.within(100.0) and found.step_um == pytest.approx(10.0)
    assert found.behind_nm > 1000.0


def test_a_reversal_taken_up_late_is_left_over() -> None:
    found = judge(reversing_run(0.2 * SLEW * PERIOD_S), with_lost_motion(), slew_mm_per_s=SLEW)
    assert found.worst_nm > 1000.0


def test_the_table_is_that_of_the_line() -> None:
    """One arc cut twice, with opposite tables; a third cut without any."""
    angle = np.linspace(0.0, 1.5, 400)
    arc = np.column_stack([20 * np.sin(angle), 0 * angle, 20 * np.cos(angle)])
    added = np.column_stack([3e-3 * angle, 0 * angle, -5e-3 * np.sin(angle)])
    command = np.concatenate([arc, arc, arc])
    line = np.repeat([7, 9, 11], len(angle)).astype(np.intp)
    drive = command + np.concatenate([added, -added, 0 * added])
    rows = np.column_stack([arc[:, [0, 2]], added[:, [0, 2]]])
    blocks = (Block(7, rows), Block(9, rows * [1, 1, -1, -1]))
    run = DrivenRun(PERIOD_S, command, drive, {}, line, np.ones(len(command), dtype=bool))
    right = judge(run, None, blocks, slew_mm_per_s=20.0)
    assert right.worst_nm < 1e-6
    wrong = judge(run, None, (Block(7, rows), Block(9, rows)), slew_mm_per_s=20.0)
    assert wrong.worst_nm > 5000.0


def test_ways_of_travel_are_those_of_the_last_move() -> None:
    x = np.array([0.0, 0.0, 1.0, 1.0, 0.5, 0.5, 0.7])
    assert travel_ways(np.column_stack([x, 0 * x, -x]))[:, 0].tolist() == [0, 0, 1, 1, -1, -1, 1]
    assert travel_ways(np.column_stack([x, 0 * x, -x]))[:, 1:].tolist() == [[0, w] for w in (0, 0, -1, -1, 1, 1, -1)]


def test_model_and_table_together_are_asked_where_both_send_the_machine() -> None:
    run = corrected_run()
    rows = np.array([[60.0, -150.0, 0.0, 0.02], [56.0, -190.0, 0.0, 0.02]])
    asked = due(replace(run, line=run.line + 7), erring_lathe.model(), (Block(7, rows),), 0.1, SLEW)
    added, warm = np.array([0.0, 0.0, 0.02]), np.asarray(run.signals["T1"])
    expected = np.zeros_like(run.command_mm)
    for _ in range(8):
        expected = -formula_mm(run.command_mm + expected, warm) + added
    assert np.abs(asked.correction_mm - expected)[5:-5].max() < 1e-9
    at_command = -formula_mm(run.command_mm, warm) + added
    assert np.abs(at_command - expected).max() > 1e-7


def test_a_table_holds_within_its_gate() -> None:
    run = corrected_run()
    rows = np.array([[60.0, -150.0, 0.01, 0.02], [56.0, -190.0, 0.01, 0.02]])
    beside = replace(run, line=run.line + 7, command_mm=run.command_mm + np.array([0.15, 0.0, 0.0]))
    assert not due(beside, None, (Block(7, rows),), 0.1, SLEW).table_mm.any()
    assert due(beside, None, (Block(7, rows),), 0.2, SLEW).table_mm.any()
