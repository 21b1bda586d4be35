"""Every way in which a correction is refused as a table by program line."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import pytest

from tests.support.correction import EXAMPLES, example_inputs
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.realtime.image import Placing, table_of_job
from trueloop.loops.realtime.process_table import PlacedCorrection, process_table
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.program import read_program

NAMED = b"G64 P0.0001 (keep to the path: corners rounded by 0.0001 in at most)"
WAY_IN = b"G1 X[#46+2.2+0.0625] Z[-6.44375+[3.6-#46]/2] (to the collar)\n"
COLLAR = b"G1 X[#46+2.2+0.0625] Z[-6.14375+[3.6-#46]/2] (collar)\n"
LAST = b"G1 X-0.0625 (a little past the axis)\n"


def _table(*changes: tuple[bytes, bytes]) -> object:
    """That of the example for LinuxCNC, its finish program changed."""
    inputs = example_inputs("linuxcnc")
    source = inputs.program.source
    for before, after in changes:
        assert source.count(before) == 1
        source = source.replace(before, after)
    inputs = replace(inputs, program=read_program(source, "linuxcnc", "finish.ngc"))
    return process_table(inputs.program, inputs.run, compensate(inputs), PlacedCorrection((100.0, -300.0)))


def _named(mode: bytes, *changes: tuple[bytes, bytes]) -> object:
    return _table((NAMED, mode), *changes)


IN_A_SUBPROGRAM = ((WAY_IN, b"O100 sub\n"), (LAST, LAST + b"O100 endsub\n" + WAY_IN + b"O100 call\n"))
SPLIT = (b"G1 X[#46+0.0625] Z[-1.76875", b"G1 X[#46+0.0625] Z-3\nG1 X[#46+0.0625] Z[-1.76875")
"""The main cylinder in two blocks."""

PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.RTC_LINE: partial(_table, *IN_A_SUBPROGRAM),
    Code.RTC_PATH_MODE: partial(_named, NAMED, SPLIT),
    Code.RTC_TABLE: partial(table_of_job, EXAMPLES / "linuxcnc" / "job.toml", Placing()),
}


def refused(produce: Callable[[], object]) -> TrueloopError:
    with pytest.raises(TrueloopError) as caught:
        produce()
    return caught.value


def test_a_subprogram_is_refused_with_its_line_and_how_often_it_runs() -> None:
    error = refused(PRODUCERS[Code.RTC_LINE])
    assert error.values == {"line": 17, "times": 1} and "called by line 27" in error.message


@pytest.mark.parametrize("mode", [b"G61", b"G61.1", b"G64 P0.0001 Q0", b"G64 P0.0001 Q0."])
def test_blocks_that_stay_apart_need_no_q(mode: bytes) -> None:
    assert _named(mode, SPLIT)


@pytest.mark.parametrize(
    ("mode", "words"),
    [
        (b"G64", "rounded without a bound"),
        (b"G64 P0", "rounded without a bound"),
        (b"G64 P[1/1000] Q0", "rounded without a bound"),
        (b"G64 P0.005 Q0", "rounded by up to 0.1270 mm; a row of the table holds 0.1 mm"),
        (b"", "no path mode is named before line 16"),
    ],
)
def test_a_path_that_is_left_by_more_than_the_gate_is_refused(mode: bytes, words: str) -> None:
    """P is in the program's unit: 0.005 inch are more than a tenth of a millimetre."""
    error = refused(partial(_named, mode))
    assert error.code is Code.RTC_PATH_MODE and words in error.message and "G64 P0.0001 Q0" in str(error.hint)


@pytest.mark.parametrize(("q", "merged"), [(b"Q0.001", True), (b"Q0.00001", True), (b"Q0", False)])
def test_q_says_what_is_merged(q: bytes, merged: bool) -> None:
    bent = (b"G1 X[#46+0.0625] Z[-1.76875", b"G1 X[#46+0.0626] Z-3\nG1 X[#46+0.0625] Z[-1.76875")
    straight = q != b"Q0.001"  # half of 0.0001 inch off the straight way: within Q0.001
    produce = partial(_named, b"G64 P0.0001 " + q, SPLIT if straight else bent)
    if merged:
        assert "lines 20 and 21" in refused(produce).message
    else:
        assert produce()


def test_where_no_q_is_named_p_says_what_is_merged() -> None:
    error = refused(PRODUCERS[Code.RTC_PATH_MODE])
    assert error.code is Code.RTC_PATH_MODE and "lines 20 and 21 go straight on within 0.0025 mm" in error.message


def test_a_mode_that_changes_in_the_pass_holds_from_there() -> None:
    opened = (COLLAR, COLLAR + b"G64\n")
    error = refused(partial(_table, opened))
    assert error.code is Code.RTC_PATH_MODE and error.place.line == 18


def test_a_corrected_program_gets_no_table() -> None:
    """Of the corrected program nothing more is to be corrected, by a program or by a table."""
    inputs = example_inputs("linuxcnc")
    correction = compensate(inputs)
    corrected = read_program(correction.corrected_program, "linuxcnc", "corrected.ngc")
    error = refused(partial(process_table, corrected, inputs.run, correction, PlacedCorrection((0.0, 0.0))))
    assert error.code is Code.CMP_TWICE


def test_the_program_of_another_correction_gets_no_table() -> None:
    """A cone shifted by 10 µm is another contour than the one that was corrected."""
    inputs = example_inputs("linuxcnc")
    other = read_program(inputs.program.source.replace(b"#47 = 0 ", b"#47 = 0.0004 "), "linuxcnc", "finish.ngc")
    error = refused(partial(process_table, other, inputs.run, compensate(inputs), PlacedCorrection((0.0, 0.0))))
    assert error.code is Code.RTC_TABLE and "µm off the one that was corrected" in error.message


def test_other_controls_have_no_table() -> None:
    error = refused(partial(table_of_job, EXAMPLES / "modbas2" / "job.toml", Placing((0.0, 0.0))))
    assert error.code is Code.CTL_DIALECT and error.values == {"dialect": "ge2000t"}


def test_a_line_that_runs_twice_is_refused() -> None:
    """The pass before the last and the last, by one loop; corrected as if there were the last alone."""
    inputs = example_inputs("linuxcnc")
    back = b"G0 Z1\nG0 X8\nG0 Z-8\n#46 = 3.52\nO1 endrepeat\n"
    source = inputs.program.source.replace(WAY_IN, b"#46 = 3.72\nO1 repeat [2]\n" + WAY_IN).replace(LAST, LAST + back)
    looped = read_program(source, "linuxcnc", "finish.ngc")
    error = refused(partial(process_table, looped, inputs.run, compensate(inputs), PlacedCorrection((0.0, 0.0))))
    assert error.code is Code.RTC_LINE and error.values == {"line": 18, "times": 2}
