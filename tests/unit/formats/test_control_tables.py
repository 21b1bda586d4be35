"""Tables read back by readers of their own: a control that adds their values to commands goes where it should."""

import re

import numpy as np
import pytest

from tests.support.machines import chain_with_travel, random_model
from trueloop.formats.control_tables import CAUTION, heidenhain_cma, heidenhain_com, siemens_cec
from trueloop.geometry.feature import Array
from trueloop.machine.axis_table import AxisTable, axis_table
from trueloop.machine.model import Machine, MachineModel, State
from trueloop.machine.names import error_name
from trueloop.machine.position_basis import segments
from trueloop.machine.term import Part, Term

MILL = Machine("mill", chain_with_travel("mill-gantry"))
AT = np.linspace(3.0, 497.0, 67)


def _model(error: str, both_ways: bool) -> MachineModel:
    term = Term(error_name(error), (Part(segments(0.0, 500.0, 3, 3)),), both_ways=both_ways)
    return random_model(MILL, (term,), np.random.default_rng(85))


def _read_cec(text: str) -> list[tuple[str, str, int, Array, Array]]:
    """(input, output, direction, positions, values) a table: by the manual's names, `;` begins a comment."""
    lines = [line.split(";")[0].strip() for line in text.splitlines()]
    set_to = dict(line[1:].split("=") for line in lines if line.startswith("$"))
    numbers = sorted({int(found[1]) for name in set_to if (found := re.fullmatch(r"AN_CEC\[(\d+),\d+\]", name))})
    tables = []
    for t in numbers:
        low, high, step = (float(set_to[f"AN_CEC_{name}[{t}]"]) for name in ("MIN", "MAX", "STEP"))
        count = round((high - low) / step) + 1
        values = np.array([float(set_to[f"AN_CEC[{t},{n}]"]) for n in range(count)])
        assert f"AN_CEC[{t},{count}]" not in set_to
        axes = [set_to[f"AN_CEC_{way}_AXIS[{t}]"].strip("()") for way in ("INPUT", "OUTPUT")]
        tables.append((*axes, int(set_to[f"AN_CEC_DIRECTION[{t}]"]), low + step * np.arange(count), values))
    return tables  # type: ignore[return-value]


def _read_com(text: str) -> dict[str, Array]:
    lines = text.splitlines()
    assert lines[0].startswith("BEGIN ") and lines[0].endswith(".COM MM") and lines[-1] == "[END]"
    rows = np.array([[float(cell) for cell in line.split()] for line in lines[2:-1]])
    assert list(rows[:, 0]) == list(range(len(rows)))
    return dict(zip(lines[1].split(), rows.T, strict=True))


def _added(text: str, output: str, way: float) -> Array:
    """What the control adds to `output` at AT, X having come that way."""
    if text.startswith("%_N_NC_CEC_INI"):
        numbered = {"X": "AX1", "Y": "AX2"}
        return sum(
            (
                np.interp(AT, at, values)
                for axis, to, direction, at, values in _read_cec(text)
                if axis == "AX1" and to == numbered[output] and direction in (0, way)
            ),
            np.zeros(len(AT)),
        )
    table = _read_com(text)
    column = table["BACKLASH"] if way < 0 and "BACKLASH" in table else table[output]
    return np.interp(AT, table["AXISPOS"], column)


@pytest.mark.parametrize("write", [siemens_cec, heidenhain_com])
@pytest.mark.parametrize(("error", "output"), [("EXX", "X"), ("EYX", "Y")])
@pytest.mark.parametrize("both_ways", [False, True])
def test_what_the_control_adds_undoes_the_error_up_to_the_table(
    write: object, error: str, output: str, both_ways: bool
) -> None:
    model = _model(error, both_ways)
    table = axis_table(model, "X", output, 101, {})
    text: str = write(table)  # type: ignore[operator]
    for way in (1.0, -1.0):
        added = _added(text, output, way)
        command = AT + (added if output == "X" else 0.0)
        state = State(MILL.chain.positions({"X": command}), way)
        error_mm = model.error_mm(state)[:, "XY".index(output)]
        left = np.abs(added + error_mm).max()
        # its five or six digits, and the slope of the error over the correction
        assert left < table.deviation_mm + 1e-5 < 0.01 * np.abs(error_mm).max()
    assert np.allclose(_added(write(table, opposite=True), output, 1.0), -_added(text, output, 1.0))  # type: ignore[operator]


def test_files_say_that_their_sign_was_not_tried() -> None:
    table = AxisTable("X", "X", np.arange(3.0), np.arange(3.0) / 1000, np.arange(3.0) / 1000, 0.0, 0.0)
    assert all(words in siemens_cec(table) for words in CAUTION)
    assert "TRY-SIGN-FIRST" in heidenhain_com(table)
    assert heidenhain_cma("X", "x.com").splitlines()[1:3] == ["NR      ACTIVE  X", "0       *       x.com"]


def test_the_stated_deviation_is_the_largest_between_entries() -> None:
    model = _model("EXX", True)
    table = axis_table(model, "X", "X", 11, {})
    at = np.linspace(0, 500, 20001)
    state = State(MILL.chain.positions({"X": at}), 1.0)
    back = State(MILL.chain.positions({"X": at}), -1.0)
    off = [np.abs(table.error_mm(at, way) - model.error_mm(s)[:, 0]).max() for way, s in ((1, state), (-1, back))]
    assert max(off) == pytest.approx(table.deviation_mm, rel=0.01)
