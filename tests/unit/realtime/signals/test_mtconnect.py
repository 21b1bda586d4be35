"""An MTConnect agent, played by a server here; what it says is laid out as MTConnect's part 1 does."""

import re
import threading
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from tests.support.signals import Kept, reading, until
from trueloop.controllers.linuxcnc.realtime.signals import mtconnect
from trueloop.controllers.linuxcnc.realtime.signals.mtconnect import MtConnect, fetched, is_address, read_current
from trueloop.controllers.linuxcnc.realtime.signals.readings import unix_s


def current(values: dict[str, tuple[str, float]], created: datetime | None = None) -> bytes:
    """The answer of an agent: values with their age in s."""
    created = created or datetime.now(UTC)
    items = "".join(
        f'<Temperature dataItemId="{item}" timestamp="{(created - timedelta(seconds=age)).isoformat()}" '
        f'sequence="7" name="{item}">{value}</Temperature>'
        for item, (value, age) in values.items()
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        '<MTConnectStreams xmlns="urn:mtconnect.org:MTConnectStreams:1.7">'
        f'<Header creationTime="{created.isoformat()}" instanceId="1" version="1.7.0" bufferSize="131072"/>'
        '<Streams><DeviceStream name="lathe" uuid="1"><ComponentStream component="Axes" componentId="a">'
        f"<Samples>{items}</Samples></ComponentStream></DeviceStream></Streams></MTConnectStreams>"
    ).encode()


class Agent:
    """What is answered next, and how often it was asked."""

    def __init__(self) -> None:
        self.answer, self.status, self.asked = b"", 200, list[str]()
        agent = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                agent.asked.append(self.path)
                self.send_response(agent.status)
                self.send_header("Content-Length", str(len(agent.answer)))
                self.end_headers()
                self.wfile.write(agent.answer)

            def log_message(self, *_: object) -> None: ...

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, args=(0.05,), daemon=True).start()


@pytest.fixture
def agent() -> Iterator[Agent]:
    played = Agent()
    yield played
    played.server.shutdown()
    played.server.server_close()


ITEMS = {"T1": "Xtemp", "T2": "Ztemp"}


def test_values_are_as_old_as_the_agent_says(agent: Agent) -> None:
    agent.answer = current({"Xtemp": ("21.25", 2.0), "Ztemp": ("22.5", 40.0), "other": ("1", 0.0)})
    with reading(MtConnect(f"{agent.url}/lathe", ITEMS, 0.05)) as source:
        for name, value, age in (("T1", 21.25, 2.0), ("T2", 22.5, 40.0)):
            read = source.wait_for(name)
            assert read.value == value
            assert age <= read.age_s(time.monotonic()) < age + 20
    assert set(agent.asked) == {"/lathe/current"}


def test_the_agents_clock_may_be_wrong(agent: Agent) -> None:
    agent.answer = current({"Xtemp": ("21.25", 2.0)}, datetime.now(UTC) - timedelta(hours=5))
    with reading(MtConnect(agent.url, ITEMS, 0.05)) as source:
        assert 2.0 <= source.wait_for("T1").age_s(time.monotonic()) < 22


def test_a_value_that_is_held_is_as_old_as_the_question(agent: Agent) -> None:
    agent.answer = current({"Xtemp": ("21.25", 3600.0)})
    with reading(MtConnect(agent.url, ITEMS, 0.05, held=True)) as source:
        assert source.wait_for("T1").age_s(time.monotonic()) < 20


def test_an_answer_that_comes_again_is_no_new_reading(agent: Agent) -> None:
    """As from a cache between agent and control."""
    agent.answer = current({"Xtemp": ("21.25", 0.0)})
    with reading(MtConnect(agent.url, ITEMS, 0.02, held=True)) as source:
        first = source.wait_for("T1")
        asked = len(agent.asked)
        source.wait_for("T1", lambda _: len(agent.asked) > asked + 5)
        assert source.board.readings()["T1"] == first


@pytest.mark.parametrize("held", [False, True])
def test_what_is_unavailable_grows_old(agent: Agent, held: bool) -> None:
    agent.answer = current({"Xtemp": ("21.25", 0.0)})
    with reading(MtConnect(agent.url, ITEMS, 0.02, held)) as source:
        first = source.wait_for("T1")
        for said, why in (("UNAVAILABLE", "UNAVAILABLE"), ("warm", "warm"), ("", "no number|convert")):
            agent.answer = current({"Xtemp": (said, 0.0)})
            until(lambda: re.search(why, source.reader.why("T1")), why)  # noqa: B023
        assert source.board.readings()["T1"] == first
        assert "Ztemp" in source.reader.why("T2")
        agent.answer = current({"Xtemp": ("22.0", 0.0)})
        assert source.wait_for("T1", lambda one: one.value == 22.0)


def test_a_time_stamp_ahead_of_the_agents_clock_is_refused() -> None:
    kept = Kept()
    answer = read_current(current({"Xtemp": ("21.25", -30.0)}))
    MtConnect("", {"T1": "Xtemp"})._take(answer, unix_s(answer.created), 0.0, kept)
    assert not kept.given
    assert "30.0 s in the future" in kept.refused["T1"]


@pytest.mark.parametrize(
    "bad",
    [
        b"",
        b"<html>",
        b"not xml",
        b"<a/>",
        b'<Header creationTime="never"/>',
        b'<!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;&b;">]><a>&c;</a>',
    ],
)
def test_what_is_no_answer_is_said_and_asked_again(agent: Agent, bad: bytes) -> None:
    agent.answer = bad
    with reading(MtConnect(agent.url, ITEMS, 0.02)) as source:
        until(lambda: source.said)
        assert "tried again" in source.said[0]
        agent.answer = current({"Xtemp": ("21.25", 0.0)})
        assert source.wait_for("T1").value == 21.25


def test_an_agent_that_is_gone_is_asked_again(agent: Agent) -> None:
    agent.answer, agent.status = current({"Xtemp": ("21.25", 0.0)}), 503
    with reading(MtConnect(agent.url, ITEMS, 0.02)) as source:
        until(lambda: source.said)
        assert "503" in source.said[0]
        agent.status = 200
        assert source.wait_for("T1").value == 21.25


def test_an_answer_without_end_is_left(agent: Agent, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mtconnect, "LARGEST", 1000)
    agent.answer = b"x" * 200_000
    with pytest.raises(OSError, match="more than 1000 bytes"):
        fetched(f"{agent.url}/current")


@pytest.mark.parametrize(
    ("url", "good"),
    [("http://10.0.0.7:5000/lathe", True), ("https://agent", True), ("agent:5000", False), ("file:///etc", False)],
)
def test_addresses(url: str, good: bool) -> None:
    assert is_address(url) is good
