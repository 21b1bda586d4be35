"""What the finish cut does otherwise: along the normal, by contact angle, in the finish cut alone."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.probing import example
from trueloop.geometry.feature import Line, contact_angle_rad
from trueloop_lab.files.virtual_machine_toml import read_virtual_machine
from trueloop_lab.loops.turned import simulate, trial_of
from trueloop_lab.simulator.machine import Repeatability, Stock, VirtualMachine
from trueloop_lab.simulator.nose import SAME, Nose, Transfer, path_along
from trueloop_lab.simulator.presets import NIST_TRANSFER, nist

UM = 1e-3
RADIUS_MM = 0.8
TRANSFER = Transfer((0.0, math.pi / 2), (-5 * UM, -1 * UM))


@pytest.mark.parametrize(("angle_deg", "expected_um"), [(0.0, -5.0), (45.0, -3.0), (90.0, -1.0), (120.0, -1.0)])
def test_a_surface_comes_out_off_by_the_value_at_its_contact_angle(angle_deg: float, expected_um: float) -> None:
    angle = math.radians(angle_deg)
    normal, along = np.array([math.sin(angle), math.cos(angle)]), np.array([-math.cos(angle), math.sin(angle)])
    start, end = (np.array([40.0, 0.0]) + RADIUS_MM * normal + reach * along for reach in (10.0, -10.0))
    line = Line("path", (float(start[0]), float(start[1])), (float(end[0]), float(end[1])))
    if line.outward_normal(0.0) @ normal < 0.0:
        line = line.reversed()
    machine, rng = VirtualMachine(Nose(RADIUS_MM), transfer=TRANSFER), np.random.default_rng(0)
    at = np.array([[40.0, 0.0]])
    finished = machine.cut(Stock(), [path_along([line])], rng, transfer=machine.transfer)
    assert finished.height_mm(at, normal[None, :])[0] / UM == pytest.approx(expected_um, abs=1e-6)
    before = machine.cut(Stock(), [path_along([line])], rng)
    assert before.height_mm(at, normal[None, :])[0] / UM == pytest.approx(0.0, abs=1e-6)


def test_the_loop_cannot_see_it_and_the_finished_part_has_it() -> None:
    """NIST's machine with a process and a probe that repeat: touches alike, the part off by the transfer."""
    trial = trial_of(example("modbas2"))
    quiet = [nist(Repeatability(), transfer) for transfer in (SAME, NIST_TRANSFER)]
    same, other = (simulate(trial, replace(w, probe=replace(w.probe, range_x_mm=0.0, range_z_mm=0.0))) for w in quiet)
    np.testing.assert_array_equal(same.touches.error_mm, other.touches.error_mm)
    angle = contact_angle_rad(trial.inputs.touches.outward_normal)
    expected = np.interp(angle, NIST_TRANSFER.angle_rad, NIST_TRANSFER.error_mm)
    np.testing.assert_allclose(other.finish_truth_mm - same.finish_truth_mm, expected, atol=0.15 * UM)
    assert np.mean(other.finish_truth_mm) < -1.5 * UM


def test_bands_that_take_two_cuts_for_alike_do_not_hold_it_and_the_default_ones_do() -> None:
    trial = trial_of(example("modbas2"))
    parts = [simulate(trial, nist(), seed) for seed in range(5)]
    truth = np.concatenate([np.abs(part.finish_truth_mm) for part in parts])
    budgets = [part.correction.prediction.budget for part in parts]
    assert np.mean(truth <= np.concatenate([budget.expanded_u_mm for budget in budgets])) > 0.95
    assert np.mean(truth <= np.concatenate([budget.alike.expanded_u_mm for budget in budgets])) < 0.75


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("", NIST_TRANSFER),
        ("[transfer]\n", SAME),
        ("[transfer]\ncontact_angle_deg = [0, 90]\nerror_um = [-5, -1]\n", TRANSFER),
    ],
)
def test_the_machine_file_says_it_or_switches_it_off(tmp_path: Path, table: str, expected: Transfer) -> None:
    file = tmp_path / "machine.toml"
    file.write_text(f'preset = "nist"\n{table}')
    assert read_virtual_machine(file).machine.transfer == expected
