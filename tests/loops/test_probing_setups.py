"""A part of two set-ups is probed in each of them, and corrected by the touches of both.

What the control logs is worked out by hand: the place as the machine has it, and the ball's radius and the error along
its normal there.
"""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_setups import SET_OFF, touched
from tests.support.cli import run
from tests.support.two_sides import FIRST, PLACES, Place, job

BALL_MM = 0.5
PROBE = f"""
[stylus]
ball_radius_mm = {BALL_MM}
stem_radius_mm = 0.25
stem_length_mm = 40.0
stem_angle_deg = 0.0

[approach]
stand_off_mm = 1.0
overtravel_mm = 0.5
margin_mm = 0.2

[calibration]
effective_radius_mm = {BALL_MM}
from_deg = -180.0
to_deg = 180.0
"""


def probed(folder: Path, errors_um: Sequence[float]) -> Path:
    """The job with a probe, whose points are those of its touches."""
    (folder / "probe.toml").write_text(PROBE)
    path = job(folder, list(errors_um))
    path.write_text(path.read_text() + 'probe = "probe.toml"\n')
    return path


def logged(places: Sequence[tuple[Place, float]]) -> str:
    """What a Fanuc writes of these touches, X a diameter."""
    rows = []
    for place, error_um in places:
        (x, z), (n_x, n_z) = place.on_machine(turned_round=True)
        far = BALL_MM + 1e-3 * error_um
        rows.append(f"X{2 * (x + far * n_x):.6f}Z{z + far * n_z:.6f}")
    return "\n".join([*rows, ""])


def test_touches_of_each_set_up_together_correct_as_the_part_s_own(tmp_path: Path) -> None:
    errors_um = touched(tmp_path, SET_OFF)
    path = probed(tmp_path, errors_um.tolist())
    run("compensate", path, "-o", tmp_path / "one")
    for name in ("first", "second"):
        own = [(p, e) for p, e in zip(PLACES, errors_um, strict=True) if (p.tool == FIRST) == (name == "first")]
        program = run("probe", "program", path, "-c", "fanuc", "--setup", name)
        assert len(re.findall(r"\(POINT \S+ ON", program.upper())) == len(own)
        (tmp_path / f"{name}.log").write_text(logged(own))
        run(
            "probe",
            "read",
            path,
            tmp_path / f"{name}.log",
            "-c",
            "fanuc",
            "--setup",
            name,
            "-o",
            tmp_path / f"{name}.csv",
        )
    text = path.read_text().replace('touches = "touches.csv"', 'touches = ["second.csv", "first.csv"]')
    path.write_text(text.replace('dialect = "linuxcnc"\n', 'dialect = "linuxcnc"\ncut_with = "given"\n'))
    run("compensate", path, "-o", tmp_path / "both")
    for name in ("first-T1", "second-T2", "second-T4"):
        one, other = (
            np.loadtxt(tmp_path / folder / f"table-{name}.csv", delimiter=",", skiprows=1, usecols=(1, 2, 3, 4))
            for folder in ("one", "both")
        )
        assert one == pytest.approx(other, abs=1e-3) and np.abs(one[:, 2:]).max() > 4.0


def test_the_ball_keeps_clear_of_what_the_other_set_up_cuts(tmp_path: Path) -> None:
    """In the second the collar of radius 26 stands behind Z −30: the ball at the face before it goes no lower."""
    path = probed(tmp_path, [0.0] * len(PLACES))
    said = run("probe", "plan", path, "--setup", "second")
    assert "back-step" in said and "seat " not in said.replace("back-seat", "")
    assert "JOB-SETUPS" in run("probe", "plan", path, status=3)
    assert "'third' is none of them" in run("probe", "plan", path, "--setup", "third", status=3)
