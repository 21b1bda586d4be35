"""Clients that open connections and send nothing, or a header a byte at a time: others sign in beside them."""

import json
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from http.client import HTTPConnection
from pathlib import Path

import pytest

from tests.support.new_stores import new_file
from tests.support.served import served
from tests.support.service import PASSWORD
from trueloop.jobs.store.codec import store_codec
from trueloop.server import run as connections
from trueloop.storage.store import Store, open_store


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = open_store(new_file(tmp_path / "trueloop.db"), codec=store_codec())
    yield opened
    opened.close()


def _place(address: str) -> tuple[str, int]:
    host, port = address.removeprefix("http://").split(":")
    return host, int(port)


def _signed_in(address: str) -> int:
    said = json.dumps({"name": "operator", "password": PASSWORD}).encode()
    headers = {"Origin": address, "Content-Type": "application/json"}
    with closing(HTTPConnection(*_place(address), timeout=20)) as calm:
        calm.request("POST", "/api/v1/session", said, headers)
        return calm.getresponse().status


@pytest.mark.parametrize("sent", [b"", b"GET /healthz HTTP/1.1\r\nX-Slow: "], ids=["nothing", "half a header"])
def test_260_connections_that_send_nothing_hold_nobody_up(store: Store, sent: bytes) -> None:
    with served(store) as address, ExitStack() as held:
        for _ in range(260):
            line = held.enter_context(socket.create_connection(_place(address), timeout=20))
            with suppress(ConnectionError):
                line.sendall(sent)
        begun = time.monotonic()
        assert [_signed_in(address) for _ in range(3)] == [200] * 3
        assert time.monotonic() - begun < 10


def test_one_address_takes_up_no_more_than_its_share(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those idle for longest are closed; one that is being answered stays."""
    monkeypatch.setattr(connections, "MOST_OF_ADDRESS", 5)
    with served(store) as address, ExitStack() as held:
        lines = [held.enter_context(socket.create_connection(_place(address), timeout=20)) for _ in range(8)]
        assert [line.recv(1) for line in lines[:3]] == [b""] * 3
        for line in lines[3:]:
            line.sendall(b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
            assert line.recv(100).startswith(b"HTTP/1.1 200")


@pytest.mark.parametrize("answered_before", [False, True])
def test_headers_that_do_not_come_end_the_connection(
    store: Store, monkeypatch: pytest.MonkeyPatch, answered_before: bool
) -> None:
    """However slowly they come, and also after a request that was answered."""
    monkeypatch.setattr(connections, "HEADERS_S", 1.5)
    monkeypatch.setattr(connections, "KEPT_ALIVE_S", 1)
    with served(store) as address, socket.create_connection(_place(address), timeout=20) as line:
        if answered_before:
            line.sendall(b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
            answer = b""
            while not answer.endswith(b"\r\n\r\nok\n"):
                answer += line.recv(10_000)
            assert answer.startswith(b"HTTP/1.1 200")
        begun = time.monotonic()
        line.settimeout(0.2)
        line.sendall(b"GET /healthz HTTP/1.1\r\nX-Slow: ")
        with suppress(ConnectionError):
            while time.monotonic() - begun < 15:
                line.sendall(b"x")
                with suppress(TimeoutError):
                    assert line.recv(1000) == b""
                    break
        assert 1.0 < time.monotonic() - begun < 10
