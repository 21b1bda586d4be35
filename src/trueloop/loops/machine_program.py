"""A program corrected by a machine model: checked, edited, marked with a record, read back."""

from collections.abc import Collection
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from trueloop import __version__
from trueloop.compensation.record import MARK, ChangedWord, Record, check_uncorrected, record_id, sha256_of
from trueloop.machine.commanded_path import Setup, commanded_path
from trueloop.machine.model import MachineModel
from trueloop.machine.program_edits import compensation_edits
from trueloop.nc.edit import Edit, apply_edits
from trueloop.nc.program import Program
from trueloop.nc.tool_path import Motion


@dataclass(frozen=True)
class MachineCorrection:
    """The corrected program, its record, and the largest correction (X, Y, Z) in mm over all programmed ends."""

    source: bytes
    record: Record
    largest_mm: tuple[float, float, float]
    blocks_before: int
    blocks_after: int


def compensate_program(
    program: Program,
    model: MachineModel,
    setup: Setup,
    *,
    tolerance_mm: float,
    parameters: dict[str, float] | None = None,
    extrapolate: Collection[str] = (),
    model_sha256: str = "",
    made_by: str = "",
) -> MachineCorrection:
    """COMP_MTG of the model at the set-up's temperatures in every programmed position.

    Raises CMP-TWICE for a program that carries a correction already, and what placing and editing it raise.
    """
    check_uncorrected(program.source)
    path = program.run(parameters)
    placed = commanded_path(model, setup, path, extrapolate)
    edits = compensation_edits(program, placed, tolerance_mm)
    inputs = {"program": sha256_of(program.source), "model": model_sha256}
    signals = {name: float(np.mean(value)) for name, value in setup.signals.items()}
    options: dict[str, object] = {
        "tolerance_mm": tolerance_mm,
        "temperatures": signals,
        "work_zero_mm": {str(number): list(zero) for number, zero in setup.work_zero_mm.items()},
        "rotary_axes_rad": dict(setup.fixed),
        "tool_mm": {str(number): list(tool) for number, tool in setup.tool_mm.items()},
    }
    identity = record_id(inputs, options)
    comment = program.dialect.comment(
        f"{MARK} {identity} for the machine {model.machine.name}, source {inputs['program'][:16]}"
    )
    source = apply_edits(program, [_marked(program, comment), *edits])
    cut = np.flatnonzero(path.motion != Motion.PROBE)
    largest = np.abs(placed.error_mm(path.end_mm[cut], cut)).max(axis=0, initial=0.0)
    record = Record(
        id=identity,
        made_at=datetime.now(UTC).isoformat(timespec="seconds"),
        made_by=made_by,
        trueloop_version=__version__,
        inputs_sha256=inputs,
        options=options,
        model={"machine": model.machine.name, "serial": model.machine.serial, "terms": len(model.terms)},
        decision=[f"{len(edits)} edits, largest correction {1e3 * largest.max():.1f} µm"],
        changes=[_change(program, edit) for edit in edits],
    )
    sizes = (float(largest[0]), float(largest[1]), float(largest[2]))
    return MachineCorrection(source, record, sizes, program.source.count(b"\n"), source.count(b"\n"))


def _marked(program: Program, comment: str) -> Edit:
    """The mark on a line of its own: after a leading % line, else first."""
    at = program.source.find(b"\n") + 1 if program.source.lstrip().startswith(b"%") else 0
    ending = "\r\n" if b"\r\n" in program.source else "\n"
    return Edit(at, at, comment + ending)


def _change(program: Program, edit: Edit) -> ChangedWord:
    place = program.place(edit.start)
    before = program.source[edit.start : edit.end].decode("latin-1")
    return ChangedWord(place.line or 0, place.column or 0, before, edit.text)
