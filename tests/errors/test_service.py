"""Every way in which the service refuses."""

from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from unittest.mock import patch

from starlette.requests import Request

from tests.support.awaited import awaited
from trueloop.errors import Code, TrueloopError
from trueloop.server import etags, manual, once, problems
from trueloop.server.access import ADMIN, require
from trueloop.server.apart.reading import not_read
from trueloop.server.gates import too_large
from trueloop.server.guarded import asked_of, require_origin
from trueloop.server.identity import accounts, attempts, keys, sessions
from trueloop.server.identity.keys import Who
from trueloop.server.identity.oidc import Oidc, SignIns, require_safe_issuer
from trueloop.server.routes import shown
from trueloop.server.run import Listening, listen, require_safe
from trueloop.server.settings import Settings, require_packages
from trueloop.storage.store import Store, open_store

AT = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)


def _store() -> Store:
    return open_store("sqlite://", create=True)


def _request(**headers: str) -> Request:
    raw = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
    scope = {"type": "http", "method": "PATCH", "path": "/x", "query_string": b"", "headers": raw, "state": {}}
    return Request(scope)


def _missing() -> None:
    with patch("trueloop.server.settings.find_spec", lambda _: None):
        require_packages()


def _too_often() -> None:
    store, tried = _store(), attempts.Attempts(count(0.0, 0.001).__next__)
    for _ in range(attempts.OF_ACCOUNT.free):
        with suppress(TrueloopError), tried.attempt("otto", "127.0.0.1"):
            sessions.account_by_password(store, "otto", "correct horse battery")
    with tried.attempt("otto", "127.0.0.1"):
        pass


def _twice() -> None:
    store = _store()
    for body in ("1" * 64, "2" * 64):
        once.begin(store, once.KeyedRequest("person::otto", "k-1", body), AT)


def _another_host() -> None:
    from trueloop.server.gates import require_host

    require_host(Settings(), "evil.example")


def _login() -> None:
    sessions.account_by_password(_store(), "otto", "correct horse battery")


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.SRV_TLS: lambda: require_safe(Listening("0.0.0.0")),
    Code.SRV_PACKAGE: _missing,
    Code.SRV_MANUAL: lambda: manual.require_built(Path("not-built")),
    Code.SRV_ADDRESS: lambda: listen(Listening("192.0.2.1", 8080)),  # an address for documents, no machine's
    Code.SRV_SIGN_IN: lambda: sessions.of_cookie(_store(), Settings(), "x", AT),
    Code.SRV_LOGIN: _login,
    Code.SRV_OIDC: lambda: SignIns(Oidc("https://login.example", "factory")).claims({"state": "x"}, "", AT),
    Code.SRV_PROVIDER: lambda: require_safe_issuer("http://login.example"),
    Code.SRV_DELAY: _too_often,
    Code.SRV_ROLE: lambda: require(ADMIN, Who("otto", "viewer", session="1")),
    Code.SRV_KEY: lambda: keys.of_bearer(_store(), "Bearer tl_x", AT),
    Code.SRV_ORIGIN: lambda: require_origin(Settings(), _request(origin="http://evil.example", host="localhost")),
    Code.SRV_HOST: _another_host,
    Code.SRV_REQUEST: lambda: _raise(problems.refused_request("the request does not fit: body.'name' is missing")),
    Code.SRV_UNKNOWN: lambda: _raise(problems.nothing("part", "12")),
    Code.SRV_METHOD: lambda: _raise(problems.of_status(405, "PUT")),
    Code.SRV_LARGE: lambda: _raise(too_large(1024, "2048 bytes are declared")),
    Code.SRV_FILE: lambda: _raise(not_read("part.dxf", "it takes longer than 30 s")),
    Code.SRV_ONCE: lambda: awaited(asked_of(_request())),
    Code.SRV_REUSED: _twice,
    Code.SRV_STALE: lambda: etags.require_same(_request(if_match='"1"'), "2"),
    Code.SRV_MATCH: lambda: etags.require_same(_request(), "2"),
    Code.SRV_CURSOR: lambda: shown.place_of(b"secret", "parts", "AAAA"),
    Code.SRV_ACCOUNT: lambda: accounts.change_account(_store(), "otto", accounts.Change(disabled=True), AT),
    Code.SRV_PASSWORD: lambda: accounts.hashed("short"),
    Code.SRV_KEYS: lambda: keys.end_key(_store(), 7, AT),
    Code.SRV_INTERNAL: lambda: _raise(problems.unexpected(ValueError("x"), "00c0ffee")),
}


def _raise(error: Exception) -> None:
    raise error
