"""A job of several edges whose tools name the control's table: one new table has the offsets of all."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_several_tools import SET_OFF, touched
from tests.support.cli import run
from tests.support.grooved import LEFT, OD, PLACES, RIGHT, job

TABLE = """%
G21
G10 P3 X-0.1 Z0.05 R0. Q3
G10 P5 X0. Z0. R0. Q3
G10 P15 X0.02 Z-0.01 R0. Q3
G10 P10003 X-155.5 Z-80.25 R0.8 Q3
G10 P10005 X-150. Z-82. R0.2 Q3
G10 P10015 X-150. Z-79. R0.2 Q4
%
"""


def with_table(folder: Path, more: str = "") -> Path:
    """The grooved shaft, its edges set wrong, every tool with a row in one table."""
    noise = np.tile([0.2, -0.2, 0.2], len(PLACES) // 3)
    path = job(folder, (touched(folder, SET_OFF) + noise).tolist(), more=more)
    path.write_text(path.read_text().replace("[[tools]]\n", '[[tools]]\ntable = "offsets.txt"\n'))
    (folder / "offsets.txt").write_text(TABLE)
    return path


def wear(text: str) -> dict[int, tuple[float, float]]:
    return {int(n): (float(x), float(z)) for n, x, z in re.findall(r"G10 P(\d{1,2}) X(\S+) Z(\S+)", text)}


def test_the_offsets_of_all_edges_are_in_one_new_table(tmp_path: Path) -> None:
    """By hand: what was there, less what each edge is off by, X as a diameter; geometry stays byte for byte."""
    run("compensate", with_table(tmp_path), "-o", tmp_path / "out")
    new = (tmp_path / "out" / "new-offsets.txt").read_text()
    before, after = wear(TABLE), wear(new)
    for edge in (OD, LEFT, RIGHT):
        dx, dz = SET_OFF[edge].off_mm
        assert after[edge] == pytest.approx((before[edge][0] - 2 * dx, before[edge][1] - dz), abs=6e-4)
    assert new.splitlines()[5:] == TABLE.splitlines()[5:]
    assert (tmp_path / "offsets.txt").read_text() == TABLE


def test_an_edge_by_the_contour_leaves_its_row(tmp_path: Path) -> None:
    run("compensate", with_table(tmp_path, '[compensation]\nby = "contour"\n'), "-o", tmp_path / "out")
    assert not (tmp_path / "out" / "new-offsets.txt").exists()


def test_the_new_table_is_refused_by_the_job_that_made_it(tmp_path: Path) -> None:
    path = with_table(tmp_path)
    run("compensate", path, "-o", tmp_path / "out")
    (tmp_path / "offsets.txt").write_bytes((tmp_path / "out" / "new-offsets.txt").read_bytes())
    assert "OFS-TWICE" in run("compensate", path, "-o", tmp_path / "again", status=3)
    assert not (tmp_path / "again").exists()
