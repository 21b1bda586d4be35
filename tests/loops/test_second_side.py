"""A second side under G41 and G42, its groove cut by both corners of an insert: turned round, mirrored, taken over.

LinuxCNC's interpreter keeps the noses off by itself, with tip orientations of a tool table, and says where their
centres run; the model moves the noses' circles there by each edge's own offset error and wear, in the machine's
directions, and the part is what they leave.
"""

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from tests.loops.test_bores import COMPENSATED, LATHE, cut_mm
from tests.support.cli import run
from tests.support.grooved import Cutting
from tests.support.second_side import (
    BORE,
    LEFT,
    NOSE_MM,
    OD,
    RIGHT,
    STATES,
    Frame,
    Groove,
    given,
    job,
    measured_um,
    places,
    second,
)
from tests.support.two_sides import FIRST, Place, setup_toml
from trueloop.arrays import Array
from trueloop.jobs.turned.compensate import corrected_part
from trueloop.jobs.turned.job_files import JobFiles

FRAMES: Sequence[Frame] = get_args(Frame)
GROOVES: Sequence[Groove] = get_args(Groove)
CONTOUR = '[compensation]\nby = "contour"\n'
OFF_MM = {
    FIRST: (0.012, -0.004),
    OD: (-0.007, 0.009),
    BORE: (0.005, 0.006),
    LEFT: (0.006, 0.009),
    RIGHT: (-0.008, 0.005),
}
SET_OFF = {tool: Cutting(off_mm) for tool, off_mm in OFF_MM.items()}


def worn(n: tuple[float, float]) -> float:
    """A nose that has lost 6 µm where it cuts diameters, 2 µm where it cuts faces, and more or less between them."""
    return 0.006 * n[0] ** 2 + 0.002 * n[1] ** 2 + 0.012 * n[0] * n[1]


WORN = {tool: Cutting(off_mm, worn) for tool, off_mm in OFF_MM.items()}


def touched(folder: Path, frame: Frame, cuttings: Mapping[int, Cutting], groove: Groove = "centre") -> Array:
    """Errors of the part that the given programs cut, which are written."""
    return measured_um(frame, given(folder, frame, groove), cuttings)


def left(folder: Path, frame: Frame, cuttings: Mapping[int, Cutting]) -> Array:
    """Errors of the part that the corrected programs in `out` cut."""
    return measured_um(
        frame, {name: folder / "out" / f"corrected-{name}.ngc" for name in ("first", "second")}, cuttings
    )


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("frame", FRAMES)
def test_the_model_cuts_a_good_part_and_errs_as_it_is_told(tmp_path: Path, frame: Frame, groove: Groove) -> None:
    """By hand: an edge that stands off by o on its machine errs by n·o; only turned round is n_Z of the part −n_z."""
    good = touched(tmp_path, frame, dict.fromkeys(NOSE_MM, Cutting((0.0, 0.0))), groove)
    assert np.max(np.abs(good)) < 0.02
    off = touched(tmp_path, frame, SET_OFF, groove) - good
    for place, error_um in zip(places(frame), off, strict=True):
        turn = -1.0 if frame == "flipped" and place.tool != FIRST else 1.0
        expected = place.normal[0] * OFF_MM[place.tool][0] + turn * place.normal[1] * OFF_MM[place.tool][1]
        within_um = 0.04 if place.feature == "edge" else 0.005  # a circle that has moved leaves (t·o)²/2R less
        assert error_um == pytest.approx(1e3 * expected, abs=within_um), place


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("frame", FRAMES)
def test_wear_is_taken_out_by_a_contour_under_g41_and_g42(tmp_path: Path, frame: Frame, groove: Groove) -> None:
    """After the cut only rounding is left; with the signs of the touches turned all is there twice."""
    errors_um = touched(tmp_path, frame, WORN, groove)
    assert np.max(np.abs(errors_um)) > 15.0
    run("compensate", job(tmp_path, frame, errors_um, CONTOUR), "-o", tmp_path / "out")
    assert np.max(np.abs(left(tmp_path, frame, WORN))) < 0.2
    run("compensate", job(tmp_path, frame, -errors_um, CONTOUR), "-o", tmp_path / "out")
    np.testing.assert_allclose(left(tmp_path, frame, WORN), 2 * errors_um, atol=0.2)


@pytest.mark.parametrize("frame", ["flipped", "taken"])
def test_each_corner_gets_its_offset_in_its_own_set_up(tmp_path: Path, frame: Frame) -> None:
    """By hand: −o, X as a diameter, Z as the program has it; the corner at the chuck is the left one."""
    done = corrected_part(JobFiles.of(job(tmp_path, frame, touched(tmp_path, frame, SET_OFF))))
    wears = {one.wear.tool: one.wear for setup in done.setups for one in setup.corrections}
    assert {tool: (wear.x, wear.z) for tool, wear in wears.items()} == {
        tool: pytest.approx((-2 * off_x, -off_z), abs=2e-4) for tool, (off_x, off_z) in OFF_MM.items()
    }
    cut = {of.tool: of.features for setup in done.setups for of in setup.edges}
    near, far = ("back-wall", "back-floor"), ("floor", "wall")
    if frame == "flipped":
        assert cut["T5 (left corner)"] == far[::-1] and cut["T15 (right corner)"] == near[::-1]
    else:
        assert cut["T5 (left corner)"] == near and cut["T15 (right corner)"] == far


@pytest.mark.parametrize("frame", FRAMES)
def test_corners_that_are_exchanged_are_refused(tmp_path: Path, frame: Frame) -> None:
    """Left and right as the drawing has them, which a part that is turned round exchanges."""
    errors_um = touched(tmp_path, frame, WORN)
    path = job(tmp_path, frame, errors_um, CONTOUR, exchanged=True)
    said = " ".join(run("compensate", path, "-o", tmp_path / "out", status=3).split())
    assert "NC-EDGE" in said and "which leans 90.0° under that corner" in said
    assert '"left" is the corner at lower Z of this program' in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("frame", FRAMES)
def test_a_nose_on_the_materials_side_is_refused(tmp_path: Path, frame: Frame) -> None:
    """G41 and G42 exchanged, as if they were of the drawing and not of the program that is turned round."""
    errors_um = touched(tmp_path, frame, WORN)
    text = second(frame)
    codes = {"G41": "G42", "G42": "G41"}
    (tmp_path / "second.ngc").write_text(re.sub("G4[12]", lambda found: codes[found[0]], text))
    said = run("compensate", job(tmp_path, frame, errors_um, CONTOUR), "-o", tmp_path / "out", status=3)
    assert "NC-COMPENSATED" in said and not (tmp_path / "out").exists()


def in_fanucs_words(text: str) -> str:
    """A second side's program as a Fanuc control has it."""
    text = text.replace("G21 G18 G7 G40 G90 G95", "%\nO0002\nG21 G18 G40 G99").replace("M2\n", "M30\n%\n")
    text = re.sub(r"(T\d+ M6 )?G43 H(\d+)", lambda found: f"T{int(found[2]):02}{int(found[2]):02}", text)
    return re.sub(r"(G4[12]) D\d+", r"\1", text)


@pytest.mark.parametrize("groove", GROOVES)
def test_a_fanuc_gets_the_same_contour(tmp_path: Path, groove: Groove) -> None:
    """Within its step of 1 µm, X a diameter."""
    errors_um = touched(tmp_path, "flipped", WORN, groove)
    path = job(tmp_path, "flipped", errors_um, CONTOUR)
    run("compensate", path, "-o", tmp_path / "out")
    (tmp_path / "second.nc").write_text(in_fanucs_words(second("flipped", groove)))
    before, after = path.read_text().split('name = "second"\n')
    after = after.replace('"linuxcnc"', '"fanuc-lathe"').replace('"second.ngc"', '"second.nc"')
    path.write_text(f'{before}name = "second"\n{after}')
    run("compensate", path, "-o", tmp_path / "out")
    found = []
    for ending in ("ngc", "nc"):
        lines = (tmp_path / "out" / f"corrected-second.{ending}").read_text().splitlines()
        ends = [re.findall(r"[XZ](-?[\d.]+)", line) for line in lines if re.search(r"G1 |G4[12]", line)]
        found.append(np.array(ends, dtype=np.float64))
    assert len(found[0]) > 10
    np.testing.assert_allclose(found[0], found[1], atol=1.1e-3)


def test_one_edge_of_the_groove_knows_nothing_of_the_other(tmp_path: Path) -> None:
    """The left corner's touches are thrown 30 µm off: what the others' corrections write stays to the last digit."""
    errors_um = touched(tmp_path, "flipped", WORN, "compensated")
    thrown = errors_um + np.array([30.0 * (place.tool == LEFT) for place in places("flipped")])
    written = []
    for errors in (errors_um, thrown):
        done = corrected_part(JobFiles.of(job(tmp_path, "flipped", errors, CONTOUR)))
        changes = {one.wear.tool: [word.after for word in one.record.changes] for one in done.setups[1].corrections}
        written.append(changes)
    assert set(written[0]) == {OD, BORE, LEFT, RIGHT}
    assert {tool for tool in written[0] if written[0][tool] != written[1][tool]} == {LEFT}


BUSH = """[part]
name = "bush"
side = "inside"
x_is = "diameter"
start = [24, -30]
feature = [
  { name = "small", to = [24, -42] },
  { name = "shoulder", to = [32, -42] },
  { name = "fillet", to = [36, -44], radius = 2, turn = "concave" },
  { name = "land", to = [36, -50] },
  { name = "taper", to = [40, -60] },
  { name = "seat", to = [40, -78] },
  { name = "chamfer", to = [44, -80] },
]
"""
"""The bore of test_bores as its part has it when it is bored from the back: z = −80 − Z."""


def _on_features(corners: Sequence[tuple[float, float]], names: Sequence[str]) -> list[Place]:
    """Seven places on each straight feature of the bush, x a radius; outward is on the left of the way."""
    found = []
    for name, (start, end) in zip(names, pairwise(corners), strict=True):
        (dx, dz), length = (end[0] - start[0], end[1] - start[1]), np.hypot(end[0] - start[0], end[1] - start[1])
        for share in np.linspace(0.2, 0.8, 7):
            normal = (float(dz / length), float(-dx / length))
            found.append(Place(name, start[0] + share * dx, start[1] + share * dz, normal, 1))
    return found


BUSH_PLACES = [
    *_on_features([(12, -30), (12, -42), (16, -42)], ["small", "shoulder"]),
    *_on_features([(18, -44), (18, -50), (20, -60), (20, -78), (22, -80)], ["land", "taper", "seat", "chamfer"]),
]


def test_a_bore_from_the_back_under_g41(tmp_path: Path) -> None:
    """The bore's program of test_bores, whose part is drawn the other way round: 20 µm are gone, or there twice."""
    at = np.array([(p.x_mm, -80.0 - p.z_mm) for p in BUSH_PLACES])
    normal = np.array([(p.normal[0], -p.normal[1]) for p in BUSH_PLACES])
    (tmp_path / "second.ngc").write_text(COMPENSATED)
    errors_um = 1e3 * cut_mm(tmp_path / "second.ngc", LATHE, at, normal)
    assert np.max(np.abs(errors_um)) > 15.0
    for sign, left_over in ((1.0, 0.0), (-1.0, 2.0)):
        rows = [
            f"{k},{p.feature},{p.x_mm},{p.z_mm},{sign * e:.6f}"
            for k, (p, e) in enumerate(zip(BUSH_PLACES, errors_um, strict=True), 1)
        ]
        header = "point,feature,nominal_x_mm,nominal_z_mm,error_um"
        (tmp_path / "touches.csv").write_text("\n".join([header, *rows, ""]))
        tool = "[[setups.tools]]\nnumber = 1\nnose_radius_mm = 0.4\n"
        setup = setup_toml("second", STATES["flipped"], "linuxcnc", tool, 'cut_with = "given"\n')
        (tmp_path / "job.toml").write_text(f'{BUSH}{setup}[gauging]\ntouches = "touches.csv"\n{CONTOUR}')
        run("compensate", tmp_path / "job.toml", "-o", tmp_path / "out")
        after = 1e3 * cut_mm(tmp_path / "out" / "corrected-second.ngc", LATHE, at, normal)
        np.testing.assert_allclose(after, left_over * errors_um, atol=0.3)
