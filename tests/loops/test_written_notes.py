"""What is said of a contour that is computed, or that several tools run on: both change with the correction."""

from pathlib import Path

from tests.loops.test_tool_without_number import FANUC, JOB, TOUCHES
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate

ROUNDED = """[[part.feature]]
name = "seat"
to = [15, -2]
[[part.feature]]
name = "edge"
to = [13, 0]
centre = [13, -2]
turn = "convex"
"""


def corrected(folder: Path, job: str, text: str) -> Correction:
    (folder / "job.toml").write_text(job)
    (folder / "finish.nc").write_text(text)
    (folder / "touches.csv").write_text(TOUCHES.replace("seat,15,-2,", "seat,15,-5,").replace(",13,0,0", ",12,0,0"))
    return compensate(read_job(folder / "job.toml").inputs)


def test_an_arc_by_formulas_is_named_where_numbers_take_its_place(tmp_path: Path) -> None:
    job = JOB.format(dialect="fanuc-lathe", number="number = 1").replace(
        '[[part.feature]]\nname = "seat"\nto = [15, 0]\n', ROUNDED
    )
    job = job.replace("[output]", '[compensation]\nby = "contour"\n[output]')
    text = FANUC.format(tool="T0101\n#101=30.").replace("X30.\nZ-30", "X26.\nG3 X#101 Z-2. R2.\nG1 Z-30")
    found = corrected(tmp_path, job, text)
    line = text.splitlines().index("G3 X#101 Z-2. R2.") + 1
    assert any(f"The arcs of lines {line} are computed" in note for note in found.notes)


def test_tools_that_run_on_one_contour_are_named(tmp_path: Path) -> None:
    job = JOB.format(dialect="fanuc-lathe", number="number = 5").replace(
        "[output]", '[compensation]\nby = "contour"\n[output]'
    )
    calls = "T0303\nM98 P7\nT0505\nM98 P7\nM30\nO7\n"
    cut = FANUC[FANUC.index("G0 X10. Z5.") :].replace("M30\n", "M99\n")
    found = corrected(tmp_path, job, f"O1\nG21 G40 G99 G97 S900 M3\n{calls}{cut}")
    assert any("run 2 times" in note for note in found.notes)
    assert any("T3 cut it too, before or after T5" in note for note in found.notes)
    assert found.wear.tool == 5 and b"X29.96" in found.corrected_program


def _tapered(folder: Path, text: str, job: str = 'number = 1\n[compensation]\nby = "contour"') -> Correction:
    """Corrects the pin, 5 µm too large at the chuck and 25 µm at its end."""
    seat = "".join(f"{k},seat,15,{-26 + 4 * k},{5 * k}\n" for k in range(1, 6))
    (folder / "job.toml").write_text(JOB.format(dialect="fanuc-lathe", number=job))
    (folder / "finish.nc").write_text(text)
    (folder / "touches.csv").write_text(TOUCHES[: TOUCHES.index("\n") + 1] + seat + TOUCHES[TOUCHES.index("6,front") :])
    return compensate(read_job(folder / "job.toml").inputs)


def test_a_line_that_takes_a_computed_coordinate_over_is_named_where_it_has_a_number(tmp_path: Path) -> None:
    text = FANUC.format(tool="T0101\n#101=30.").replace("X30.\n", "X#101\n")
    found = _tapered(tmp_path, text)
    line = text.splitlines().index("Z-30.") + 1
    assert any(f"In lines {line} a coordinate" in note for note in found.notes)
    assert not any("a coordinate that" in note for note in _tapered(tmp_path, text.replace("X#101", "X30.")).notes)


def test_a_tip_under_compensation_is_not_stated_to_be_without(tmp_path: Path) -> None:
    compensated = FANUC.format(tool="T0101")
    job = 'number = 1\ntip = 3\n[compensation]\nby = "contour"'
    assert not any("imaginary tip" in note for note in _tapered(tmp_path, compensated, job).notes)
