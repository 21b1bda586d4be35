"""Uploads become facts of the store: a program, or measurements of a part of an order."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final

from trueloop.domain.codec import Codec
from trueloop.domain.factory import BlockKind
from trueloop.domain.record import Program, ProgramText
from trueloop.domain.values import CODEC as STORED
from trueloop.errors import Code
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import OrderNow, PartNow
from trueloop.factory.load import StoreReader, order_of
from trueloop.factory.requests import By, RecordStep
from trueloop.factory.views import by_hand, uploads
from trueloop.factory.views.uploads import ImportedView, ProgramRead
from trueloop.jobs.factory.by_hand import part_by_hand, tried_by_hand
from trueloop.jobs.factory.hand_job import (
    AskedMilled,
    AskedPart,
    AskedProgram,
    AskedReadings,
    AskedTool,
    HandJob,
    MilledReadings,
    MillJob,
)
from trueloop.jobs.factory.hand_mill import MilledAnswer, milled_entries, milled_part
from trueloop.jobs.factory.job_folder import job_folder, programs_of
from trueloop.jobs.factory.uploads import (
    HandedFile,
    ReadingOptions,
    Upload,
    UploadedInspection,
    inspected,
    order_read,
    program_read,
    remarked,
    toml_read,
    upload_view,
)
from trueloop.jobs.measure.keep_measured import After, StatedCut, keep_in
from trueloop.jobs.store.keep_facts import CutStatement
from trueloop.jobs.store.opened import Keeping
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.report.texts.texts import Texts
from trueloop.storage.store import Store, find, keep
from trueloop.wording import wording

READINGS: Final[Mapping[str, Callable[[HandedFile], Any]]] = {
    one.__name__: one
    for one in (
        upload_view,
        program_read,
        inspected,
        order_read,
        toml_read,
        part_by_hand,
        tried_by_hand,
        milled_part,
        milled_entries,
    )
}
CODEC: Final[Codec] = STORED.with_more(
    *(HandedFile, ReadingOptions, UploadedInspection, uploads.UploadView, uploads.ProgramRead, uploads.MeasurementRead),
    *(uploads.InspectionRead, uploads.ValueRead, uploads.DrawingRead, uploads.Remarked),
    *(
        HandJob,
        AskedPart,
        AskedProgram,
        AskedTool,
        AskedReadings,
        by_hand.PartByHand,
        by_hand.SizeToMeasure,
        by_hand.Unstated,
    ),
    *(by_hand.MadeBefore, by_hand.Picture),
    *(MillJob, AskedMilled, MilledReadings, MilledAnswer, by_hand.MilledPart, by_hand.MilledFeatureShown),
    *(by_hand.MilledSize, by_hand.MilledEntries, by_hand.Expectation, by_hand.FileMade),
)
"""Questions to a process that reads files, and its answers."""


@dataclass(frozen=True)
class OfPart:
    """The part of an order that was measured, after what; `run` of the file's; `measured_at` if none is stated."""

    order: str
    part: int
    after: After = "released"
    run: int | None = None
    measured_at: datetime | None = None


def import_program(store: Store, upload: Upload, read: ProgramRead, by: By) -> ImportedView:
    """Keeps a program's text under its hash; one that is there already stays as it was described."""
    known = find(store, Program, identity=upload.sha256)
    values = [] if known else [Program(upload.name, read.dialect, upload.sha256, read.unit)]
    kept = keep(store, [*values, ProgramText(upload.sha256, upload.content)], by=by.name)
    return ImportedView(upload.sha256, len(kept) + len(known), sum(stored.new for stored in kept), read.remarks)


def import_measurement(
    store: Store, upload: Upload, read: UploadedInspection, of: OfPart, by: By, now: datetime, *, say: Texts
) -> ImportedView:
    """Keeps what was measured of a part; where measuring it is the order's next step, that step is recorded.

    Raises MSR errors for what does not fit the part, MSR-SERIAL for a file of another part, STO and FAC errors.
    """
    order, programs = _order(store, of.order)
    part = order.part(of.part)
    # The inspection that is meant, which says nothing else than that it is of this part
    found = dict(read.runs)
    serial = part.value.serial
    own = {
        k: inspection
        for k, inspection in found.items()
        if of.run in (None, k) and inspection.part.serial in ("", serial)
    }
    if len(own) != 1:
        serials = [inspection.part.serial for inspection in found.values()]
        listed = ", ".join(f"{k}: {one!r}" for k, one in zip(found, serials[:20], strict=False))
        raise Code.MSR_SERIAL.refusal(
            wording(
                "{file!r} has {n} inspections of part {serial!r}; its {all} are {listed}",
                file=upload.name,
                n=len(own),
                serial=serial,
                all=len(found),
                listed=listed,
            ),
            hint=wording("hand over the file of this part, or say which of its inspections is meant"),
            values={"serials": serials[:20]},
        )
    measured = next(iter(own.values()))
    said = CutStatement(
        record=next((step.run for step in part.steps if step.kind is BlockKind.CORRECT and step.run), None)
    )
    with job_folder(order.order, programs) as job:
        files = JobFiles.of(job).with_serial(part.value.serial)
        shown = StatedCut(of.after, said, of.measured_at or now)
        kept = keep_in(store, [(upload.name, measured)], files, shown, Keeping(serial=part.value.serial))
    remarks = tuple(remarked(finding, say) for finding in kept.findings)
    recorded = _record(store, order, part, by, now, f"measured: {upload.name} {upload.sha256[:12]}")
    return ImportedView(upload.sha256, len(kept.kept), len(kept.new), remarks, recorded)


def _order(store: Store, name: str) -> tuple[OrderNow, dict[str, bytes]]:
    with store.reading() as connection:
        known = StoreReader(connection, store.codec)
        order = order_of(known, name)
        return order, programs_of(known, order.order)


def _record(store: Store, order: OrderNow, part: PartNow, by: By, now: datetime, why: str) -> bool:
    step = part.next
    if step is None or step.kind is not BlockKind.MEASURE:
        return False
    carry_out(store, RecordStep(order.order.id, part.row, step.no, why), by, now)
    return True
