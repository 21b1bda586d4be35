"""Accounts and keys, for administrators."""

from dataclasses import dataclass

from fastapi import Request, Response

from trueloop.server import etags
from trueloop.server.guarded import By, Here, RowPath, router
from trueloop.server.identity import accounts, keys
from trueloop.server.identity.accounts import AccountRow, Change, NewAccount
from trueloop.server.identity.keys import KeyRow, MadeKey, NewKey

routes = router()


@dataclass(frozen=True)
class Accounts:
    """All of them."""

    items: list[AccountRow]


@dataclass(frozen=True)
class Keys:
    """All of them."""

    items: list[KeyRow]


@routes.get("/accounts")
def list_accounts(here: Here) -> Accounts:
    """All accounts, by name."""
    return Accounts(accounts.accounts(here.store))


@routes.post("/accounts", status_code=201)
def add_account(body: NewAccount, here: Here, who: By, response: Response) -> AccountRow:
    """A new account."""
    made = accounts.add_account(here.store, body, here.clock(), by=who.name)
    etags.tag(response, made.etag)
    return made


@routes.patch("/accounts/{name}")
def change_account(name: str, change: Change, here: Here, who: By, request: Request, response: Response) -> AccountRow:
    """Another role, password, language or state; its sessions end."""
    changed = accounts.change_account(here.store, name, change, here.clock(), etags.wanted(request), by=who.name)
    etags.tag(response, changed.etag)
    return changed


@routes.get("/keys")
def list_keys(here: Here) -> Keys:
    """All keys, newest first; none of them can be used by what is shown."""
    return Keys(keys.keys(here.store))


@routes.post("/keys", status_code=201)
def add_key(body: NewKey, here: Here, who: By, request: Request) -> MadeKey:
    """A new key, shown this once: a repeated request is not answered with it."""
    request.state.secret_answer = True
    return keys.add_key(here.store, body, who.name, here.clock())


@routes.delete("/keys/{id}", status_code=204)
def end_key(id: RowPath, here: Here, who: By) -> None:
    """Ends a key."""
    keys.end_key(here.store, id, here.clock(), by=who.name)
