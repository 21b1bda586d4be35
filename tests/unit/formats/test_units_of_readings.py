"""Readings in the unit of the instrument: 1″ is π/648000 rad, 4.848 µrad; 1 inch is 25.4 mm."""

from pathlib import Path

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.readings_csv import read_readings
from trueloop.machine.model.term import chain_of

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


def test_positions_readings_and_uncertainties_in_inches_are_mm_inside(tmp_path: Path) -> None:
    """Each column by its own name: positions in inches with readings in µm, and the other way round."""
    chain = chain_of("mill-table-x")
    for header, row in (
        ("X_in,Y_mm,along,reading_um,u_in", "10,3,X,2,1e-5"),
        ("X_mm,Y_in,along,reading_in,u_um", "254,3,X,2,1"),
    ):
        (tmp_path / "r.csv").write_text(f"{header}\n{row}\n")
        found = read_readings(tmp_path / "r.csv", chain)
        x, y = found.state.positions[0, :2]
        inch = "Y_in" in header
        assert (x, y) == pytest.approx((254.0, 76.2 if inch else 3.0))
        assert found.reading[0] == pytest.approx(50.8 if inch else 2e-3)
        assert found.standard_u[0] == pytest.approx(1e-3 if inch else 2.54e-4)


def test_an_axis_with_positions_in_two_units_is_refused(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("X_in,X_mm,along,reading_um\n10,254,X,2\n")
    with pytest.raises(TrueloopError) as refused:
        read_readings(tmp_path / "r.csv", chain_of("mill-table-x"))
    assert refused.value.code is Code.MCH_UNIT
