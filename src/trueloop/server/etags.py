"""Optimistic locking over HTTP: `ETag` in answers, `If-Match` in changes.

How a reader wants to be told what is said in sentences and pictures: `Say`, his language and his unit of lengths.

Numbers of an answer are in mm and µm whatever he wants; their names say so.
"""

from typing import Annotated

from fastapi import Depends, Request, Response

from trueloop.domain.option import Language, LengthUnit
from trueloop.errors import Code
from trueloop.report.texts.texts import Texts
from trueloop.server.identity.accounts import stale


def wanted(request: Request) -> str:
    """Returns the ETag of the request's `If-Match`. Raises SRV-MATCH where there is none, or `*`."""
    given = request.headers.get("if-match", "").strip()
    if not given or given == "*":
        raise Code.SRV_MATCH.refusal(
            f"the header 'If-Match' is {given or 'missing'}: a change needs the ETag that was read",
            hint="read the resource, and send its ETag as `If-Match`",
        )
    return given.removeprefix("W/").strip('"')


def require_same(request: Request, now: str) -> None:
    """Raises SRV-MATCH without an ETag, SRV-STALE where it is not the present one."""
    given = wanted(request)
    if given != now:
        raise stale(given, now)


def tag(response: Response, etag: str) -> None:
    """Sets the ETag of an answer."""
    response.headers["ETag"] = f'"{etag}"'


def reader_of(request: Request) -> Texts:
    """Returns the language and the unit of who asks: those of the address, else the language of `Accept-Language`."""
    language = request.query_params.get("language") or request.headers.get("accept-language", "")
    unit: LengthUnit = "inch" if request.query_params.get("unit") == "inch" else "mm"
    return Texts("de" if language.lower().startswith("de") else "en", unit)


def _texts(request: Request, language: Language | None = None, unit: LengthUnit = "mm") -> Texts:
    return Texts(language or reader_of(request).language, unit)


Say = Annotated[Texts, Depends(_texts)]
