"""The client with a service that is not there, another program than was sent, or the key of another machine."""

from base64 import b64encode
from contextlib import closing
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from hashlib import sha256
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from trueloop.controllers.linuxcnc.cell.client import Client, Offered, Pace, RefusedError, Service
from trueloop.controllers.linuxcnc.cell.decide import ControlNow, Doing, Patience
from trueloop.controllers.linuxcnc.cell.journal import Entry, Journal
from trueloop.controllers.linuxcnc.cell.linuxcnc import EMPTY
from trueloop.domain.factory import FactKind
from trueloop.errors import Code, TrueloopError
from trueloop.nc.witness import witnessed

KEY = "O1.1.0.1"
TEXT = witnessed(b"(PROBEOPEN t.txt)\nG38.2 X0\nM2\n", KEY)
PACE = Pace(0, 0, 0, 0, Patience(0, 20, 0))


@dataclass
class Table:
    """A control whose every state the test sets."""

    state: ControlNow = field(default_factory=lambda: ControlNow(Doing.IDLE, "", 9.0))
    log: str = ""
    files: dict[str, bytes] = field(default_factory=dict)
    starts: int = 0
    alters: bool = False

    def now(self) -> ControlNow:
        return self.state

    def witness(self) -> str:
        return self.log

    def write(self, name: str, text: bytes) -> None:
        self.files[name] = text.replace(b"X0", b"X9") if self.alters else text

    def read_back(self, name: str) -> bytes | None:
        return self.files.get(name)

    def open(self, name: str) -> None:
        self.state = ControlNow(Doing.IDLE, name, 9.0)

    def clear(self, name: str) -> None:
        self.files.pop(name, None)
        if self.state.program == name:
            self.state = ControlNow(Doing.IDLE, "", 9.0)

    def cycle_start(self) -> None:
        self.starts += 1

    def touches(self, name: str) -> bytes | None:
        return self.files.get(name)

    def discard_touches(self, name: str) -> None:
        self.files.pop(name, None)


@dataclass
class Office:
    """A service that offers one block and keeps what it is told."""

    offer: Offered | None = field(
        default_factory=lambda: Offered(KEY, "lathe", "probe", sha256(TEXT).hexdigest(), TEXT, True)
    )
    away: bool = False
    never: str = ""
    told: list[Entry] = field(default_factory=list)
    words: list[Any] = field(default_factory=list)

    def next(self) -> Offered | None:
        self._reached()
        return self.offer

    def tell(self, entries: list[Entry]) -> None:
        self._reached()
        if self.never in [one.values.get("what") for one in entries]:
            raise RefusedError(Code.CEL_SERVICE, f"it never {self.never}", hint="see what the cell noted")
        self.told += entries

    def heartbeat(self, said: Any) -> None:
        self._reached()
        self.words.append(said)

    def _reached(self) -> None:
        if self.away:
            raise TrueloopError(Code.CEL_SERVICE, "0 answers", hint="wait")

    def facts(self) -> list[str]:
        return [str(one.values["what"]) for one in self.told if one.what == "fact"]


def _client(folder: Path, table: Table, office: Office) -> Client:
    return Client("lathe", table, office, Journal(folder / "cell.journal"), PACE)  # type: ignore[arg-type]


def _steps(client: Client, count: int = 30) -> None:
    for _ in range(count):
        client.step()


def test_a_block_is_sent_read_back_started_and_told(tmp_path: Path) -> None:
    table, office = Table(), Office()
    client = _client(tmp_path, table, office)
    _steps(client, 6)
    assert table.starts == 1
    table.files["t.txt"], table.log = b"1 2 3", f"{KEY} started\n{KEY} ended\n"
    office.offer = None
    _steps(client)
    assert office.facts() == ["sent", "verified", "started", "ended"]
    assert [one.values["file"] for one in office.told if one.what == "touches"] == [b64encode(b"1 2 3").decode()]
    assert table.starts == 1 and client.known.run is None and table.files == {"t.txt": b"1 2 3"}


@pytest.mark.parametrize("line", ["(PROBEOPEN t.txt)", "(LOGOPEN,t.txt)", "( logopen , t.txt )"])
def test_the_file_that_a_gauging_program_writes_is_gathered(tmp_path: Path, line: str) -> None:
    """By PROBEOPEN or, as those of `trueloop probe program`, by LOGOPEN; never the log of its witness."""
    text = witnessed(f"{line}\nG38.2 X0\n(LOG,#5061)\nM2\n".encode(), KEY)
    table, office = Table(), Office(Offered(KEY, "lathe", "probe", sha256(text).hexdigest(), text, True))
    client = _client(tmp_path, table, office)
    _steps(client, 3)
    assert client.known.run is not None and client.known.run.touches == "t.txt"


def test_what_stands_in_for_no_program_is_not_told_as_one(tmp_path: Path) -> None:
    table, office = Table(ControlNow(Doing.IDLE, EMPTY, 9.0)), Office(None)
    client = _client(tmp_path, table, office)
    _steps(client, 1)
    table.state = ControlNow(Doing.IDLE, "part.ngc", 9.0)
    _steps(client, 1)
    assert [(one["state"], one["program"]) for one in office.words] == [("idle", ""), ("idle", "part.ngc")]


def test_a_lost_network_stops_the_next_cut_alone(tmp_path: Path) -> None:
    table, office = Table(), Office()
    client = _client(tmp_path, table, office)
    _steps(client, 6)
    office.away = True
    table.files["t.txt"], table.log = b"1 2 3", f"{KEY} started\n{KEY} ended\n"
    _steps(client)
    client.journal.close()
    assert office.facts() == ["sent", "verified"]
    again = _client(tmp_path, table, office)
    _steps(again)
    assert again.known.run is None and len(again.known.waiting) == 3
    office.away, office.offer = False, None
    _steps(again)
    assert office.facts() == ["sent", "verified", "started", "ended"]
    assert office.told[-1].what == "touches" and not again.known.waiting and table.starts == 1


def test_of_a_batch_that_is_refused_only_what_is_wrong_is_given_up(tmp_path: Path) -> None:
    table, office = Table(), Office()
    client = _client(tmp_path, table, office)
    _steps(client, 6)
    office.away = True
    table.files["t.txt"], table.log = b"1 2 3", f"{KEY} started\n{KEY} ended\n"
    _steps(client, 6)
    office.away, office.offer, office.never = False, None, "started"
    _steps(client)
    assert office.facts() == ["sent", "verified", "ended"] and not client.known.waiting
    (refused,) = client.known.refused
    (given_up,) = (one for one in client.journal.entries if one.no in refused["entries"])
    assert given_up.values["what"] == "started" and refused["said"] == "it never started"


@pytest.mark.parametrize(
    ("status", "content", "is_refusal"),
    [
        (422, b'{"code": "SRV-REQUEST", "detail": "facts.0.at"}', True),
        (404, b'{"code": "FAC-UNKNOWN", "detail": "run"}', True),
        (409, b'{"code": "FAC-TOUCHES", "detail": "another"}', True),
        (422, b'{"code": "STO-FILE", "detail": "connection refused"}', False),
        (422, b'{"code": "STO-DAMAGED", "detail": "row 7"}', False),
        (400, b'{"code": "SRV-ONCE", "detail": "a proxy took the header"}', False),
        (404, b"<html>nginx</html>", False),
        (410, b"", False),
        (422, b'{"detail": "no code"}', False),
    ],
)
def test_only_a_reasoned_refusal_of_the_entry_itself_ends_it(status: int, content: bytes, is_refusal: bool) -> None:
    class Answers(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            self.send_response(status)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Answers) as server:
        Thread(target=server.handle_request, daemon=True).start()
        service = Service(f"http://127.0.0.1:{server.server_port}", "key")
        with closing(service), pytest.raises(TrueloopError) as raised:
            service.tell([Entry(1, "fact", {"run": KEY})])
    assert isinstance(raised.value, RefusedError) is is_refusal


def test_what_was_read_back_otherwise_is_told_and_never_loaded(tmp_path: Path) -> None:
    table, office = Table(alters=True), Office()
    client = _client(tmp_path, table, office)
    _steps(client, 4)
    office.offer = None
    _steps(client)
    assert list(dict.fromkeys(office.facts())) == ["sent", "verified"]
    read = [one.values["values"].get("read_back_sha256") for one in office.told]
    assert read[-1] == sha256(TEXT.replace(b"X0", b"X9")).hexdigest()
    assert table.starts == 0 and table.state.program == "" and client.known.run is None


def test_a_program_edited_after_it_was_verified_is_not_started(tmp_path: Path) -> None:
    table, office = Table(), Office()
    client = _client(tmp_path, table, office)
    while client.known.run is None or not client.known.run.opened:
        client.step()
    table.files[f"{KEY}.ngc"] = TEXT + b"G0 X1\n"
    _steps(client, 4)
    office.offer = None
    _steps(client)
    assert table.starts == 0 and office.facts() == ["sent", "verified", "verified"]


def test_told_to_start_and_killed_it_is_unknown_and_never_started_again(tmp_path: Path) -> None:
    table, office = Table(), Office()
    client = _client(tmp_path, table, office)
    while not table.starts:
        client.step()
    client.journal.close()
    again = _client(tmp_path, table, office)
    _steps(again)
    assert again.said == "it may have begun"
    table.state = ControlNow(Doing.IDLE, f"{KEY}.ngc", 21.0)
    _steps(again)
    assert office.facts()[-1] == FactKind.UNKNOWN.value and table.starts == 1
    office.offer = None
    table.log = f"{KEY} started\n{KEY} ended\n"  # it was made: the machine says so later
    _steps(again)
    assert office.facts()[-2:] == ["started", "ended"] and table.starts == 1


def test_not_armed_it_waits_for_cycle_start(tmp_path: Path) -> None:
    table, office = Table(), Office(Offered(KEY, "lathe", "probe", sha256(TEXT).hexdigest(), TEXT, False))
    client = _client(tmp_path, table, office)
    _steps(client)
    assert table.starts == 0 and table.state.program == f"{KEY}.ngc"
    table.state = ControlNow(Doing.RUNNING, f"{KEY}.ngc")
    _steps(client, 3)
    assert office.facts()[-1] == "started"
    assert [one.values["witness"] for one in office.told][-1] == "control"


def test_a_block_that_is_withdrawn_is_unloaded(tmp_path: Path) -> None:
    table, office = Table(), Office(Offered(KEY, "lathe", "probe", sha256(TEXT).hexdigest(), TEXT, False))
    client = _client(tmp_path, table, office)
    _steps(client)
    office.offer = None
    _steps(client)
    assert table.state.program == "" and not table.files and client.known.run is None


@pytest.mark.parametrize(
    "offer",
    [
        Offered(KEY, "mill", "probe", sha256(TEXT).hexdigest(), TEXT, True),
        Offered(KEY, "lathe", "probe", "0" * 64, TEXT, True),
        Offered(KEY, "lathe", "probe", sha256(b"M2").hexdigest(), b"M2", True),
    ],
    ids=["another machine", "another text", "no witness"],
)
def test_what_is_not_for_this_cell_is_not_taken(tmp_path: Path, offer: Offered) -> None:
    table, office = Table(), Office(offer)
    client = _client(tmp_path, table, office)
    _steps(client, 5)
    assert client.fault is not None and client.fault.code is Code.CEL_OFFER
    assert not table.files and not office.told


def test_a_key_that_is_over_is_never_taken_again(tmp_path: Path) -> None:
    """As after the service's store was restored from an older copy."""
    table, office = Table(), Office()
    client = _client(tmp_path, table, office)
    _steps(client, 6)
    table.log = f"{KEY} started\n{KEY} ended\n"
    _steps(client, 10)
    before = len(office.told)
    _steps(client, 4)
    assert table.starts == 1 and client.known.run is None
    assert "ended" in [str(one.values.get("what")) for one in office.told[before:]]


def test_a_temperature_is_told_as_of_when_it_was_measured(tmp_path: Path) -> None:
    table, office = Table(), Office(None)
    client = _client(tmp_path, table, office)
    before = datetime.now(UTC)
    client.temperatures({"spindle": 23.5}, 700.0)
    _steps(client, 2)
    (told,) = [one for one in office.told if one.what == "temperatures"]
    at = datetime.fromisoformat(str(told.values["at"]))
    assert timedelta(0) <= at - (before - timedelta(seconds=700)) < timedelta(seconds=60)
