"""Signing in and out, and who one is."""

from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any

from fastapi import Request, Response
from sqlalchemy import Row
from starlette.concurrency import run_in_threadpool

from trueloop.described import filled_from
from trueloop.domain.option import Language, LengthUnit
from trueloop.errors import Code
from trueloop.server.guarded import By, Here, Service, router
from trueloop.server.identity import accounts, sessions
from trueloop.server.identity.accounts import is_right
from trueloop.server.identity.keys import Role, Who
from trueloop.wording import wording

routes = router()


@dataclass(frozen=True)
class SignIn:
    """Name and password."""

    name: str
    password: str


@dataclass(frozen=True)
class First(SignIn):
    """The first account, an administrator; `secret`: from the link that the service printed as it started."""

    secret: str
    language: Language = "en"


@dataclass(frozen=True)
class Me:
    """Who is signed in. `unit`: of the lengths that pages show to him; all answers are in mm and µm."""

    name: str
    display: str
    role: Role
    language: str
    unit: LengthUnit
    expires_at: datetime | None


@dataclass(frozen=True)
class Mine:
    """Changes of people to their own account. A new password needs the present one, and ends all sessions."""

    language: Language | None = None
    unit: LengthUnit | None = None
    password: str | None = None
    present_password: str | None = None


def me_of(who: Who) -> Me:
    """As the pages want it."""
    return filled_from(Me, who)


def set_cookie(here: Service, response: Response, value: str) -> None:
    """The session's id, for this host alone and for no script."""
    response.set_cookie(here.settings.cookie, value, path="/", secure=here.settings.tls, httponly=True, samesite="lax")


@routes.post("/session")
def sign_in(body: SignIn, here: Here, request: Request, response: Response) -> Me:
    """Begins a new session, with an id that nobody knew before; the one that was open ends."""
    address = request.client.host if request.client else ""
    with here.attempts.attempt(body.name, address):
        account = sessions.account_by_password(here.store, body.name, body.password)
    return _begun(here, account, request, response)


@routes.post("/session/first")
def make_first_account(body: First, here: Here, request: Request, response: Response) -> Me:
    """Makes the first account of a new store, and begins its session."""
    first: accounts.FirstAccount = request.app.state.first
    first.add(body.secret, accounts.NewAccount(body.name, "admin", body.password, language=body.language), here.clock())
    account = sessions.account_by_password(here.store, body.name, body.password)
    return _begun(here, account, request, response)


def _begun(here: Service, account: Row[Any], request: Request, response: Response) -> Me:
    address = request.client.host if request.client else ""
    begun = sessions.begin(here.store, here.settings, account, address, here.clock())
    old = request.cookies.get(here.settings.cookie)
    if old:
        sessions.end_of_cookie(here.store, old, here.clock())
    set_cookie(here, response, begun.id)
    return me_of(begun.who)


@routes.delete("/session", status_code=204)
def sign_out(here: Here, who: By, response: Response) -> None:
    """Ends the session, here and in the browser."""
    sessions.end(here.store, who.session, here.clock())
    set_cookie_gone(here, response)


def set_cookie_gone(here: Service, response: Response) -> None:
    """Takes the cookie, and what the browser kept, away."""
    response.delete_cookie(here.settings.cookie, path="/", secure=here.settings.tls, httponly=True, samesite="lax")
    response.headers["Clear-Site-Data"] = '"cache", "storage"'


@routes.get("/me")
def me(who: By) -> Me:
    """Who is signed in."""
    return me_of(who)


@routes.patch("/me")
async def change_me(body: Mine, here: Here, who: By, request: Request, response: Response) -> Me:
    """Changes language, unit or password of one's own account; guessing the present one costs what signing in does."""
    address = request.client.host if request.client else ""

    def change() -> None:
        if body.password is not None:
            with here.attempts.attempt(who.name, address):
                if not is_right(accounts.stored_password(here.store, who.name), body.present_password or ""):
                    raise Code.SRV_LOGIN.refusal(
                        wording("the present password is not right"), hint=wording("type the password that holds now")
                    )
        wanted = accounts.Change(password=body.password, language=body.language, unit=body.unit)
        accounts.change_account(here.store, who.name, wanted, here.clock())

    await run_in_threadpool(change)
    if body.password is not None:
        set_cookie_gone(here, response)
    return me_of(replace(who, language=body.language or who.language, unit=body.unit or who.unit))
