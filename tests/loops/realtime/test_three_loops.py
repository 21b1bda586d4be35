"""Three loops together in LinuxCNC [6876 §1.2, §3.3; 4773 §2.3]: the machine's model in force at every cut, the touches
with the corrector off and on, and what the touches say of the process as a table by program line beside the model.

The part is judged against the loop of a simulator whose machine does not err; `tests/support/three_loops.py` drives.
"""

import numpy as np

from tests.support.three_loops import actual_mm, error_vectors_of, finished, given, probed, semifinished
from trueloop.arrays import Array
from trueloop_lab.loops.turned import simulate
from trueloop_lab.simulator.mill import VirtualCmm

UM = 1e-3


def rms_um(values_mm: Array) -> float:
    return float(np.sqrt(np.mean(values_mm**2)) / UM)


def test_touches_with_the_corrector_off_and_on_say_the_same() -> None:
    """Off: COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG; on, the control's coordinates are actual already."""
    found = probed()
    off, on = error_vectors_of(actual_mm(found.off_mm)).error_mm, error_vectors_of(found.on_mm).error_mm
    bare = error_vectors_of(found.off_mm).error_mm
    print(f"off less on {rms_um(off - on):.2f} um RMS, {np.abs(off - on).max() / UM:.2f} at most")
    print(f"without COMP_MTG {rms_um(bare - on):.2f} um RMS")
    assert len(off) == len(on) == 32
    assert np.abs(off - on).max() < 2.0 * UM  # each is latched within a servo period of a micrometre
    assert rms_um(bare - on) > 10.0


def test_touches_show_the_process_alone() -> None:
    """What is touched is the worn nose's doing, for the machine was corrected while it cut and is while it probes."""
    at, allowance_mm = given()[1].inputs.touches, given()[1].inputs.allowance_mm
    shifted = at.nominal_mm + allowance_mm * at.outward_normal
    truth = semifinished()[0].height_mm(shifted, at.outward_normal)
    seen = error_vectors_of(probed().on_mm).error_mm
    workshop, trial = given()
    alone = simulate(trial, workshop).semifinish_truth_mm
    print(f"semi-finish errors {rms_um(truth):.2f} um RMS; touches less truth {rms_um(seen - truth):.2f} um RMS")
    assert rms_um(truth) > 40.0 and np.abs(seen - truth).max() < 1.5 * UM
    assert np.abs(truth - alone).max() < 0.1 * UM


def test_the_finished_part_is_that_of_a_machine_without_errors() -> None:
    stock, driven, rows = finished()
    workshop, trial = given()
    alone = simulate(trial, workshop)
    cmm = VirtualCmm(frame_mm=0.0003, tilt_rad=2e-6, mpe_mm=0.0009, mpe_per_mm=0.9e-3 / 350)
    at = trial.inputs.touches
    truth = stock.height_mm(at.nominal_mm, at.outward_normal)
    measured = cmm.measure(stock, at.nominal_mm, at.outward_normal, np.random.default_rng(1))
    print(f"{rows} rows; finished part {rms_um(truth):.2f} um RMS, {np.abs(truth).max() / UM:.2f} at the worst place")
    print(f"measured {rms_um(measured):.2f} um RMS; machine without errors: {rms_um(alone.finish_truth_mm):.2f} um RMS")
    assert not driven.messages and not driven["rtec.fault-code"].any()
    assert rms_um(truth) < rms_um(alone.finish_truth_mm) + 1.0 and np.abs(truth).max() < 2.5 * UM
