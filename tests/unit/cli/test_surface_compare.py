"""The pattern as CAD, and parts after a correction beside those before: judged by a plane, whose normals are all alike.

On the plane z = 0 the pattern's surface is z = factor · e(x, y): to judge it takes no closest point, no spline of ours.
"""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader

from tests.support.chromium import console_errors, dump_dom
from tests.support.cli import run
from tests.support.surfaces import points_to_csv
from trueloop.arrays import Array
from trueloop.cli.terminal import ExitStatus
from trueloop.formats.cad.kernel import kernel
from trueloop.jobs.surface.job import read_nominal, read_surface
from trueloop.loops.surface.surface import model_of, pattern_model

SIDE_MM = 40.0
AT = np.linspace(0.0, SIDE_MM, 21)
X, Y = (a.ravel() for a in np.meshgrid(AT, AT, indexing="ij"))
NOISE_MM = 2e-5


def pattern_mm(x: Array, y: Array) -> Array:
    """12 µm left on in one corner, 8 µm too much taken in another."""
    a, b = x / SIDE_MM, y / SIDE_MM
    return np.asarray(0.012 * a**3 - 0.008 * b**2 * (1 - a))


def job(folder: Path, name: str, share: float, parts: int, more: str = "", wave_mm: float = 0.0) -> Path:
    """Parts of the plane that keep a share of the pattern, with noise, and waves that no few pieces follow."""
    (folder / name).mkdir()
    (folder / "plane.csv").write_bytes(points_to_csv(np.stack([X, Y, 0 * X], axis=1), (21, 21)))
    for k in range(parts):
        noise = np.random.default_rng(k).normal(0, NOISE_MM, len(X))
        wave = wave_mm * np.sin(2 * np.pi * X / 17.0) * np.cos(2 * np.pi * Y / 23.0)
        points = np.stack([X, Y, share * pattern_mm(X, Y) + wave + noise], axis=1)
        (folder / name / f"{name[0].upper()}{k + 1}.csv").write_bytes(points_to_csv(points, (21, 21)))
    path = folder / f"{name}.toml"
    table = f'name = "{name}"\n[surface]\nfile = "plane.csv"\n[gauging]\npoints = ["{name}/*.csv"]\n'
    path.write_text(table + more, encoding="utf-8")
    return path


def read_by(reader: Any, path: Path) -> Array:
    """Points all over the one face of a file, as the kernel's own reader has it."""
    occ = kernel()
    assert reader.ReadFile(str(path)) == occ.DONE and reader.TransferRoots() == 1
    faces = occ.Explorer(reader.OneShape(), occ.FACE)
    face = occ.as_face(faces.Current())
    u0, u1, v0, v1 = occ.uv_bounds(face)
    whole = occ.surface_of(face)
    places = ((u, v) for u in np.linspace(u0, u1, 31).tolist() for v in np.linspace(v0, v1, 31).tolist())
    return np.array([[p.X(), p.Y(), p.Z()] for p in (whole.Value(u, v) for u, v in places)])


@pytest.mark.parametrize(("ending", "reader"), [("step", STEPControl_Reader), ("iges", IGESControl_Reader)])
def test_the_pattern_is_written_in_true_size_and_magnified(
    tmp_path: Path, ending: str, reader: Callable[[], object]
) -> None:
    run("surface", "pattern", job(tmp_path, "before", 1.0, 4), "-o", tmp_path / "out", "--magnify", "250")
    for factor, name in ((1, "pattern"), (250, "pattern-x250")):
        file = tmp_path / "out" / f"{name}.{ending}"
        x, y, z = read_by(reader(), file).T
        assert np.ptp(x) == pytest.approx(SIDE_MM, abs=1e-6) and np.ptp(y) == pytest.approx(SIDE_MM, abs=1e-6)
        # 0.1 µm of refit, and what noise leaves of the mean of four parts: a wrong sign would be 24 µm.
        assert np.max(np.abs(z / factor - pattern_mm(x, y))) < 1.5e-4
        assert f"nominal + {factor} x machining pattern, not to be cut".encode() in file.read_bytes()


def test_compare_prints_what_the_correction_left(tmp_path: Path) -> None:
    """The pattern kept to a quarter: 0.25 of its root mean square, worst corner 3 µm for 12, noise as before."""
    before, after = job(tmp_path, "before", 1.0, 3), job(tmp_path, "after", 0.25, 2)
    told = json.loads(run("surface", "compare", before, after, "-o", tmp_path / "out", "--json"))
    whole = 1000 * np.sqrt(np.mean(pattern_mm(X, Y) ** 2))
    for which, share, parts in (("before", 1.0, 3), ("after", 0.25, 2)):
        group = told[which]
        assert [part["name"] for part in group["parts"]] == [f"{which[0].upper()}{k + 1}" for k in range(parts)]
        assert group["deterministic_part"]["rms_um"] == pytest.approx(share * whole, abs=0.01)
        assert group["all_deviations"]["worst_um"] == pytest.approx(share * 12.0, abs=0.1)
        assert group["all_deviations"]["low_um"] == pytest.approx(share * -8.0, abs=0.1)
        assert group["random_part"]["rms_um"] == pytest.approx(1000 * NOISE_MM, rel=0.15)
    assert json.loads((tmp_path / "out" / "compare.json").read_text(encoding="utf-8"))["after"] == told["after"]
    said = run("surface", "compare", before, after, "-o", tmp_path / "out")
    assert re.search(r"deterministic part +\S+ RMS +\S+ RMS +0\.25\n", said)
    assert re.search(r"worst \(part\) +\+1[12]\.\d \(B\d\) +\+[23]\.\d \(A\d\) +0\.25\n", said)


def test_the_page_has_all_maps_on_one_scale_and_a_silent_console(tmp_path: Path) -> None:
    run("surface", "compare", job(tmp_path, "before", 1.0, 3), job(tmp_path, "after", 0.25, 1), "-o", tmp_path)
    page = tmp_path / "compare.html"
    dom = dump_dom(page)
    assert console_errors(page) == []
    assert len(re.findall(r'<figure id="(?:before|after)-[a-z]+" class="small map"><svg', dom)) == 8
    scales = re.findall(r'dy="\.35em">([^<]+ µm)</text>', dom)
    assert len(scales) == 8 * 5 and len(set(scales)) == 5


@pytest.mark.parametrize(
    ("more", "old", "said"),
    [
        ('alignment = "best-fit"\n', "", "gauging.alignment is 'best-fit' here and 'datum'"),
        ("", 'file = "plane.csv"', "its normals are turned over"),
    ],
)
def test_parts_that_cannot_be_set_beside_each_other_are_refused(tmp_path: Path, more: str, old: str, said: str) -> None:
    before, after = job(tmp_path, "before", 1.0, 3), job(tmp_path, "after", 0.25, 1, more)
    if old:
        after.write_text(after.read_text(encoding="utf-8").replace(old, f"{old}\nflip = true"), encoding="utf-8")
    refusal = run("surface", "compare", before, after, "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    assert "SRF-COMPARE" in refusal and said in " ".join(refusal.split())
    assert not (tmp_path / "out").exists()


def test_the_page_names_the_written_patterns_and_how_far_they_deviate(tmp_path: Path) -> None:
    """Judged by the written files: what they hold, and how far they deviate from the pattern at places of their own."""
    path = job(tmp_path, "before", 1.0, 3, wave_mm=0.01)
    run("surface", "pattern", path, "-o", tmp_path / "out", "--magnify", "250")
    inputs = read_surface(path).inputs
    model = pattern_model(inputs.surface, model_of(inputs.surface, inputs.parts, inputs.options), inputs.options)
    shown = re.search(r'<table id="cad-table">.*?</table>', dump_dom(tmp_path / "out" / "pattern.html"))
    assert shown is not None
    rows = [re.sub("<[^>]+>", "|", row) for row in re.findall("<tr>(.*?)</tr>", shown[0])[1:]]
    at = np.random.default_rng(5).uniform(0.0, 1.0, 400)
    for (name, factor), row in zip((("pattern", 1), ("pattern-x250", 250)), rows, strict=True):
        written = read_nominal(tmp_path / "out" / f"{name}.step", None, flip=False)
        x, y, z = written.grid_mm(at[:200], at[200:]).reshape(-1, 3).T
        told = model.pattern.mean.value_mm(np.clip(x / SIDE_MM, 0, 1), np.clip(y / SIDE_MM, 0, 1))
        off_um = 1000 * np.max(np.abs(z - factor * told))
        cells = [cell for cell in row.split("|") if cell.strip(" ,")]
        assert cells[:3] == [f"{name}.step", f"{name}.iges", f"× {factor}"]
        assert cells[3] == " × ".join(map(str, written.degrees))
        assert cells[4] == " × ".join(map(str, written.control_mm.shape[:2]))
        assert 0.3 * float(cells[5]) < off_um < 1.05 * float(cells[5]) + 5e-4
