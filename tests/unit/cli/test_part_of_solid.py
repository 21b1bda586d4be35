"""Solids from the outside: `trueloop part from-step` and `trueloop new --drawing`, for outside and bore."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.pmi import Asked, toleranced
from tests.support.solids import revolved, written
from trueloop.domain.characteristic import Quantity
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.job import read_part
from trueloop.jobs.turned.job_files import JobFiles

BORE = [
    (22.0, 0.0), (20.0, -2.0), (20.0, -20.0), (18.0, -30.0),
    (18.0, -36.0), (16.0, -38.0), (12.0, -38.0), (12.0, -51.0),
]  # fmt: skip
SECTION: list[Any] = [
    (30.0, -51.0), (30.0, 0.0), *BORE[:5],
    ((16 + math.sqrt(2), -36 - math.sqrt(2)), (16.0, -38.0)), *BORE[6:],
]  # fmt: skip
SEAT = 4
"""The bush: faces in the file's order from the chuck face on; the seat of 40 mm is the fifth."""

PROGRAM = """G21 G18 G7 G40 G90 G94
T1 M6
G0 X20 Z5
G41 G0 X46 Z2
G1 X44 Z0 F100
X40 Z-2
Z-20
X36 Z-30
Z-36
G3 X32 Z-38 R2
G1 X24
Z-51
G40 G0 X18
Z5
M2
"""
REST = (
    '[tool]\nnose_radius_mm = 0.4\n[programs]\ndialect = "linuxcnc"\nfinish = "bore.ngc"\n'
    '[gauging]\ntouches = "t.csv"\nball_radius_mm = 1.0\n'
)


@pytest.fixture
def bush(tmp_path: Path) -> Path:
    (tmp_path / "bore.ngc").write_text(PROGRAM)
    asked = [Asked("diameter", [SEAT], 40.0, fit=("H", "7")), Asked("CYLINDRICITY", [SEAT], 0.01)]
    return toleranced(revolved(SECTION), asked, tmp_path / "bush.step")


def is_the_bore(job: Path) -> None:
    features = read_part(job).profile.features
    ends = [features[0].start_mm, *(feature.end_mm for feature in features)]
    np.testing.assert_allclose(ends, BORE, atol=1e-8)


def test_the_table_of_a_bore_reads_back_as_the_bore_with_its_tolerance(bush: Path) -> None:
    table = run("part", "from-step", bush, "--side", "inside")
    assert 'side = "inside"' in table and "# Also found: outside, 3 features" in table
    assert "# Tolerance left out: cylindricity … to 0.0100 of cylinder-1" in table
    job = bush.with_name("job.toml")
    job.write_text(table + REST, encoding="utf-8")
    is_the_bore(job)
    (one,) = characteristics_of(JobFiles.of(job).located, read_part(job).profile)
    assert (one.quantity, one.feature, one.nominal) == (Quantity.DIAMETER, "cylinder-1", 40.0)
    assert (one.lower_limit, one.upper_limit) == pytest.approx((40.0, 40.025))  # H7 of 40 mm by ISO 286-2


def test_a_job_that_names_the_solid_reads_its_bore(bush: Path) -> None:
    job = bush.with_name("job.toml")
    job.write_text('[part]\nname = "bush"\nstep = "bush.step"\nside = "inside"\nstep_outline = 1\n' + REST)
    is_the_bore(job)
    outside = job.read_text().replace('side = "inside"\nstep_outline = 1\n', "")
    job.write_text(outside)
    assert read_part(job).profile.features[1].start_mm == pytest.approx((30.0, -51.0))
    job.write_text(outside.replace("[tool]", 'side = "around"\n[tool]'))
    assert "0 contours around" in run("part", "show", job, status=3)


def test_a_new_job_of_a_bore_is_that_of_the_solid(bush: Path) -> None:
    folder = bush.with_name("job")
    said = run("new", bush.with_name("bore.ngc"), "--nose-radius-mm", "0.4", "--drawing", bush, "--side", "inside",
               "--folder", folder)  # fmt: skip
    assert "8 features in order: " not in said and "7 features in order: cone-1, cylinder-1, cone-2" in said
    is_the_bore(folder / "job.toml")
    text = (folder / "job.toml").read_text()
    assert 'step = "../bush.step"' in text and 'tolerance = "H7"' in text


def test_a_solid_without_a_bore_says_what_it_has(tmp_path: Path) -> None:
    path = written(revolved([(0.0, -20.0), (10.0, -20.0), (10.0, 0.0), (0.0, 0.0)]), tmp_path / "bar.step")
    refusal = run("part", "from-step", path, "--side", "inside", status=3)
    assert "GEO-STEP" in refusal and "0 contours inside; found: outside, 3 features" in refusal
