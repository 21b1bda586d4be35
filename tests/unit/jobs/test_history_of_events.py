"""An edge's history follows its events: a new corner or insert starts it anew, a setting changes its name."""

from dataclasses import replace
from datetime import timedelta

import pytest

from tests.support.correction import example_correction
from tests.support.kept import EDGE, MADE_AT, cut_of, inspected, of_part
from trueloop.domain.life import EdgeEvent, EdgeEventKind
from trueloop.domain.tool import Edge
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.history import history_of
from trueloop.loops.turned.provenance import enveloped
from trueloop.storage.store import Store, keep, open_store

SERIALS = ("2511", "2611", "2711")


@pytest.fixture
def store() -> Store:
    """Three parts, cut at 8, 9 and 10 o'clock by one edge."""
    made = open_store("sqlite://", create=True, codec=store_codec())
    for order, serial in enumerate(SERIALS):
        correction = of_part(example_correction("modbas2"), serial)
        cut = cut_of(correction, serial, order=order)
        keep(made, [enveloped(correction), cut, *inspected(correction, cut, 1.0 + order)])
    return made


def event(kind: EdgeEventKind, hours: float, edge: Edge = EDGE) -> EdgeEvent:
    return EdgeEvent(edge, kind, MADE_AT + timedelta(hours=hours))


def serials(store: Store, edge: Edge = EDGE) -> list[str]:
    return [part.serial for part in history_of(store, edge)]


def test_without_events_all_cuts_of_an_edge_count(store: Store) -> None:
    assert serials(store) == list(SERIALS)


@pytest.mark.parametrize(("mounted", "expected"), [(-1.0, SERIALS), (0.5, SERIALS[1:]), (2.5, ())])
def test_a_mounting_starts_the_history_anew(store: Store, mounted: float, expected: tuple[str, ...]) -> None:
    keep(store, [event(EdgeEventKind.MOUNTED, -10), event(EdgeEventKind.MOUNTED, mounted)])
    assert serials(store) == list(expected)


def test_the_age_counts_from_the_mounting(store: Store) -> None:
    keep(store, [event(EdgeEventKind.MOUNTED, 0.5)])
    assert [part.minutes_in_cut for part in history_of(store, EDGE)] == [0.0, 3.0]


def test_a_setting_begins_where_the_tool_was_set(store: Store) -> None:
    keep(store, [event(EdgeEventKind.MOUNTED, -10), event(EdgeEventKind.SET, 0.5)])
    first, second, third = (part.setting for part in history_of(store, EDGE))
    assert first != second == third
    assert second.endswith((MADE_AT + timedelta(hours=0.5)).isoformat())


def test_wear_measured_is_no_new_setting(store: Store) -> None:
    keep(store, [event(EdgeEventKind.MOUNTED, -10), event(EdgeEventKind.WORN, 0.5)])
    assert len({part.setting for part in history_of(store, EDGE)}) == 1


@pytest.mark.parametrize("end", [EdgeEventKind.TURNED, EdgeEventKind.REMOVED])
def test_cuts_after_an_end_teach_nothing_until_the_edge_is_set_again(store: Store, end: EdgeEventKind) -> None:
    keep(store, [event(EdgeEventKind.MOUNTED, -10), event(end, 0.5)])
    assert serials(store) == ["2511"]
    keep(store, [event(EdgeEventKind.SET, 1.5)])
    assert serials(store) == ["2511", "2711"]


def test_events_of_another_corner_change_nothing(store: Store) -> None:
    keep(store, [event(EdgeEventKind.MOUNTED, 0.5, replace(EDGE, corner="3"))])
    assert serials(store) == list(SERIALS)
    assert serials(store, replace(EDGE, corner="3")) == []
