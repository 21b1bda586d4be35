"""Machines over HTTP: by any name, and their correctors as they are told by key."""

import json
from datetime import UTC, datetime, timedelta
from itertools import islice
from typing import Any

import pytest
from httpx2 import Client

from tests.support.corrector import SIGNALS, stretches, trace
from tests.support.factory import CELL, OPERATOR, Shop
from tests.support.served import served
from tests.support.service import PASSWORD, Running, problem
from trueloop.controllers.linuxcnc.cell.client import Service
from trueloop.factory import requests as ask
from trueloop.factory.shown.machines import heard
from trueloop.jobs.realtime.watched import ToldService
from trueloop.server.identity.keys import NewKey, add_key
from trueloop.server.traces import KEPT, Stretch, Trace, Traces
from trueloop.storage.store import Store


def told(traces: Traces, machine: str, seen: int = 0) -> list[dict[str, object]]:
    """What a page would hear after a number."""
    lines = [one for event in traces.after(machine, seen)[1] for one in event.decode().splitlines()]
    return [json.loads(one.removeprefix("data: ")) for one in lines if one.startswith("data: ")]


def test_a_trace_is_shown_of_the_machine_of_its_key_and_of_no_other(service: Running) -> None:
    assert service.cell("lathe").post("cell/trace", trace(count=3)).status_code == 204
    traces: Traces = service.app.state.traces
    assert told(traces, "mill") == []
    found = told(traces, "lathe")
    assert [one["from"] for one in found] == pytest.approx([0.0, 0.1, 0.2])
    assert (found[0]["axes"], found[0]["signals"], found[0]["alarm"]) == ("xz", list(SIGNALS), False)
    assert [one["from"] for one in told(traces, "lathe", 2)] == pytest.approx([0.2])


def test_a_machine_that_only_a_key_has_named_is_known(service: Running) -> None:
    add_key(service.store, NewKey("lathe 2/B", "watch", 1), "test", service.clock())
    shown = service.signed_in("viewer").get("machines/lathe 2%2FB").json()
    assert (shown["now"]["name"], shown["now"]["at"], shown["now"]["stale"], shown["keys"]) == (
        "lathe 2/B",
        None,
        True,
        1,
    )
    assert problem(service.signed_in("viewer").get("machines/lathe 2")) == "FAC-UNKNOWN"


@pytest.mark.parametrize(
    "wrong",
    [
        {"axes": "X!"},
        {"stretches": []},
        {"stretches": [stretches(1)[0] | {"to_s": -1.0}]},
        {"stretches": [stretches(2)[1] | {"to_s": 0.05}]},
        {"stretches": stretches(101)},
        {"stretches": [stretches(1)[0] | {"low": {str(k): 0.0 for k in range(101)}}]},
        {"stretches": [stretches(1)[0] | {"said": {"state": "x" * 201}}]},
    ],
    ids=["axes", "none", "before zero", "backwards", "too many", "too wide", "too long"],
)
def test_what_is_no_trace_is_refused(service: Running, wrong: dict[str, object]) -> None:
    assert problem(service.cell("lathe").post("cell/trace", trace() | wrong)) == "SRV-REQUEST"


def test_no_more_than_the_latest_stretches_are_kept() -> None:
    traces, at = Traces(), datetime(2026, 1, 2, tzinfo=UTC)
    for first in range(0, 2 * KEPT, 100):
        parts = tuple(Stretch(**one) for one in stretches(100, first))
        traces.add("lathe", Trace("r", "xz", SIGNALS, parts), at)
    found = told(traces, "lathe")
    assert len(found) == KEPT and found[-1]["to"] == pytest.approx(0.1 * 2 * KEPT)


def test_temperatures_are_the_latest_of_a_shift_and_old_ones_are_said_so(service: Running) -> None:
    shop = Shop(service.store, service.clock()).set_up()
    heard(shop.store, "lathe", {"state": "idle"}, CELL, shop.now)
    for minutes in (600, 30, 20, 10):
        at = service.clock.at - timedelta(minutes=minutes)
        shop.do(ask.RecordTemperatures("lathe", {"bed": 20.0 + minutes}, at), CELL)
    shop.do(ask.RecordTemperatures("lathe", {"old": 1.0}, service.clock.at - timedelta(days=4)), CELL)
    shop.do(ask.Calibrated("lathe", {"radius_mm": "1.0003"}), OPERATOR)
    shown = service.signed_in("viewer").get("machines/lathe").json()
    by_signal = {one["signal"]: one for one in shown["temperatures"]}
    assert by_signal["bed"]["celsius"] == [50.0, 40.0, 30.0] and by_signal["bed"]["stale"]
    assert by_signal["old"]["celsius"] == [1.0] and by_signal["old"]["stale"]
    assert shown["calibrations"][0]["values"] == {"radius_mm": "1.0003"}


def test_a_record_is_told_in_order_over_http_and_a_silent_service_holds_nothing_up(store: Store) -> None:
    """As watch tells it: the live page's ticks, from a thread of their own. Where nobody listens it is said once."""
    ticks = [_tick(one) for one in stretches(30)]
    with served(store) as address:
        key = add_key(store, NewKey("lathe", "watch", 1), "test", datetime.now(UTC)).key
        said: list[str] = []
        with ToldService(Service(address, key), "r", "xz", SIGNALS, said.append) as service:
            for one in ticks:
                service.take(one)
            service.take({"alarm": True, "said": {"state": "no period has come for 2 s"}})
            heard = watched(address)
    assert said == [] and [one["from"] for one in heard] == pytest.approx([0.1 * k for k in range(30)])
    silent = ToldService(Service("http://127.0.0.1:9", key), "r", "xz", SIGNALS, said.append)
    for _ in range(3):
        silent.take(ticks[0])
        silent.send()
    assert len(said) == 1 and "service" in said[0]


def watched(address: str) -> list[dict[str, Any]]:
    """What a page hears first of the lathe's corrector, by the stream that it listens to."""
    with Client(base_url=f"{address}/api/v1", headers={"Origin": address}, timeout=20) as client:
        client.post("/session", json={"name": "viewer", "password": PASSWORD})
        with client.stream("GET", "/machines/lathe/corrector") as stream:
            lines = (line.removeprefix("data: ") for line in stream.iter_lines() if line.startswith("data: "))
            return [json.loads(line) for line in islice(lines, 30)]


def _tick(stretch: dict[str, object]) -> dict[str, object]:
    return {"from": stretch["from_s"], "to": stretch["to_s"]} | {
        name: stretch[name] for name in ("low", "high", "alarm", "said")
    }
