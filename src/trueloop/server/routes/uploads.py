"""Files handed over: read and shown first, then kept as a program or as what was measured; and certificates."""

from dataclasses import dataclass
from typing import Annotated, Literal

from fastapi import Query, Request
from pydantic import AwareDatetime, Field
from starlette.concurrency import run_in_threadpool

from trueloop.domain.option import Language
from trueloop.factory.shown.records import certificate_row
from trueloop.factory.views.parts import CertificateRow
from trueloop.factory.views.uploads import ImportedView, UploadView
from trueloop.jobs.factory.correction_page import certify
from trueloop.jobs.factory.imports import OfPart, import_measurement, import_program
from trueloop.jobs.factory.uploads import ReadingOptions, add_upload, inspected, program_read, upload_of, upload_view
from trueloop.server.apart.reading import read_apart
from trueloop.server.etags import Say
from trueloop.server.guarded import By, Here, Row, factory_by, router

routes = router()
Name = Annotated[str, Query(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f]+$")]
Mapping = Annotated[str, Field(max_length=100_000)]


@dataclass(frozen=True)
class AsProgram:
    """How an NC program is to be read."""

    dialect: str | None = None
    unit: Literal["mm", "inch"] | None = None


@dataclass(frozen=True)
class AsMeasurement:
    """Of which part of which order it is, after what it was measured, and how it is to be read."""

    order: str
    part: Row
    after: Literal["semifinish", "finish", "released"] = "released"
    run: Row | None = None
    measured_at: AwareDatetime | None = None
    unit: Literal["mm", "inch"] | None = None
    mapping_toml: Mapping = ""


@dataclass(frozen=True)
class CertifyPart:
    """Which part; `u_um`: standard uncertainty of readings that state none."""

    part: Row
    language: Language = "en"
    u_um: Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)] | None = None


@routes.post("/uploads", status_code=201)
async def upload(request: Request, name: Name, here: Here, who: By, say: Say) -> UploadView:
    """A file, as the request's body. Nothing of it is a fact yet; it is forgotten after a day."""
    content = await request.body()
    kept = await run_in_threadpool(add_upload, here.store, name, content, who.name, here.clock())
    return await read_apart(here, kept, ReadingOptions(), upload_view, say)


@routes.post("/uploads/{sha}/read")
async def read(sha: str, body: ReadingOptions, here: Here, who: By, say: Say) -> UploadView:
    """Reads the file again in another way."""
    found = await run_in_threadpool(upload_of, here.store, sha, who.name)
    return await read_apart(here, found, body, upload_view, say)


@routes.post("/uploads/{sha}/program", status_code=201)
async def as_program(sha: str, body: AsProgram, here: Here, who: By, say: Say) -> ImportedView:
    """Kept as a program, which may be released then."""
    asked = ReadingOptions("program", body.dialect, body.unit)
    found = await run_in_threadpool(upload_of, here.store, sha, who.name)
    known = await read_apart(here, found, asked, program_read, say)
    return await run_in_threadpool(import_program, here.store, found, known, factory_by(who))


@routes.post("/uploads/{sha}/measurement", status_code=201)
async def as_measurement(sha: str, body: AsMeasurement, here: Here, who: By, say: Say) -> ImportedView:
    """Kept as what was measured of a part."""
    asked = ReadingOptions("measurement", None, body.unit, body.order, body.mapping_toml)
    of = OfPart(body.order, body.part, body.after, body.run, body.measured_at)
    found = await run_in_threadpool(upload_of, here.store, sha, who.name)
    known = await read_apart(here, found, asked, inspected)
    given = (found, known, of, factory_by(who), here.clock())
    return await run_in_threadpool(import_measurement, here.store, *given, say=say)


@routes.post("/certificates", status_code=201)
def certificate(body: CertifyPart, here: Here, who: By) -> CertificateRow:
    """A part's certificate, from what is known of it now."""
    sha256 = certify(here.store, body.part, body.language, factory_by(who), here.clock(), body.u_um)
    return certificate_row(here.store, body.part, sha256)
