"""Drilled plates of a telescope's fibre positioner: a corrected drilling program and CMM reports, as published."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import output_of
from trueloop.formats.measurements.positioning_data import read_plate_report
from trueloop.machine.standards import Plate, fit_pattern, fit_similarity

pytestmark = pytest.mark.corpus

MAGNITUDE, ANGLE = 32e-6, -38.33
"""Magnitude and angle in degrees stated in the header of the adjusted program."""

COORDINATE = re.compile(rb"([XY])(-?\d*\.\d*)")


def _programs(corpus: Path) -> tuple[Path, Path]:
    folder = corpus / "data/public/nc"
    return folder / "sdss-4642-unadjusted.par", folder / "sdss-4642-adjusted.par"


def _corrected(source: Path, folder: Path, magnitude: float) -> bytes:
    """All X and Y of the file, as the published tool did it: those that set coordinate systems too.

    But for G68, whose centre is 0, 0 and stays there, and stands where increments are in force.
    """
    out = folder / "corrected.par"
    options = ["-d", "fanuc-mill", "--all-words", "--quadrupole", f"{magnitude},{ANGLE}", "-o", str(out)]
    output_of("machine", "points", source, *options)
    return out.read_bytes()


def _without_header(program: bytes) -> list[bytes]:
    return [line for line in program.split(b"\n") if not line.startswith((b"(Adjusted ", b"(trueloop corrected "))]


def _deviations(ours: bytes, published: bytes) -> list[float]:
    """Differences of all coordinates; everything else must be equal byte by byte."""
    left, right = _without_header(ours), _without_header(published)
    assert len(left) == len(right)
    found = []
    for a, b in zip(left, right, strict=True):
        assert COORDINATE.sub(rb"\1", a) == COORDINATE.sub(rb"\1", b)
        pairs = zip(COORDINATE.findall(a), COORDINATE.findall(b), strict=True)
        found += [abs(float(x[1]) - float(y[1])) for x, y in pairs]
    return found


def test_the_adjusted_program_is_reproduced(corpus: Path, tmp_path: Path) -> None:
    unadjusted, adjusted = _programs(corpus)
    deviations = _deviations(_corrected(unadjusted, tmp_path, MAGNITUDE), adjusted.read_bytes())
    assert len(deviations) > 2000
    assert max(deviations) <= 0.000005 + 1e-12


def test_the_opposite_sign_is_seen(corpus: Path, tmp_path: Path) -> None:
    unadjusted, adjusted = _programs(corpus)
    deviations = _deviations(_corrected(unadjusted, tmp_path, -MAGNITUDE), adjusted.read_bytes())
    assert max(deviations) > 0.01


def _plates(corpus: Path) -> list[Plate]:
    return [read_plate_report(corpus / f"data/public/cmm/sdss-D813{k}.txt") for k in (1, 2, 3)]


def test_similarity_is_the_published_fit(corpus: Path) -> None:
    plate = _plates(corpus)[0]
    fit = fit_similarity(plate.nominal_mm, plate.measured_mm)
    assert tuple(round(value, 4) for value in fit.offset_mm) == (-0.0438, 0.0792)
    assert round(fit.scale, 7) == 1.0000066
    assert round(math.degrees(fit.rotation_rad), 4) == 0.0290
    assert fit.rms_mm == pytest.approx(8.1e-3, abs=0.05e-3)


def test_residuals_of_the_published_fit(corpus: Path) -> None:
    """Each hole's residual as printed, to the last digit printed (0.5 µm, and 0.5 µm of its coordinates)."""
    text = (corpus / "data/public/cmm/sdss-fit-8131.txt").read_text().split("DataTable")[1].splitlines()[2:]
    table = np.array([[float(cell) for cell in line.split()] for line in text if line.strip()])
    fit = fit_similarity(table[:, 0:2], table[:, 2:4])
    np.testing.assert_allclose(fit.residual_mm, table[:, 4:6], atol=1.05e-3)


@pytest.mark.parametrize(("left_out", "limit_um"), [(0, 5.0), (1, 5.9), (2, 5.5)])
def test_a_pattern_of_two_plates_holds_on_the_third(corpus: Path, left_out: int, limit_um: float) -> None:
    plates = _plates(corpus)
    pattern = fit_pattern([plate for k, plate in enumerate(plates) if k != left_out])
    third = plates[left_out]
    before = fit_similarity(third.nominal_mm, third.measured_mm).rms_mm
    assert before > 7.7e-3
    left = third.measured_mm - pattern.error_mm(third.nominal_mm, third.tool)
    assert fit_similarity(third.nominal_mm, left).rms_mm * 1e3 < limit_um
