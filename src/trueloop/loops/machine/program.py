"""A program corrected by a machine model: COMP_MTG as a field over it; and the record of that, or of any field."""

from collections.abc import Collection, Mapping
from dataclasses import replace
from datetime import datetime

from trueloop import __version__
from trueloop.domain.option import MapOptions
from trueloop.domain.record import Product, Record
from trueloop.domain.tool import Machine
from trueloop.loops.machine.mapped_program import Mapped
from trueloop.machine.correct import Setup, compensation_field
from trueloop.machine.drift import zeroed_at
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import means
from trueloop.machine.model.validity import require_in_force
from trueloop.nc.field.field import Field
from trueloop.nc.program.called import tool_rows
from trueloop.nc.program.unit import recorded_program
from trueloop.units import UM_PER_MM


def field_of_model(model: MachineModel, sha256: str, setup: Setup, extrapolate: Collection[str] = ()) -> Field:
    """Returns COMP_MTG of the model, of which `sha256` is the hash, at the set-up's temperatures.

    Raises MCH-OFFERED for a refined model that was not accepted, MCH-FRAME, MCH-TRAVEL and MCH-RANGE at positions that
    the model does not know.
    """
    require_in_force(model, sha256)
    known = model if setup.zero_signals is None else zeroed_at(model, setup.zero_signals)
    return compensation_field(known, setup, _provenance(setup, sha256), extrapolate)


def record_of(
    name: str,
    done: Mapped,
    model: MachineModel,
    sha256: str,
    setup: Setup,
    options: MapOptions,
    parameters: Mapping[str, float],
    now: datetime,
) -> Record:
    """Returns the record of a program of that name corrected by the field of `field_of_model`; it names nobody yet."""
    given = {**vars(options), **_provenance(setup, sha256), "unit": done.unit, "parameters": dict(parameters)}
    known = {"machine": model.machine.name, "serial": model.machine.serial, "terms": len(model.terms)}
    made = _record(name, done, {"model": sha256}, given, known, now)
    return replace(made, machine=Machine(model.machine.name, model.machine.serial))


def record_of_field(
    name: str,
    done: Mapped,
    field: Field,
    inputs_sha256: Mapping[str, str],
    options: MapOptions,
    parameters: Mapping[str, float],
    now: datetime,
) -> Record:
    """Returns the record of a program corrected by any field, which was made from these inputs; it names nobody yet."""
    given = {**vars(options), "unit": done.unit, "parameters": dict(parameters)}
    return _record(name, done, inputs_sha256, given, {"field": field.identity}, now)


def _record(
    name: str,
    done: Mapped,
    inputs_sha256: Mapping[str, str],
    options: dict[str, object],
    model: dict[str, object],
    now: datetime,
) -> Record:
    largest_um = UM_PER_MM * max(done.largest_mm)
    return Record(
        id=done.record,
        made_at=now.isoformat(timespec="seconds"),
        made_by="",
        trueloop_version=__version__,
        inputs_sha256={"program": done.source_sha256, **inputs_sha256},
        options=options,
        model=model,
        decision=[f"{done.edits} edits, {done.added_blocks} new blocks, largest correction {largest_um:.1f} µm"],
        changes=[],
        product=Product.MACHINE,
        edits=done.edits,
        program=recorded_program(name, done.dialect, done.source_sha256, done.unit),
    )


def _provenance(setup: Setup, model_sha256: str) -> dict[str, object]:
    return {
        "model": model_sha256,
        "temperatures": means(setup.signals),
        "work_zero_mm": {str(number): list(zero) for number, zero in setup.work_zero_mm.items()},
        "rotary_axes_rad": dict(setup.fixed),
        "tool_mm": {str(number): list(tool) for number, tool in setup.tool_mm.items()},
        **({} if setup.zero_signals is None else {"temperatures_at_zero": means(setup.zero_signals)}),
        **({} if setup.table is None else {"tools": [list(row) for row in tool_rows(setup.table)]}),
    }
