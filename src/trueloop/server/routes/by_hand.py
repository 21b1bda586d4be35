"""A part that a person measures and corrects, without an order."""

from dataclasses import dataclass, replace
from functools import partial

from fastapi import Response
from starlette.concurrency import run_in_threadpool

from trueloop.factory.views.by_hand import CorrectedByHand, FileMade, MilledEntries, MilledPart, PartByHand
from trueloop.jobs.factory.by_hand import (
    HandRequest,
    correct_by_hand,
    hand_files,
    made_before,
    part_by_hand,
    tolerances_before,
    tried_by_hand,
)
from trueloop.jobs.factory.hand_job import AskedMilled, AskedPart, AskedReadings, MilledReadings
from trueloop.jobs.factory.hand_mill import keep_milled, mill_files, milled_entries, milled_part
from trueloop.jobs.factory.uploads import add_upload, upload_of
from trueloop.server.apart.reading import answered, in_turn
from trueloop.server.etags import Say
from trueloop.server.guarded import By, Here, router

routes = router()


@dataclass(frozen=True)
class MeasuredPart:
    """The part, and what was measured of it."""

    part: AskedPart
    measured: AskedReadings


@routes.post("/by-hand/part")
async def show_part(body: AskedPart, here: Here, who: By, say: Say) -> PartByHand:
    """The part that a finish program cuts, and what to measure of it. Nothing is kept."""
    asked = HandRequest(body, None, who.name, say)

    def read() -> PartByHand:
        with hand_files(here.store, asked) as handed:
            found = answered(here.settings.limits, handed, part_by_hand)
        return replace(
            found,
            made_before=made_before(here.store, body, found.tools),
            tolerances=tolerances_before(here.store, body.program, found.unit),
        )

    return await in_turn(here, read)


@routes.post("/by-hand/correction", status_code=201)
async def correct(body: MeasuredPart, here: Here, who: By, say: Say) -> CorrectedByHand:
    """The correction by what was measured; a part with a serial number is kept with it."""
    asked = HandRequest(body.part, body.measured, who.name, say)
    first = partial(answered, here.settings.limits, reading=tried_by_hand)
    return await in_turn(here, partial(correct_by_hand, here.store, asked, here.clock(), first))


@dataclass(frozen=True)
class MeasuredMilled:
    """The milled part, and what was measured of it."""

    part: AskedMilled
    measured: MilledReadings


@routes.post("/by-hand/milled")
async def show_milled(body: AskedMilled, here: Here, who: By, say: Say) -> MilledPart:
    """The features that a finish program mills, and what to measure of them. Nothing is kept."""

    def read() -> MilledPart:
        with mill_files(here.store, body, None, who.name, say) as handed:
            return answered(here.settings.limits, handed, milled_part)

    return await in_turn(here, read)


@routes.post("/by-hand/entries", status_code=201)
async def enter(body: MeasuredMilled, here: Here, who: By, say: Say) -> MilledEntries:
    """The numbers to enter by what was measured of a milled part; one with a serial number is kept in the store."""

    def read() -> MilledEntries:
        with mill_files(here.store, body.part, body.measured, who.name, say) as handed:
            found = answered(here.settings.limits, handed, milled_entries)
        texts = found.files.items()
        kept = [add_upload(here.store, name, text.encode(), who.name, here.clock()) for name, text in texts]
        known = keep_milled(here.store, body.part, body.measured, found.inspections, who.name)
        return replace(found.shown, files=tuple(FileMade(upload.name, upload.sha256) for upload in kept), kept=known)

    return await in_turn(here, read)


@routes.get("/uploads/{sha}/file", response_class=Response)
async def show_file(sha: str, here: Here, who: By) -> Response:
    """A file that was handed over or made, as an attachment, for this account and a day."""
    found = await run_in_threadpool(upload_of, here.store, sha, who.name)
    name = "".join(
        letter if letter.isascii() and letter.isprintable() and letter not in '"\\' else "_" for letter in found.name
    )
    return Response(
        found.content,
        headers={"Content-Disposition": f'attachment; filename="{name}"'},
        media_type="application/octet-stream",
    )
