"""Surfaces through STEP and IGES, and the kernel as an independent judge of points, normals and projections."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.cad_text import points_of_iges, points_of_step
from tests.support.surfaces import sphere, wavy_surface
from trueloop.arrays import Array
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.loops import classified, distance_mm, edges_mm
from trueloop.formats.cad.step import named_faces, read_faces, surface_to_bytes, write_surface
from trueloop.geometry.surface import Surface, closest
from trueloop.surface.deviations.points import BEYOND_MM

RNG = np.random.default_rng(51)
U, V = RNG.uniform(0.02, 0.95, (2, 200))


@pytest.mark.parametrize("ending", [".step", ".igs"])
@pytest.mark.parametrize("surface", [wavy_surface(), sphere(), sphere().turned_over()], ids=["wavy", "ball", "hollow"])
def test_what_is_written_is_read_again_with_its_normals(tmp_path: Path, surface: Surface, ending: str) -> None:
    path = tmp_path / f"surface{ending}"
    write_surface(surface, path)
    feet = closest(named_faces(path)[0].surface, surface.point_mm(U, V))
    assert np.max(np.abs(feet.distance_mm)) < 1e-6
    np.testing.assert_allclose(feet.normal, surface.normal(U, V), atol=1e-6)
    if ending == ".step":
        assert b"AP242" in path.read_bytes()


@pytest.mark.parametrize(("ending", "points_of"), [("step", points_of_step), ("igs", points_of_iges)])
@pytest.mark.parametrize("surface", [wavy_surface(), sphere()], ids=["wavy", "ball"])
def test_another_kernel_finds_the_same_surface_in_the_file(
    tmp_path: Path, surface: Surface, ending: str, points_of: Callable[[Path, Array, Array], Array]
) -> None:
    """geomdl, given the numbers in the file's text, to 1e-6 mm; described as it was asked to be."""
    path = tmp_path / f"surface.{ending}"
    path.write_bytes(surface_to_bytes(surface, ending, "what it is: 12"))
    (u0, u1), (v0, v1) = surface.domain
    theirs = points_of(path, (U - u0) / (u1 - u0), (V - v0) / (v1 - v0))
    np.testing.assert_allclose(theirs, surface.point_mm(U, V), atol=1e-6)
    assert b"what it is: 12" in path.read_bytes()
    assert named_faces(path)[0].number == 1


@pytest.mark.parametrize("surface", [wavy_surface(), sphere()], ids=["wavy", "ball"])
def test_the_kernel_projects_points_to_the_same_feet(tmp_path: Path, surface: Surface) -> None:
    write_surface(surface, tmp_path / "surface.step")
    face, occ = named_faces(tmp_path / "surface.step")[0], kernel()
    points = surface.point_mm(U, V) + RNG.uniform(-2, 2, (200, 1)) * surface.normal(U, V)
    ours = closest(face.surface, points)
    whole = occ.surface_of(face.handle)
    for k, (x, y, z) in enumerate(points):
        projection = occ.Projection(occ.Pnt(x, y, z), whole)
        assert projection.LowerDistance() == pytest.approx(abs(ours.distance_mm[k]), abs=1e-7)


@pytest.mark.corpus
def test_a_solid_of_others_gives_its_faces_with_outward_normals(corpus: Path) -> None:
    """STEP AP214 in inch: five faces, the solid's normals point away from its material."""
    faces = read_faces(corpus / "data/public/cad/conical-surface.step")
    assert [face.kind for face in faces] == [
        "CylindricalSurface",
        "Plane",
        "Plane",
        "CylindricalSurface",
        "ConicalSurface",
    ]
    outer, bore = faces[0].surface, faces[3].surface
    np.testing.assert_allclose(
        outer.curvatures_per_mm(np.array([0.3]), np.array([1.0]))[0], [0, 1 / 13.5165], atol=1e-4
    )
    assert bore.curvatures_per_mm(np.array([0.3]), np.array([1.0]))[0, 0] == pytest.approx(-1 / 5.5, rel=1e-4)


@pytest.mark.corpus
def test_a_trimmed_face_knows_what_was_cut_away(corpus: Path) -> None:
    ring = read_faces(corpus / "data/public/cad/conical-surface.step")[2]
    (u0, u1), (v0, v1) = ring.surface.domain
    middle, edge = np.array([(v0 + v1) / 2]), np.array([v0 + 0.01 * (v1 - v0)])
    assert ring.trimmed_away(np.array([(u0 + u1) / 2]), middle).tolist() == [True]  # the bore
    assert ring.trimmed_away(np.array([(u0 + u1) / 2]), edge).tolist() == [False]


@pytest.mark.corpus
def test_every_face_is_trimmed_as_the_kernel_says_point_by_point(corpus: Path) -> None:
    """Planes with and without a bore, cylinders with a seam, a cone, patches of a lens."""
    cad = corpus / "data/public/cad"
    seen = set[bool]()
    for face in (*read_faces(cad / "conical-surface.step"), *read_faces(cad / "sunglasses-lens.igs")[:3]):
        (u0, u1), (v0, v1) = face.surface.domain
        u, v = u0 + (u1 - u0) * RNG.uniform(0, 1, 300), v0 + (v1 - v0) * RNG.uniform(0, 1, 300)
        points = face.surface.point_mm(u, v)
        wanted = classified(face.handle, points) & (distance_mm(edges_mm(face.handle), points) > BEYOND_MM)
        assert face.trimmed_away(u, v).tolist() == wanted.tolist()
        seen |= set(wanted.tolist())
    assert seen == {True, False}


@pytest.mark.corpus
def test_a_scanned_lens_in_inch_is_read_in_millimetres(corpus: Path) -> None:
    """IGES 128 of others: nine patches of about 60 × 40 mm together."""
    faces = read_faces(corpus / "data/public/cad/sunglasses-lens.igs")
    assert len(faces) == 9
    assert all(face.surface.degrees == (3, 3) for face in faces)
    assert 1500 < sum(face.area_mm2 for face in faces) < 2500
