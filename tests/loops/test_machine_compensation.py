"""Model → program → LinuxCNC's interpreter → machine with exact errors: what is left of the volumetric error."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.machined_path import actual_mm, corrected, distances_mm, interpreted_points, rms, run_points
from tests.support.machines import chain_with_travel, random_model
from trueloop.machine.correct import Setup
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import mill_terms, turning_terms

MILL = Machine("mill", chain_with_travel("mill-table-x"))
LATHE = Machine("lathe", chain_with_travel("turning"))
SETUP = Setup({1: (250.0, 10.0, -260.0)}, {-1: (0.0, 0.0, -120.0)})

PART = """G21 G90 G17 G54 ( pocket, boss and slope )
#1=20
G0 X-80 Y-60 Z5
G1 Z-2 F200
X[80+#1] ( an expression )
Y60 F400
G3 X80 Y80 I-20 J0
G1 X-60
G3 X-80 Y60 R20
G1 Y-60
G0 Z5
G0 X30 Y0
G1 Z-3
G2 I-30 J0
G3 X-30 Y0 Z-10 I-30 J0 ( helix )
G1 X0 Y0 Z-15
G18 G2 X40 Z-15 I20 K5
G19 G3 Y30 Z0 J15 K7.5
G17 G1 X100 Y90 Z4.5
G0 Z20
M2
"""


@pytest.fixture
def truth() -> MachineModel:
    rng = np.random.default_rng(31)
    return random_model(MILL, mill_terms(MILL.chain, count=3), rng)


def test_98_percent_of_a_21_term_mills_error_is_gone(truth: MachineModel, tmp_path: Path) -> None:
    """Wanted is the programmed path; found is where the machine with exact errors goes. All three directions."""
    wanted, ends = interpreted_points(PART, tmp_path, "programmed", 0.5)
    sent, sent_ends = interpreted_points(corrected(PART, truth, SETUP), tmp_path, "corrected", 0.009)
    before = np.linalg.norm(actual_mm(truth, SETUP, ends) - ends, axis=1)
    after = distances_mm(ends, actual_mm(truth, SETUP, sent_ends))
    assert rms(before) > 0.02
    assert rms(after) < 0.02 * rms(before)
    # between the ends: 0.2 µm of tolerance; its points lie less than 10 µm apart, so 5 µm along it
    reached = actual_mm(truth, SETUP, sent)
    assert distances_mm(wanted, reached).max() < np.hypot(0.005, 0.0003)
    assert distances_mm(reached[::50], interpreted_points(PART, tmp_path, "programmed", 0.01)[0]).max() < np.hypot(
        0.005, 0.0003
    )


def test_structure_words_and_comments_stay(truth: MachineModel) -> None:
    after = corrected(PART, truth, SETUP)
    assert "( pocket, boss and slope )" in after and "( an expression )" in after and "( helix )" in after
    assert "#1=20" in after
    assert "[80+#1" in after
    assert after.splitlines()[-1] == "M2"


def test_a_coarser_tolerance_needs_fewer_blocks_and_is_kept(truth: MachineModel, tmp_path: Path) -> None:
    lengths = []
    for tolerance_mm in (0.005, 0.0005, 0.00005):
        after = corrected(PART, truth, SETUP, tolerance_mm)
        lengths.append(len(after.splitlines()))
        sent, _ = interpreted_points(after, tmp_path, "corrected", 0.004)
        wanted, _ = interpreted_points(PART, tmp_path, "programmed", 1.0)
        off = distances_mm(wanted, actual_mm(truth, SETUP, sent))
        assert off.max() < np.hypot(0.002, tolerance_mm + 0.00003)
    assert lengths[0] < lengths[1] < lengths[2]


@pytest.mark.parametrize("machine", [MILL, LATHE], ids=lambda machine: machine.name)
def test_the_sign_of_every_term_through_a_program(machine: Machine) -> None:
    """One term at a time: corrected by the model, the machine errs by less than a fiftieth."""
    rng = np.random.default_rng(32)
    lathe = machine is LATHE
    terms = (turning_terms if lathe else mill_terms)(machine.chain)
    zero = random_model(machine, terms, rng)
    part = (
        "G18 G21 G8\nG1 X30 Z-10 F100\nX60 Z-10\nX90 Z-80\nZ-150\n"
        if lathe
        else "G21\nG1 X-50 Y20 Z5 F100\nX90 Y-70\nX20 Y60 Z-30\n"
    )
    setup = (
        Setup({1: (60.0, 0.0, -60.0)}, {-1: (20.0, 0.0, 25.0)})
        if lathe
        else Setup(SETUP.work_zero_mm, {-1: (15.0, -10.0, -120.0)})
    )
    for term, where in zip(terms, zero.slices(), strict=True):
        size = 3e-5 if term.name.is_rotation else 0.02
        coefficients = np.zeros(len(zero.coefficients))
        coefficients[where] = term.admissible() @ np.full(term.admissible().shape[1], size)
        truth = MachineModel(machine, terms, coefficients, zero.covariance)
        _, ends = run_points(part)
        _, sent = run_points(corrected(part, truth, setup, 0.001))
        before = np.linalg.norm(actual_mm(truth, setup, ends) - ends, axis=1)
        assert before.max() > 1e-4, str(term.name)
        assert distances_mm(ends, actual_mm(truth, setup, sent)).max() < before.max() / 50 + 1e-5, str(term.name)
