"""The service in this process: a store, a clock that tests turn, accounts of every role, and clients."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import cache
from itertools import count
from typing import Any
from unittest.mock import patch

from fastapi import FastAPI
from fastapi.testclient import TestClient
from httpx2 import Response

from trueloop.server.app import create_app
from trueloop.server.identity import accounts
from trueloop.server.identity.accounts import NewAccount, add_account, hashed
from trueloop.server.identity.keys import ROLES, NewKey, add_key
from trueloop.server.identity.oidc import Oidc
from trueloop.server.settings import Settings
from trueloop.storage.store import Store

PASSWORD = "four words, none alike"
ORIGIN = "http://localhost"
API = "/api/v1"
_KEYS = count()


@dataclass
class Clock:
    """Stands still until a test turns it."""

    at: datetime = datetime(2026, 1, 2, 8, 0, tzinfo=UTC)

    def __call__(self) -> datetime:
        return self.at

    passed_s: float = 0.0

    def turn(self, **by: float) -> None:
        """So much time passes."""
        self.at += timedelta(**by)
        self.passed_s += timedelta(**by).total_seconds()

    def set(self, **by: float) -> None:
        """Somebody sets the clock, and no time passes."""
        self.at += timedelta(**by)

    def seconds(self) -> float:
        """A clock that nobody sets."""
        return self.passed_s


@dataclass
class Caller:
    """A browser with its cookies, or a program with its key."""

    client: TestClient
    headers: Mapping[str, str] = field(default_factory=dict)

    def ask(self, method: str, path: str, **given: Any) -> Response:
        """A request as the pages send it: with Origin and a new Idempotency-Key, unless told otherwise."""
        usual = {"Origin": ORIGIN, "Idempotency-Key": f"k{next(_KEYS)}"} if method != "GET" else {}
        headers = {**usual, **self.headers, **given.pop("headers", {})}
        return self.client.request(method, path if path.startswith("/") else f"{API}/{path}", headers=headers, **given)

    def get(self, path: str, **given: Any) -> Response:
        return self.ask("GET", path, **given)

    def post(self, path: str, body: object = None, **given: Any) -> Response:
        return self.ask("POST", path, json=body if body is not None else {}, **given)


@dataclass
class Running:
    """A service with accounts `viewer` … `admin`, all of one password, made once per test."""

    store: Store
    clock: Clock
    app: FastAPI

    def caller(self) -> Caller:
        """Nobody yet."""
        return Caller(TestClient(self.app, base_url=ORIGIN, raise_server_exceptions=False))

    def signed_in(self, name: str) -> Caller:
        """An account of that name, which is its role."""
        caller = self.caller()
        assert caller.post("session", {"name": name, "password": PASSWORD}).status_code == 200
        return caller

    def cell(self, machine: str = "lathe", days: int = 30) -> Caller:
        """A cell with a key of that machine."""
        made = add_key(self.store, NewKey(machine, f"cell of {machine}", days), "test", self.clock())
        return Caller(self.caller().client, {"Authorization": f"Bearer {made.key}"})


@cache
def _hashed(password: str, name: str) -> str:
    return hashed(password, name)


def started(
    store: Store, settings: Settings | None = None, clock: Clock | None = None, oidc: Oidc | None = None
) -> Running:
    """A service on a store that has no accounts yet."""
    clock = clock or Clock()
    with patch.object(accounts, "hashed", _hashed):
        for role in ROLES:
            add_account(store, NewAccount(role, role, PASSWORD), clock())
    return Running(
        store, clock, create_app(store, settings or Settings(poll_s=0.01, workers=0), clock, oidc, clock.seconds)
    )


def problem(answer: Response) -> str:
    """The code of a refusal, in its proper form."""
    assert answer.headers["content-type"] == "application/problem+json", answer.text
    said = answer.json()
    assert said["status"] == answer.status_code
    assert "Traceback" not in answer.text
    assert said["detail"] and said["hint"]
    return str(said["code"])
