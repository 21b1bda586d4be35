"""Angles of an autocollimator in arcseconds: 1″ is π/648000 rad, 4.848 µrad."""

from pathlib import Path

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.readings_csv import read_readings
from trueloop.machine.model.structure import chain_of

HEADER = "X_mm,along,reading_{unit},u_{u},run\n"


def readings(folder: Path, unit: str, u: str) -> tuple[float, float]:
    (folder / "r.csv").write_text(HEADER.format(unit=unit, u=u) + "0,B,2,0.5,1\n100,B,3,0.5,1\n")
    found = read_readings(folder / "r.csv", chain_of("mill-table-x"))
    return float(found.reading[0]), float(found.standard_u[0])


def test_they_are_radians_inside(tmp_path: Path) -> None:
    arcsec = np.pi / 648000
    assert readings(tmp_path, "arcsec", "arcsec") == pytest.approx((2 * arcsec, 0.5 * arcsec))
    assert readings(tmp_path, "urad", "arcsec") == pytest.approx((2e-6, 0.5 * arcsec))


def test_an_uncertainty_in_a_unit_of_length_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as refused:
        readings(tmp_path, "arcsec", "um")
    assert refused.value.code is Code.MCH_UNIT
