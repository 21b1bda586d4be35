"""A run that the computer interrupts is made again; a fault of the program is not."""

import json
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop_lab.linuxcnc import session

Answer = dict[str, object]

BUSY: Answer = {"error": "an error that it does not name", "line": 1}
GAPS: Answer = {"error": None, "overruns": 3, "line": 2}
PROBED: Answer = {"error": "Queue is not empty after probing", "line": 1}
TWICE: Answer = {"error": "joint 0: compensation values must increase", "line": 1}
LATE: Answer = {"error": "LinuxCNC carried out no command within 60 s", "line": None}
FAULT: Answer = {"error": "Linear move on line 2 would exceed joint 0's positive limit", "line": 2}
WHOLE: Answer = {"error": None, "overruns": 0, "line": 2}


def _cut(answers: list[Answer]) -> tuple[object, int]:
    """The positions or the error of a cut whose runs end as stated, and how many runs were made."""
    left = iter(answers)

    def play(folder: Path, progress: object = None) -> None:
        answer = next(left)
        (folder / "linuxcnc.log").write_text(f"{session.TOO_BUSY}\n" if answer in (BUSY, TWICE) else "")
        (folder / "config" / "answer.json").write_text(json.dumps(answer))
        (folder / "config" / "positions.txt").write_text("1.0 2.0\n")

    with mock.patch.object(session, "play", play):
        try:
            result: object = session.cut(b"G1 X1\nG1 X250\nM2\n")
        except TrueloopError as error:
            result = error
    return result, len(answers) - len(list(left))


@pytest.mark.parametrize("first", [BUSY, GAPS, PROBED, TWICE, LATE])
def test_an_interrupted_run_is_made_again(first: Answer) -> None:
    positions, runs = _cut([first, first, WHOLE, WHOLE])
    assert runs == 3
    assert np.array_equal(np.asarray(positions), [[1.0, 2.0]])


def test_three_interrupted_runs_are_reported() -> None:
    error, runs = _cut([BUSY, GAPS, BUSY, WHOLE])
    assert isinstance(error, TrueloopError)
    assert (error.code, runs) == (Code.CTL_LINUXCNC, 3)
    assert "did not answer for a second" in error.message


def test_a_fault_of_the_program_is_reported_at_once() -> None:
    error, runs = _cut([FAULT, WHOLE])
    assert isinstance(error, TrueloopError)
    assert (error.code, runs, error.values["block"]) == (Code.CTL_PROGRAM, 1, "G1 X250")


def test_a_table_that_does_not_increase_is_a_fault_where_the_motion_was_in_time() -> None:
    error, runs = _cut([{**TWICE, "line": 2}, WHOLE])
    assert isinstance(error, TrueloopError)
    assert (error.code, runs) == (Code.CTL_PROGRAM, 1)
