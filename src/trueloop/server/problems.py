"""Refusals as `application/problem+json`: of our own code, of a request that does not fit, of anything else.

No answer carries a traceback: what the service did not expect is logged with a number, and the answer has the number.
"""

import json
import secrets
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any, Final

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from trueloop.errors import Code, TrueloopError
from trueloop.report.texts.texts import Texts
from trueloop.server.etags import reader_of
from trueloop.server.settings import log
from trueloop.storage.engines import AWAY
from trueloop.wording import wording

_STATUS: Final[Mapping[str, int]] = {
    "SRV-SIGN-IN": 401,
    "SRV-LOGIN": 401,
    "SRV-OIDC": 401,
    "SRV-PROVIDER": 502,
    "SRV-KEY": 401,
    "SRV-ROLE": 403,
    "SRV-ORIGIN": 403,
    "SRV-DELAY": 429,
    "SRV-HOST": 421,
    "SRV-REQUEST": 422,
    "SRV-UNKNOWN": 404,
    "SRV-METHOD": 405,
    "SRV-LARGE": 413,
    "SRV-ONCE": 400,
    "SRV-CURSOR": 400,
    "SRV-REUSED": 409,
    "SRV-STALE": 412,
    "SRV-MATCH": 428,
    "SRV-ACCOUNT": 409,
    "SRV-INTERNAL": 500,
    "FAC-ROLE": 403,
    "FAC-MACHINE": 403,
    "FAC-UNKNOWN": 404,
    "FAC-STALE": 412,
    "FAC-PLAN": 422,
    "STO-FILE": 503,
    "STO-SCHEMA": 503,
    "STO-BUSY": 503,
    "STO-WRITE": 507,
}
_AGAIN_S: Final = 5
"""`Retry-After` where the store is away: what was sent may be right, and is to be sent again."""
_OF_OTHERS: Final = {
    404: (Code.SRV_UNKNOWN, "there is nothing at this address", "the addresses stand in /api/v1/openapi.json"),
    405: (Code.SRV_METHOD, "this address does not take that method", "the addresses stand in /api/v1/openapi.json"),
    400: (Code.SRV_REQUEST, "the request cannot be read", "send what /api/v1/openapi.json says"),
}
MEDIA: Final = "application/problem+json"
HUNG_UP: Final = 499
"""The status in log and figures of a request whose client went away before it was whole; nobody reads the answer."""


def status_of(code: Code) -> int:
    """Returns the HTTP status of a refusal: 409 where the factory refuses, 422 where a file or value does not fit."""
    return _STATUS.get(code.value, 409 if code.startswith("FAC-") else 422)


def answer_of(error: TrueloopError, say: Texts) -> Response:
    """Converts a refusal to an answer in the language of who asks."""
    status = status_of(error.code)
    headers = {}
    if error.code is Code.SRV_DELAY:
        headers["Retry-After"] = str(int(float(str(error.values.get("retry_after_s", 1)))))
    if error.code in AWAY:
        headers["Retry-After"] = str(_AGAIN_S)
    if status == HTTPStatus.UNAUTHORIZED:
        headers["WWW-Authenticate"] = "Bearer"
    content = {
        "type": f"/errors#{error.code.value}",
        "title": error.code.meaning,
        "status": status,
        "code": error.code.value,
        "detail": say.refusal(error.code.meaning, error.message),
        "hint": say.note(error.hint),
        "values": error.json_values,
        "override": error.override,
    }
    return Response(json.dumps(content, ensure_ascii=False), status, headers, MEDIA)


def refused_request(why: str, hint: str = "the shapes stand in /api/v1/openapi.json") -> TrueloopError:
    """Returns SRV-REQUEST, for a request whose values do not have the documented shape."""
    return Code.SRV_REQUEST.refusal(why, hint=hint)


def nothing(what: str, name: str) -> TrueloopError:
    """Makes the error SRV-UNKNOWN."""
    return Code.SRV_UNKNOWN.refusal(
        wording("there is no {what} {name!r}", what=what, name=name),
        hint=wording("look it up in the list"),
        values={"name": name},
    )


def of_status(status: int, name: str) -> TrueloopError:
    """Converts what the framework refuses to an error of ours; `name`: the method, or the address."""
    code, said, hint = _OF_OTHERS.get(status, _OF_OTHERS[400])
    return code.refusal(f"{said}: {name!r}", hint=hint, values=dict.fromkeys(code.values, name))


def unexpected(error: Exception, number: str = "") -> TrueloopError:
    """Makes SRV-INTERNAL for a fault; the log has the rest, under that number (a new one, if not given)."""
    number = number or secrets.token_hex(4)
    log("fault", number=number, error=f"{type(error).__name__}: {error}", where=_where(error))
    return Code.SRV_INTERNAL.refusal(
        wording("the service failed at this; fault {number} in its log", number=number),
        hint=wording("this is a fault of trueloop: report what the log says"),
        values={"number": number},
    )


def install(app: FastAPI) -> None:
    """Makes every refusal of an app a problem."""

    @app.exception_handler(TrueloopError)
    async def of_ours(request: Request, error: TrueloopError) -> Response:
        return answer_of(error, reader_of(request))

    @app.exception_handler(RequestValidationError)
    async def of_shape(request: Request, error: RequestValidationError) -> Response:
        why = wording("the request does not fit: {why}", why=_said(error.errors()))
        return answer_of(refused_request(why), reader_of(request))

    @app.exception_handler(HTTPException)
    async def of_framework(request: Request, error: HTTPException) -> Response:
        name = request.method if error.status_code == HTTPStatus.METHOD_NOT_ALLOWED else request.url.path
        answer = answer_of(of_status(error.status_code, name), reader_of(request))
        answer.headers.update(error.headers or {})
        return answer

    @app.exception_handler(ClientDisconnect)
    async def of_client_gone(_: Request, __: ClientDisconnect) -> Response:
        return Response(status_code=HUNG_UP)

    @app.exception_handler(Exception)
    async def of_fault(request: Request, error: Exception) -> Response:
        return answer_of(unexpected(error), reader_of(request))


def _said(errors: Sequence[Any]) -> str:
    """Where and what, without what was given: it may be a password."""
    return "; ".join(f"{'.'.join(map(str, error['loc']))}: {error['msg']}" for error in errors[:5])


def _where(error: Exception) -> list[str]:
    found, trace = [], error.__traceback__
    while trace is not None:
        code = trace.tb_frame.f_code
        found.append(f"{code.co_filename.rpartition('/')[2]}:{trace.tb_lineno} {code.co_name}")
        trace = trace.tb_next
    return found[-12:]
