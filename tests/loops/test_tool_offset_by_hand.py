"""The tool offset as numbers to enter, whatever else is written: sign, factor of two, unit, and what it leaves."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_contour_under_g42 import OWN_SHIFT, PIN, pin
from tests.support.cli import invoke
from tests.support.correction import example_correction, example_inputs
from tests.support.linuxcnc import Tool, interpret
from tests.support.machined_path import distances_mm, interpreted_points
from trueloop.arrays import Array
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.called import CalledOffset, called
from trueloop.nc.program.program import read_program
from trueloop.report.turned.correction_json import correction_as_dict
from trueloop.report.turned.page import page
from trueloop.turned.options import By
from trueloop.turned.program.wear_numbers import WearOffset, wear_offset

NOSE = Tool(1, nose_radius_mm=0.79375, orientation=9)
OVERSIZE_MM = (0.012, -0.004)
"""A part 24 µm too thick and 4 µm too short: the tool has to go 12 µm in on the radius, and 4 µm out along z."""


def test_a_contour_of_g71_and_g70_that_no_shift_can_stand_around_gets_numbers() -> None:
    correction = pin(OWN_SHIFT, OVERSIZE_MM)
    assert correction.decision.by_offset and correction.offsets_program is None
    u = correction.decision.expanded_u_mm
    assert u == pytest.approx((0.0056, 0.0056), abs=0.0004)  # 1.96 · √2 · 2 µm of two cuts, and little of the touches
    assert correction.wear.words == "tool 3: wear X \u22120.024 (diameter), Z +0.004 mm (X ± 0.011, Z ± 0.006)"
    kept = correction.record.tool_offset
    assert kept is not None and kept.expanded_u_mm == pytest.approx(u)
    assert WearOffset.of(kept, "radius").expanded_u == pytest.approx(u)
    assert correction.wear.blocks == ("G21 G10 P3 U-0.024 W0.004",)
    assert correction.corrected_program == OWN_SHIFT
    assert correction.name_to_run == "program.nc"
    assert np.max(np.abs(correction.prediction.after_mm)) < 2e-4
    assert "tool 3: wear X \u22120.024" in page(correction)


def test_nothing_that_looks_like_a_corrected_program_is_written(tmp_path: Path) -> None:
    """The numbers are the correction: the summary, the JSON and the report say them, and which program to run."""
    places = [(28, -50, 1, 0), (23, -35, 0, 1), (22, -35, 0, 1), (15, -20, 1, 0), (15, -8, 1, 0)]
    rows = [
        f"{k},{x},{z},{1000 * (nx * OVERSIZE_MM[0] + nz * OVERSIZE_MM[1]) + (0.1, -0.1)[k % 2]}"
        for k, (x, z, nx, nz) in enumerate(places)
    ]
    (tmp_path / "finish.nc").write_bytes(OWN_SHIFT)
    (tmp_path / "touches.csv").write_text("\n".join(["point,nominal_x_mm,nominal_z_mm,error_um", *rows, ""]))
    (tmp_path / "job.toml").write_text(
        '[part]\nname = "pin"\nfrom_program = true\n[tool]\nnose_radius_mm = 0.4\n'
        '[programs]\ndialect = "fanuc-lathe"\nfinish = "finish.nc"\n[gauging]\ntouches = "touches.csv"\n'
    )
    told = invoke("compensate", tmp_path / "job.toml", "-o", tmp_path / "out", status=0).stdout
    assert "(X ± 0.011, Z ± 0.006) (enter it at the control once, then run finish.nc" in told
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        "record.json", "report.html", "report.json", "table.csv",
    ]  # fmt: skip
    answer = json.loads(invoke("compensate", tmp_path / "job.toml", "-o", tmp_path / "out", "--json", status=0).stdout)
    assert (answer["tool_offset"]["x"], answer["tool_offset"]["z"]) == (-0.024, 0.004)
    assert answer["program_to_run"] == "finish.nc"
    assert max(abs(row["worst_um"]) for row in answer["tool_offset"]["leaves"]) < 0.3


def test_it_is_told_beside_a_corrected_contour_with_what_it_leaves() -> None:
    """By arithmetic of its own: measured errors plus the offset that the words say, in inches of diameter."""
    correction = example_correction("modbas2")
    wear = correction.wear
    assert (wear.tool, wear.unit, wear.x_is_diameter) == (1, "inch", True)
    moved = correction.touches.outward_normal @ np.array([wear.x / 2, wear.z]) * 25.4
    left_um = (correction.touches.error_mm + moved) * 1e3
    offset = correction_as_dict(correction)["tool_offset"]
    assert isinstance(offset, dict)
    worst = max((row["worst_um"] for row in offset["leaves"]), key=abs)
    assert worst == pytest.approx(left_um[np.argmax(np.abs(left_um))], abs=0.3)
    assert abs(worst) > 50


@pytest.mark.parametrize(
    ("dialect", "head", "is_diameter", "blocks"),
    [
        ("fanuc-lathe", "O1\nG21 T0305", None, ("G21 G10 P5 U-0.024 W0.004",)),
        ("fanuc-lathe", "O1\nG21 T0305", False, ("G21 G10 P5 U-0.012 W0.004",)),
        ("haas-lathe", "O00001\nG21 T505", None, ("G21 G10 L11 P5 U-0.024 W0.004",)),
        (
            "siemens",
            "G18 G71 G90 DIAMON T5",
            None,
            ("$TC_DP12[5,1]=$TC_DP12[5,1]-0.0120", "$TC_DP13[5,1]=$TC_DP13[5,1]+0.0040"),
        ),
        ("siemens", "G18 G70 G90 DIAMON T5", None, ()),
        ("ge2000t", "G71 G90 T0505", None, ("(UPD, 5, TOV(X), -0.0240)", "(UPD, 5, TOV(Z), 0.0040)")),
        (
            "ge2000t",
            "(UPD, 5, TOV(X), 0.1)\n(UPD, 5, TOV(Z), 0.2)\nG71 G90 T0505",
            None,
            ("(UPD, 5, TOV(X), 0.0760)", "(UPD, 5, TOV(Z), 0.2040)"),
        ),
        ("heidenhain", "BEGIN PGM A MM\nTOOL CALL 5 Z\nL Z+3 R0 FMAX", None, ()),
    ],
)
def test_in_each_controls_own_words(dialect: str, head: str, is_diameter: bool | None, blocks: tuple[str, ...]) -> None:
    tail = "L X+20 Z-20 F100\n" if dialect == "heidenhain" else "G0 X20. Z5.\nG1 Z-20. F.1\n"
    program = read_program(f"{head}\n{tail}".encode(), dialect)
    path = program.run()
    call = called(program.dialect, path, len(path) - 1)
    assert call == CalledOffset(5)
    found = wear_offset(program, path, len(path) - 1, (-0.012, 0.004), 5, is_diameter)
    assert found.blocks == blocks


@pytest.mark.parametrize(("mode", "x"), [("G7", "60"), ("G8", "30")])
@pytest.mark.parametrize(("unit", "mm"), [("G21", 1.0), ("G20", 25.4)])
def test_linuxcncs_interpreter_moves_the_tool_by_it(tmp_path: Path, mode: str, x: str, unit: str, mm: float) -> None:
    """The blocks call the tool and change its offset: positions afterwards lie off by it, x as a radius."""
    plain = [f"{unit} {mode} G18 G40 G90 G94 F10", "T3 M6", "G43"]
    course = [f"{mode} G0 X{x} Z5", "G1 Z-20 F10", "M2", ""]
    program = read_program("\n".join([*plain, *course]).encode(), "linuxcnc")
    wear = wear_offset(program, program.run(), 1, (-0.012, 0.004), 3, None)
    ends = []
    for name, blocks in (("plain", plain), ("worn", wear.blocks)):
        (tmp_path / name).write_text("\n".join([*blocks, *course]))
        tool = Tool(3, 0.4, x_offset_mm=3.0, z_offset_mm=7.0)
        ends.append(np.array([move.machine_mm for move in interpret(tmp_path / name, tools=[tool])]))
    moved: Array = ends[1] - ends[0]
    step_mm = 1e-6 * mm if unit == "G20" else 1e-5
    assert moved == pytest.approx(np.tile([-0.012, 0.0, 0.004], (2, 1)), abs=step_mm)


def by(name: str, choice: By, error_mm: tuple[float, float] | None = None) -> Correction:
    inputs = example_inputs(name)
    touches = inputs.touches
    if error_mm is not None:  # z counts from no face: an offset along Z shows
        none = np.zeros_like(touches.at_reference)
        touches = replace(touches, error_mm=touches.outward_normal @ np.array(error_mm), at_reference=none)
    return compensate(replace(inputs, touches=touches, options=replace(inputs.options, by=choice)))


def test_an_offset_can_be_chosen_whatever_it_leaves() -> None:
    """What remains at every feature stands in the table, the prediction and the summary."""
    correction = by("modbas2", "offset")
    assert not correction.decision.offset_is_enough
    assert correction.name_to_run == "offsets.nc"
    assert correction.prediction.after_mm == pytest.approx(correction.left_by_offset_mm, abs=1e-9)
    assert np.max(np.abs(correction.prediction.after_mm)) > 0.05
    assert any("by offset, whatever the test says" in note for note in correction.notes)


def test_the_contour_can_carry_what_an_offset_could(tmp_path: Path) -> None:
    """The path of LinuxCNC's interpreter is the source's moved by the offset, on the dome and about the edges too."""
    correction = by("linuxcnc", "contour", (0.02, -0.01))
    assert correction.decision.offset_is_enough and correction.name_to_run == "corrected.ngc"
    source = [p.shifted.centre_mm(np.linspace(p.start_mm, p.end_mm, 200)) for p in correction.commanded]
    old = np.insert(np.concatenate(source), 1, 0.0, axis=1)
    new, _ = interpreted_points(correction.corrected_program.decode(), tmp_path, "corrected", 0.001, [NOSE])
    assert np.max(distances_mm(old + np.array([-0.02, 0.0, 0.01]), new)) < np.hypot(0.0005, 0.0006)
    assert np.max(distances_mm(old + np.array([0.02, 0.0, -0.01]), new)) > 0.03
    assert any("by contour, whatever the test says" in note for note in correction.notes)


def test_the_job_names_the_tool_and_a_program_that_calls_another_is_noticed() -> None:
    assert pin(PIN.read_bytes(), OVERSIZE_MM).wear.tool == 3
    inputs = example_inputs("modbas2")
    named = compensate(replace(inputs, options=replace(inputs.options, tool=7)))
    assert named.wear.tool == 0  # register 7 would move another tool
    assert any("The job says tool 7; the finish pass" in note for note in named.notes)
