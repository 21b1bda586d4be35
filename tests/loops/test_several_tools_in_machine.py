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
from tests.support.grooved import LEFT, NOSE_MM, OD, RIGHT, job, measured_um, program
from trueloop.arrays import Array
from trueloop.formats.tables.model_file import model_to_json

ZERO = (70.0, 0.0, -100.0)
TOOLS = {OD: (-30.0, 0.0, 45.0), LEFT: (-45.0, 0.0, 70.0), RIGHT: (-45.0, 0.0, 73.0)}
CUTTING_C = 28.0
MACHINE = (
    f'[machine]\nmodel = "model.json"\ncutting = {{ T1 = {CUTTING_C} }}\n'
    'semifinish_cut = "compensated"\ntouched_on = "cmm"\n'
)


def driven(path: Array, zero: tuple[float, float, float], tool: tuple[float, float, float]) -> Array:
    """Where the machine takes the nose's centre, (n, 2): to the command + E at the axes' places."""
    axes = path + np.array([zero[0] - tool[0], zero[2] - tool[2]])
    return np.asarray(path + erring_lathe.error_mm(axes[:, 0], axes[:, 1], CUTTING_C))


def left_um(file: Path) -> Array:
    """Errors of the part that the finish cut leaves at all places, µm."""
    paths = {tool: driven(path, ZERO, TOOLS[tool]) for tool, path in commanded(file).items()}
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


def in_setups_um(folder: Path, monkeypatch: pytest.MonkeyPatch, out: str = "") -> Array:
    """Errors of a part that is turned round, each set-up's program driven with E at its own zero, µm along the part's
    normals.
    """
    plain = two_sides.centres_mm

    def on_machine(programs: Mapping[str, Path], tools: Mapping[str, tuple[int, ...]]) -> dict[int, Array]:
        zero = {tool: BOTH[name] for name, of in tools.items() for tool in of}
        return {tool: driven(path, zero[tool], AT[tool]) for tool, path in plain(programs, tools).items()}

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
        ("[gauging]\n", '[gauging]\nz_reference = "1"\n', "z is taken at the device"),
    ],
)
def test_what_places_a_tool_is_stated_once(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = placed(tmp_path, MACHINE + f"work_zero_mm = {list(ZERO)}\n")
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    said = run("compensate", path, "-o", tmp_path / "out", status=3)
    assert "JOB-" in said and words in said and not (tmp_path / "out").exists()


assert set(NOSE_MM) == set(TOOLS)
