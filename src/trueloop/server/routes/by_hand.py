"""A part that a person measures and corrects, without an order."""

from dataclasses import dataclass, replace
from functools import partial

from fastapi import Response
from starlette.concurrency import run_in_threadpool

from trueloop.factory.views.by_hand import CorrectedByHand, PartByHand
from trueloop.jobs.factory.by_hand import (
    HandRequest,
    correct_by_hand,
    hand_files,
    made_before,
    part_by_hand,
    tolerances_before,
    tried_by_hand,
)
from trueloop.jobs.factory.hand_job import AskedPart, AskedReadings
from trueloop.jobs.factory.uploads import upload_of
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
