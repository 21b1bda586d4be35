"""Every way in which a machine model or its data is refused."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.files import read_as_file
from tests.support.worn_lathe import cut, lathe_model, nothing
from trueloop.diagnosis.components import Inspections, error_components
from trueloop.errors import Code, Finding, TrueloopError
from trueloop.formats.examples import example
from trueloop.formats.measurements.positioning_data import read_positioning
from trueloop.formats.tables.control_tables import linuxcnc_comp
from trueloop.jobs.machine.machine_model import fit_machine
from trueloop.machine.correct import AxisTable, Setup, displace_points, state_at
from trueloop.machine.identify.identify import at_bounds, identify
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.history import Lag, check_lags_given
from trueloop.machine.model.model import Acceptance, Machine, MachineModel, State, Version
from trueloop.machine.model.term import CONSTANT, Part, PositionBasis, Term, chain_of, segments
from trueloop.machine.model.validity import check_state, require_in_force, require_serial
from trueloop.machine.refine.refine import refine, require_better
from trueloop.machine.standards import LeftOut, QuadrupoleField, require_repeating
from trueloop.nc.program.program import read_program

MILL = Machine("mill", chain_of("mill-gantry"))
EXX = Term(error_name("EXX"), (Part(segments(0.0, 500.0, 1, 2)),))
T1, T2 = Part(CONSTANT, "T1", 20.0), Part(CONSTANT, "T2", 20.0)


def _readings(positions: dict[str, np.ndarray], **signals: np.ndarray) -> Observations:
    state = State(MILL.chain.positions(positions), 0.0, signals)
    n = len(state.positions)
    along = np.tile([1.0, 0.0, 0.0], (n, 1))
    return Observations(state, along, np.sin(np.arange(n)), np.zeros(n, bool), np.full(n, np.nan), ("1",) * n)


def _two_normals_for_three_points() -> object:
    points = np.zeros((3, 3))
    seen = Inspections(points, np.tile([1.0, 0.0, 0.0], (2, 1)), points, points, 1e-3, 1e-3)
    model = MachineModel(MILL, (EXX,), np.zeros(3), np.zeros((3, 3)))
    return error_components(model, seen, State(points), State(points), compensated=True)


def _placed(source: str, **signals: float) -> object:
    chain = MILL.chain.with_axes({"X": replace(MILL.chain.axis("X"), travel=(0.0, 500.0))})
    term = replace(EXX, parts=(*EXX.parts, T1))
    known = {"X": (0.0, 500.0), "T1": (20.0, 30.0)}
    model = MachineModel(Machine("mill", chain), (term,), np.zeros(4), np.zeros((4, 4)), known)
    setup = Setup({1: (0.0, 0.0, 0.0)}, signals=signals or {"T1": 25.0})
    path = read_program(source.encode(), "linuxcnc").run()
    state = state_at(model, setup, path.end_mm, path.work_offset, path.tool, np.zeros((len(path), 3)))
    check_state(model, state)
    return state


def _positioning(text: str) -> object:
    return read_as_file(text, read_positioning)


def _outlier() -> object:
    data = _readings({"X": np.linspace(0, 500, 30)})
    slipped = 1e-3 * data.reading
    slipped[12] += 0.1
    return identify(MILL, [EXX], replace(data, reading=slipped)).findings[0]


def _fitted(factor: Callable[[str], float]) -> object:
    """The example's machine, from readings of which those of a run are multiplied."""
    header, *rows = example("machine/readings.csv").read_text(encoding="utf-8").splitlines()
    reading, run = header.split(",").index("reading_um"), header.split(",").index("run")
    words = [row.split(",") for row in rows]
    changed = [[*row[:reading], repr(float(row[reading]) * factor(row[run])), *row[reading + 1 :]] for row in words]
    text = "\n".join([header, *(",".join(row) for row in changed), ""])
    return read_as_file(text, lambda file: fit_machine(example("machine/machine.toml"), [file]))


OFFERED = Version(2, 64 * "0", ("EXX",), "EXX refined", "better", "2026-11-23T10:00:00+00:00")


def _offered(version: Version | None = OFFERED) -> None:
    model = MachineModel(MILL, (EXX,), np.zeros(3), np.zeros((3, 3)), version=version)
    require_in_force(model, 64 * "1")


def test_a_model_that_was_fitted_and_one_that_was_accepted_are_in_force() -> None:
    _offered(None)
    _offered(replace(OFFERED, accepted=Acceptance("K. Roth", "2026-11-24T10:00:00+00:00")))


def _no_better() -> None:
    model = lathe_model()
    require_better(refine(model, cut(model, nothing, 1, 4), []))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MCH_NAME: lambda: error_name("EXX1"),
    Code.MCH_STRUCTURE: lambda: chain_of("w X Y Z t"),
    Code.MCH_AXIS: lambda: chain_of("mill-gantry").axis("C"),
    Code.MCH_BASIS: lambda: PositionBasis((0.0, 500.0, 250.0), 3),
    Code.MCH_SIGNAL: lambda: T1.factor({"T2": 21.5}),
    Code.MCH_DATA: lambda: identify(MILL, [EXX], _readings({"Y": np.linspace(0, 500, 9)})),
    Code.MCH_COLLINEAR: lambda: identify(
        MILL,
        [Term(error_name("EX0S"), (T1, T2))],
        _readings({"X": np.zeros(9)}, T1=np.arange(9.0), T2=2 * np.arange(9.0) - 20),
    ),
    Code.MCH_OUTLIER: _outlier,
    Code.MCH_RUN: lambda: _fitted(lambda row: {"X at 20 °C": -1.0}.get(row, 1.0)),
    Code.MCH_SCATTER: lambda: _fitted(lambda row: 1e-3),
    Code.MCH_PROGRAM: lambda: displace_points(
        read_program(b"G21 G91\nX1. Y1.\n", "linuxcnc"), QuadrupoleField(1e-5, 0.0)
    ),
    Code.MCH_FRAME: lambda: _placed("G21 G55 G1 X10. F100\n"),
    Code.MCH_TRAVEL: lambda: _placed("G21 G54 G1 X600. F100\n"),
    Code.MCH_RANGE: lambda: _placed("G21 G54 G1 X10. F100\n", T1=45.0),
    Code.MCH_TABLE: lambda: linuxcnc_comp(AxisTable("X", "Y", np.arange(3.0), np.zeros(3), np.zeros(3), 0.0, 0.0)),
    Code.MCH_MACHINE: lambda: require_serial(
        MachineModel(Machine("mill", MILL.chain, "4711"), (EXX,), np.zeros(3), np.zeros((3, 3))), "4712"
    ),
    Code.MCH_OFFERED: _offered,
    Code.DIA_WORSE: _no_better,
    Code.MCH_SHAPE: _two_normals_for_three_points,
    Code.MCH_HISTORY: lambda: check_lags_given((Lag("column", "T1", 1800.0),), {"T1": 21.0}),
    Code.MCH_LAG: lambda: at_bounds((Lag("column", "T1", 300.0, between_s=(300.0, 9000.0)),))[0],
    Code.MCH_PATTERN: lambda: require_repeating([LeftOut(f"plate {k}", 8.3e-3, 9.9e-3) for k in range(3)]),
    Code.MCH_FILE: lambda: read_positioning(Path("no-such-file-1.csv")),
    Code.MCH_UNIT: lambda: _positioning("target_ft,approach,cycle,actual_ft\n0,up,1,0\n"),
}


@pytest.mark.parametrize("code", PRODUCERS)
def test_refusal_names_code_values_and_hint(code: Code) -> None:
    try:
        said = PRODUCERS[code]()
    except TrueloopError as error:
        said = error
    assert isinstance(said, (TrueloopError, Finding))
    assert said.code is code
    assert any(character.isdigit() for character in said.message)
    assert said.hint
