"""What a diagnosis from stored inspections is refused with."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from tests.support.diagnosed_files import model_file
from trueloop.diagnosis.components import Inspections
from trueloop.diagnosis.terms.judge import check
from trueloop.diagnosis.terms.suspects import Residuals
from trueloop.domain.inspection import BothInspections, MachineStood
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Machine
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.diagnose.records import (
    both_of_machine,
    cut_under_others,
    given_model,
    keep_standard,
    part_named,
    standard_of,
)
from trueloop.loops.diagnosis.left_on_parts import BothSeen, checked, residuals, states_of
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import chain_of
from trueloop.storage.store import open_store

SIGNALS = {"T_spindle": 22.0, "T_carriage": 21.0, "T_cross_slide": 23.0}


def _model() -> MachineModel:
    with TemporaryDirectory() as folder:
        return read_model(model_file(Path(folder)))


def _seen(
    shift_mm: tuple[float, float, float], signals: dict[str, float] | None = None
) -> tuple[MachineModel, BothSeen]:
    """One part of twelve points about its axis; the measuring machine finds it shifted."""
    model, angle = _model(), np.linspace(0.0, 2 * np.pi, 12, endpoint=False)
    normal = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(12)])
    nominal = 20.0 * normal + np.array([0.0, 0.0, 1.0]) * np.linspace(5.0, 60.0, 12)[:, None]
    seen = Inspections(nominal, normal, nominal, nominal + np.array(shift_mm), 0.001, 0.001)
    state = states_of(model, seen, (0.0, 0.0, 120.0), (40.0, 0.0, 60.0), SIGNALS if signals is None else signals)
    return model, BothSeen("17", "shaft", tuple(map(str, range(12))), seen, state, state, True)


def _checked(*shift_mm: float) -> object:
    x, y, z = shift_mm
    model, part = _seen((x, y, z))
    return checked(model, [part])


def _without_signal() -> object:
    model, part = _seen((0.0, 0.0, 0.0), {"T_spindle": 22.0})
    return residuals(model, [part, replace(part, serial="18")], {})


def _nothing_stored() -> object:
    with TemporaryDirectory() as folder:
        return both_of_machine(open_store("sqlite://", create=True), given_model(model_file(Path(folder))))


def _not_calibrated() -> object:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "certificate.csv"
        file.write_text("characteristic,quantity,nominal_mm,actual_mm\nd1,diameter,40,40.001\n")
        store = open_store("sqlite://", create=True)
        return keep_standard(store, file, standard_of("shaft", "master"), StatedFacts())


def _tools_alike() -> object:
    seen = Residuals(
        np.arange(8) // 2,
        np.tile([1.0, 0.0, 0.0], (8, 1)),
        State(np.arange(16.0).reshape(8, 2), 0.0, {"T": np.arange(8.0)}),
        np.zeros(8),
        {"C": "T"},
    )
    return check(chain_of("turning"), seen)[0]


def _cut_under_another_model() -> object:
    stood = MachineStood((0.0, 0.0, 0.0), ((0.0, 0.0, 0.0),))
    part, machine = Part(PartType("shaft"), "17"), Machine("lathe")
    both = BothInspections(part, machine, ("a",), ("b",), stood, stood, "1" * 64, compensated=True)
    return next(cut_under_others([both], "2" * 64))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.DIA_ALIKE: _tools_alike,
    Code.DIA_MODEL: _cut_under_another_model,
    Code.DIA_NONE: lambda: part_named(open_store("sqlite://", create=True), "17", None),
    Code.DIA_PART: lambda: _checked(0.5, 0.0, 0.0),
    Code.DIA_MOVED: lambda: _checked(0.05, 0.03, 0.0),
    Code.DIA_SIGNAL: _without_signal,
    Code.DIA_STANDARD: _not_calibrated,
}


def test_a_store_without_parts_of_the_machine() -> None:
    with pytest.raises(TrueloopError, match="DIA-NONE"):
        _nothing_stored()
