"""Several edges on one virtual part: every edge errs by itself, and is corrected by itself."""

import numpy as np

from studies.simulated_edges import GROOVE_NOSE_MM, grooving
from studies.simulator_families import groove
from trueloop_lab.simulator.machine import Repeatability


def test_what_repeats_is_taken_out_of_what_each_edge_cuts() -> None:
    """Without scatter: left are the probe's, and what one offset for a wall and a floor that err otherwise leaves."""
    made = groove(Repeatability())(0)
    assert len(made.left_mm) > 40
    assert np.max(np.abs(made.left_mm)) < 1.5e-3


def test_the_insert_lies_on_its_corners_side_and_stands_back_from_the_floor() -> None:
    """The left corner's body is towards z+, the right one's towards z−; both corners are worn alike, mirrored."""
    left, right = (grooving(corner).machine for corner in ("left", "right"))
    assert all(x > 0.0 and z > 0.0 for x, z in left.body_mm)
    assert [(x, -z) for x, z in right.body_mm] == list(left.body_mm)
    angle = np.radians([10.0, 45.0, 90.0])
    np.testing.assert_allclose(right.nose.wear_at_mm(np.pi - angle), left.nose.wear_at_mm(angle), atol=1e-9)
    assert left.nose.radius_mm == GROOVE_NOSE_MM
