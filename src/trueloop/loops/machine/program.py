"""A program corrected by a machine model: COMP_MTG as a field over it; and the record of that, or of any field.

A drilling program corrected by errors in the plane: its words displaced, marked, read back.
"""

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Final

from trueloop import __version__
from trueloop.domain import values
from trueloop.domain.option import Limits, MapOptions
from trueloop.domain.record import (
    ChangedWord,
    Correction,
    Product,
    Record,
    check_uncorrected,
    mark_of_field,
    record_id,
    sha256_of,
)
from trueloop.domain.tool import Machine
from trueloop.errors import Code, in_file
from trueloop.loops.machine.mapped_program import Mapped
from trueloop.machine.correct import (
    IN_NO_CASE,
    NO_POSITIONS,
    Setup,
    compensation_field,
    displace_points,
    off_mm,
    references_mm,
)
from trueloop.machine.drift import zeroed_at
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import means
from trueloop.machine.model.validity import require_in_force
from trueloop.machine.standards import PlanarField
from trueloop.nc.edit.changes import changes, insert_heading, not_as_intended
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.field import Field
from trueloop.nc.program.called import tool_rows
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.nc.program.understood import FROM_OUTSIDE, require_sound
from trueloop.nc.program.unit import recorded_program, unit_of_path
from trueloop.units import UM_PER_MM


def field_of_model(model: MachineModel, sha256: str, setup: Setup, extrapolate: Collection[str] = ()) -> Field:
    """Returns COMP_MTG of the model, of which `sha256` is the hash, at the set-up's temperatures.

    Raises MCH-OFFERED for a refined model that was not accepted, MCH-FRAME, MCH-TRAVEL and MCH-RANGE at positions that
    the model does not know.
    """
    known, identity = model_in_force(model, sha256, setup)
    return compensation_field(known, setup, identity, extrapolate)


def model_in_force(model: MachineModel, sha256: str, setup: Setup) -> tuple[MachineModel, dict[str, object]]:
    """Returns the model, of which `sha256` is the hash, as it holds since the work zero was set, and what identifies it
    in a corrected program. Raises MCH-OFFERED for a refined model that was not accepted.
    """
    require_in_force(model, sha256)
    known = model if setup.zero_signals is None else zeroed_at(model, setup.zero_signals)
    return known, _provenance(model, setup, sha256)


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
    given = {**vars(options), **_provenance(model, setup, sha256), "unit": done.unit, "parameters": dict(parameters)}
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


def _provenance(model: MachineModel, setup: Setup, model_sha256: str) -> dict[str, object]:
    return {
        "model": model_sha256,
        "temperatures": means(setup.signals),
        "work_zero_mm": {str(number): list(zero) for number, zero in setup.work_zero_mm.items()},
        "rotary_axes_rad": dict(setup.fixed),
        "tool_mm": {str(number): list(tool) for number, tool in setup.tool_mm.items()},
        **({"reference_mm": references} if (references := references_mm(model, setup)) else {}),
        **({} if setup.zero_signals is None else {"temperatures_at_zero": means(setup.zero_signals)}),
        **({} if setup.tool_point is None else {"tool_point": setup.tool_point}),
        **({} if setup.table is None else {"tools": [list(row) for row in tool_rows(setup.table)]}),
    }


WHOLE: Final = re.compile(r"[XY][+-]?\d+")
"""A coordinate without a decimal point."""


def _require_read(program: Program, path: ToolPath) -> None:
    """Raises NC-WORD for a coordinate of the plane that cannot be read, and would stay where it is, NC-PARAMETER for a
    number without a point whose size a parameter of the machine decides.
    """
    hints = {Code.NC_WORD: "write the coordinate as a number", Code.NC_PARAMETER: "write the coordinate with a point"}
    for found in (*program.findings, *path.findings):
        word = found.message[1:].partition('"')[0].upper()
        if found.code in hints and word[:1] in ("X", "Y") and (found.code is Code.NC_WORD or WHOLE.fullmatch(word)):
            raise found.code.refusal(found.message, hint=hints[found.code], place=found.place, values=found.values)


@dataclass(frozen=True)
class CorrectedPoints:
    """The result of a correction: points and words, and the largest correction of X and of Y in mm."""

    record: str
    source_sha256: str
    points: int
    edits: int
    largest_mm: tuple[float, float]


def correct_points(
    program: Program,
    field: PlanarField,
    provenance: dict[str, object],
    *,
    all_words: bool = False,
    limit_mm: float = Limits.correction_mm,
) -> tuple[bytes, CorrectedPoints, list[ChangedWord]]:
    """Adds −E to every X and Y word of the program, and returns it with its changes; `provenance` identifies the field
    in its mark.

    With `all_words` those words too that set coordinate systems or name places of the machine, except dwells and the
    centre of a rotation. Raises CMP-TWICE (corrected before), the program's own errors apart from those that values and
    programs from outside would mend, CMP-SIZE (a correction beyond the limit), CMP-READ-BACK, MCH-PROGRAM and what the
    field raises.
    """
    left_alone = IN_NO_CASE if all_words else NO_POSITIONS
    with in_file(program.file):
        check_uncorrected(program.source)
        path = program.run(strict=False, roughing=False)
        require_sound(path, FROM_OUTSIDE)
        _require_read(program, path)
        found = displace_points(program, field, left_alone)
    for axis, size in zip("XY", found.largest_mm, strict=True):
        if size > limit_mm:
            raise Code.CMP_SIZE.refusal(
                f"a correction of {axis} by {UM_PER_MM * size:.1f} µm is larger than {UM_PER_MM * limit_mm:g} µm",
                hint="check the unit and the sign of the field",
                place=program.place(found.largest_at),
                override=f"--limit-um {math.ceil(UM_PER_MM * size)}",
                values={"size_um": UM_PER_MM * float(size), "limit_um": UM_PER_MM * limit_mm},
            )
    digest = sha256_of(program.source)
    identity = record_id({"program": digest}, {"field": provenance, "all_words": all_words})
    mark = program.dialect.comment(mark_of_field(identity, digest))
    written = apply_edits(program, [insert_heading(program, [mark]), *found.edits])
    for line, off in off_mm(program.rewritten(written), found.wanted_mm, left_alone):
        raise not_as_intended(f"line {line} of the written program stands {off * UM_PER_MM:.2f} µm from where it shall")
    done = CorrectedPoints(identity, digest, len(found.wanted_mm), len(found.edits), found.largest_mm)
    return written, done, changes(program, found.edits)


def record_of_points(
    program: Program,
    done: CorrectedPoints,
    changed: list[ChangedWord],
    options: Mapping[str, object],
    provenance: dict[str, object],
    inputs_sha256: Mapping[str, str],
    now: datetime,
) -> Record:
    """Returns the record of the result of `correct_points` with these options; it names nobody yet."""
    unit = unit_of_path(program.unit, program.run(strict=False, roughing=False))
    x_um, y_um = (UM_PER_MM * value for value in done.largest_mm)
    return Record(
        id=done.record,
        made_at=now.isoformat(timespec="seconds"),
        made_by="",
        trueloop_version=__version__,
        inputs_sha256={"program": done.source_sha256, **inputs_sha256},
        options={**options, "unit": unit},
        model={"field": provenance},
        decision=[f"{done.edits} edits at {done.points} points, largest correction X {x_um:.1f} Y {y_um:.1f} µm"],
        changes=changed,
        product=Product.POINTS,
        edits=done.edits,
        program=recorded_program(program.file or "", program.dialect.name, done.source_sha256, unit),
    )


CODEC: Final = values.CODEC.with_more(Correction, Mapped, CorrectedPoints)
