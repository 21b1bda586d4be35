"""A job, or a correction kept in a store, as the table by program line that the real-time corrector applies.

`record.json` alone does not do: it says what was changed, not where everything between goes. A job is corrected anew,
as `trueloop compensate` does it, and nothing is written; a store holds every correction whole.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.domain.record import Correction as Kept
from trueloop.domain.record import Product
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.formats.input_file import FilePath
from trueloop.jobs.db.named import named_row
from trueloop.jobs.store.keeping import Keeping
from trueloop.jobs.store.opened import opened
from trueloop.jobs.store.where import Choice
from trueloop.jobs.turned.compensate import correct_job
from trueloop.loops.realtime.process_table import Placed, machine_of, process_table
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.correction import Correction
from trueloop.nc.program.program import Program, read_program
from trueloop.realtime.image import Block
from trueloop.storage.kinds import joined
from trueloop.storage.store import find

SAME_MM: Final = 1e-6


@dataclass(frozen=True)
class Placing:
    """What the caller says of where the program stands, as `Placed`.

    `origin_mm` (x as a radius, z) None: as the job's `[machine]` has it, `work_zero_mm` less `tool_mm`.
    """

    origin_mm: tuple[float, float] | None = None
    tip: int = 0
    gate_mm: float = 0.1


@dataclass(frozen=True)
class CorrectedProgram:
    """The table of a correction, and whose it is.

    `program` and `program_sha256` are of the *given* finish program, which is to be run; `record` is the id that the
    corrected program bears. `limit_mm`: the largest correction that the job allows, along the normal. `model_sha256`
    is that of the model file that must act in real time besides, as the correction counts on it, `machine` and `serial`
    its machine's; "" where the correction takes nothing from a model. `files` must not be written over.
    """

    blocks: tuple[Block, ...]
    program: str
    program_sha256: str
    record: str
    limit_mm: float
    model_sha256: str = ""
    machine: str = ""
    serial: str = ""
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()


def table_of_job(job: FilePath, placing: Placing, keeping: Keeping | None = None) -> CorrectedProgram:
    """Makes the table of a job's correction, as `trueloop compensate` makes it. Nothing is written or kept.

    Raises what reading and correcting refuse, RTC-TABLE where the program's place is not stated, RTC-LINE,
    RTC-PATH-MODE, CTL-DIALECT.
    """
    made = correct_job(job, keeping or Keeping())
    with in_file(str(job)):
        return _table(made.inputs.program, made.inputs.run, made.correction, placing, made.read.files)


def table_of_record(record: str, placing: Placing, db: Choice = None) -> CorrectedProgram:
    """Makes the table of a correction kept in a store (`db`, else `trueloop.db` in the present folder), by record id.

    Raises STO errors, STO-UNKNOWN for a record that is not there, RTC-TABLE for one that corrects no turned part, and
    what `table_of_job` raises of tables.
    """
    store = opened(db, read_only=True)
    found: list[Any] = find(store, Kept, identity=joined((record,)))
    kept: Kept[Correction] = found[-1].value if found else named_row(store, record).kept.value
    if kept.record.product is not Product.TURNED:
        raise TrueloopError(
            Code.RTC_TABLE,
            f"record {record} corrects no turned part: its product is {str(kept.record.product)!r}",
            hint="a table is made of what `trueloop compensate` corrects",
        )
    correction = kept.payload
    with in_file(correction.source_name):
        return _table(_program(correction), _run(correction), correction, placing, (Path(store.where),))


def _table(
    program: Program, run: Run, correction: Correction, placing: Placing, files: tuple[Path, ...]
) -> CorrectedProgram:
    part = machine_of(correction)
    table = process_table(program, run, correction, _placed(correction, placing))
    assert correction.record.program is not None  # every turned part's record has one
    return CorrectedProgram(
        table.blocks,
        correction.source_name,
        correction.record.program.sha256,
        correction.record.id,
        correction.options.limits.correction_mm,
        "" if part is None else part.sha256,
        "" if part is None else part.machine.name,
        "" if part is None else part.machine.serial,
        table.notes,
        files,
    )


def _placed(correction: Correction, placing: Placing) -> Placed:
    """Where the program stands. Raises RTC-TABLE where nobody says it, or the job and the caller say two things."""
    part, said = machine_of(correction), placing.origin_mm
    if part is not None:
        x, _, z = np.subtract(part.work_zero_mm, part.tool_mm).tolist()
        if said is not None and max(abs(said[0] - x), abs(said[1] - z)) > SAME_MM:
            raise TrueloopError(
                Code.RTC_TABLE,
                f"the program's zero is at x {x:g} mm (radius), z {z:g} mm by [machine] of the job, and was given as "
                f"x {said[0]:g} mm, z {said[1]:g} mm",
                hint="leave the origin out: the job says it",
            )
        said = x, z
    if said is None:
        raise TrueloopError(
            Code.RTC_TABLE,
            "where the program stands in the machine is not known: 0 of 2 coordinates of its zero are given",
            hint="give the machine coordinates of the program's zero, X as a radius: work offset plus tool offset",
        )
    return Placed(said, placing.tip, placing.gate_mm)


def _program(correction: Correction) -> Program:
    """The given finish program as it was read then."""
    stated = correction.record.program
    unit = None if stated is None else stated.unit
    return read_program(correction.source_program, correction.dialect, correction.source_name, unit)


def _run(correction: Correction) -> Run:
    """How it was run, as far as the record says it: `process_table` refuses where it was run otherwise."""
    given = correction.record.options.get("parameters")
    return Run({str(name): float(value) for name, value in given.items()} if isinstance(given, dict) else {})
