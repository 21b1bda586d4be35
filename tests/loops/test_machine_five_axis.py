"""Five-axis machines with their tables turned: the sign of every error through a program, one at a time."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.exact_kinematics import exact_error_of
from tests.support.machined_path import corrected, run_points
from tests.support.machines import set_back_chain
from trueloop.arrays import Array
from trueloop.machine.correct import Setup
from trueloop.machine.model.chain import AxisKind
from trueloop.machine.model.kinematics import bed_to_work
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import CONSTANT, PRESETS, Part, Term, segments

PART = "G21\nG1 X-50 Y20 Z5 F100\nX90 Y-70\nX20 Y60 Z-30\n"
TOOL = (15.0, -10.0, -120.0)


def _model(structure: str) -> MachineModel:
    """Every error the structure can have, 20 µm or 30 µrad, motions of linear axes growing along the travel."""
    chain = set_back_chain(structure)
    terms, coefficients = [], []
    for name in chain.errors():
        grows = chain.axis(name.axis).kind is AxisKind.LINEAR and not name.place
        terms.append(Term(name, (Part(segments(*chain.axis(name.axis).travel, 1, 1) if grows else CONSTANT),)))
        size = 3e-5 if name.is_rotation else 0.02
        coefficients += [0.5 * size, size] if grows else [size]
    return MachineModel(Machine(structure, chain), tuple(terms), np.array(coefficients), np.zeros((1, 1)))


def _off_mm(truth: MachineModel, setup: Setup, commanded: Array) -> Array:
    """E by the exact transforms, along the program's X, Y, Z, where they were commanded."""
    chain = truth.machine.chain
    axes = commanded + np.array(setup.work_zero_mm[1]) - np.array(TOOL)
    given: dict[str, Array | float] = {**setup.fixed, **{name: axes[:, k] for k, name in enumerate("XYZ")}}
    error = exact_error_of(truth, State(chain.positions(given), 0.0, {}, TOOL))
    along: Array = error @ bed_to_work(chain, setup.fixed).T
    return along


@pytest.mark.parametrize("structure", [name for name in PRESETS if name.startswith("five-axis")])
def test_the_sign_of_every_error(structure: str) -> None:
    whole = _model(structure)
    chain = whole.machine.chain
    turned = {axis.name: 0.7 * (axis in chain.work) for axis in chain.axes if axis.kind is AxisKind.ROTARY}
    setup = Setup({1: (60.0, 10.0, -40.0)}, {-1: TOOL}, fixed=turned)
    _, ends = run_points(PART)
    for term, where in zip(whole.terms, whole.slices(), strict=True):
        truth = replace(whole, terms=(term,), coefficients=whole.coefficients[where])
        before = np.abs(_off_mm(truth, setup, ends)).max()
        _, sent = run_points(corrected(PART, truth, setup, 1.0))
        after = np.abs(sent + _off_mm(truth, setup, sent) - ends).max()
        assert after < before / 50 + 1e-5, str(term.name)
        assert before > 1e-4 or term.name.component == "C", str(term.name)
