"""Tables read back by readers of their own: a control that adds their values to commands goes where it should."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.machines import chain_with_travel, random_model
from trueloop.arrays import Array
from trueloop.formats.tables.control_tables import CAUTION, heidenhain_cma, heidenhain_com, siemens_cec
from trueloop.machine.correct import AxisTable, axis_table
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import Part, Term, segments

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


def _read_cma(path: Path) -> dict[str, Path]:
    """The tables in force by the axis whose position they run over: those of the one line that is active."""
    lines = path.read_text().splitlines()
    assert lines[0].split()[0] == "BEGIN" and lines[0].endswith(".CMA") and lines[-1] == "[END]"
    columns, *rows = [line.split() for line in lines[1:-1]]
    assert columns[:2] == ["NR", "ACTIVE"] and [row[0] for row in rows] == [str(n) for n in range(len(rows))]
    (active,) = [row for row in rows if row[1] == "*"]
    return {axis: path.with_name(name) for axis, name in zip(columns[2:], active[2:], strict=True)}


def _siemens(folder: Path, table: AxisTable, *, opposite: bool = False) -> None:
    (folder / "cec.ini").write_text(siemens_cec(table, opposite=opposite))


def _heidenhain(folder: Path, table: AxisTable, *, opposite: bool = False) -> None:
    (folder / "x.com").write_text(heidenhain_com(table, opposite=opposite))
    (folder / "axes.cma").write_text(heidenhain_cma(table.input_axis, "x.com"))


def _added(folder: Path, output: str, way: float) -> Array:
    """What the control adds to `output` at AT, X having come that way."""
    if (folder / "cec.ini").exists():
        numbered = {"X": "AX1", "Y": "AX2"}
        return sum(
            (
                np.interp(AT, at, values)
                for axis, to, direction, at, values in _read_cec((folder / "cec.ini").read_text())
                if axis == "AX1" and to == numbered[output] and direction in (0, way)
            ),
            np.zeros(len(AT)),
        )
    table = _read_com(_read_cma(folder / "axes.cma")["X"].read_text())
    column = table["BACKLASH"] if way < 0 and "BACKLASH" in table else table[output]
    return np.interp(AT, table["AXISPOS"], column)


@pytest.mark.parametrize("write", [_siemens, _heidenhain])
@pytest.mark.parametrize(("error", "output"), [("EXX", "X"), ("EYX", "Y")])
@pytest.mark.parametrize("both_ways", [False, True])
def test_what_the_control_adds_undoes_the_error_up_to_the_table(
    tmp_path: Path, write: Callable[..., None], error: str, output: str, both_ways: bool
) -> None:
    model = _model(error, both_ways)
    table = axis_table(model, "X", output, 101, {})
    write(tmp_path, table)
    added = {way: _added(tmp_path, output, way) for way in (1.0, -1.0)}
    for way, values in added.items():
        command = AT + (values if output == "X" else 0.0)
        state = State(MILL.chain.positions({"X": command}), way)
        error_mm = model.error_mm(state)[:, "XY".index(output)]
        left = np.abs(values + error_mm).max()
        # its five or six digits, and the slope of the error over the correction
        assert left < table.deviation_mm + 1e-5 < 0.01 * np.abs(error_mm).max()
    write(tmp_path, table, opposite=True)
    assert np.allclose(_added(tmp_path, output, 1.0), -added[1.0])


def test_files_say_that_their_sign_was_not_tried() -> None:
    table = AxisTable("X", "X", np.arange(3.0), np.arange(3.0) / 1000, np.arange(3.0) / 1000, 0.0, 0.0)
    assert all(words in siemens_cec(table) for words in CAUTION)
    assert "TRY-SIGN-FIRST" in heidenhain_com(table)


def test_the_stated_deviation_is_the_largest_between_entries() -> None:
    model = _model("EXX", True)
    table = axis_table(model, "X", "X", 11, {})
    at = np.linspace(0, 500, 20001)
    state = State(MILL.chain.positions({"X": at}), 1.0)
    back = State(MILL.chain.positions({"X": at}), -1.0)
    off = [np.abs(table.error_mm(at, way) - model.error_mm(s)[:, 0]).max() for way, s in ((1, state), (-1, back))]
    assert max(off) == pytest.approx(table.deviation_mm, rel=0.01)
