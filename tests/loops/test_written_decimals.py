"""Decimals: a corrected program is never coarser than its source, and finer where it is asked for."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.mapped import FREE, mapped, path_of
from trueloop.domain.option import MapOptions
from trueloop.nc.field import function_field
from trueloop.nc.program.program import read_program

EXAMPLES = Path(__file__).parents[2] / "src/trueloop/examples"
WAVES = function_field(
    lambda p: np.column_stack([0.02 * np.sin(p[:, 1] / 9), 0.02 * np.cos(p[:, 0] / 7), 1e-4 * p[:, 0]]), "waves"
)
"""A field with no round numbers in it."""


def milled(decimals: int) -> str:
    """A path of points with so many decimals."""
    points = [(30 * np.cos(k / 9), 25 * np.sin(k / 7), -k / 90) for k in range(300)]
    first, *others = (f"X{x:.{decimals}f} Y{y:.{decimals}f} Z{z:.{decimals}f}" for x, y, z in points)
    return "\n".join([f"G21 G90 G0 {first}", f"G1 F100. {others[0]}", *others[1:], "M30\n"])


def rms_um(text: str, source: str, dialect: str) -> float:
    """How far the ends written are from where the field takes those of the source."""
    asked = path_of(source, dialect).end_mm
    off = path_of(text, dialect).end_mm - (asked + WAVES.displacement_mm(asked))
    return float(np.sqrt(np.mean(off**2)) * 1e3)


def rounding_um(decimals: int) -> float:
    """RMS of rounding evenly to that many decimals of a millimetre: the step by the root of 12."""
    return float(1e3 * 10.0**-decimals / np.sqrt(12))


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas-mill"])
@pytest.mark.parametrize(("own", "written"), [(3, 3), (4, 4), (5, 5), (2, 3)])
def test_a_mapped_program_has_the_decimals_of_its_source(tmp_path: Path, dialect: str, own: int, written: int) -> None:
    source = milled(own)
    text, _ = mapped(tmp_path, source, WAVES, dialect, MapOptions(limit_mm=np.inf, slope=np.inf, tolerance_mm=1.0))
    assert rms_um(text, source, dialect) == pytest.approx(rounding_um(written), rel=0.1)


def test_more_decimals_are_written_where_they_are_asked_for_and_fewer_never(tmp_path: Path) -> None:
    source = milled(4)
    for asked, written in ((6, 6), (2, 4), (0, 4)):
        options = MapOptions(limit_mm=np.inf, slope=np.inf, tolerance_mm=1.0, decimals=asked)
        text, _ = mapped(tmp_path, source, WAVES, "fanuc-mill", options)
        assert rms_um(text, source, "fanuc-mill") == pytest.approx(rounding_um(written), rel=0.1)


def test_the_finest_word_counts_wherever_it_stands(tmp_path: Path) -> None:
    """The last block of a program of many parts has the decimals."""
    source = "G21 G90 G0 X0. Y0. Z5.\nG1 Z-1. F100.\n" + "X1.\nX2.\n" * 40_000 + "X3.00001\n"
    text, _ = mapped(tmp_path, source, WAVES, "fanuc-mill", FREE)
    assert "X0. Y0.02000 Z5." in text


def test_a_written_out_contour_keeps_its_decimals(tmp_path: Path) -> None:
    source = "G21 G90 G0 X0. Y0. Z0.\nG1 X10.1234 F100.,R2.\nY10.1234\n"
    text, _ = mapped(tmp_path, source, WAVES, "fanuc-mill", FREE)
    written = [word for block in read_program(text.encode(), "fanuc-mill").blocks for word in block.words]
    ends = [word.text for word in written if word.letter in ("X", "Y", "I", "J", "R") and word.text not in source]
    assert ends and all(len(text.partition(".")[2]) >= 4 for text in ends)


def test_a_job_asks_for_more(tmp_path: Path) -> None:
    """NIST's programs have five decimals of an inch; eight are asked for."""
    folder = Path(shutil.copytree(EXAMPLES / "modbas2", tmp_path / "job"))
    text = (folder / "job.toml").read_text()
    (folder / "job.toml").write_text(text.replace("[programs]\n", "[programs]\ndecimals = 8\n"))
    run("compensate", folder / "job.toml", "--output", folder / "fine")
    run("compensate", EXAMPLES / "modbas2/job.toml", "--output", folder / "usual")

    def longest(name: str) -> int:
        changes = json.loads((folder / name / "record.json").read_text())["changes"]
        program = read_program("\n".join(change["after"] for change in changes).encode(), "ge2000t")
        numbers = [word for block in program.blocks for word in block.words if word.letter in "XZIK"]
        return max(len(word.text.partition(".")[2]) for word in numbers if word.kind == "number")

    assert (longest("usual"), longest("fine")) == (5, 8)
