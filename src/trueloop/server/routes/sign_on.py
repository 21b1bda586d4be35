"""Signing in by an identity provider: where the browser is sent, and where it comes back."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from fastapi import Request, Response
from fastapi.responses import RedirectResponse
from sqlalchemy import Row

from trueloop.errors import TrueloopError
from trueloop.server import problems
from trueloop.server.guarded import Here, Service, router
from trueloop.server.identity import oidc, sessions
from trueloop.server.identity.accounts import FirstAccount
from trueloop.server.identity.oidc import LONGEST, SignIns
from trueloop.server.routes.session import set_cookie
from trueloop.wording import wording

routes = router("/session")
CALLBACK = "/api/v1/session/oidc/callback"


@dataclass(frozen=True)
class Ways:
    """How people sign in. `oidc`: the name of the identity provider, if any; `accounts`: whether there are any yet."""

    oidc: str | None
    accounts: bool


@routes.get("/ways")
def ways(request: Request) -> Ways:
    """How people can sign in."""
    found: SignIns | None = request.app.state.sign_ins
    first: FirstAccount = request.app.state.first
    return Ways(None if found is None else found.oidc.label, not first.fragment)


@routes.get("/oidc", status_code=302, response_class=RedirectResponse)
def begin(here: Here, request: Request) -> Response:
    """Sends the browser to the identity provider."""
    going = _sign_ins(request).begin(_redirect(here, request), here.clock())
    answer = RedirectResponse(going.address, 302)
    answer.set_cookie(_cookie(here), going.cookie, max_age=int(LONGEST.total_seconds()), **_kept(here))  # type: ignore[arg-type]
    return answer


@routes.get("/oidc/callback", status_code=303, response_class=RedirectResponse)
def end(here: Here, request: Request) -> Response:
    """Where it comes back: begins a new session of the account that is linked, and ends the one that was open.

    A browser that is refused comes to the page where one signs in, which says so.
    """
    now = here.clock()
    try:
        account = _account(here, request, now)
    except TrueloopError as refused:
        if "text/html" not in request.headers.get("accept", ""):
            raise
        return RedirectResponse(f"/?refused={refused.code.value}", 303)
    old = request.cookies.get(here.settings.cookie)
    if old:
        sessions.end_of_cookie(here.store, old, now)
    address = request.client.host if request.client else ""
    begun = sessions.begin(here.store, here.settings, account, address, now)
    answer = RedirectResponse("/", 303)
    answer.delete_cookie(_cookie(here), **_kept(here))  # type: ignore[arg-type]
    set_cookie(here, answer, begun.id)
    return answer


def _account(here: Service, request: Request, now: datetime) -> Row[Any]:
    sign_ins = _sign_ins(request)
    claims = sign_ins.claims(dict(request.query_params), request.cookies.get(_cookie(here), ""), now)
    return oidc.account_of(here.store, sign_ins.oidc, claims, now)


def _sign_ins(request: Request) -> SignIns:
    found: SignIns | None = request.app.state.sign_ins
    if found is None:
        raise problems.nothing(wording("way to sign in"), "oidc")
    return found


def _redirect(here: Service, request: Request) -> str:
    """Our own address by the name that the browser uses, which the gates have checked."""
    return f"{here.settings.scheme}://{request.headers['host']}{CALLBACK}"


def _cookie(here: Service) -> str:
    return "__Host-oidc" if here.settings.tls else "oidc"


def _kept(here: Service) -> dict[str, object]:
    return {"path": "/", "secure": here.settings.tls, "httponly": True, "samesite": "lax"}
