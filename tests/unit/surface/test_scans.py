"""Scans of a whole part: every format read as the same points, and those on the face taken out of them."""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.scan import read_scan
from trueloop.geometry.surface import fit_grid
from trueloop.jobs.surface.job import read_surface
from trueloop.loops.surface.surface import deviations_of
from trueloop.surface.deviations.points import MeasuredPoints, on_face

SIDE_MM, DEEP_MM = 40.0, 12.0
WAVE_MM = 0.008


def height_mm(x: Array, y: Array) -> Array:
    """The nominal face."""
    return 2.0 * np.sin(x / 13) * np.cos(y / 17)


def left_mm(x: Array, y: Array) -> Array:
    """Material left on the face of every part, along z."""
    return WAVE_MM * np.sin(x / 5) * np.cos(y / 6)


def triangles(count: int = 41) -> Array:
    """A closed block (n, 3, 3): the face as it was cut on top, four walls, a floor; a grid of `count` points a side."""
    at = np.linspace(0.0, SIDE_MM, count)
    x, y = np.meshgrid(at, at, indexing="ij")
    top = np.stack([x, y, height_mm(x, y) + left_mm(x, y)], axis=2)
    floor = np.stack([x, y, np.full_like(x, -DEEP_MM)], axis=2)
    walls = [np.stack([a, b]) for a, b in ((floor[0], top[0]), (top[-1], floor[-1]))]
    walls += [np.stack([a, b]) for a, b in ((top[:, 0], floor[:, 0]), (floor[:, -1], top[:, -1]))]
    found = []
    for grid in (top, floor[::-1], *walls):
        a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
        found += [np.stack(corners, axis=2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))]
    return np.concatenate(found)


def binary_stl(faces: Array) -> bytes:
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *face.ravel(), 0) for face in faces)
    return bytes(80) + struct.pack("<I", len(faces)) + body


def ascii_stl(faces: Array) -> bytes:
    lines = ["solid part"]
    for face in faces:
        corners = [f"vertex {x:.6f} {y:.6f} {z:.6f}" for x, y, z in face]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part", ""]).encode()


def obj(faces: Array) -> bytes:
    corners = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in faces.reshape(-1, 3)]
    return "\n".join([*corners, *(f"f {k} {k + 1} {k + 2}" for k in range(1, len(corners), 3)), ""]).encode()


def ply(faces: Array) -> bytes:
    points = faces.reshape(-1, 3)
    head = [
        *("ply", "format ascii 1.0", f"element vertex {len(points)}", "property double x", "property double y"),
        *("property double z", f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"),
    ]
    corners = [f"{x:.6f} {y:.6f} {z:.6f}" for x, y, z in points]
    return "\n".join([*head, *corners, *(f"3 {k} {k + 1} {k + 2}" for k in range(0, len(points), 3)), ""]).encode()


MESHES = {"part.stl": binary_stl, "ascii.stl": ascii_stl, "part.obj": obj, "part.ply": ply}


def _sorted(points: Array) -> Array:
    return np.unique(np.round(points, 4), axis=0)


@pytest.mark.parametrize(("name", "written"), MESHES.items(), ids=MESHES)
@pytest.mark.parametrize("unit_mm", [1.0, 25.4])
def test_every_mesh_gives_its_points_once_with_normals_out_of_the_material(
    tmp_path: Path, name: str, written: Callable[[Array], bytes], unit_mm: float
) -> None:
    faces = triangles(9)
    (tmp_path / name).write_bytes(written(faces / unit_mm))
    scan = read_scan(tmp_path / name, unit_mm)
    expected = _sorted(faces.reshape(-1, 3))
    assert len(scan.points_mm) == len(expected)
    near = np.linalg.norm(scan.points_mm[:, None] - expected[None], axis=2).min(axis=1)
    assert np.max(near) < 2e-4
    assert scan.normal is not None
    inside = np.array([SIDE_MM / 2, SIDE_MM / 2, -DEEP_MM / 2])
    assert np.all(np.einsum("nk,nk->n", scan.normal, scan.points_mm - inside) > 0)


POINTS = np.array([[54.3909, 7.67865, 19.88829], [8.74128, 8.63964, 25.63624], [58.43637, 35.74794, -15.41229]])
CLOUDS = {
    "XYZ.csv": "X,Y,Z\n{x:.5f},{y:.5f},{z:.5f}\n",
    "bare.xyz": "{x:.5f} {y:.5f} {z:.5f}\n",
    "normals.xyz": "{x:.5f} {y:.5f} {z:.5f} 0 0 1\n",
    "leica.pts": "3\n{x:.5f} {y:.5f} {z:.5f} -1200 10 20 30\n",
    "cloudcompare.asc": "//X Y Z Scalar_field\n{x:.5f} {y:.5f} {z:.5f} 0.5\n",
    "hash.txt": "# a remark\n# x y z\n{x:.5f}\t{y:.5f}\t{z:.5f}\n",
    "quoted.csv": '"{x:.5f}","{y:.5f}","{z:.5f}"\n',
    "named.csv": '"P {k}, left","{x:.5f}","{y:.5f}","{z:.5f}"\n',
    "brackets.txt": "# X [mm] Y [mm] Z [mm]\n{x:.5f} {y:.5f} {z:.5f}\n",
    "units.asc": "//Z in mm Y in mm X in mm\n{z:.5f} {y:.5f} {x:.5f}\n",
    "other.txt": "# z, y, x\n{z:.5f} {y:.5f} {x:.5f}\n",
    "gom.csv": 'Export\n"Name";"Ist Z";"Ist X";"Ist Y";"Soll X"\nP{k};{z:.5f};{x:.5f};{y:.5f};1\n',
    "comma.csv": "x;y;z\n{x:.5f};{y:.5f};{z:.5f}\n",
    "inch.csv": "X [in],Y [in],Z [in],NX,NY,NZ\n{x_inch:.7f},{y_inch:.7f},{z_inch:.7f},0,0,2\n",
}


DECIMAL_COMMAS = ("comma.csv", "quoted.csv", "named.csv")


@pytest.mark.parametrize(("name", "form"), CLOUDS.items(), ids=CLOUDS)
def test_columns_of_text_are_found(tmp_path: Path, name: str, form: str) -> None:
    *head, row = form.splitlines()
    lines = [
        row.format(k=k, x=x, y=y, z=z, x_inch=x / 25.4, y_inch=y / 25.4, z_inch=z / 25.4)
        for k, (x, y, z) in enumerate(POINTS, 1)
    ]
    text = "\n".join([*head, *lines, ""])
    (tmp_path / name).write_text(text.replace(".", ",") if name in DECIMAL_COMMAS else text)
    scan = read_scan(tmp_path / name, None if name in ("inch.csv", "units.asc", "brackets.txt") else 1.0)
    assert scan.points_mm == pytest.approx(POINTS, abs=1e-5)
    if name == "inch.csv":
        assert scan.normal == pytest.approx(np.tile([0.0, 0.0, 1.0], (3, 1)))


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("1 2 3\n4 5 6\n", Code.SRF_UNIT, None),
        ("a,b,c\n1,2,3\n", Code.SRF_FILE, 1),
        ("X,Y,Z\n1,2,3\n1,zwei,3\n", Code.SRF_FILE, 3),
        ("X,Y,Z\n1,2,3\n1,2\n", Code.SRF_FILE, 3),
        ("X,Y,Z\n1,2,3\n1,2,inf\n", Code.SRF_FILE, 3),
        ("X,Y,Z,x\n1,2,3,4\n", Code.SRF_FILE, 1),
        ("text alone\n", Code.SRF_FILE, 1),
        ("0 10 5.1 0 0 1\n1 10 5.2 0 0 1\n2 10 5.3 0 0 1\n", Code.SRF_FILE, 1),  # x, or numbers of points
        ("7,1.5,2.5,3.5\n9,1.5,2.5,3.5\n", Code.SRF_FILE, 1),
        ("10,125,20,250,5,375\n10,125,20,250,5,380\n", Code.SRF_FILE, 1),  # decimal commas, or columns
        ('"1,234","2.5","3.5"\n', Code.SRF_FILE, 1),  # a thousand, or 1.234
        ("1.5;2.5;3.5\n1.5;2.5;1,234\n", Code.SRF_FILE, 2),
        ("# Ist X Ist Y Ist Z\n1.5 2.5 3.5\n", Code.SRF_FILE, 1),
        ("# x y z\n1.5 2.5 3.5 0.1 0.2 0.9\n", Code.SRF_FILE, 1),
        ("X,Y,Z [inch]\n1,2,3\n", Code.SRF_UNIT, 1),
        ("X [mm],Y [inch],Z [mm]\n1,2,3\n", Code.SRF_UNIT, 1),
        ("// X in Y in Z in\n1 2 3\n", Code.SRF_UNIT, 1),
        ("# unit: inch\n1 2 3\n4 5 6\n", Code.SRF_UNIT, 1),
    ],
)
def test_a_cloud_that_cannot_be_read_is_refused_with_its_line(
    tmp_path: Path, text: str, code: Code, line: int | None
) -> None:
    path = tmp_path / "part.txt"
    path.write_text(text)
    with pytest.raises(TrueloopError) as caught:
        read_scan(path, None if code is Code.SRF_UNIT and line is None else 1.0)
    assert (caught.value.code, caught.value.place.line) == (code, line)


@pytest.mark.parametrize(
    "text",
    [
        "0 54.3909 7.67865 19.88829\n1 8.74128 8.63964 25.63624\n2 58.43637 35.74794 -15.41229\n",
        "# x y z\n0 54.3909 7.67865 19.88829 9\n0 8.74128 8.63964 25.63624 9\n0 58.43637 35.74794 -15.41229 9\n",
        "A;B;C;D\n0;54,3909;7,67865;19,88829\n0;8,74128;8,63964;25,63624\n0;58,43637;35,74794;-15,41229\n",
    ],
)
def test_stated_columns_overrule_headings_and_what_may_count_the_points(tmp_path: Path, text: str) -> None:
    (tmp_path / "part.txt").write_text(text)
    assert read_scan(tmp_path / "part.txt", 1.0, [2, 3, 4]).points_mm == pytest.approx(POINTS)
    assert read_scan(tmp_path / "part.txt", 1.0, [4, 2, 3]).points_mm == pytest.approx(POINTS[:, [2, 0, 1]])
    with pytest.raises(TrueloopError) as caught:
        read_scan(tmp_path / "part.txt", 1.0, [2, 3, 7])
    assert caught.value.code is Code.SRF_FILE


@pytest.mark.parametrize(
    ("text", "mm"),
    [
        ("X (m);Y (m);Z (m)\n0,001;0,002;0,003\n", 1.0),
        ("# unit: inch\nx y z\n1 2 3\n", 25.4),
        ("# Units: mm\n1 2 3\n", 1.0),
    ],
)
def test_the_unit_that_a_cloud_states_is_its_unit(tmp_path: Path, text: str, mm: float) -> None:
    path = tmp_path / "cloud.txt"
    path.write_text(text)
    np.testing.assert_allclose(read_scan(path, None).points_mm, [[mm, 2 * mm, 3 * mm]])


@pytest.mark.parametrize("heading", ["# x [in] y [in] z [in]", "A [in];B [in];C [in];D [in];E [in];F [in]"])
def test_units_of_headings_hold_for_stated_columns(tmp_path: Path, heading: str) -> None:
    separator = ";" if ";" in heading else " "
    (tmp_path / "part.txt").write_text(f"{heading}\n{separator.join(f'{k}.5' for k in range(1, 7))}\n")
    scan = read_scan(tmp_path / "part.txt", None, [4, 5, 6])
    assert scan.points_mm == pytest.approx(np.array([[4.5, 5.5, 6.5]]) * 25.4)
    with pytest.raises(TrueloopError) as caught:
        read_scan(tmp_path / "part.txt", 1.0, [4, 5, 6])
    assert caught.value.code is Code.SRF_UNIT


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("P1.e57", b"ASTM-E57" + bytes(40), "'P1.e57' is an E57 file"),
        ("P1.xyz", b"ISO-10303-21;\nHEADER;\n", "'P1.xyz' is a STEP file"),
        ("P1.stl", binary_stl(triangles(3))[:-120], "is cut short: it holds 29 of its 32 facets"),
    ],
)
def test_what_holds_no_points_is_refused_with_what_it_is(tmp_path: Path, name: str, content: bytes, why: str) -> None:
    """Top and floor of 4 squares and 4 walls of 2 make 32 facets of 50 bytes; 120 bytes are 2 of them and a part."""
    (tmp_path / name).write_bytes(content)
    with pytest.raises(TrueloopError) as caught:
        read_surface(_job(tmp_path, f'points = ["{name}"]\nalignment = "datum"\nunit = "mm"'))
    assert caught.value.code is Code.SRF_FILE and why in caught.value.message and "export" in caught.value.hint


@pytest.mark.parametrize("ending", ["stl", "ply", "obj"])
def test_a_mesh_that_is_none_is_refused(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"part.{ending}"
    path.write_bytes(b"no mesh at all\n")
    with pytest.raises(TrueloopError) as caught:
        read_scan(path, 1.0)
    assert caught.value.code is Code.SRF_FILE


def _job(folder: Path, gauging: str) -> Path:
    at = np.linspace(0.0, SIDE_MM, 31)
    rows = [f"{i},{j},{x:.6f},{y:.6f},{height_mm(x, y):.6f}" for i, x in enumerate(at, 1) for j, y in enumerate(at, 1)]
    (folder / "nominal.csv").write_text("\n".join(["row,column,x_mm,y_mm,z_mm", *rows, ""]))
    job = folder / "job.toml"
    job.write_text(f'name = "block"\n[surface]\nfile = "nominal.csv"\n[gauging]\n{gauging}\n')
    return job


@pytest.mark.parametrize("unit", ["mm", "inch"])
@pytest.mark.parametrize("normals", [True, False], ids=["mesh", "cloud"])
def test_a_scan_of_the_whole_part_gives_the_deviations_of_its_face(tmp_path: Path, unit: str, normals: bool) -> None:
    """Truth: what `left_mm` adds to the face, along its normal; walls and floor are counted and left."""
    faces = triangles() / (25.4 if unit == "inch" else 1.0)
    if normals:
        (tmp_path / "P1.stl").write_bytes(binary_stl(faces))
    else:
        points = np.unique(faces.reshape(-1, 3), axis=0)
        (tmp_path / "P1.xyz").write_text("".join(f"{x:.8f} {y:.8f} {z:.8f}\n" for x, y, z in points))
    read = read_surface(_job(tmp_path, f'points = ["P1.*"]\nalignment = "datum"\nunit = "{unit}"'))
    (found,) = deviations_of(read.inputs.surface, read.inputs.parts, read.inputs.options)
    x, y = found.nominal_mm[:, 0], found.nominal_mm[:, 1]
    assert found.error_mm == pytest.approx(left_mm(x, y) * found.normal[:, 2], abs=3e-4)
    inner = (39 * 39, 41 * 41)
    assert inner[0] <= len(x) <= inner[1]
    assert f"{len(x)} of {41 * 41 + 4 * 40 + 39 * 39} points of 'P1' are on the face" in found.findings[0].message


def test_points_of_a_wall_within_reach_of_the_face_are_told_by_their_normals() -> None:
    """A step of 0.5 mm up from the face: its points lie over the patch and within 1 mm."""
    at = np.linspace(0.0, SIDE_MM, 21)
    x, y = np.meshgrid(at, at, indexing="ij")
    surface = fit_grid(np.stack([x, y, height_mm(x, y)], axis=2)).surface
    rng = np.random.default_rng(3)
    x, y = rng.uniform(1, 39, (2, 3000))
    wall_y, up = rng.uniform(1, 39, 400), rng.uniform(0.05, 0.5, 400)
    wall_x = np.full(400, 20.0)
    points = np.concatenate(
        [
            np.stack([x, y, height_mm(x, y) + left_mm(x, y)], axis=1),
            np.stack([wall_x, wall_y, height_mm(wall_x, wall_y) + up], axis=1),
        ]
    )
    flat = np.tile([0.0, 0.0, 1.0], (3000, 1))
    normal = np.concatenate([flat, np.tile([1.0, 0.0, 0.0], (400, 1))])
    kept = on_face(surface, MeasuredPoints(points, name="P1"), normal, 1.0)
    assert kept.points_mm == pytest.approx(points[:3000])
    assert "0 are more than 1 mm off it or beside it, 400 face elsewhere" in kept.findings[0].message


def test_a_scan_needs_its_unit_and_its_frame_and_has_to_be_where_the_face_is(tmp_path: Path) -> None:
    (tmp_path / "P1.stl").write_bytes(binary_stl(triangles(9) + np.array([0, 0, 300.0])))
    for gauging, code in (
        ('points = ["P1.stl"]\nunit = "mm"', Code.JOB_KEY),
        ('points = ["P1.stl"]\nalignment = "datum"', Code.SRF_UNIT),
        ('points = ["P1.stl"]\nalignment = "datum"\nunit = "mm"', Code.SRF_OFF),
    ):
        with pytest.raises(TrueloopError) as caught:
            read_surface(_job(tmp_path, gauging))
        assert caught.value.code is code
    assert "gauging.columns" in caught.value.hint


FRAMES = {
    "as the model": lambda x, y, z: (x, y, z),
    "x and y swapped": lambda x, y, z: (y, x, z),
    "mirrored in z": lambda x, y, z: (x, y, -z),
    "mirrored in y": lambda x, y, z: (x, SIDE_MM - y, z),
    "turned by 180°": lambda x, y, z: (SIDE_MM - x, SIDE_MM - y, z),
}


@pytest.mark.parametrize("frame", FRAMES)
def test_a_scan_in_another_frame_is_refused(tmp_path: Path, frame: str) -> None:
    """Its points cross the nominal face: those within reach would be deviations that end at the farthest."""
    x, y = (grid.ravel() for grid in np.meshgrid(*[np.linspace(1.0, SIDE_MM - 1, 25)] * 2))
    rows = np.column_stack(FRAMES[frame](x, y, height_mm(x, y) + left_mm(x, y)))
    np.savetxt(tmp_path / "P1.xyz", rows, "%.9f")
    job = _job(tmp_path, 'points = ["P1.xyz"]\nalignment = "datum"\nunit = "mm"\nfarthest_mm = 0.5')
    if frame == "as the model":
        (part,) = read_surface(job).inputs.parts
        assert len(part.points_mm) == len(x) and part.findings == ()  # all are on the face: there is nothing to state
        return
    with pytest.raises(TrueloopError) as caught:
        read_surface(job)
    assert caught.value.code is Code.SRF_OFF and "another frame" in caught.value.message
    assert "mirror" in caught.value.hint and caught.value.values["limit_mm"] == 0.5


@pytest.mark.parametrize(
    ("per_mm", "unit", "hint"),
    [
        (1 / 25.4, "mm", 'gauging.unit = "inch"'),
        (1.0, "inch", 'gauging.unit = "mm"'),
        (1e-3, "mm", "they are in m: write them in mm"),
        (1e3, "mm", "they are in µm: write them in mm"),
    ],
)
def test_a_scan_in_another_unit_is_told_which(tmp_path: Path, per_mm: float, unit: str, hint: str) -> None:
    """Points of the face alone, as a cloud: too wide for it, or a cluster in its corner."""
    x, y = (grid.ravel() for grid in np.meshgrid(*[np.linspace(1.0, SIDE_MM - 1, 25)] * 2))
    rows = per_mm * np.column_stack([x, y, height_mm(x, y) + left_mm(x, y)])
    np.savetxt(tmp_path / "P1.xyz", rows, "%.9f")
    with pytest.raises(TrueloopError) as caught:
        inputs = read_surface(_job(tmp_path, f'points = ["P1.xyz"]\nalignment = "datum"\nunit = "{unit}"')).inputs
        list(deviations_of(inputs.surface, inputs.parts, inputs.options))
    assert caught.value.code is Code.SRF_UNIT and hint in caught.value.hint


@pytest.mark.parametrize(("decimals", "columns"), [(6, ""), (4, "columns = [1, 2, 3]"), (3, "")])
def test_nominal_points_beside_a_column_of_deviations_are_no_scan(tmp_path: Path, decimals: int, columns: str) -> None:
    """They would be a part without errors; its measured points, as few decimals as they have, are one."""
    x, y = (grid.ravel() for grid in np.meshgrid(*[np.linspace(1.0, SIDE_MM - 1, 15)] * 2))
    measured = height_mm(x, y) + left_mm(x, y)
    for z, refused in ((height_mm(x, y), True), (measured, False)):
        rows = np.column_stack([x, y, z, left_mm(x, y)])
        np.savetxt(tmp_path / "P1.csv", rows, f"%.{decimals}f", ",", header="X,Y,Z,Deviation", comments="")
        job = _job(tmp_path, f'points = ["P1.csv"]\nalignment = "datum"\nunit = "mm"\n{columns}')
        if not refused:
            assert len(read_surface(job).inputs.parts) == 1
            continue
        with pytest.raises(TrueloopError) as caught:
            read_surface(job)
        assert caught.value.code is Code.SRF_FILE and "exactly nominal" in str(caught.value)
