"""Poses found without a start: points made by hand on plane faces, turned by any rotation and moved anywhere."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.solids import block, without, written
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.formats.cad.step import read_faces
from trueloop.jobs.surface.job import read_surface
from trueloop.loops.surface.surface import deviations_of
from trueloop.surface.deviations.pose import Model, found_pose, model_of_faces

LIMITS = {"farthest_mm": 1.0, "setup_mm": 0.2}
Rectangle = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
"""A corner and two sides, whose cross product points out of the material."""

SIDES: Sequence[Rectangle] = (
    ((0, 0, 0), (0, 40, 0), (60, 0, 0)),
    ((0, 0, 0), (60, 0, 0), (0, 0, 10)),
    ((0, 0, 10), (45, 0, 0), (0, 0, 10)),
    ((0, 40, 0), (0, 0, 20), (60, 0, 0)),
    ((0, 0, 0), (0, 0, 20), (0, 40, 0)),
    ((60, 0, 0), (0, 40, 0), (0, 0, 10)),
    ((60, 25, 10), (0, 15, 0), (0, 0, 10)),
)
TOP: Sequence[Rectangle] = (
    ((0, 0, 20), (45, 0, 0), (0, 25, 0)),
    ((0, 25, 20), (60, 0, 0), (0, 15, 0)),
    ((45, 0, 10), (15, 0, 0), (0, 25, 0)),
)
STEP: Sequence[Rectangle] = (((45, 0, 10), (0, 25, 0), (0, 0, 10)), ((45, 25, 10), (15, 0, 0), (0, 0, 10)))


def scan(faces: Sequence[Rectangle], count: int, seed: int) -> Array:
    """Points on rectangles, evenly over their area; 4 µm of noise, and waves of 10 µm, along the normal."""
    rng = np.random.default_rng(seed)
    corner, a, b = (np.array([face[k] for face in faces], float) for k in range(3))
    out = np.cross(a, b)
    area = np.linalg.norm(out, axis=1)
    own = rng.choice(len(faces), count, p=area / area.sum())
    s, t = rng.uniform(0, 1, (2, count, 1))
    points = corner[own] + s * a[own] + t * b[own]
    error = 0.004 * rng.normal(size=count) + 0.01 * np.sin(points @ [0.1, 0.13, 0.2])
    return np.asarray(points + error[:, None] * (out / area[:, None])[own])


def model(solid: Any, folder: Path) -> Model:
    faces = read_faces(written(solid, folder / "part.step"))
    return model_of_faces([(face.surface, face.trimmed_away) for face in faces])


def stepped() -> Any:
    """60 × 40 × 20 mm, without a corner of 15 × 25 × 10 mm: no rotation brings it onto itself."""
    return without(block((0, 0, 0), (60, 40, 20)), block((45, -5, 10), (70, 25, 30)))


def anywhere(points: Array, seed: int) -> Array:
    moved = Rotation.random(random_state=seed).apply(points)
    return np.asarray(moved + np.random.default_rng(seed).uniform(-300, 300, 3))


PARTIAL: Sequence[Rectangle] = (*SIDES[1:], *TOP, *STEP)


@pytest.mark.parametrize("faces", [(*SIDES, *TOP, *STEP), PARTIAL], ids=["all", "bottom not scanned"])
def test_random_poses_are_found(tmp_path: Path, faces: Sequence[Rectangle]) -> None:
    """Truth: where the points were before they were moved, to the form that leaks into the motions."""
    of = model(stepped(), tmp_path)
    for seed in range(4):
        points = scan(faces, 4000, seed)
        pose, note = found_pose(of, anywhere(points, seed), 0.0, "P1", **LIMITS)
        assert np.max(np.linalg.norm(pose.apply(anywhere(points, seed)) - points, axis=1)) < 0.02
        assert note.code is Code.SRF_SETUP


def test_ball_centres_stand_off_the_faces_by_the_radius(tmp_path: Path) -> None:
    """Points on the lower faces alone, because a centre beside an edge has no place of its own."""
    faces, out = SIDES[1:5], np.array([[0, -1, 0], [0, -1, 0], [0, 1, 0], [-1, 0, 0]], float)
    parts = [scan([face], 1200, k) + 2.0 * n for k, (face, n) in enumerate(zip(faces, out, strict=True))]
    points = np.concatenate([*parts, *(scan([face], 1200, 9) + np.array([0, 0, 2.0]) for face in TOP)])
    pose, _ = found_pose(model(stepped(), tmp_path), anywhere(points, 3), 2.0, "P1", **LIMITS)
    assert np.max(np.linalg.norm(pose.apply(anywhere(points, 3)) - points, axis=1)) < 0.02


BLOCK: Sequence[Rectangle] = (
    *((SIDES[0], SIDES[3], SIDES[4])),
    *(((0, 0, 0), (60, 0, 0), (0, 0, 20)), ((60, 0, 0), (0, 40, 0), (0, 0, 20)), ((0, 0, 20), (60, 0, 0), (0, 40, 0))),
)


def test_a_part_that_looks_alike_turned_is_refused_with_the_turn(tmp_path: Path) -> None:
    of = model(block((0, 0, 0), (60, 40, 20)), tmp_path)
    with pytest.raises(TrueloopError) as caught:
        found_pose(of, anywhere(scan(BLOCK, 4000, 1), 1), 0.0, "P1", **LIMITS)
    assert caught.value.code is Code.SRF_SETUP
    assert "turned by 180.0° about (" in caught.value.message or "turned by 179.9° about (" in caught.value.message


def test_points_that_slide_on_their_faces_are_refused_with_the_motion(tmp_path: Path) -> None:
    """Of a round bar no point knows how far it is turned, nor, without its ends, how far it is moved along."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    turn, z = np.random.default_rng(1).uniform([[0.0], [5.0]], [[6.28], [45.0]], (2, 3000))
    points = np.stack([8 * np.cos(turn), 8 * np.sin(turn), z], axis=1)
    with pytest.raises(TrueloopError) as caught:
        found_pose(model(BRepPrimAPI_MakeCylinder(8.0, 50.0).Shape(), tmp_path), points, 0.0, "P1", **LIMITS)
    assert caught.value.code is Code.SRF_SETUP


def test_another_part_and_another_unit_are_refused(tmp_path: Path) -> None:
    of = model(stepped(), tmp_path)
    whole = scan((*SIDES, *TOP, *STEP), 4000, 1)
    for points in (whole / 25.4, whole * [1.0, 1.0, -1.0], whole * [1.1, 1.0, 1.0]):
        with pytest.raises(TrueloopError) as caught:
            found_pose(of, points, 0.0, "P1", **LIMITS)
        assert caught.value.code is Code.SRF_OFF


def test_a_scan_in_any_frame_gives_the_deviations_of_its_face(tmp_path: Path) -> None:
    """The level face at z = 10 was left 30 µm too high; the file is in inches, in a frame of its own."""
    written(stepped(), tmp_path / "part.step")
    low_mm = scan(TOP[2:], 375, 3) + np.array([0, 0, 0.03])
    points = np.concatenate([scan((*SIDES, *TOP[:2], *STEP), 9000, 2), low_mm])
    rows = (f"{x:.7f} {y:.7f} {z:.7f}" for x, y, z in anywhere(points, 7) / 25.4)
    (tmp_path / "P1.xyz").write_text("\n".join([*rows, ""]))
    low = [k.number for k in read_faces(tmp_path / "part.step") if k.area_mm2 == pytest.approx(375.0)]
    for number in low:
        (tmp_path / "job.toml").write_text(
            f'name = "low"\n[surface]\nfile = "part.step"\nface = {number}\n[gauging]\npoints = ["P1.xyz"]\n'
            'unit = "inch"\nalignment = "found"\n'
        )
        read = read_surface(tmp_path / "job.toml")
        if abs(read.inputs.surface.control_mm[..., 2].max() - 10.0) < 1e-6:
            break
    (part,) = read.inputs.parts
    assert 300 < len(part.points_mm) < 390
    assert np.mean(part.points_mm[:, 2]) == pytest.approx(np.mean(low_mm[:, 2]), abs=0.015)
    (found,) = deviations_of(read.inputs.surface, read.inputs.parts, read.inputs.options)
    assert any("the pose of 'P1' was found" in finding.message for finding in part.findings)
    assert np.std(found.error_mm) < 0.012
