"""The worn nose runs through its table."""

import math

import numpy as np
import pytest

from trueloop.errors import TrueloopError
from trueloop_lab.simulator.nose import Nose


@pytest.mark.parametrize("last_deg", [10.5, 10.0, 0.3])
def test_the_wear_runs_through_every_radius_error_of_the_table(last_deg: float) -> None:
    """Also where the table is no whole number of degrees long: its last value is reached at its last angle."""
    angle = tuple(math.radians(share * last_deg) for share in (0.0, 0.5, 1.0))
    nose = Nose(0.8, angle, (0.0, 2e-7, 5e-7))
    assert np.allclose(nose.wear_at_mm(np.array([angle[0], angle[2], 1.0])), [0.0, 5e-7, 5e-7], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("angles_deg", "wear_mm", "words"),
    [
        (
            (0.0, 17.0, 34.0),
            (0.0, 0.08, 0.0),
            "hollow at a contact angle of 1[0-9].[0-9] degrees: its local radius is -",
        ),
        ((-185.0, 0.0), (0.0, 0.001), "-185.0°"),
        ((0.0, 181.0), (0.0, 0.001), "181.0°"),
        ((0.0, float("inf")), (0.0, 0.001), "by 2 angles and 2 radius errors"),
    ],
)
def test_what_is_no_nose_is_refused(angles_deg: tuple[float, ...], wear_mm: tuple[float, ...], words: str) -> None:
    with pytest.raises(TrueloopError, match=f"SIM-NOSE: .*{words}"):
        Nose(0.8, tuple(map(math.radians, angles_deg)), wear_mm)


def test_a_table_may_reach_once_around() -> None:
    assert Nose(0.8, (-math.pi, math.pi), (0.0, 0.001)).wear_at_mm(np.array([math.pi]))[0] == pytest.approx(0.001)
