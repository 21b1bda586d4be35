"""Events of tools: what is kept, what it makes of the edge that a job means, and what is refused."""

from datetime import UTC, datetime, timedelta

import pytest

from tests.support.tools import DAY, NOW, at, mount, put, set_anew, turn
from trueloop.domain.life import Cut, EdgeEventKind, Stage, in_pockets, lives
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Edge, Machine, Setting, Tool
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.tools import (
    Happened,
    cuts_after_end,
    cuts_of,
    edge_of,
    keep_events,
    lives_in,
    of_mounted,
    require_touches_since,
)
from trueloop.storage.store import Store, keep, open_store

T3 = Edge(Tool(3, "SVJBR 2020", 0.8), "VBMT 160408", "1")


@pytest.fixture
def store() -> Store:
    return open_store("sqlite://", create=True)


def refused(code: Code) -> "pytest.RaisesExc[TrueloopError]":
    return pytest.RaisesExc(TrueloopError, check=lambda error: error.code is code)


def test_a_job_that_states_the_number_alone_gets_edge_and_setting(store: Store) -> None:
    mount(store, at(8))
    assert edge_of(store, None, 3, at(9)) == Setting(T3, at(8))
    set_anew(store, at(10))
    assert edge_of(store, None, 3, at(11)) == Setting(T3, at(10))
    assert edge_of(store, None, 3, at(9)) == Setting(T3, at(8))  # as it was then
    assert edge_of(store, None, 3, at(7)) is None
    assert edge_of(store, None, 4, at(11)) is None


def test_an_edge_that_was_turned_is_another_one(store: Store) -> None:
    mount(store, at(8))
    turn(store, "2", at(10))
    now = edge_of(store, None, 3, at(11))
    assert now is not None and now.edge.corner == "2" and now.set_at == at(10)
    before = edge_of(store, None, 3, at(9))
    assert before is not None and before.edge.corner == "1"


def test_what_the_job_states_has_to_agree(store: Store) -> None:
    mount(store, at(8))
    assert edge_of(store, Edge(Tool(3), "VBMT 160408"), 3, at(9)) == Setting(T3, at(8))
    assert edge_of(store, T3, 3, at(9), set_at=at(8)) == Setting(T3, at(8))
    for stated, set_at in (
        (Edge(Tool(3), corner="2"), None),
        (Edge(Tool(3), "CNMG 120408"), None),
        (Edge(Tool(3, "other holder")), None),
        (T3, at(7)),
    ):
        with refused(Code.EDG_OTHER):
            edge_of(store, stated, 3, at(9), set_at=set_at)


def test_without_events_the_job_counts(store: Store) -> None:
    assert edge_of(store, T3, 3, at(9), set_at=at(8)) == Setting(T3, at(8))
    assert edge_of(store, T3, 3, at(9)) == Setting(T3, None)
    assert edge_of(store, None, None, at(9)) is None


def test_an_edge_that_was_turned_away_or_removed_cuts_no_more(store: Store) -> None:
    mount(store, at(8))
    put(store, "remove", at(10))
    with refused(Code.EDG_ENDED):
        edge_of(store, T3, 3, at(11))
    assert edge_of(store, T3, 3, at(9)) == Setting(T3, at(8))


def test_cuts_by_an_edge_that_was_turned_are_named(store: Store) -> None:
    mount(store, at(8))
    turn(store, "2", at(10))
    for serial, hour in (("1", 9), ("2", 11)):
        part = Part(PartType("CAP"), serial)
        keep(store, [Cut(part, Stage.FINISH, Setting(T3, at(8)), at=at(hour))])
    first = lives_in(store)[0]
    (found,) = cuts_after_end(first, cuts_of(store, T3))
    assert found.code is Code.EDG_ENDED and "CAP 2" in found.message


def test_a_new_insert_of_the_same_designation_is_a_new_life(store: Store) -> None:
    mount(store, at(8))
    mount(store, at(12))
    first, second = lives_in(store)
    assert first.ended is not None and first.ended.at == at(12)
    assert (first.holds(at(11)), first.holds(at(12)), second.holds(at(12))) == (True, False, True)
    mount(store, at(12))  # entered twice
    assert [len(life.events) for life in lives_in(store)] == [2, 1]


def test_an_edge_taken_up_again_keeps_its_form_and_gets_a_setting(store: Store) -> None:
    mount(store, at(8))
    put(store, "remove", at(10))
    mount(store, at(12), again=True)
    (life,) = lives_in(store)
    assert life.ended is None and life.began == at(8) and life.set_at == at(12)
    turn(store, "2", at(13))
    turn(store, "1", at(14), again=True)
    assert [one.began for one in lives_in(store)] == [at(8), at(13)]
    assert [one.edge.corner for one in in_pockets(lives_in(store), at(15))] == ["1"]


def test_a_corner_that_cut_before_is_refused_until_the_insert_is_new(store: Store) -> None:
    mount(store, at(8))
    turn(store, "2", at(9))
    for corner in ("1", "2", ""):
        with refused(Code.EDG_CORNER):
            turn(store, corner, at(10))
    with refused(Code.EDG_CORNER):
        turn(store, "3", at(10), again=True)
    mount(store, at(11))
    turn(store, "2", at(12))
    assert [life.began for life in lives_in(store) if life.edge.corner == "2"] == [at(9), at(12)]


def test_one_pocket_holds_one_tool(store: Store) -> None:
    mount(store, at(8))
    with refused(Code.EDG_POCKET):
        mount(store, at(9), holder="PCLNR 2525")
    with refused(Code.EDG_POCKET):  # one edge in two pockets
        mount(store, at(9), tool="T5")
    assert len(lives_in(store)) == 1


def test_pockets_of_several_machines(store: Store) -> None:
    mount(store, at(8), machine="lathe A", holder="A3")
    mount(store, at(9), machine="lathe B", holder="B3")
    with refused(Code.EDG_POCKET):
        edge_of(store, None, 3, at(10))
    found = edge_of(store, None, 3, at(10), machine=Machine("lathe A", "17"))
    assert found is not None and found.edge.tool.name == "A3"
    with refused(Code.EDG_POCKET):  # the edge of machine A in machine B as well
        mount(store, at(10), machine="lathe B", tool="T7", holder="A3")


def test_events_before_later_facts_are_refused_unless_late(store: Store) -> None:
    mount(store, at(8))
    keep(store, [Cut(Part(PartType("CAP"), "7"), Stage.FINISH, Setting(T3, at(8)), at=at(12))])
    with refused(Code.EDG_PAST):
        set_anew(store, at(11))
    set_anew(store, at(11), late=True)
    assert edge_of(store, None, 3, at(12)) == Setting(T3, at(11))
    set_anew(store, at(13))
    with refused(Code.EDG_PAST):
        set_anew(store, at(12, 30))


def test_a_late_event_may_not_put_two_tools_into_one_pocket(store: Store) -> None:
    mount(store, at(10), holder="PCLNR 2525")
    with refused(Code.EDG_POCKET):
        mount(store, at(8), late=True)
    assert len(lives_in(store)) == 1


def test_an_event_of_the_future_is_refused(store: Store) -> None:
    mount(store, NOW + timedelta(seconds=30))  # clocks differ
    with refused(Code.EDG_TIME):
        set_anew(store, NOW + timedelta(minutes=2))


def test_wear_needs_a_value_that_a_wear_can_have(store: Store) -> None:
    mount(store, at(8))
    with refused(Code.EDG_VALUE):
        put(store, "wear", at(9))
    with refused(Code.EDG_VALUE):
        put(store, "wear", at(9), flank_wear_mm=-0.1)
    with refused(Code.EDG_VALUE):
        put(store, "wear", at(9), minutes_in_cut=float("nan"))
    put(store, "wear", at(9), flank_wear_mm=0.12)
    (life,) = lives_in(store)
    assert dict(life.events[-1].values) == {"flank_wear_mm": 0.12} and life.set_at == at(8)


def test_an_offset_may_be_negative(store: Store) -> None:
    mount(store, at(8))
    happened = Happened(at(9), values={"x_mm": -12.5, "z_mm": 3.0})
    (event,) = keep_events(store, lambda known: of_mounted(known, "T3", EdgeEventKind.SET, happened), NOW)
    assert event.values["x_mm"] == -12.5


def test_no_mounting_without_nose_radius(store: Store) -> None:
    with refused(Code.EDG_VALUE):
        mount(store, at(8), nose_radius_mm=None)
    mount(store, at(8))
    put(store, "remove", at(9))
    mount(store, at(10), nose_radius_mm=None, again=True)  # it is known
    assert edge_of(store, None, 3, at(11)) == Setting(T3, at(10))


def test_unknown_tools_are_named_with_the_nearest(store: Store) -> None:
    mount(store, at(8))
    with pytest.raises(TrueloopError, match="SVJBR 2020") as error:
        put(store, "remove", at(9), tool="SVJBR 2002")
    assert error.value.code is Code.EDG_UNKNOWN and "SVJBR 2020" in error.value.hint


def test_touches_before_the_setting_are_refused() -> None:
    setting = Setting(T3, at(10))
    with refused(Code.EDG_SETTING):
        require_touches_since(setting, at(9))
    require_touches_since(setting, at(10))
    require_touches_since(setting, None)
    require_touches_since(Setting(T3), at(9))


def test_lives_do_not_depend_on_the_order_of_keeping(store: Store) -> None:
    mount(store, at(8))
    turn(store, "2", at(9))
    set_anew(store, at(10))
    events = [event for life in lives_in(store) for event in life.events]
    assert lives(events) == lives(reversed(events))


def test_times_of_other_zones_are_the_same_times(store: Store) -> None:
    from datetime import timezone

    mount(store, at(8).astimezone(timezone(timedelta(hours=2))))
    found = edge_of(store, None, 3, at(8))
    assert found is not None and found.set_at == at(8)
    assert datetime(2026, 3, DAY, 8, tzinfo=UTC) == at(8)
