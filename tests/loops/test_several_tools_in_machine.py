"""A machine that errs, known by its model, and several tools that stand in it in their own ways.

Judged by the formula of the machine's error, by LinuxCNC's interpreter, and by a nose run along the path that the
machine drives.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from tests.loops import test_setups
from tests.loops.test_several_tools import WORN, commanded
from tests.support import erring_lathe, two_sides
from tests.support.cli import run
from tests.support.grooved import LEFT, NOSE_MM, OD, PLACES, RIGHT, job, measured_um, program
from trueloop.arrays import Array
from trueloop.formats.tables.model_file import model_to_json

ZERO = (70.0, 0.0, -100.0)
TOOLS = {OD: (-30.0, 0.0, 45.0), LEFT: (-45.0, 0.0, 70.0), RIGHT: (-45.0, 0.0, 73.0)}
CUTTING_C = 28.0
MACHINE = (
    f'[machine]\nmodel = "model.json"\ncutting = {{ T1 = {CUTTING_C} }}\n'
    'semifinish_cut = "compensated"\ntouched_on = "cmm"\n'
)


def driven(
    path: Array, zero: tuple[float, float, float], tool: tuple[float, float, float], t1_degc: float = CUTTING_C
) -> Array:
    """Where the machine takes the nose's centre, (n, 2): to the command + E at the axes' places."""
    axes = path + np.array([zero[0] - tool[0], zero[2] - tool[2]])
    return np.asarray(path + erring_lathe.error_mm(axes[:, 0], axes[:, 1], t1_degc))


def left_um(file: Path, t1_degc: float = CUTTING_C) -> Array:
    """Errors of the part that a cut at this temperature leaves at all places, µm."""
    paths = {tool: driven(path, ZERO, TOOLS[tool], t1_degc) for tool, path in commanded(file).items()}
    return np.array(measured_um(paths, WORN))


def placed(folder: Path, machine: str = MACHINE) -> Path:
    """The job with the machine's model, each tool with its place; in the semi-finish cut the control corrected E."""
    given = folder / "given.ngc"
    given.write_text(program("linuxcnc"))
    (folder / "model.json").write_text(model_to_json(erring_lathe.model(), {}))
    path = job(folder, measured_um(commanded(given), WORN), "linuxcnc", machine)
    text = path.read_text()
    for tool, at_mm in TOOLS.items():
        text = text.replace(f"number = {tool}\n", f"number = {tool}\ntool_mm = {list(at_mm)}\n")
    path.write_text(text)
    return path


def test_each_tool_is_corrected_where_it_stands_in_the_machine(tmp_path: Path) -> None:
    """What is left is second order; with two tools' places exchanged, or the machine forgotten, it is there."""
    path = placed(tmp_path, MACHINE + f"work_zero_mm = {list(ZERO)}\n")
    run("compensate", path, "-o", tmp_path / "out")
    left = left_um(tmp_path / "out" / "corrected.ngc")
    before = left_um(tmp_path / "given.ngc")
    assert np.max(np.abs(before)) > 30.0 and np.max(np.abs(left)) < 0.6
    text = path.read_text()
    a, b = (str(list(TOOLS[tool])) for tool in (OD, LEFT))
    path.write_text(text.replace(a, "A").replace(b, a).replace("A", b))
    run("compensate", path, "-o", tmp_path / "exchanged")
    assert np.max(np.abs(left_um(tmp_path / "exchanged" / "corrected.ngc"))) > 3.0
    path.write_text(text.replace(MACHINE + f"work_zero_mm = {list(ZERO)}\n", '[compensation]\nby = "contour"\n'))
    run("compensate", path, "-o", tmp_path / "without")
    assert np.max(np.abs(left_um(tmp_path / "without" / "corrected.ngc"))) > 3.0


BOTH = {"first": (70.0, 0.0, -100.0), "second": (62.0, 0.0, -85.0)}
AT = {two_sides.FIRST: (-30.0, 0.0, 45.0), two_sides.SECOND: (-30.0, 0.0, 20.0), two_sides.BORE: (-55.0, 0.0, 70.0)}


def in_setups_um(folder: Path, monkeypatch: pytest.MonkeyPatch, out: str = "", t1_degc: float = CUTTING_C) -> Array:
    """Errors of a part that is turned round, each set-up's program driven with E at its own zero, µm along the part's
    normals.
    """
    plain = two_sides.centres_mm

    def on_machine(programs: Mapping[str, Path], tools: Mapping[str, tuple[int, ...]]) -> dict[int, Array]:
        zero = {tool: BOTH[name] for name, of in tools.items() for tool in of}
        return {tool: driven(path, zero[tool], AT[tool], t1_degc) for tool, path in plain(programs, tools).items()}

    with monkeypatch.context() as patched:
        patched.setattr(two_sides, "centres_mm", on_machine)
        return test_setups.touched(folder, test_setups.WORN, out)


def test_each_set_up_is_corrected_where_its_zero_lies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the second set-up's part turned round; with the zeros exchanged the machine's error is there."""
    (tmp_path / "model.json").write_text(model_to_json(erring_lathe.model(), {}))
    frames = {name: f"{frame}\nwork_zero_mm = {list(BOTH[name])}" for name, frame in two_sides.FRAMES.items()}
    path = two_sides.job(tmp_path, test_setups.touched(tmp_path, test_setups.WORN).tolist(), MACHINE, frames=frames)
    text = path.read_text()
    for tool, at_mm in AT.items():
        text = text.replace(f"number = {tool}\n", f"number = {tool}\ntool_mm = {list(at_mm)}\n")
    path.write_text(text)
    run("compensate", path, "-o", tmp_path / "out")
    before, left = (in_setups_um(tmp_path, monkeypatch, out) for out in ("", "out"))
    assert np.max(np.abs(before)) > 30.0 and np.max(np.abs(left)) < 0.6
    a, b = (str(list(zero)) for zero in BOTH.values())
    path.write_text(text.replace(a, "A").replace(b, a).replace("A", b))
    run("compensate", path, "-o", tmp_path / "exchanged")
    assert np.max(np.abs(in_setups_um(tmp_path, monkeypatch, "exchanged"))) > 3.0
    mirrored = text.replace("flipped = true", "mirrored_z = true")
    path.write_text(mirrored)
    assert "mirrored_z" in run("compensate", path, "-o", tmp_path / "no", status=3)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (f"tool_mm = {list(TOOLS[LEFT])}\n", "", "`tool_mm` is stated in each table of tools"),
        ("[machine]\n", "[machine]\ntool_mm = [0.0, 0.0, 0.0]\n", "`tool_mm` is stated in each table of tools"),
        (f"work_zero_mm = {list(ZERO)}\n", "", "`work_zero_mm` is stated in the table [machine]"),
    ],
)
def test_what_places_a_tool_is_stated_once(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = placed(tmp_path, MACHINE + f"work_zero_mm = {list(ZERO)}\n")
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    said = run("compensate", path, "-o", tmp_path / "out", status=3)
    assert "JOB-" in said and words in said and not (tmp_path / "out").exists()


SEMIFINISH_C = 22.0
BEFORE = MACHINE.replace("compensated", "uncompensated") + f"semifinish = {{ T1 = {SEMIFINISH_C} }}\n"
OF_ZERO = f"work_zero_mm = {list(ZERO)}\n"
SIZES = (
    *(("big", z, 25.0) for z in (-56.0, -50.0, -44.0)),
    *(("floor-left", z, 20.0) for z in (-39.2, -37.6)),
    *(("floor-right", z, 20.0) for z in (-36.4, -34.8)),
    *(("mid", z, 25.0) for z in (-31.0, -27.0, -23.0)),
    *(("seat", z, 18.0) for z in (-17.0, -11.0, -5.0)),
)
"""Diameters read: the feature, z and its radius, mm."""
FACES = {"left-wall": (-40.0, 1.0), "right-wall": (-34.0, -1.0), "step": (-20.0, 1.0)}
"""By face its z and normal along z."""


def errors_um(found: Array, feature: str, z_mm: float | None = None) -> float:
    """The error of a feature, or at one of its places."""
    return float(
        np.mean([e for e, p in zip(found, PLACES, strict=True) if p.feature == feature and z_mm in (None, p.z_mm)])
    )


def read_um(found: Array) -> dict[str, float]:
    """Deviations that gauges read, µm: of diameters twice the error, of lengths from the left wall by their ends."""
    sizes = {f"{feature} {z}": 2.0 * errors_um(found, feature, z) for feature, z, _ in SIZES}
    ends = {name: n_z * errors_um(found, name) for name, (_, n_z) in FACES.items()}
    return sizes | {name: ends[name] - ends["left-wall"] for name in ("right-wall", "step")}


def by_gauges(folder: Path, more: str) -> Path:
    """The job with readings of a part that was cut on the erring machine, at the temperature of the cut before."""
    path = placed(folder, more)
    read = read_um(left_um(folder / "given.ngc", SEMIFINISH_C))
    rows = [f"{f},{z},{2 * x + read[f'{f} {z}'] / 1e3:.6f},," for f, z, x in SIZES]
    rows += [f"{f},,,{FACES[f][0] + 40.0 + read[f] / 1e3:.6f},left-wall" for f in ("right-wall", "step")]
    head = "# uncertainty_um: 0.1\nfeature,z_mm,diameter_mm,length_mm,from"
    (folder / "readings.csv").write_text("\n".join([head, *rows, ""]))
    path.write_text(path.read_text().replace('touches = "touches.csv"', 'readings = "readings.csv"'))
    return path


def test_what_gauges_read_is_split_between_machine_and_each_edge(tmp_path: Path) -> None:
    """The read surface carries E of its own cut at its own temperature, each edge's where that edge stood: after the
    next cut diameters and lengths are right. As if it carried none, they are wrong by that.
    """
    path = by_gauges(tmp_path, BEFORE + OF_ZERO)
    said = run("compensate", path, "-o", tmp_path / "out")
    before, left = (
        np.abs(list(read_um(left_um(tmp_path / name)).values())) for name in ("given.ngc", "out/corrected.ngc")
    )
    assert before.max() > 40.0 and left.max() < 2.0
    assert "Readings and points of inspection files are taken as they are" in said and "touches were" not in said
    path.write_text(path.read_text().replace("uncompensated", "compensated"))
    run("compensate", path, "-o", tmp_path / "wrong")
    assert np.max(np.abs(list(read_um(left_um(tmp_path / "wrong" / "corrected.ngc")).values()))) > 10.0


@pytest.mark.parametrize("seen_from", ["step", "left-wall"])
def test_z_from_a_face_of_one_edge_is_that_of_all_in_the_machine(tmp_path: Path, seen_from: str) -> None:
    """Touches that count z from elsewhere, by 17 µm: the part is right as seen from the face, which one edge cuts."""
    path = placed(tmp_path, BEFORE + OF_ZERO)
    shifted = left_um(tmp_path / "given.ngc", SEMIFINISH_C) + np.array([17.0 * p.normal[1] for p in PLACES])
    job(tmp_path, shifted.tolist(), "linuxcnc", BEFORE + OF_ZERO)
    reference = next(k for k, p in enumerate(PLACES) if p.feature == seen_from)
    text = path.read_text().replace("[gauging]\n", f'[gauging]\nz_reference = "{reference + 1}"\n')
    for tool, at_mm in TOOLS.items():
        text = text.replace(f"number = {tool}\n", f"number = {tool}\ntool_mm = {list(at_mm)}\n")
    path.write_text(text)
    run("compensate", path, "-o", tmp_path / "out")
    left = left_um(tmp_path / "out" / "corrected.ngc")
    from_face = left - np.array([p.normal[1] for p in PLACES]) * left[reference] * PLACES[reference].normal[1]
    assert np.max(np.abs(from_face)) < 0.6


def test_z_from_a_face_of_one_set_up_is_that_of_the_other_in_the_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a part that is turned round for its second side and stands there on its front, touched on a measuring machine.

    E where the front was cut is in the front as it was cut: the second side counts from that face, and carries none of
    it.
    """
    (tmp_path / "model.json").write_text(model_to_json(erring_lathe.model(), {}))
    frames = {name: f"{frame}\nwork_zero_mm = {list(BOTH[name])}" for name, frame in two_sides.FRAMES.items()}
    test_setups.touched(tmp_path, test_setups.WORN)
    n_z = np.array([p.normal[1] for p in two_sides.PLACES])
    errors = two_sides.standing_um(in_setups_um(tmp_path, monkeypatch, t1_degc=SEMIFINISH_C), 0.0) + 17.0 * n_z
    path = two_sides.job(tmp_path, errors.tolist(), BEFORE, frames=frames)
    text = path.read_text().replace("[gauging]\n", f'[gauging]\nz_reference = "{len(n_z)}"\n')
    for tool, at_mm in AT.items():
        text = text.replace(f"number = {tool}\n", f"number = {tool}\ntool_mm = {list(at_mm)}\n")
    path.write_text(text)
    run("compensate", path, "-o", tmp_path / "out")
    left = two_sides.standing_um(in_setups_um(tmp_path, monkeypatch, "out"), 0.0)
    assert np.max(np.abs(left - n_z * left[-1])) < 0.6
    of_machine = 'touched_on = "machine"\nprobe_mm = [0.0, 0.0, 0.0]\nprobing = { T1 = 22.0 }'
    path.write_text(text.replace('touched_on = "cmm"', of_machine))
    assert "count from the zero of each" in run("compensate", path, "-o", tmp_path / "no", status=3)


assert set(NOSE_MM) == set(TOOLS)
