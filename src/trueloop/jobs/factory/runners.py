"""The functions that carry out each kind of task, by kind: `RUNNERS`."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Final

from sqlalchemy import select

from trueloop.domain.factory import StepState
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import OrderNow, PartNow
from trueloop.factory.load import StoreReader, order_of, program_text, record_of
from trueloop.factory.requests import By, CorrectionRefused, Role, StepCorrected
from trueloop.factory.shown.machines import all_machines
from trueloop.factory.shown.records import known_of, last_transfers
from trueloop.factory.tasks import Runner, Task, Working
from trueloop.factory.views.orders import LinksView, LinkView
from trueloop.formats.links_toml import read_links
from trueloop.jobs.factory.job_folder import job_folder, programs_of, unnamed_folder
from trueloop.jobs.factory.uploads import HandedFile
from trueloop.jobs.links import link_of
from trueloop.jobs.store.keep_correction import keep_correction, part_of
from trueloop.jobs.store.opened import Keeping
from trueloop.jobs.turned.compensate import Corrected, corrected_of
from trueloop.jobs.turned.job import ReadJob, read_job
from trueloop.loops.turned.correction import Correction
from trueloop.storage.schema import RUN_TOUCHES
from trueloop.storage.store import Store


def links_view(store: Store, settings: Path | None, now: datetime) -> LinksView:
    """Returns all links in the file, and all with recorded transfers; connects to no control. Raises LNK-FILE."""
    stated = [] if settings is None else list(_stated(settings))
    with known_of(store) as known:
        last = last_transfers(known)
        machines = {machine.name for machine in all_machines(known, now)}
    named = {name for name, *_ in stated}
    every = [*stated, *((name, "", "") for name in last if name not in named)]
    items = (LinkView(name, kind, where, name in machines, last.get(name)) for name, kind, where in sorted(every))
    return LinksView(settings is not None, tuple(items))


def _stated(settings: Path) -> Iterator[tuple[str, str, str]]:
    """Name, kind and address of each; passwords stand in the environment, not in the file."""
    for kind, tables in read_links(settings).by_kind.items():
        for name, table in tables.items():
            yield name, kind, link_of(table, settings.parent, lambda _: None).where


SERVICE = By("service", Role.SERVICE)


@dataclass(frozen=True)
class _CorrectionInputs:
    """The inputs of a correction: `touches` of the last gauging run, and texts by their names in the job."""

    order: OrderNow
    part: PartNow
    step: int
    gauged_by: str
    touches: bytes
    programs: dict[str, bytes]


def correct(
    store: Store, task: Task, working: Working, first: Callable[[HandedFile], object] | None = None
) -> dict[str, str]:
    """Corrects, keeps, and sets the finish cut's program; a refusal of the loop holds the part with its code.

    `first` reads job, programs and touches before this process does, where they may take any time and memory.
    Done twice it comes to the same record of the same inputs, or finds the step recorded.
    """
    order, row, step = task.values["order"], int(task.values["part"]), int(task.values["step"])
    with store.reading() as connection:
        known = StoreReader(connection, store.codec)
        now = order_of(known, order)
        if now.step(row, step).state is StepState.RECORDED:
            return {"correction": now.step(row, step).run}
        given = _given(known, now, now.part(row), step)
    working.say(0.1, f"part {given.part.value.serial}: correcting")
    try:
        if first is not None:
            with unnamed_folder() as folder:
                file = folder / "touches"
                file.write_bytes(given.touches)
                name = f"job of order {given.order.order.id} with the touches of run {given.gauged_by}"
                first(
                    HandedFile(
                        str(file), name, sha256_of(given.touches), order=given.order.order, programs=given.programs
                    )
                )
        made = _corrected(store, given)
        if not _kept_already(store, made.correction):
            keep_correction(store, made.inputs, made.correction, Keeping())
    except TrueloopError as refused:
        why = refused.code.value, f"{refused.message}; {refused.hint}"
        carry_out(store, CorrectionRefused(order, row, step, given.gauged_by, *why), SERVICE, working.clock())
        raise
    corrected = StepCorrected(
        order=order,
        part=row,
        step=step,
        gauged_by=given.gauged_by,
        correction=made.correction.record.id,
        program_sha256=sha256_of(made.correction.corrected_program),
        touches_sha256=sha256_of(given.touches),
    )
    carry_out(store, corrected, SERVICE, working.clock())
    return {"correction": corrected.correction, "program_sha256": corrected.program_sha256}


def _kept_already(store: Store, made: Correction) -> bool:
    """Returns whether a worker had kept it before it was ended: a record of that id, of its inputs, and the program.

    The record says when it was made, and so differs from the one that is there.
    """
    with store.reading() as connection:
        known = StoreReader(connection, store.codec)
        text = program_text(known, sha256_of(made.corrected_program))
        return record_of(known, made.record.id) is not None and text is not None


def _given(reader: StoreReader, order: OrderNow, part: PartNow, step: int) -> _CorrectionInputs:
    run = part.gauged_by(step)
    touches = reader.connection.scalar(select(RUN_TOUCHES.c.content).where(RUN_TOUCHES.c.run == run))
    if touches is None:
        raise Code.FAC_TOUCHES.refusal(
            f"part {part.value.serial!r} has no touches of run {run or 'none'!r}",
            hint="its cell sends them once the gauging program has run",
            values={"run": run},
        )
    return _CorrectionInputs(
        order=order,
        part=part,
        step=step,
        gauged_by=run,
        touches=bytes(touches),
        programs=programs_of(reader, order.order),
    )


def _corrected(store: Store, inputs: _CorrectionInputs) -> Corrected:
    with job_folder(inputs.order.order, inputs.programs, inputs.touches) as job:
        read = read_job(job, serial=inputs.part.value.serial)
        made = corrected_of(_with_log(read, inputs), store)
    found = part_of(made.inputs).identity
    if found != inputs.part.value.identity:
        raise Code.FAC_TOUCHES.refusal(
            f"the job corrects part {'/'.join(found)!r}, the order makes {'/'.join(inputs.part.value.identity)!r}",
            hint="give `name` and `revision` of the job's table [part] as the order has them",
            values={"run": ""},
        )
    return made


def _with_log(read: ReadJob, inputs: _CorrectionInputs) -> ReadJob:
    """Adds a gauging run's file to the inputs of the correction, also a log that touches were read from."""
    route = inputs.order.order.route
    if not route.probe_toml:
        return read
    log = {f"log of {route.probe_control}": sha256_of(inputs.touches)}
    return replace(read, inputs=replace(read.inputs, inputs_sha256={**read.inputs.inputs_sha256, **log}))


RUNNERS: Final[Mapping[str, Runner]] = {"correct": correct}
