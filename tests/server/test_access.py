"""Who gets in where: every address by every role and kind of key; and what a stranger tries besides."""

import json
import re
import select
import socket
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from datetime import UTC, datetime
from http.client import HTTPConnection
from itertools import product
from typing import Any

import pytest
from sqlalchemy import select as query

from tests.support.factory import Shop
from tests.support.full_shop import SCRIPT, full_shop
from tests.support.served import served
from tests.support.service import API, PASSWORD, Caller, Running, problem
from trueloop.factory.shown.programs import proposal_views
from trueloop.server.access import ACCESS
from trueloop.server.identity.keys import ROLES, NewKey, add_key
from trueloop.storage.schema import IDEMPOTENCY
from trueloop.storage.store import Store

LETS_IN = ("SRV-SIGN-IN", "SRV-ROLE", "SRV-KEY")
"""The refusals by which somebody does not get in; whatever else is answered, he was let in."""
STREAMS = ("/events", "/machines/{name:path}/trace", "/machines/{name:path}/corrector")
ENDS = (("DELETE", "/session"), ("POST", "/session"))
FILLED = {"{id}": "1", "{name}": "nobody", "{sha}": "0" * 64, "{a}": "0" * 64, "{b}": "1" * 64, "{part}": "1"}
FILLED |= {"{part_type:path}": "shaft", "{serial:path}": "a"}
FILLED |= {"{part_type}": "shaft", "{characteristic:path}": "dome", "{name:path}": "nobody/2"}


def asked(caller: Caller, method: str, path: str) -> str:
    """The code of the refusal; empty: none."""
    for name, value in FILLED.items():
        path = path.replace(name, value)
    given: dict[str, Any] = (
        {} if method == "GET" else {"content": b"{", "headers": {"Content-Type": "application/json"}}
    )
    answer = caller.ask(method, path[1:], **given)
    return problem(answer) if answer.status_code >= 400 else ""


def test_every_address_lets_in_whom_the_table_names_and_nobody_else(service: Running) -> None:
    people: dict[str, Caller] = {role: service.signed_in(role) for role in ROLES}
    metrics = add_key(service.store, NewKey("", "m", 30, scope="metrics"), "test", service.clock())
    keys = {
        "cell": service.cell(),
        "metrics": Caller(service.caller().client, {"Authorization": f"Bearer {metrics.key}"}),
    }
    nobody = service.caller()
    for (method, path), access in ACCESS.items():
        if path in STREAMS or (method, path) in ENDS:
            continue
        if access.open:
            assert asked(nobody, method, path) not in LETS_IN, (method, path)
            continue
        assert asked(nobody, method, path) == "SRV-SIGN-IN", (method, path)
        for role, caller in people.items():
            may = access.role is not None and ROLES.index(role) >= ROLES.index(access.role)
            assert (asked(caller, method, path) not in LETS_IN) is may, (method, path, role)
        for scope, caller in keys.items():
            assert (asked(caller, method, path) not in LETS_IN) is (access.key == scope), (method, path, scope)


@pytest.mark.parametrize("path", STREAMS)
def test_streams_are_for_who_is_signed_in(service: Running, path: str) -> None:
    assert asked(service.caller(), "GET", path) == "SRV-SIGN-IN"
    assert asked(service.cell(), "GET", path) == "SRV-KEY"


def test_the_key_of_one_machine_is_none_for_another(service: Running) -> None:
    shop = Shop(service.store).set_up()
    offer = shop.next()
    assert offer is not None
    fact = {"run": offer.run.key, "what": "started", "at": service.clock().isoformat(), "witness": "x", "values": {}}
    assert problem(service.cell("mill").post("cell/facts", {"facts": [fact]})) == "FAC-MACHINE"
    assert problem(service.cell("mill").post("machines/lathe/calibrated", {"values": {}})) == "FAC-MACHINE"
    assert problem(service.cell("mill").post(f"orders/{shop.order}/arm", {"parts": 1, "why": "x"})) == "FAC-ARM"


@pytest.mark.parametrize(
    "path",
    [
        "/../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/assets/../../access.py",
        "/..%5c..%5cetc",
        "//etc/passwd",
        "/%00",
    ],
)
def test_no_path_leads_out_of_the_pages(service: Running, path: str) -> None:
    answer = service.caller().client.get(f"http://localhost{path}")
    assert b"root:" not in answer.content and b"def access_of" not in answer.content
    assert answer.status_code in (200, 400, 404)


def test_a_body_of_two_gigabytes_is_refused_before_it_is_read(service: Running) -> None:
    otto = service.signed_in("operator")
    declared = {"Content-Length": f"{2 << 30}"}
    assert problem(otto.ask("POST", "uploads", params={"name": "a"}, content=b"", headers=declared)) == "SRV-LARGE"
    assert problem(otto.ask("POST", "orders/O1/hold", content=b" " * (2 << 20))) == "SRV-LARGE"


def test_a_body_without_end_is_cut_off(store: Store) -> None:
    """Over a real connection: pieces are sent until the service answers, and it answers soon after its limit."""
    with served(store) as address:
        host, port = address.removeprefix("http://").split(":")
        said = json.dumps({"name": "operator", "password": PASSWORD}).encode()
        with closing(HTTPConnection(host, int(port), timeout=30)) as calm:
            calm.request("POST", "/api/v1/session", said, {"Origin": address, "Content-Type": "application/json"})
            cookie = calm.getresponse().headers["set-cookie"].partition(";")[0]
        with socket.create_connection((host, int(port)), timeout=30) as line:
            headers = {"Host": f"{host}:{port}", "Origin": address, "Cookie": cookie, "Idempotency-Key": "k"}
            head = "".join(f"{name}: {value}\r\n" for name, value in headers.items())
            line.sendall(f"POST /api/v1/uploads?name=a HTTP/1.1\r\n{head}Transfer-Encoding: chunked\r\n\r\n".encode())
            sent = 0
            piece = b"10000\r\n" + bytes(1 << 16) + b"\r\n"
            with suppress(ConnectionError):
                while sent < (1 << 30) and not select.select([line], [], [], 0)[0]:
                    line.sendall(piece)
                    sent += 1 << 16
            assert b" 413 " in line.recv(1000).splitlines()[0]
    assert sent < (100 << 20)


def test_a_post_that_comes_twice_is_done_once_and_another_under_its_key_refused(service: Running) -> None:
    shop = full_shop(service.store)
    alarm = service.signed_in("viewer").get("alarms").json()["items"][0]["id"]
    otto, key = service.signed_in("operator"), {"Idempotency-Key": "seen it"}
    first = otto.post(f"alarms/{alarm}/acknowledge", {"why": "seen"}, headers=key)
    again = otto.post(f"alarms/{alarm}/acknowledge", {"why": "seen"}, headers=key)
    assert (first.status_code, again.status_code) == (200, 200) and again.headers["idempotent-replay"] == "true"
    assert problem(otto.post(f"alarms/{alarm}/acknowledge", {"why": "other"}, headers=key)) == "SRV-REUSED"
    assert problem(otto.post(f"alarms/{alarm}/acknowledge", {"why": "seen"})) == "FAC-STALE"
    ana = service.signed_in("engineer")
    assert ana.post(f"alarms/{alarm}/acknowledge", {"why": "seen"}, headers=key).status_code == 412  # her own key
    assert shop.order


def test_of_many_who_accept_one_proposal_one_does(service: Running) -> None:
    service.clock.at = datetime.now(UTC)  # a proposal is of its time
    full_shop(service.store)
    (proposal,) = (one for one in proposal_views(service.store, service.clock()) if one.state == "open")
    callers = [service.signed_in("engineer") for _ in range(4)]
    tag = callers[0].get(f"proposals/{proposal.id}").headers["etag"]

    def accept(caller: Caller) -> int:
        body = {"why": "as it says", "overrides": ["--old", "--alarm", "--large"]}
        return caller.post(f"proposals/{proposal.id}/accept", body, headers={"If-Match": tag}).status_code

    with ThreadPoolExecutor(4) as pool:
        found = sorted(pool.map(accept, callers))
    assert found[0] == 200 and set(found[1:]) <= {409, 412, 422}, found
    done = callers[0].get(f"proposals/{proposal.id}").json()
    assert (done["state"], done["decided_by"]) == ("accepted", "engineer")
    assert problem(callers[0].post(f"proposals/{proposal.id}/reject", {"why": "no"})) == "SRV-MATCH"


def test_names_that_are_scripts_come_as_text_and_nothing_else(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    for path in ("orders", "alarms", "parts", "programs", "machines", "today"):
        answer = vera.get(path)
        assert answer.headers["content-type"] == "application/json"
        assert (answer.headers["x-content-type-options"], answer.headers["cache-control"]) == ("nosniff", "no-store")
    assert any(SCRIPT in json.dumps(vera.get(path).json()) for path in ("orders", "alarms"))


def test_guessing_the_present_password_waits_as_signing_in_does(service: Running) -> None:
    otto = service.signed_in("operator")
    body = {"password": "another four words, all new", "present_password": "a guess"}
    codes = [problem(otto.ask("PATCH", "me", json=body)) for _ in range(7)]
    assert codes[0] == "SRV-LOGIN" and codes[-1] == "SRV-DELAY"


def test_nothing_of_a_new_accounts_password_is_kept_but_its_slow_hash(service: Running) -> None:
    root = service.signed_in("admin")
    new = {"name": "nina", "role": "viewer", "password": PASSWORD}
    assert root.post("accounts", new).status_code == 201
    with service.store.reading() as connection:
        assert connection.execute(query(IDEMPOTENCY)).all() == []
    assert problem(root.post("accounts", new)) == "SRV-ACCOUNT"


def test_a_number_that_no_row_has_is_refused(service: Running) -> None:
    """Of 40 digits, negative, or with a NUL: for every address and every role that it opens to."""
    people: dict[str, Caller] = {role: service.signed_in(role) for role in ROLES}
    cell = service.cell()
    for (method, path), access in ACCESS.items():
        if "{" not in path or path in STREAMS or access.open:
            continue
        caller = people[access.role] if access.role else cell
        for value in ("9" * 40, "-1", str(1 << 63), "a%00b"):
            given: dict[str, Any] = {} if method == "GET" else {"json": {"why": "x", "values": {}}}
            answer = caller.ask(method, f"{API}{re.sub('{[^}]*}', value, path)}", **given)
            assert answer.status_code < 500, (method, path, value, answer.text)
            if answer.status_code >= 400:
                problem(answer)
    for path in ("parts", "tasks", "certificates"):
        assert people["viewer"].get(f"{path}/{'9' * 40}{'/life' * (path == 'parts')}").status_code in (404, 422)


def test_a_client_that_hangs_up_is_no_fault(store: Store, capfd: pytest.CaptureFixture[str]) -> None:
    with served(store) as address:
        host, port = address.removeprefix("http://").split(":")
        head = f"Host: {host}:{port}\r\nOrigin: {address}\r\nContent-Type: application/json\r\nContent-Length: 100"
        with socket.create_connection((host, int(port)), timeout=30) as line:
            line.sendall(f"POST /api/v1/session HTTP/1.1\r\n{head}\r\n\r\n{{".encode())
            time.sleep(0.2)
        logged, end = "", time.monotonic() + 20
        while '"request"' not in logged and time.monotonic() < end:
            time.sleep(0.05)
            logged += capfd.readouterr().err
    assert '"status": 499' in logged and '"fault"' not in logged


def test_whatever_is_sent_no_answer_has_a_traceback(service: Running) -> None:
    ana = service.signed_in("engineer")
    bodies = (b"", b"[]", b"null", b'{"a":', b"\xff\xfe", b'{"why": "\\ud800"}', b"[" * 20_000)
    paths = ("orders", "orders/O1/hold", "proposals/x/accept", "alarms/1/acknowledge", "certificates", "uploads/x/read")
    for body, path in product(bodies, paths):
        answer = ana.ask("POST", path, content=body, headers={"Content-Type": "application/json"})
        assert 400 <= answer.status_code < 500, (path, body[:20], answer.text)
        problem(answer)
