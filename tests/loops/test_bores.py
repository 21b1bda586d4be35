"""Bores, back faces and profiles around the part: corrected by a job, and cut again by discs that know no side.

The part: a bore of 40 mm with a chamfer, a taper, a fillet of 2 mm, a shoulder and a bore of 24 mm, in LinuxCNC's words
by hand. The machine is a shift, a taper and a nose larger than the tool table says, by plain arithmetic.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.discs import centres_of, left_on_mm, moved
from tests.support.linuxcnc import LATHE_STARTUP, Tool, interpret
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.compensate import compensate_job
from trueloop.jobs.turned.job import read_part

Array = NDArray[np.float64]
NOSE_MM = 0.4

BORE = """[part]
name = "bush"
side = "inside"
x_is = "diameter"
start = [44, 0]
feature = [
  {{ name = "chamfer", to = [40, -2] }},
  {{ name = "seat", to = [40, -20] }},
  {{ name = "taper", to = [36, -30] }},
  {{ name = "land", to = [36, -36] }},
  {{ name = "fillet", to = [32, -38], radius = 2, turn = "concave" }},
  {{ name = "shoulder", to = [24, -38] }},
  {{ name = "small", to = [24, -50] }},
]
"""
COMPENSATED = """G21 G18 G7 G40 G90 G94
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


@dataclass(frozen=True)
class Lathe:
    """What the tool does otherwise than it was sent: (x, z) mm, a taper of x over z, and the true nose."""

    shift_mm: tuple[float, float]
    taper: float
    nose_mm: float

    def error_mm(self, at: Array) -> Array:
        return np.column_stack([self.shift_mm[0] + self.taper * at[:, 1], np.full(len(at), self.shift_mm[1])])


LATHE = Lathe((0.021, -0.009), 2.0e-4, NOSE_MM)


def cut_mm(program: Path, lathe: Lathe, nominal: Array, normal: Array) -> Array:
    """What LinuxCNC's moves leave on the part, mm along the normals."""
    moves = interpret(program, tools=[Tool(1, NOSE_MM)], startup=LATHE_STARTUP)
    return left_on_mm(moved(centres_of(moves), lathe.error_mm), lathe.nose_mm, nominal, normal)


def places(profile: Profile, count: int = 7) -> tuple[list[str], Array, Array]:
    """Features, points and normals, off the ends that a nose does not reach."""
    names, points, normals = [], [], []
    for feature in profile.features:
        s = feature.length_mm * np.linspace(0.15, 0.8, count)
        names += [feature.name] * count
        points.append(feature.point_mm(s))
        normals.append(feature.outward_normal(s))
    return names, np.concatenate(points), np.concatenate(normals)


def write_job(folder: Path, part: str, program: str, lathe: Lathe = LATHE, more: str = "") -> Path:
    """A job whose touches are what the erring lathe leaves of the given program."""
    (folder / "finish.ngc").write_text(program)
    job = folder / "job.toml"
    job.write_text(
        part.replace("{{", "{").replace("}}", "}")
        + f'\n[tool]\nnose_radius_mm = {NOSE_MM}\n\n[programs]\ndialect = "linuxcnc"\nfinish = "finish.ngc"\n'
        + f'\n[gauging]\ntouches = "touches.csv"\n{more}\n[output]\nfolder = "out"\n'
    )
    (folder / "touches.csv").write_text("point,feature,nominal_x_mm,nominal_z_mm,measured_x_mm,measured_z_mm\n")
    names, nominal, normal = places(read_part(job).profile)
    error = cut_mm(folder / "finish.ngc", lathe, nominal, normal)
    with (folder / "touches.csv").open("a", newline="") as file:
        rows = csv.writer(file)
        for k, (name, at, n, e) in enumerate(zip(names, nominal, normal, error, strict=True)):
            rows.writerow([k + 1, name, *(f"{v:.7f}" for v in (*at, *(at + e * n)))])
    return job


def left_after(job: Path, lathe: Lathe = LATHE) -> tuple[Array, Array]:
    """What is left on before and after the correction, at all places."""
    compensate_job(job)
    _, nominal, normal = places(read_part(job).profile)
    folder = job.parent
    return (
        cut_mm(folder / "finish.ngc", lathe, nominal, normal),
        cut_mm(folder / "out" / "corrected.ngc", lathe, nominal, normal),
    )


def test_a_bore_under_g41_is_cut_true(tmp_path: Path) -> None:
    """A wrong sign would double 20 µm; what is left is the rounding of words and the chords."""
    before, after = left_after(write_job(tmp_path, BORE, COMPENSATED))
    assert np.abs(before).max() > 0.015
    assert np.abs(after).max() < 0.0007


PLAIN = """[part]
name = "bush"
side = "inside"
start = [20, 0]
feature = [
  { name = "seat", to = [20, -20] },
  { name = "shoulder", to = [12, -20] },
  { name = "small", to = [12, -40] },
]
"""
CENTRE = """G21 G18 G8 G40 G90 G94
T1 M6
G0 X10 Z5
G0 X19.6 Z2
G1 Z-19.6 F100
X11.6
Z-40
G0 X9
Z5
M2
"""
"""The nose's centre by hand: 0.4 mm from every surface, towards the axis on cylinders, to the free end on the face."""

BY_CONTOUR = '[compensation]\nby = "contour"\n'

BACK_PART = """[part]
name = "flange"
side = "around"
start = [15, -10]
feature = [{ name = "back", to = [25, -10] }, { name = "rim", to = [25, 0] }]
"""
BACK = """G21 G18 G8 G40 G90 G94
T1 M6
G0 X40 Z-10.4
G1 X14.8 F100
G0 Z-13
X40
G0 X25.4 Z-11
G1 Z0.5
G0 X40
M2
"""


@pytest.mark.parametrize("backwards", [False, True])
def test_the_nose_centres_path_in_a_bore_is_cut_true_both_ways(tmp_path: Path, backwards: bool) -> None:
    program = CENTRE
    if backwards:
        way = "G1 X11.6 Z-40 F100\nZ-19.6\nX19.6\nZ2\nG0 X9\n"
        program = CENTRE[: CENTRE.index("G0 X19.6")] + "G0 X9 Z-40\n" + way + "Z5\nM2\n"
    before, after = left_after(write_job(tmp_path, PLAIN, program))
    assert np.abs(before).max() > 0.008
    assert np.abs(after).max() < 0.0007


def test_a_back_face_is_cut_true(tmp_path: Path) -> None:
    """Its normal looks at the chuck: 9 µm too far from the chuck is 9 µm too little left on a front, too much here."""
    lathe = Lathe((0.010, 0.009), 0.0, NOSE_MM)
    before, after = left_after(write_job(tmp_path, BACK_PART, BACK, lathe, BY_CONTOUR), lathe)
    assert before[:7] == pytest.approx(-0.009, abs=1e-6), "the nose came nearer to the free end, into the flange"
    assert before[7:] == pytest.approx(0.010, abs=1e-6)
    assert np.abs(after).max() < 0.0006


def test_the_profile_of_a_bore_comes_from_its_program(tmp_path: Path) -> None:
    (tmp_path / "finish.ngc").write_text(COMPENSATED)
    table = '[part]\nname = "b"\nside = "inside"\nfrom_program = true\n'
    job = tmp_path / "job.toml"
    job.write_text(
        f'{table}[tool]\nnose_radius_mm = {NOSE_MM}\n[programs]\ndialect = "linuxcnc"\nfinish = "finish.ngc"\n'
        '[gauging]\ntouches = "touches.csv"\n'
    )
    profile = read_part(job).profile
    assert profile.names[1:3] == ("cone-2", "cylinder-1")
    assert float(profile.features[2].outward_normal(0.0)[0]) == -1.0
    job.write_text(job.read_text().replace('side = "inside"\n', ""))
    with pytest.raises(TrueloopError) as refused:
        read_part(job)
    assert refused.value.code is Code.NC_BORE and "part.side" in refused.value.hint


def test_a_bore_in_the_order_of_an_outside_is_refused(tmp_path: Path) -> None:
    """Its normals would look into the material, and the correction would double the error."""
    with pytest.raises(TrueloopError) as refused:
        write_job(tmp_path, PLAIN.replace('side = "inside"\n', ""), CENTRE)
    assert refused.value.code is Code.GEO_ORDER


def test_a_bore_stated_as_an_outside_is_refused_by_its_rapid_moves(tmp_path: Path) -> None:
    """A pointed tool cuts on the profile itself, whichever side is meant: only its rapid moves show the side."""
    reversed_part = """[part]
name = "bush"
start = [12, -40]
feature = [
  { name = "small", to = [12, -20] },
  { name = "shoulder", to = [20, -20] },
  { name = "seat", to = [20, 0] },
]
"""
    pointed = CENTRE.replace("X19.6", "X20").replace("Z-19.6", "Z-20").replace("X11.6", "X12")
    job = write_job(tmp_path, PLAIN, pointed)
    text = job.read_text().replace(f"nose_radius_mm = {NOSE_MM}", "nose_radius_mm = 0")
    job.write_text(text.replace(PLAIN, reversed_part))
    (tmp_path / "touches.csv").write_text("point,feature,nominal_x_mm,nominal_z_mm,error_um\n1,seat,20,-8,12\n")
    with pytest.raises(TrueloopError) as refused:
        compensate_job(job)
    assert refused.value.code is Code.NC_BORE and refused.value.place.line == 7


def with_touches(folder: Path, columns: str, row: str) -> Path:
    job = write_job(folder, PLAIN, CENTRE)
    (folder / "touches.csv").write_text(f"point,feature,nominal_x_mm,nominal_z_mm,{columns}\n{row}")
    return job


def test_errors_of_a_bore_with_an_outsides_sign_are_refused(tmp_path: Path) -> None:
    """The radius is 12 µm too large: 12 µm too little is left on, and +12 is an outside's sign."""
    rows = "".join(f"{k},seat,20,{-4 * k},20.012,{-4 * k},12\n" for k in range(1, 5))
    with pytest.raises(TrueloopError) as refused:
        compensate_job(with_touches(tmp_path, "measured_x_mm,measured_z_mm,error_um", rows))
    assert refused.value.code is Code.TCH_SIGN and "bore" in refused.value.hint


def test_ball_centres_of_an_outside_are_refused_in_a_bore(tmp_path: Path) -> None:
    """The ball of 1 mm stands in the bore, at 19 mm; 21 mm is where it would touch an outside."""
    rows = "".join(f"{k},seat,20,{-4 * k},21.004,{-4 * k}\n" for k in range(1, 5))
    job = with_touches(tmp_path, "measured_x_mm,measured_z_mm", rows)
    job.write_text(job.read_text().replace("[gauging]\n", "[gauging]\nball_radius_mm = 1.0\n"))
    with pytest.raises(TrueloopError) as refused:
        compensate_job(job)
    assert refused.value.code is Code.TCH_SIGN and "part.side" in refused.value.hint


def test_the_right_side_of_the_ball_is_taken(tmp_path: Path) -> None:
    rows = "".join(f"{k},seat,20,{-4 * k},{18.996},{-4 * k}\n" for k in range(1, 5))
    job = with_touches(tmp_path, "measured_x_mm,measured_z_mm", rows)
    job.write_text(job.read_text().replace("[gauging]\n", "[gauging]\nball_radius_mm = 1.0\n"))
    corrected, _ = compensate_job(job)
    assert corrected.touches.error_mm == pytest.approx(0.004), "the bore is 4 µm too small in radius: left on"
