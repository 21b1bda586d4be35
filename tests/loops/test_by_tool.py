"""The answer by tool comes first where an offset does most of the work, with what it moves and what it leaves."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_contour_under_g42 import OWN_SHIFT
from tests.loops.test_tool_table_of_a_job import job
from tests.support.cli import run
from tests.support.correction import example_correction, example_inputs, size_error_correction
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.report.turned.touch_table import by_tool_as_dict, by_tool_block, by_tool_lines
from trueloop.turned.options import By
from trueloop.turned.program.by_tool import ByTool, MovedFeature

ANSWER = "T3 wear X \u22120.024 mm (diameter), Z +0.004 (X \u00b1 0.011, Z \u00b1 0.006)"
PLAIN = "number = 3\nnose_radius_mm = 0.4"


def by_tool_of(path: Path, by: By = "auto") -> ByTool:
    inputs = read_job(path).inputs
    found = compensate(replace(inputs, options=replace(inputs.options, by=by))).by_tool
    assert found is not None
    return found


def test_it_is_the_first_line_of_the_summary_and_stands_in_record_json_and_page(tmp_path: Path) -> None:
    path = job(tmp_path, PLAIN)
    printed = run("compensate", path, "-o", tmp_path / "out")
    assert printed.startswith(f"{ANSWER}\n")
    answer = json.loads(run("compensate", path, "-o", tmp_path / "out", "--json"))["by_tool"]
    assert answer["words"] == ANSWER and answer["comes_first"]
    record = json.loads((tmp_path / "out" / "record.json").read_text())
    assert f"{ANSWER}." in record["decision"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert page.index("id='by-tool'") < page.index("id='wear'")
    assert "X \u22120.024 mm (diameter)" in page


def test_terminal_page_and_record_name_what_to_run_and_the_offset_as_instead_of_it(tmp_path: Path) -> None:
    """Whoever runs the corrected program and enters the offset corrects twice."""
    path = job(tmp_path, PLAIN)
    path.write_text(f'{path.read_text()}\n[compensation]\nby = "contour"\n')
    printed = run("compensate", path, "-o", tmp_path / "out")
    assert "(instead of corrected.nc, not with it;" in " ".join(printed.split()) and "Run corrected.nc." in printed
    page = (tmp_path / "out" / "report.html").read_text()
    section = page[page.index("id='to-run'") : page.index("id='by-tool'")]
    assert "Run <code>corrected.nc</code>, the tool offset as it is." in section
    assert "instead of it, not with it" in section
    told = json.loads((tmp_path / "out" / "report.json").read_text())
    record = json.loads((tmp_path / "out" / "record.json").read_text())
    assert told["program_to_run"] == "corrected.nc"
    assert f"Instead of the corrected contour, not with it: {ANSWER}." in record["decision"]


def test_every_feature_that_the_tool_cuts_is_moved_along_its_normal(tmp_path: Path) -> None:
    """By hand: the offset is −12 µm on the radius and +4 µm along z. A cylinder faces x, a face z, the cone both."""
    moved = {one.feature: one for one in by_tool_of(job(tmp_path, PLAIN)).features}
    for name, um in {"cylinder-1": -12, "cylinder-2": -12, "face-1": 4, "face-2": 4, "cone-1": -8 / 2**0.5}.items():
        assert (moved[name].low_mm, moved[name].high_mm) == pytest.approx((um / 1e3, um / 1e3), abs=2e-4), name
    assert (moved["arc-1"].low_mm, moved["arc-1"].high_mm) == pytest.approx((-0.012, 0.004), abs=2e-4)
    assert {name for name, one in moved.items() if one.touched} == {"cylinder-1", "cylinder-2", "face-1"}
    assert not any(one.against for one in moved.values())
    assert "cone-1 −5.7 µm (not measured)" in by_tool_of(job(tmp_path, PLAIN)).moved_words


def test_its_share_is_what_of_the_correction_an_offset_leaves_out() -> None:
    """Computed anew on MODBAS2, from the curves: 1 − rms(c − n·o)/rms(c), evenly along the touched features."""
    correction = example_correction("modbas2")
    found = correction.by_tool
    assert found is not None
    squares = np.zeros(2)
    for index, piece in enumerate(correction.commanded):
        if not len(correction.touches.of_feature(index)):
            continue
        feature = piece.shifted.feature
        low, high = max(piece.start_mm, 0.0), min(piece.end_mm, feature.length_mm)
        s = np.linspace(low, high, 801)
        own = -correction.model.curves[index].value_mm(s)
        left = own - feature.outward_normal(s) @ np.array(correction.decision.offset_mm)
        squares += (high - low) * np.array([np.mean(own**2), np.mean(left**2)])
    assert found.share == pytest.approx(1 - np.sqrt(squares[1] / squares[0]), abs=2e-3)
    assert not found.comes_first and by_tool_lines(correction) == [] and by_tool_block(correction) == ""
    answer = by_tool_as_dict(correction)
    assert answer is not None and answer["share"] == found.share


def test_what_the_contour_would_take_out_beyond_has_its_place() -> None:
    """The dome's own correction and the offset differ most there, by as much as the curves say."""
    correction = example_correction("modbas2")
    found = correction.by_tool
    assert found is not None
    index = correction.profile.names.index(found.beyond_on)
    feature = correction.profile.features[index]
    s = feature.locate([found.at_mm])[0]
    own = -correction.model.curves[index].value_mm(s)
    moved = feature.outward_normal(s) @ np.array(correction.decision.offset_mm)
    assert found.beyond_mm == pytest.approx(float((own - moved)[0]), abs=1e-6)


def test_a_size_error_is_the_offsets_work_and_a_half_weight_stays_so() -> None:
    found = size_error_correction().by_tool
    assert found is not None and found.share > 0.95
    inputs = example_inputs("modbas2")
    touches = replace(inputs.touches, error_mm=0.010 * inputs.touches.outward_normal[:, 0])
    half = compensate(replace(inputs, touches=touches, options=replace(inputs.options, weight=0.5))).by_tool
    assert half is not None and half.share > 0.95


def test_a_feature_that_is_moved_the_wrong_way_is_named(tmp_path: Path) -> None:
    """Cylinder 1 is 6 µm too thin, the others 12 µm too thick: one offset takes still more off it."""
    path = job(tmp_path, PLAIN)
    touches = (tmp_path / "touches.csv").read_text().replace("0,28,-50,12.1", "0,28,-50,-6")
    assert "-6" in touches
    (tmp_path / "touches.csv").write_text(touches)
    found = by_tool_of(path, "offset")
    against = [one for one in found.features if one.against]
    assert [one.feature for one in against] == ["cylinder-1"]
    assert against[0].own_mm == pytest.approx(0.006, abs=2e-4) and against[0].moved_mm < -0.005
    assert "cylinder-1 −6.0 µm (its own correction would be +6.0 µm, the other way)" in found.moved_words


def test_a_feature_that_nobody_touched_is_not_compared() -> None:
    assert not MovedFeature("cone", 0.004, 0.004, -0.006, 0.004, touched=False).against
    assert MovedFeature("cone", 0.004, 0.004, -0.006, 0.004, touched=True).against
    assert not MovedFeature("cone", 0.004, 0.004, -0.0003, 0.004, touched=True).against


def test_other_tools_of_the_program_are_answered(tmp_path: Path) -> None:
    path = job(tmp_path, PLAIN)
    grooving = b"T0505\nG00 X60. Z-50.\nG01 X50. F0.05\nG00 X62.\nG28 U0. W0.\nM30"
    (tmp_path / "finish.nc").write_bytes(OWN_SHIFT.replace(b"M30", grooving))
    assert by_tool_of(path).words == f"{ANSWER}; T5 not measured"


TWO = """%
O1
G21 G18 G40 G99
T0303
G00 X20. Z2.
G01 Z-20. F0.1
X30.
G00 X60. Z5.
T0505
G00 X30. Z-19.
G01 Z-40.
X50.
G00 X60. Z5.
M30
%
"""


def two_tools(folder: Path, more: str = "") -> Path:
    features = ['{ name = "flange", to = [15, -40] }', '{ name = "big", to = [15, -20] }',
                '{ name = "step", to = [10, -20] }', '{ name = "small", to = [10, 0] }']  # fmt: skip
    (folder / "finish.nc").write_text(TWO)
    rows = ["1,15,-35,10.1", "2,15,-25,9.9", "3,10,-15,10.1", "4,10,-5,9.9"]
    (folder / "touches.csv").write_text("\n".join(["point,nominal_x_mm,nominal_z_mm,error_um", *rows, ""]))
    (folder / "job.toml").write_text(
        f'[part]\nname = "two"\nstart = [20, -40]\nfeature = [{", ".join(features)}]\n[tool]\nnose_radius_mm = 0.0\n'
        '[programs]\ndialect = "fanuc-lathe"\nfinish = "finish.nc"\n[gauging]\ntouches = "touches.csv"\n' + more
    )
    return folder / "job.toml"


def test_a_contour_of_two_tools_is_corrected_as_a_contour(tmp_path: Path) -> None:
    """10 µm too thick all over: one tool would get an offset; of two tools no one offset moves all."""
    inputs = read_job(two_tools(tmp_path)).inputs
    correction = compensate(inputs)
    assert correction.by_tool is not None
    assert correction.by_tool.words == "T3 none; T5 none" and not correction.by_tool.comes_first
    assert not correction.decision.by_offset and correction.name_to_run == "corrected.nc"
    assert any("cut with the tool offsets 3, 5" in note for note in correction.notes)
    assert correction.record.tool_offset is not None and not correction.record.tool_offset.makes_the_correction
    with pytest.raises(TrueloopError) as caught:
        compensate(replace(inputs, options=replace(inputs.options, by="offset")))
    assert caught.value.code is Code.NC_OFFSET
