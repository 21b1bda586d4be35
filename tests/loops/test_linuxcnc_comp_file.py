"""The table that `trueloop machine export` writes, in force in LinuxCNC: where its motor goes, with which sign."""

import numpy as np
import pytest

from tests.support.machines import chain_with_travel, random_model
from trueloop.arrays import Array
from trueloop.formats.tables.control_tables import linuxcnc_comp
from trueloop.machine.correct import axis_table
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import Part, Term, segments
from trueloop_lab.linuxcnc.session import _run, _session, _uninterrupted

MOTOR_AND_COMMAND = """loadrt sampler depth=60000 cfg=ff
addf sampler.0 servo-thread
net x-position => sampler.0.pin.0
net x-command joint.0.pos-cmd => sampler.0.pin.1
setp sampler.0.enable 0
"""
TARGETS = (20.0, 111.7, 203.4, 333.3, 471.0, 402.6, 287.7, 154.3, 36.0)
"""Up, then down again."""
HOME_MM = 300.0


@pytest.fixture
def truth() -> MachineModel:
    """EXX in four segments, other on the way back: some 15 µm."""
    machine = Machine("lathe", chain_with_travel("turning"))
    term = Term(error_name("EXX"), (Part(segments(0.0, 500.0, 4, 3)),), both_ways=True)
    return random_model(machine, (term,), np.random.default_rng(81))


def _motor_at_targets(table: str) -> Array:
    """Where the motor of X stands after each dwell, (targets,)."""
    blocks = "".join(f"G1 X{x} F11000\nG4 P0.3\n" for x in TARGETS)
    program = f"G21 G18 G8 G90 G94\nG0 X5 Z50\n{blocks}M2\n".encode()

    def run() -> Array:
        with _session(program, 1.0, MOTOR_AND_COMMAND, sample=True) as folder:
            config = folder / "config"
            (config / "x.comp").write_text(table)
            with_table = "[JOINT_0]\nCOMP_FILE = x.comp\nCOMP_FILE_TYPE = 0\n"
            (config / "machine.ini").write_text((config / "machine.ini").read_text().replace("[JOINT_0]\n", with_table))
            _run(folder, None)
            return np.loadtxt(config / "positions.txt", ndmin=2)

    rows = _uninterrupted(run)
    # by content, not by count: a busy computer may lose periods, but it stands at each target when it dwells there
    stands = [np.flatnonzero(np.abs(rows[:, 1] - target) < 1e-9) for target in TARGETS]
    assert all(len(periods) > 0 for periods in stands), [len(periods) for periods in stands]
    # the middle one: single periods pass a target on the way to another.
    # Homing where it stands calls that 300 mm, HOME of the configuration.
    return np.array([rows[periods[len(periods) // 2], 0] for periods in stands]) + HOME_MM


def _error_mm(truth: MachineModel, motor: Array) -> Array:
    """What the machine does with a motor there, having come up or down, (n,)."""
    way = np.where(np.arange(len(TARGETS)) < 5, 1.0, -1.0)
    positions = truth.machine.chain.positions({"X": motor})
    return truth.error_mm(State(positions, np.column_stack([way, 0 * way])))[:, 0]


def test_the_corrected_axis_errs_by_what_the_table_says_it_leaves(truth: MachineModel) -> None:
    """With the opposite sign it would err by twice what it errs by without a table, with none by as much."""
    table = axis_table(truth, "X", "X", 201, {})
    corrected = _motor_at_targets(linuxcnc_comp(table))
    before = _error_mm(truth, np.array(TARGETS))
    after = corrected + _error_mm(truth, corrected) - TARGETS
    assert np.abs(before).max() > 8e-3
    # beside the chords of the table: its digits, and the slope of the error over the correction
    assert np.abs(after).max() < table.deviation_mm + 2e-5 < 0.01 * np.abs(before).max()
