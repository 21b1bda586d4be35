"""The same part, touches and programs in another control's words: the correction is the same."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.standoff import feed_moves_of, standoff_mm
from trueloop.geometry.feature import Array
from trueloop.loops.job_inputs import read_inputs
from trueloop.loops.process_intermittent import Correction, compensate
from trueloop.nc.program import read_program

ROOT = Path(__file__).parents[2]
WITHIN_MM = 0.0002


def corrected(job: Path) -> tuple[Correction, Array]:
    """The correction, and how far the contour stands off the nominal at the touches in its corrected program."""
    inputs = read_inputs(job).inputs
    correction = compensate(inputs)
    program = read_program(correction.corrected_program, correction.dialect)
    moves = feed_moves_of(program.run(inputs.parameters))
    pairs = zip(correction.touches.nominal_mm, correction.touches.outward_normal, strict=True)
    stands = [standoff_mm(moves, point, normal, correction.nose_radius_mm) for point, normal in pairs]
    return correction, np.array(stands)


@pytest.mark.parametrize("control", ["siemens"])
def test_the_corrected_contour_is_that_of_the_ge_2000t(control: str) -> None:
    correction, stands = corrected(ROOT / "tests" / "loops" / control / "job.toml")
    _, wanted = corrected(ROOT / "examples" / "modbas2" / "job.toml")
    assert correction.dialect == control
    assert np.abs(stands - wanted).max() < WITHIN_MM
    assert np.abs(stands).max() > 0.05  # it is corrected at all
