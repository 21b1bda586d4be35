"""The reader, asked of an agent played here: numbered observations in a buffer, as MTConnect's part 1 has them."""

import json
import threading
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest

from tests.support.cli import invoke
from trueloop.controllers.linuxcnc.realtime.signals.mtconnect import read_current
from trueloop.controllers.mtconnect.agent import read
from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.history_csv import read_history

MODEL = """<MTConnectDevices xmlns="urn:mtconnect.org:MTConnectDevices:{version}"><Header instanceId="{instance}"
 version="{version}"/><Devices><Device id="d" name="lathe" uuid="1"><DataItems>
<DataItem category="SAMPLE" id="t1" name="spindle" type="TEMPERATURE" units="CELSIUS"/>
<DataItem category="EVENT" id="p" name="program" type="PROGRAM"/>
<DataItem category="CONDITION" id="s" type="SYSTEM"/></DataItems></Device></Devices></MTConnectDevices>"""
STREAMS = """<MTConnectStreams xmlns="urn:mtconnect.org:MTConnectStreams:{version}"><Header
 creationTime="2026-01-02T08:00:00Z" instanceId="{instance}" version="{version}" firstSequence="{first}"
 nextSequence="{next}" lastSequence="{last}"/><Streams><DeviceStream name="lathe" uuid="1"><ComponentStream
 component="Device" name="lathe" componentId="d">{rows}</ComponentStream></DeviceStream></Streams></MTConnectStreams>"""
REFUSED = """<MTConnectError xmlns="urn:mtconnect.org:MTConnectError:{version}"><Header instanceId="{instance}"
 version="{version}"/><Errors><Error errorCode="OUT_OF_RANGE">'from' must be at least {first}</Error></Errors>
</MTConnectError>"""
TAGS = {"t1": "Temperature", "p": "Program"}


class Played:
    """An agent with a buffer; `status` of its refusals is 200 before version 2 and 404 since."""

    def __init__(self, version: str = "1.7", status: int = 404, size: int = 100) -> None:
        self.version, self.status, self.size = version, status, size
        self.instance, self.rows, self.first = 1, list[tuple[str, str]](), 1
        self.after: list[tuple[str, str]] = []
        self.before_sample: Callable[[], None] = lambda: None
        self.document: bytes | None = None
        agent = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                status, content = agent.answer(self.path)
                self.send_response(status)
                self.send_header("Content-Length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *_: object) -> None: ...

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, args=(0.02,), daemon=True).start()

    def add(self, *rows: tuple[str, str]) -> None:
        """Item and value; the buffer drops its first ones."""
        self.rows += rows
        while len(self.rows) > self.size:
            self.rows.pop(0)
            self.first += 1

    def restart(self) -> None:
        self.instance, self.rows, self.first = self.instance + 1, [], 1

    def answer(self, path: str) -> tuple[int, bytes]:
        if self.document is not None:
            return 200, self.document
        parts = urlsplit(path)
        if parts.path == "/probe":
            return 200, self.filled(MODEL)
        numbered = list(enumerate(self.rows, self.first))
        following = self.first + len(self.rows)
        if parts.path == "/sample":
            self.before_sample()
            numbered = list(enumerate(self.rows, self.first))
            following = self.first + len(self.rows)
            asked, count = (int(parse_qs(parts.query)[key][0]) for key in ("from", "count"))
            if not self.first <= asked <= following:
                return self.status, self.filled(REFUSED)
            numbered = [row for row in numbered if asked <= row[0] < asked + count]
            following = min(following, asked + count)
        else:
            numbered = list({item: (number, (item, value)) for number, (item, value) in numbered}.values())
        return 200, self.filled(STREAMS, following, "".join(map(_row, numbered)))

    def filled(self, text: str, following: int = 0, rows: str = "") -> bytes:
        given = {"first": self.first, "next": following, "last": following - 1, "rows": rows}
        return text.format(version=self.version, instance=self.instance, **given).encode()


def _row(numbered: tuple[int, tuple[str, str]]) -> str:
    number, (item, value) = numbered
    stamp = f"2026-01-02T08:{number // 60:02d}:{number % 60:02d}Z"
    head = f'dataItemId="{item}" sequence="{number}" timestamp="{stamp}"'
    if item == "s":
        return f'<Condition><{value} {head} type="SYSTEM"/></Condition>'
    return f"<Samples><{TAGS[item]} {head}>{value}</{TAGS[item]}></Samples>"


@pytest.fixture
def agent() -> Iterator[Played]:
    played = Played()
    yield played
    played.server.shutdown()
    played.server.server_close()


def after(answers: int) -> Iterator[bool]:
    """Not before so many answers."""
    yield from [False] * (answers - 1)
    while True:
        yield True


def seen(agent: Played, answers: int) -> tuple[list[tuple[int, str, str]], list[str]]:
    said: list[str] = []
    ends = after(answers)
    found = read(agent.url, lambda: next(ends), said.append)
    return [(one.sequence, one.item.name or one.item.id, one.value) for one in found], said


@pytest.mark.parametrize("version", ["1.2", "1.3", "1.8", "2.0", "2.5"])
def test_what_is_current_and_what_comes_each_once(agent: Played, version: str) -> None:
    agent.version = version
    agent.add(("t1", "20.5"), ("p", "A.NC"), ("s", "Normal"), ("t1", "21"))
    waiting = iter([[("t1", "22"), ("s", "Fault")], [], [("p", "UNAVAILABLE")]])
    agent.before_sample = lambda: agent.add(*next(waiting))
    found, said = seen(agent, 4)
    assert found == [
        *[(2, "program", "A.NC"), (3, "s", "NORMAL"), (4, "spindle", "21")],
        *[(5, "spindle", "22"), (6, "s", "FAULT"), (7, "program", "UNAVAILABLE")],
    ]
    assert said == []


@pytest.mark.parametrize("status", [200, 404, 400])
def test_a_buffer_that_went_past_is_told(agent: Played, status: int) -> None:
    agent.size, agent.status = 5, status
    agent.add(("t1", "20"))
    many = iter([[("t1", str(k)) for k in range(20)], []])
    agent.before_sample = lambda: agent.add(*next(many))
    found, said = seen(agent, 3)
    assert found == [(1, "spindle", "20"), (21, "spindle", "19")]
    assert len(said) == 1 and "from 2 on" in said[0] and "begins at 17" in said[0]


@pytest.mark.parametrize("rows", [1, 8])
def test_an_agent_that_was_started_anew_is_told(agent: Played, rows: int) -> None:
    """With fewer numbers than were read, or with more: those would look like the next ones."""
    agent.add(*[("t1", "20")] * 4)
    begun = list[bool]()

    def restart() -> None:
        if not begun:
            begun.append(True)
            agent.restart()
            agent.add(*[("t1", "30")] * rows)

    agent.before_sample = restart
    found, said = seen(agent, 3)
    assert found == [(4, "spindle", "20"), (rows, "spindle", "30")]
    assert len(said) == 1 and "started anew" in said[0]


@pytest.mark.parametrize(
    "document",
    [
        b"",
        b"<html><body>busy</body></html>",
        b"<a",
        b'<!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;&b;">]><a>&c;</a>',
        b'<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>',
        b'<M><Header instanceId="1" nextSequence="soon"/></M>',
    ],
)
def test_what_is_no_answer_is_refused(agent: Played, document: bytes) -> None:
    agent.document = document
    with pytest.raises(TrueloopError) as found:
        seen(agent, 2)
    assert found.value.code is Code.MTC_AGENT


def test_the_log_is_what_machine_commands_read(agent: Played, tmp_path: Path) -> None:
    agent.add(("t1", "UNAVAILABLE"), ("p", "A.NC"))
    added = iter([[("t1", "20.5"), ("t1", "0"), ("t1", "UNAVAILABLE"), ("t1", "21.25")]])
    agent.before_sample = lambda: agent.add(*next(added, []))
    log, out = tmp_path / "log.csv", tmp_path / "seen.csv"
    invoke("mtconnect", "read", agent.url, "--seconds", 1.2, "--log", log, "--out", out, status=0)
    history = read_history(log)
    assert history.signals["spindle"].tolist() == [20.5, 0.0, 21.25]
    assert (history.time_s - history.time_s[0]).tolist() == [0.0, 1.0, 3.0]
    assert out.read_text().splitlines()[2] == "p,program,PROGRAM,,2026-01-02T08:00:02Z,2,A.NC"
    assert "OUT-INPUT" in invoke("mtconnect", "read", agent.url, "--out", out, status=4).stderr


def test_only_the_types_asked_for(agent: Played) -> None:
    agent.add(("t1", "20.5"), ("p", "A.NC"), ("s", "Normal"))
    done = invoke("mtconnect", "read", agent.url, "--type", "program", "--json", status=0)
    assert [one["value"] for one in json.loads(done.stdout)["observations"]] == ["A.NC"]


@pytest.mark.corpus
def test_an_answer_of_nists_agent(corpus: Path) -> None:
    """36 temperatures, numbers 20149 to 21439, as the list of the corpus says; all ids are in the device model."""
    folder = corpus / "data" / "public" / "mtconnect"
    answer = read_current((folder / "nist-agent-sample.xml").read_bytes())
    model = read_current((folder / "nist-Devices.xml").read_bytes())
    assert sum(one.kind == "Temperature" for one in answer.all) == 36
    numbers = [one.sequence for one in answer.all]
    assert (min(numbers), max(numbers)) == (20149, 21439)
    assert {one.item for one in answer.all} <= {one["id"] for one in model.items}
    assert answer.header["nextSequence"] == "21440"
