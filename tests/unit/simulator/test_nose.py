"""The worn nose runs through its table."""

import math

import numpy as np
import pytest

from trueloop.simulator.nose import Nose


@pytest.mark.parametrize("last_deg", [10.5, 10.0, 0.3])
def test_the_wear_runs_through_every_radius_error_of_the_table(last_deg: float) -> None:
    """Also where the table is no whole number of degrees long: its last value is reached at its last angle."""
    angle = tuple(math.radians(share * last_deg) for share in (0.0, 0.5, 1.0))
    nose = Nose(0.8, angle, (0.0, 2e-7, 5e-7))
    assert np.allclose(nose.wear_at_mm(np.array([angle[0], angle[2], 1.0])), [0.0, 5e-7, 5e-7], rtol=0.0, atol=1e-15)
