"""A finish pass whose tool has no number, or shares its offset with another tool: no other tool is named."""

from dataclasses import replace
from pathlib import Path

import pytest

from trueloop.domain.life import Ran
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.in_force import in_force, ways_of
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.report.turned.summary import offset_words, to_run
from trueloop.turned.options import By

JOB = """[part]
name = "pin"
start = [15, -30]
[[part.feature]]
name = "seat"
to = [15, 0]
[[part.feature]]
name = "front"
to = [5, 0]
[tool]
nose_radius_mm = 0.8
{number}
[programs]
dialect = "{dialect}"
finish = "finish.nc"
[gauging]
touches = "touches.csv"
[output]
folder = "out"
"""
TOUCHES = "point,feature,nominal_x_mm,nominal_z_mm,error_um\n" + "".join(
    f"{k},seat,15,{-26 + 4 * k},20\n" for k in range(1, 6)
)
TOUCHES += "".join(f"{5 + k},front,{15 - 2 * k},0,0\n" for k in range(1, 5))
CUT = "G0 X10. Z5.\nG42 G1 X10. Z0. F0.1\nX30.\nZ-30.\nG40 X40.\nG0 X100. Z100.\n"
SIEMENS = "G18 G71 G90 G40 DIAMON\n{tool}\nG95 F0.1 G97 S1000 M4\n" + CUT + "M30\n"
FANUC = "O1\nG21 G40 G99\n{tool}\nG97 S1000 M3\n" + CUT + "M30\n"


def corrected(folder: Path, dialect: str, text: str, by: By, number: str = "") -> Correction:
    (folder / "job.toml").write_text(JOB.format(dialect=dialect, number=number))
    (folder / "finish.nc").write_text(text)
    (folder / "touches.csv").write_text(TOUCHES)
    inputs = read_job(folder / "job.toml").inputs
    return compensate(replace(inputs, options=replace(inputs.options, by=by)))


NAMELESS = [("siemens", SIEMENS.format(tool='T="FINISH_OD" D1')), ("fanuc-lathe", FANUC.format(tool="(no tool)"))]


@pytest.mark.parametrize(("dialect", "text"), NAMELESS)
def test_its_offset_is_refused_without_the_number(tmp_path: Path, dialect: str, text: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        corrected(tmp_path, dialect, text, "offset")
    assert refused.value.code is Code.OFS_TOOL and refused.value.place.line == (6 if dialect == "siemens" else 7)
    found = corrected(tmp_path, dialect, text, "offset", "number = 7")
    assert found.wear.answer.startswith("T7 wear X")
    assert all("[7,1]" in block or "P7" in block for block in found.wear.blocks)


@pytest.mark.parametrize(("dialect", "text"), NAMELESS)
def test_its_contour_is_corrected_and_no_tool_is_named(tmp_path: Path, dialect: str, text: str) -> None:
    found = corrected(tmp_path, dialect, text, "contour")
    assert b"X29.96" in found.corrected_program
    assert found.wear.tool == 0 and found.wear.blocks == ()
    assert found.wear.answer.startswith("the finishing tool (its number is not known) wear X")


def test_the_second_edge_of_a_sinumeriks_tool_is_named(tmp_path: Path) -> None:
    found = corrected(tmp_path, "siemens", SIEMENS.format(tool="T3 D2"), "offset")
    assert found.wear.answer.startswith("T3 D2 wear X −0.0200 mm (radius)")
    assert found.wear.blocks[0] == "$TC_DP12[3,2]=$TC_DP12[3,2]-0.0200"
    assert (
        found.record.tool_offset is not None and found.record.tool_offset.held.edge == 2
    )  # `offsets program` reads it
    nameless = SIEMENS.format(tool='T="FINISH_OD" D2')
    assert corrected(tmp_path, "siemens", nameless, "offset", "number = 3").wear.blocks == found.wear.blocks
    for edge in (1, 3):
        with pytest.raises(TrueloopError, match=f"edge {edge}.*edge 2") as refused:
            corrected(tmp_path, "siemens", SIEMENS.format(tool="T3 D2"), "offset", f"table_edge = {edge}")
        assert refused.value.code is Code.OFS_TOOL and refused.value.hint.startswith("tool.table_edge = 2")


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("siemens", SIEMENS.format(tool="T3 D0")),
        ("fanuc-lathe", FANUC.format(tool="T0300")),
        ("okuma-lathe", FANUC.format(tool="TG=3 OG=0").replace("O1\nG21 G40 G99", "G40 G95").replace("M30", "M02")),
        ("linuxcnc", FANUC.format(tool="G7 G18 T3 M6").removeprefix("O1\n").replace("G99", "G95")),
    ],
)
def test_an_offset_that_is_not_in_force_is_not_changed(tmp_path: Path, dialect: str, text: str) -> None:
    """T0300, D0 and T3 without G43 leave the row of the table out of the cut: its wear would move nothing."""
    number = 'number = 3\n[compensation]\nby = "auto"'
    stated = JOB.replace('dialect = "{dialect}"', 'dialect = "{dialect}"\nunit = "mm"') if dialect[0] == "o" else JOB
    asked_for: tuple[tuple[By, str], ...] = (("offset", ""), ("auto", ""), ("auto", number))
    for by, also in asked_for:
        (tmp_path / "job.toml").write_text(stated.format(dialect=dialect, number=also))
        (tmp_path / "finish.nc").write_text(text)
        (tmp_path / "touches.csv").write_text(TOUCHES)
        inputs = read_job(tmp_path / "job.toml").inputs
        asked = replace(inputs, options=replace(inputs.options, by=by))
        if by == "offset" and dialect == "okuma-lathe":
            with pytest.raises(TrueloopError) as refused:
                compensate(asked)
            assert refused.value.code is Code.OFS_TOOL and "without the tool's offset" in refused.value.message
            continue
        if by == "offset":  # the program shifts its contour by itself
            shifted = compensate(asked)
            assert (b"ATRANS" if dialect == "siemens" else b"G52") in shifted.corrected_program
            assert shifted.wear.tool == 0 and shifted.wear.blocks == () and shifted.by_tool is None
            assert "not to be entered" in offset_words(shifted) and "enter" not in to_run(shifted)
            assert any("would move nothing" in note for note in shifted.notes)
            assert ways_of(shifted.record) == (Ran.OFFSETS,)
            with pytest.raises(TrueloopError, match="is carried out by \"offsets\", not by 'wear'") as refused:
                in_force(shifted.record, Ran.WEAR, inputs.program, None)
            assert refused.value.code is Code.CMP_CUT_WITH
            assert in_force(shifted.record, None, inputs.program, None).cut_with.ran is Ran.OFFSETS
            continue
        found = compensate(asked)
        assert b"X29.96" in found.corrected_program and found.record.tool_offset is None and found.by_tool is None
        assert found.wear.tool == 0 and found.wear.blocks == () and not found.decision.by_offset
        assert "not to be entered" in offset_words(found)


def test_no_number_is_given_for_a_tool_that_the_finish_pass_does_not_run_with(tmp_path: Path) -> None:
    """The job states tool 99, the program cuts with T0303: register 99 would move another tool."""
    text = FANUC.format(tool="T0303")
    with pytest.raises(TrueloopError) as refused:
        corrected(tmp_path, "fanuc-lathe", text, "offset", "number = 99")
    assert refused.value.code is Code.OFS_TOOL and "offset 3" in refused.value.message
    found = corrected(tmp_path, "fanuc-lathe", text, "contour", "number = 99")
    assert found.wear.tool == 0 and found.wear.blocks == ()
    assert any("would move another tool" in note for note in found.notes)
    assert corrected(tmp_path, "fanuc-lathe", text, "contour", "number = 3").wear.tool == 3


def test_two_tools_of_one_offset_number_are_not_corrected_by_it(tmp_path: Path) -> None:
    """T0101 roughs, T0201 finishes: wear 1 moves the cuts of both."""
    rough = "T0101\nG0 X42. Z5.\nG1 Z-30. F0.3\nG0 X50.\nZ5.\nT0201"
    with pytest.raises(TrueloopError) as refused:
        corrected(tmp_path, "fanuc-lathe", FANUC.format(tool=rough), "offset")
    assert refused.value.code is Code.NC_OFFSET and "T0101, T0201" in str(refused.value)
    found = corrected(tmp_path, "fanuc-lathe", FANUC.format(tool=rough), "auto")
    assert b"X29.96" in found.corrected_program
    assert any("T0101, T0201" in note for note in found.notes)


def test_a_program_never_gets_a_block_number_twice(tmp_path: Path) -> None:
    """Operations N1 and N2: a block N2 behind N1 would be found first by a search or a GOTO 2."""
    tool = "N1 (ROUGH)\nT0101\nG0 X42. Z5.\nN2 (FINISH)\nT0303"
    found = corrected(tmp_path, "fanuc-lathe", FANUC.format(tool=tool).replace("O1\n", "O1\nN1\n", 1), "offset")
    assert found.offsets_program is not None
    lines = found.offsets_program.decode().splitlines()
    assert sum(line.startswith("N2") for line in lines) == 1
    assert any(line.startswith("G52 X-0.04") for line in lines)
