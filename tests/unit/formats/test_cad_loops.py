"""Faces trimmed as others were: through STEP and IGES, judged by geometry and by the kernel point by point."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.support.surfaces import random_surface, wavy_surface
from trueloop.arrays import Array
from trueloop.domain.option import Limits
from trueloop.errors import Code, TrueloopError
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.loops import Loop, distance_mm, edges_mm
from trueloop.formats.cad.step import CadFace, named_faces, read_faces, write_surface
from trueloop.geometry.surface import Surface, closest
from trueloop.surface.compensation.shift import corrected_surface

RNG = np.random.default_rng(71)
HOLE, RADIUS = (0.3, 0.6), (0.1, 0.2)


def outer() -> Loop:
    """The square less its corner at (1, 1): u + v < 1.6."""
    corners = np.array([[0, 0], [1, 0], [1, 0.6], [0.6, 1], [0, 1], [0, 0]], float)
    return tuple(np.array([a, b]) for a, b in pairwise(corners))


def hole() -> Loop:
    turn = np.linspace(0, -2 * np.pi, 129)
    turn[-1] = 0.0
    return (np.array(HOLE) + np.array(RADIUS) * np.stack([np.cos(turn), np.sin(turn)], axis=1),)


def inside(u: Array, v: Array, larger: float = 0.0) -> np.ndarray:
    round_the_hole = ((u - HOLE[0]) / RADIUS[0]) ** 2 + ((v - HOLE[1]) / RADIUS[1]) ** 2
    return np.asarray((u + v < 1.6 - larger) & (round_the_hole > 1 + larger))


def places(count: int = 400) -> tuple[Array, Array, Array]:
    """Places of the square that are 0.1 mm or more from the edges, and which of them are on the face."""
    u, v = RNG.uniform(0.01, 0.99, (2, count))
    clear = inside(u, v, 0.03) | ~inside(u, v, -0.03)
    return u[clear], v[clear], inside(u, v)[clear]


def kept(face: CadFace, points_mm: Array) -> np.ndarray:
    feet = closest(face.surface, points_mm)
    assert np.max(np.abs(feet.distance_mm)) < 1e-6
    return ~face.trimmed_away(feet.u, feet.v)


@pytest.mark.parametrize("ending", [".step", ".igs"])
@pytest.mark.parametrize("surface", [wavy_surface(), wavy_surface().turned_over()], ids=["up", "down"])
def test_a_face_with_a_hole_and_a_cut_corner_is_read_as_it_was_written(
    tmp_path: Path, surface: Surface, ending: str
) -> None:
    path = tmp_path / f"face{ending}"
    write_surface(surface, path, (outer(), hole()))
    face = named_faces(path)[0]
    u, v, wanted = places()
    points = surface.point_mm(u, v)
    np.testing.assert_array_equal(kept(face, points), wanted)
    assert 0 < np.count_nonzero(wanted) < len(wanted)
    np.testing.assert_allclose(closest(face.surface, points).normal, surface.normal(u, v), atol=1e-6)
    assert sorted(map(len, face.loops)) == [1, 5]


def test_loops_that_were_read_are_those_that_were_written(tmp_path: Path) -> None:
    """The circle's places keep to the circle, with the face on their left: the hole goes round clockwise."""
    surface = wavy_surface()
    write_surface(surface, tmp_path / "face.step", (hole(), outer()))
    (around,) = min(named_faces(tmp_path / "face.step")[0].loops, key=len)
    from_middle = (around - np.array(HOLE)) / np.array(RADIUS)
    np.testing.assert_allclose(np.hypot(*from_middle.T), 1.0, atol=1e-6)
    turns = np.diff(np.unwrap(np.arctan2(from_middle[:, 1], from_middle[:, 0])))
    assert np.sum(turns) == pytest.approx(-2 * np.pi, abs=1e-9)


def test_a_whole_patch_has_no_loops(tmp_path: Path) -> None:
    write_surface(wavy_surface(), tmp_path / "whole.step")
    assert named_faces(tmp_path / "whole.step")[0].loops == ()


def test_a_point_a_little_outside_the_edge_is_no_touch_of_the_face(tmp_path: Path) -> None:
    """Whatever a parameter is in mm, here some 50: 0.04 mm beyond an edge is still the face, 0.06 mm no longer."""
    surface = wavy_surface()
    write_surface(surface, tmp_path / "face.step", (outer(), hole()))
    face = named_faces(tmp_path / "face.step")[0]
    edge, slope = surface.point_mm(*np.array([[0.8], [0.8]])), surface.partials(*np.array([[0.8], [0.8]]))
    a_mm = np.linalg.norm((slope.du + slope.dv)[0] / np.sqrt(2))
    for beyond_mm, away in ((0.04, False), (0.06, True)):
        at = np.array([0.8 + beyond_mm / a_mm / np.sqrt(2)])
        assert face.trimmed_away(at, at).tolist() == [away]
    assert distance_mm(edges_mm(face.handle), edge) < 1e-5


def test_a_face_whose_edge_passes_the_end_of_its_surface_is_read(tmp_path: Path) -> None:
    """By 5 nm, which the kernel takes for nothing when it writes."""
    wide = tuple(piece * (1 + 1e-7) for piece in outer())
    write_surface(wavy_surface(), tmp_path / "face.step", (wide,))
    face, (u, v, _) = named_faces(tmp_path / "face.step")[0], places()
    np.testing.assert_array_equal(kept(face, wavy_surface().point_mm(u, v)), u + v < 1.6)
    assert np.max(np.concatenate(face.loops[0])) == 1.0


def test_loops_that_bound_nothing_are_refused(tmp_path: Path) -> None:
    """An outline that crosses itself."""
    crossing = tuple(piece[:, ::-1] if k == 1 else piece for k, piece in enumerate(outer()))
    with pytest.raises(TrueloopError, match="1 loops of edges") as refused:
        write_surface(wavy_surface(), tmp_path / "face.step", (crossing,))
    assert refused.value.code is Code.SRF_TRIM


def shared(surface: Surface, shares: Array) -> tuple[Array, Array]:
    (u0, u1), (v0, v1) = surface.domain
    return u0 + (u1 - u0) * shares[0], v0 + (v1 - v0) * shares[1]


def corrected_is_trimmed_as(face: CadFace, path: Path) -> None:
    """Corrected by up to some µm and written, a face of others is trimmed in the same places: with random ones."""
    pattern = random_surface(np.random.default_rng(3), 4, 0.002)
    corrected = corrected_surface(face.surface, pattern, limits=Limits(slope=1.0)).surface
    write_surface(corrected, path, face.loops)
    again, shares = named_faces(path)[0], RNG.uniform(0, 1, (2, 500))
    wanted = ~face.trimmed_away(*shared(face.surface, shares))
    found = kept(again, corrected.point_mm(*shared(corrected, shares)))
    clear = distance_mm(edges_mm(face.handle), face.surface.point_mm(*shared(face.surface, shares))) > 0.1
    np.testing.assert_array_equal(found[clear], wanted[clear])
    assert np.any(~wanted) and np.any(wanted)
    assert len(again.loops) == len(face.loops)


@pytest.mark.corpus
def test_corrected_faces_of_others_keep_what_they_were_trimmed_by(corpus: Path, tmp_path: Path) -> None:
    """Rings of a turned part in inch and of a plate: every face of these files that is not a whole patch."""
    cad = corpus / "data/public/cad"
    found = [
        face
        for name in ("conical-surface.step", "nist-mbe-pmi-11.stp")
        for face in read_faces(cad / name)
        if face.loops
    ]
    assert len(found) == 4
    for face in found:
        corrected_is_trimmed_as(face, tmp_path / "corrected.step")


def test_a_corrected_cylinder_keeps_a_bore_across(tmp_path: Path) -> None:
    """A closed face, whose seam bounds it twice, and whose patch does not have its angles for parameters."""
    path = tmp_path / "cylinder.step"
    across_bored_cylinder(path)
    wall = next(face for face in read_faces(path) if len(face.loops) == 3)
    corrected_is_trimmed_as(wall, tmp_path / "corrected.step")


def across_bored_cylinder(path: Path) -> None:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    occ = kernel()
    bore = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(3, -50, 25), gp_Dir(0, 1, 0)), 8.0, 100.0).Shape()
    writer = occ.StepWriter()
    writer.Transfer(BRepAlgoAPI_Cut(BRepPrimAPI_MakeCylinder(20.0, 50.0).Shape(), bore).Shape(), occ.AS_IS)
    writer.Write(str(path))
