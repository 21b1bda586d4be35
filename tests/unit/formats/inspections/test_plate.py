"""Reports of drilled plates, judged by numpy on real ones."""

from pathlib import Path

import numpy as np
import pytest

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts

REPORT = """Plug Plate: 17
Date: 2026-03-14

    Meas X    Meas Y     Nom X     Nom Y     Err X     Err Y  Meas D   Nom D   Round
     1.012    -2.000     1.000    -1.990     0.012    -0.010   2.170   2.167   0.006
     5.000     6.000     5.000     6.000     0.030     0.000   2.160   2.167   0.004
"""


def test_a_hole_is_two_coordinates_a_diameter_and_a_form(tmp_path: Path) -> None:
    path = tmp_path / "plate.txt"
    path.write_text(REPORT)
    file = read_measured_file(path, StatedFacts("mm"))
    (one,) = file.inspections
    x, y, diameter, form = one.readings[:4]
    assert (one.part.part_type.name, one.part.serial, one.measured_at is not None) == ("Plug Plate", "17", True)
    assert (x.actual, x.nominal, x.axis) == (1.012, 1.0, "x")
    assert (y.actual, y.nominal, y.axis) == (-2.0, -1.99, "y")
    assert (diameter.quantity, diameter.actual, diameter.nominal) == (Quantity.DIAMETER, 2.17, 2.167)
    assert (form.quantity, form.actual) == (Quantity.FORM, 0.006)
    assert "1 of 4 deviations are not that: 'hole 2 x'" in file.remarks[0].text
    assert read_measured_file(path, StatedFacts("inch")).inspections[0].readings[0].actual == pytest.approx(25.7048)
    with pytest.raises(TrueloopError) as refusal:
        read_measured_file(path, StatedFacts())
    assert refusal.value.code is Code.MSR_UNIT


@pytest.mark.corpus
@pytest.mark.parametrize("number", ["8131", "8132", "8133"])
def test_real_plates(corpus: Path, number: str) -> None:
    path = corpus / "data" / "public" / "cmm" / f"sdss-D{number}.txt"
    table = np.loadtxt(path, skiprows=4)
    file = read_measured_file(path, StatedFacts("mm"))
    (one,) = file.inspections
    read = np.array([reading.actual for reading in one.readings]).reshape(-1, 4)
    assert read == pytest.approx(table[:, [0, 1, 6, 8]])
    nominal = np.array([reading.nominal for reading in one.readings]).reshape(-1, 4)
    assert nominal[:, :3] == pytest.approx(table[:, [2, 3, 7]])
    assert (read - nominal)[:, :2] == pytest.approx(table[:, 4:6], abs=0.0021)
    assert one.part.serial == number
