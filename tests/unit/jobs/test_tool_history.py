"""A job's history holds its edge's parts and, before them, the parts of earlier edges of its tool."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta

import pytest

from tests.support.correction import example_correction, example_inputs
from tests.support.kept import EDGE, MADE_AT, cut_of, inspected, of_part
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import EdgeEvent, EdgeEventKind, EdgeLife
from trueloop.domain.part import Part
from trueloop.domain.tool import Edge, Setting
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.history import history_of
from trueloop.jobs.store.tool_history import LATEST, history_of_tool, with_history
from trueloop.jobs.tool_life import tool_memory
from trueloop.loops.turned.provenance import enveloped
from trueloop.memory.made_part import MadePart
from trueloop.storage.store import Store, find, keep, open_store

NEXT = replace(EDGE, corner="3")


def keep_parts(store: Store, edge: Edge, serials: Sequence[str], first_hour: int) -> None:
    """Parts finished and inspected hour by hour; the order of each edge begins at 0."""
    for k, serial in enumerate(serials):
        correction = of_part(example_correction("modbas2"), serial)
        correction = replace(correction, record=replace(correction.record, edge=edge))
        cut = cut_of(correction, serial, order=k)
        cut = replace(cut, setting=Setting(edge, MADE_AT), at=MADE_AT + timedelta(hours=first_hour + k))
        keep(store, [enveloped(correction), cut, *inspected(correction, cut, 1.0 + k)])


@pytest.fixture
def store() -> Store:
    """Corner 2 cut three parts, then corner 3 two."""
    made = open_store("sqlite://", create=True, codec=store_codec())
    keep_parts(made, EDGE, ("1", "2", "3"), 0)
    keep_parts(made, NEXT, ("4", "5"), 5)
    return made


def history(store: Store, edge: Edge, serial: str = "9") -> tuple[MadePart, ...]:
    inputs = replace(example_inputs("modbas2"), edge=edge)
    part = Part(inputs.part, serial)
    of_serial = tuple(replace(one, part=part) for one in inputs.inspections) or (Inspection(part, "touches", "", 0),)
    return with_history(store, replace(inputs, inspections=of_serial)).history


def listed(parts: Sequence[MadePart]) -> list[tuple[str, float]]:
    return [(part.serial, part.order) for part in parts]


EARLIER = [("1", -3.0), ("2", -2.0), ("3", -1.0)]


def test_parts_of_the_corner_before_come_before_those_of_the_edge(store: Store) -> None:
    found = history_of_tool(store, NEXT, (), False)
    assert listed(found) == [*EARLIER, ("4", 0.0), ("5", 1.0)]
    assert [part.edge == found[-1].edge for part in found] == [False] * 3 + [True] * 2
    assert found[0].finish is not None and found[0].correction_mm is not None and len(found[0].semifinish) == 31
    assert [part.serial for part in history_of(store, NEXT)] == ["4", "5"]
    assert listed(history(store, NEXT)) == [("1", -3.0), ("2", -2.0), ("3", -1.0), ("4", 0.0), ("5", 1.0)]


def test_the_first_part_of_a_corner_has_those_before_it_alone(store: Store) -> None:
    """Of the corner that cut first nothing that came later is taken; nor of another designation, or of none."""
    assert listed(history(store, replace(EDGE, corner="4")))[-1] == ("5", -1.0)
    assert listed(history(store, EDGE)) == [("1", 0.0), ("2", 1.0), ("3", 2.0)]
    assert history(store, replace(NEXT, insert="VCMT 110304")) == () == history(store, replace(NEXT, insert=""))
    other = replace(NEXT, tool=replace(NEXT.tool, name="another holder"))
    assert history(store, other) == ()


def test_a_tool_known_by_its_number_alone_has_no_earlier_edges() -> None:
    """T2 of another machine, or of a magazine that was loaded anew, is another tool."""
    store = open_store("sqlite://", create=True, codec=store_codec())
    first, following = (replace(one, tool=replace(one.tool, name="", number=2)) for one in (EDGE, NEXT))
    keep_parts(store, first, ("1", "2", "3"), 0)
    keep_parts(store, following, ("4",), 5)
    assert listed(history_of_tool(store, following, (), False)) == [("4", 0.0)]


def test_the_page_of_a_tool_predicts_its_next_part_as_the_correction_does(store: Store) -> None:
    """By the parts of earlier edges too: the next part is known better than where corner 3 alone has cut."""
    alone = open_store("sqlite://", create=True, codec=store_codec())
    keep_parts(alone, NEXT, ("4", "5"), 5)
    left_um = list[float]()
    for one in (store, alone):
        (row,) = [kept.row for kept in find(one, Edge) if kept.value == NEXT]
        shown = tool_memory(one, row)
        assert (shown.parts, shown.next_parts[0].refusal) == (2, "")
        left_um.append(shown.next_parts[0].left_um or 0.0)
    assert 0.0 < left_um[0] < left_um[1]


def test_corners_that_cut_side_by_side_are_no_earlier_edges_of_each_other(store: Store) -> None:
    """The left and the right corner of a grooving insert, on the same parts; and on parts in turn."""
    left, right = (replace(EDGE, insert="N123", corner=corner) for corner in ("L", "R"))
    keep_parts(store, left, ("11", "13"), 10)
    keep_parts(store, right, ("12", "14"), 10)
    assert listed(history_of_tool(store, left, (), False)) == [("11", 0.0), ("13", 1.0)]
    assert listed(history_of_tool(store, right, (), False)) == [("12", 0.0), ("14", 1.0)]


def test_an_insert_mounted_anew_has_what_the_one_before_it_cut(store: Store) -> None:
    events = [EdgeEvent(EDGE, EdgeEventKind.MOUNTED, MADE_AT + timedelta(hours=hours)) for hours in (-10.0, 1.5)]
    keep(store, events)
    found = history_of_tool(store, EDGE, (), False)
    assert listed(found) == [("1", -2.0), ("2", -1.0), ("3", 0.0)]
    assert found[0].edge == found[1].edge != found[2].edge and found[1].setting != found[2].setting
    assert EdgeLife(tuple(events[1:])).began.isoformat() in found[2].setting


def test_of_many_parts_of_earlier_edges_the_latest_are_taken(store: Store) -> None:
    keep_parts(store, replace(EDGE, corner="1"), [str(k) for k in range(20, 30)], 20)
    assert [part.serial for part in history(store, replace(EDGE, corner="4"))] == [
        *("4", "5"), *(str(k) for k in range(20, 30)),
    ]  # fmt: skip
    assert LATEST == 12
