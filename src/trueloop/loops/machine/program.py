"""A program corrected by a machine model: COMP_MTG as a field over it, in streaming, with a record beside it."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from trueloop import __version__
from trueloop.domain.correction import Product
from trueloop.domain.machine import Machine
from trueloop.domain.map_options import MapOptions
from trueloop.domain.record import Record, sha256_of
from trueloop.formats.outputs import Named
from trueloop.loops.machine.mapped_program import Mapped, map_program
from trueloop.machine.correct.setup import Setup, compensation_field
from trueloop.machine.drift.terms import zeroed_at
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import means
from trueloop.nc.program.cutter_tool import tool_rows
from trueloop.nc.program.unit import recorded_program
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class ModelFile:
    """A machine model with the file it was read from."""

    model: MachineModel
    file: Path

    @property
    def sha256(self) -> str:
        """By which the record knows it."""
        return sha256_of(self.file.read_bytes())


def compensate_program(
    source: Path,
    target: Path,
    known: ModelFile,
    setup: Setup,
    options: MapOptions,
    *,
    dialect: str | None = None,
    parameters: Mapping[str, float] | None = None,
    extrapolate: Collection[str] = (),
    inputs: Collection[Path] = (),
    made_by: str = "",
) -> Mapped:
    """Writes `source` to `target` with COMP_MTG of the model, at the set-up's temperatures, in every position.

    The record is written beside it, as STEM.record.json. Raises what placing the program in the machine raises
    (MCH-FRAME, MCH-TRAVEL, MCH-RANGE) and what `map_program` does; nothing is written then.
    """
    model, sha256 = known.model, known.sha256
    if setup.zero_signals is not None:
        model = zeroed_at(model, setup.zero_signals)
    told = _told(setup, sha256)

    def record(done: Mapped) -> list[Named]:
        given = {**vars(options), **told, "unit": done.unit, "parameters": dict(parameters or {})}
        made = replace(_record(source, done, model, sha256, given), made_by=made_by)
        return [(f"{target.stem}.record.json", made.to_json().encode())]

    return map_program(
        source,
        target,
        compensation_field(model, setup, told, extrapolate),
        options,
        dialect=dialect,
        parameters=parameters,
        inputs=(known.file, *inputs),
        beside=record,
    )


def _told(setup: Setup, model_sha256: str) -> dict[str, object]:
    return {
        "model": model_sha256,
        "temperatures": means(setup.signals),
        "work_zero_mm": {str(number): list(zero) for number, zero in setup.work_zero_mm.items()},
        "rotary_axes_rad": dict(setup.fixed),
        "tool_mm": {str(number): list(tool) for number, tool in setup.tool_mm.items()},
        **({} if setup.zero_signals is None else {"temperatures_at_zero": means(setup.zero_signals)}),
        **({} if setup.table is None else {"tools": [list(row) for row in tool_rows(setup.table)]}),
    }


def _record(source: Path, done: Mapped, model: MachineModel, model_sha256: str, options: dict[str, object]) -> Record:
    largest_um = UM_PER_MM * max(done.largest_mm)
    return Record(
        id=done.record,
        made_at=datetime.now(UTC).isoformat(timespec="seconds"),
        made_by="",
        trueloop_version=__version__,
        inputs_sha256={"program": done.source_sha256, "model": model_sha256},
        options=options,
        model={"machine": model.machine.name, "serial": model.machine.serial, "terms": len(model.terms)},
        decision=[f"{done.edits} edits, {done.added_blocks} new blocks, largest correction {largest_um:.1f} µm"],
        changes=[],
        product=Product.MACHINE,
        edits=done.edits,
        machine=Machine(model.machine.name, model.machine.serial),
        program=recorded_program(source.name, done.dialect, done.source_sha256, done.unit),
    )
