"""What controls write of touches, read back."""

import numpy as np
import pytest

from tests.support.probing import STEP, log_of, plan_of
from trueloop.controllers.probing import Settings
from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.touches_csv import parse_probe_log

PLAN = plan_of(STEP, {"cylinder": 3, "face": 2})


@pytest.mark.parametrize("inch", [False, True])
@pytest.mark.parametrize("diameter", [False, True])
@pytest.mark.parametrize("control", ["fanuc", "haas", "renishaw", "siemens"])
def test_positions_come_back_as_the_program_has_them_written(control: str, diameter: bool, inch: bool) -> None:
    """To what a number of the program resolves, 0.1 µm or 0.00001 in."""
    centres = np.add([touch.contact_mm for touch in PLAN.touches], [0.01234, -1.23456])
    written = log_of(PLAN, centres, control=control, program=Settings(inch=inch, diameter=diameter))
    found = parse_probe_log(written, "log", control, inch=inch, diameter=diameter)
    np.testing.assert_allclose([touch.position_mm for touch in found], centres, rtol=0.0, atol=1.3e-4)


def test_blanks_stand_for_leading_zeros_before_and_behind_the_sign() -> None:
    (found,) = parse_probe_log("X   12.000 Z-   1.000\n", "log", "fanuc")
    assert found.position_mm == (6.0, -1.0)


def test_a_number_too_small_for_its_digits_has_an_exponent() -> None:
    (found,) = parse_probe_log("X30.5 Z-1.25EX-05\n", "log", "siemens")
    assert found.position_mm == (15.25, -1.25e-5)


@pytest.mark.parametrize("line", ["X1.5 Z2.5.5", "X1.5 Z2.5mm", "X1..5 Z2", "X1 Z2E"])
def test_what_is_no_number_is_no_touch(line: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        parse_probe_log(f"{line}\n", "log", "fanuc")
    assert refused.value.code is Code.PRB_LOG
