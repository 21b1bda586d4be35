"""What is kept comes back as it was; it is kept once, never changed, and an error is superseded."""

import math
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any
from uuid import uuid4

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import insert

from tests.support import records
from tests.support.stores import AT, EDGE, TYPE, cut, link, part, touched
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.domain.life import Cut, EdgeEvent, EdgeEventKind, InspectionLink
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import Correction, Record
from trueloop.domain.tool import Edge, Machine, Setting, Tool
from trueloop.domain.values import CODEC
from trueloop.errors import Code, TrueloopError
from trueloop.storage import keeping
from trueloop.storage.keeping import Keeping
from trueloop.storage.kinds import joined
from trueloop.storage.schema import METADATA, STATES, TABLES
from trueloop.storage.store import Store, find, keep, open_store

READING = Reading("12", Quantity.DIAMETER, 20.0, place_mm=(1.0, 2.0))
GUARDED = sorted(set(METADATA.tables) - {table.name for table in STATES})
SHARED = open_store("sqlite://", create=True)


@settings(max_examples=60)
@given(st.lists(st.one_of(records.touches, records.readings, records.cmm_points), max_size=8).map(tuple))
def test_values_of_an_inspection_come_back_to_the_last_bit(values: tuple[Touch, ...]) -> None:
    given = replace(touched(), values=values, sha256=uuid4().hex)
    keep(SHARED, [given])
    (found,) = find(SHARED, Inspection, file_sha256=given.sha256)
    assert found.value == given
    assert CODEC.to_json(found.value) == CODEC.to_json(given)  # −0.0 and 0.0 are equal, and are not the same


@settings(max_examples=30)
@given(records.records)
def test_any_record_comes_back(record: Record) -> None:
    correction = Correction(replace(record, id=uuid4().hex), {"size_mm": 0.15}, None)
    keep(SHARED, [correction])
    assert [one.value for one in find(SHARED, Correction, identity=correction.record.id)] == [correction]


def test_what_no_column_holds_comes_back_too(store: Store) -> None:
    odd = (
        Touch("a\x00b", (-0.0, math.inf), error_mm=math.nan, line=2**70),
        CmmPoint((1.0, -0.0, 5e-324), name="\ud800"),
        Touch("plain", (1.0, 2.0)),
    )
    keep(store, [replace(touched(), values=odd)])
    assert repr(find(store, Inspection)[0].value.values) == repr(odd)


@pytest.mark.parametrize("error_mm", [-0.0, 0.0, math.nan, -math.inf])
def test_each_odd_number_comes_back_by_itself(store: Store, error_mm: float) -> None:
    odd = (Touch("a", (1.0, 2.0), error_mm=error_mm), Touch("b", (1.0, 2.0), error_mm=0.25))
    keep(store, [replace(touched(), values=odd)])
    assert repr(find(store, Inspection)[0].value.values) == repr(odd)


def test_every_kind_is_found_by_what_it_is_found_by(store: Store) -> None:
    shown, done = touched(), cut(correction="c0ffee")
    event = EdgeEvent(EDGE, EdgeEventKind.WORN, AT, "ana", {"flank_wear_mm": 0.12})
    given = [shown, done, link(shown, done), event]
    assert all(one.new for one in keep(store, given, by="ana"))
    assert [one.value for one in find(store, Cut, edge=joined(EDGE.identity), correction="c0ffee")] == [done]
    assert [one.value for one in find(store, Inspection, part_type="shaft", serial="17")] == [shown]
    assert [one.value for one in find(store, InspectionLink, cut=joined(done.identity))] == [given[2]]
    assert [one.value for one in find(store, EdgeEvent, event="worn")] == [event]
    assert [one.by for one in find(store, Cut)] == ["ana"]
    assert find(store, Cut, serial="18") == []


def test_a_document_that_is_not_long_is_decoded_once(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    keep(store, [cut()])
    first, again = (find(store, Cut)[0].value for _ in range(2))
    assert first is again
    monkeypatch.setattr(keeping, "SHORT", 0)
    apart = find(store, Cut)[0].value
    assert apart == first and apart is not first


def test_what_a_value_names_is_kept_with_it_once(store: Store) -> None:
    keep(store, [cut(), touched()])
    keep(store, [cut("18")])
    assert [one.value for one in find(store, PartType)] == [TYPE]
    assert [one.value for one in find(store, Part)] == [part(), part("18")]
    assert [one.value for one in find(store, Machine)] == [Machine("lathe", "7")]
    assert [one.value for one in find(store, Setting)] == [Setting(EDGE, AT)]
    assert [one.value for one in find(store, Edge)] == [EDGE]
    assert [one.value for one in find(store, Tool)] == [EDGE.tool]


def test_a_name_that_says_less_than_what_is_known_is_no_contradiction(store: Store) -> None:
    keep(store, [TYPE])
    bare = Inspection(Part(PartType("shaft", "B"), "17"), "touches", "1" * 64, 0)
    keep(store, [bare])
    assert [one.value for one in find(store, PartType)] == [TYPE]
    assert find(store, Inspection)[0].value == bare


def test_the_same_twice_is_one_row(store: Store) -> None:
    first, again = keep(store, [touched(), touched()])
    assert (first.new, again.new, again.row) == (True, False, first.row)
    assert keep(store, [touched()])[0].kept_at == first.kept_at


def test_one_changed_touch_is_another_content_and_nothing_of_the_call_is_kept(store: Store) -> None:
    keep(store, [touched()])
    with pytest.raises(TrueloopError, match="row 1, with another content") as refused:
        keep(store, [cut(), touched(shift_mm=1e-16)])
    assert refused.value.code is Code.STO_DIFFERS
    assert find(store, Cut) == []


def test_an_error_is_superseded_by_a_row_that_names_it(store: Store) -> None:
    (wrong,) = keep(store, [touched()])
    right = touched(shift_mm=0.001)
    (kept,) = keep(store, [right], supersedes=wrong.row, by="ana", why="probe not calibrated")
    assert [one.value for one in find(store, Inspection)] == [right]
    (old, new) = find(store, Inspection, superseded=True)
    assert (old.value, old.superseded_by) == (touched(), kept.row)
    assert (new.supersedes, new.by, new.why) == (wrong.row, "ana", "probe not calibrated")
    assert keep(store, [right], supersedes=wrong.row)[0].row == kept.row
    (known,) = keep(store, [touched()])
    assert (known.row, known.new, known.superseded_by) == (wrong.row, False, kept.row)


def test_what_belongs_to_another_part_is_superseded_by_that_of_the_other(store: Store) -> None:
    (wrong,) = keep(store, [touched("17")])
    keep(store, [touched("18")], supersedes=wrong.row, why="parts swapped")
    assert [one.value.part.serial for one in find(store, Inspection)] == ["18"]
    assert keep(store, [touched("17", shift_mm=0.001)])[0].new  # nothing of part 17 stands any more


def test_a_row_goes_back_to_an_earlier_content(store: Store) -> None:
    (first,) = keep(store, [touched()])
    (second,) = keep(store, [touched(shift_mm=0.001)], supersedes=first.row)
    (third,) = keep(store, [touched()], supersedes=second.row)
    assert third.new
    assert [one.value for one in find(store, Inspection)] == [touched()]


def test_rows_that_are_copied_twice_are_there_once_in_their_order(store: Store) -> None:
    """Of a chain whose last content is its first."""
    (first,) = keep(store, [touched()], by="ana")
    (second,) = keep(store, [touched(shift_mm=0.001)], supersedes=first.row, by="ben", why="probe")
    keep(store, [touched()], supersedes=second.row, by="ana", why="it was right")
    of_store = find(store, Inspection, superseded=True)
    copy = open_store("sqlite://", create=True)
    for _ in range(2):
        numbers: dict[int | None, int | None] = {None: None}
        for one in of_store:
            with copy.writing() as connection:
                keeping = Keeping(copy.codec, connection, one.by, one.why)
                numbers[one.row] = keeping.keep(one.value, numbers[one.supersedes], one.kept_at).row
    assert find(copy, Inspection, superseded=True) == of_store


def test_a_clock_that_goes_back_is_said_and_the_order_stays(store: Store) -> None:
    keep(store, [touched("17")])
    with store.writing() as connection:
        kept = Keeping(store.codec, connection).keep(touched("18"), kept_at=datetime(2020, 1, 1, tzinfo=UTC))
    assert kept.clock_back and not keep(store, [touched("19")])[0].clock_back
    assert [one.value.part.serial for one in find(store, Inspection)] == ["17", "18", "19"]
    assert find(store, Inspection, serial="18")[0].kept_at == datetime(2020, 1, 1, tzinfo=UTC)


def test_what_an_earlier_version_wrote_of_the_same_value_is_the_same(store: Store) -> None:
    """A field that is new has its default: the document differs, the value does not."""
    event = EdgeEvent(EDGE, EdgeEventKind.WORN, AT, "ana", {"flank_wear_mm": 0.12})
    document = CODEC.to_json(event).replace(', "machine": null', "")
    assert "machine" not in document
    row = {"identity": joined(event.identity), "version": 1, "kept_at": AT.isoformat(), "kept_by": "", "reason": ""}
    with store.writing() as connection:
        connection.execute(insert(TABLES["edge_event"]).values(**row, sha256="0" * 64, document=document))
    assert not keep(store, [event])[0].new
    with pytest.raises(TrueloopError, match="another content"):
        keep(store, [replace(event, by="ben")])


def test_only_what_stands_is_superseded(store: Store) -> None:
    (first,) = keep(store, [touched()])
    keep(store, [touched(shift_mm=0.001)], supersedes=first.row)
    with pytest.raises(TrueloopError, match="row 2") as twice:
        keep(store, [touched("18")], supersedes=first.row)
    with pytest.raises(TrueloopError, match="no inspection in row 77") as nothing:
        keep(store, [touched("19")], supersedes=77)
    assert (twice.value.code, nothing.value.code) == (Code.STO_DIFFERS, Code.STO_UNKNOWN)
    assert len(find(store, Inspection, superseded=True)) == 2


def test_identities_that_look_alike_when_joined_are_kept_apart(store: Store) -> None:
    names = (Machine("a\x1fb", "c"), Machine("a", "b\x1fc"), Machine("a\\u001fb", "c"), Machine("n" * 9000, "1"))
    assert all(one.new for one in keep(store, [*names, Machine("n" * 9001, "1"), Machine("a\x00", "1")]))
    assert [one.value for one in find(store, Machine, machine="n" * 9000)] == [names[3]]


def test_no_row_is_changed_replaced_or_taken_away(store: Store) -> None:
    shown, done = replace(touched(), values=(*touched().values, CmmPoint((1.0, 2.0, 3.0)), READING)), cut()
    keep(store, [shown, done, link(shown, done)])
    connection: Any = store.engine.raw_connection()
    try:
        for table in GUARDED:
            for statement in changes(store, connection, table):
                with pytest.raises(Exception, match="append-only"):
                    connection.cursor().execute(statement)
                connection.rollback()
    finally:
        connection.close()
    assert [one.value for one in find(store, Inspection)] == [shown]


def changes(store: Store, connection: Any, table: str) -> list[str]:
    """Every way to change a table. SQLite's triggers are of rows: a table without any has nothing to lose."""
    column = list(METADATA.tables[table].columns)[-1].name
    cursor = connection.cursor()
    cursor.execute(f"SELECT 1 FROM {table} LIMIT 1")
    filled = cursor.fetchone() is not None
    plain = [f"UPDATE {table} SET {column} = NULL", f"DELETE FROM {table}"]
    if store.engine.dialect.name == "sqlite":
        return [*plain, f"REPLACE INTO {table} SELECT * FROM {table}"] if filled else []
    return [*plain, f"TRUNCATE {table} CASCADE"]


def test_every_table_is_guarded() -> None:
    with SHARED.reading() as connection:
        rows = connection.exec_driver_sql("SELECT name FROM sqlite_master WHERE type = 'trigger'")
        guards = {row[0] for row in rows}
    assert guards == {f"{table}_no_{change}" for table in GUARDED for change in ("update", "delete")}


def test_columns_hold_what_they_are_named(store: Store) -> None:
    """Whoever reads the tables by SQL: x is a radius, z the second coordinate, and the error keeps its sign."""
    touch = Touch("7", (10.5, -3.25), "dome", (10.75, -3.5), -0.125, 9)
    keep(store, [replace(touched(), values=(touch,))])
    names = "point, feature, nominal_x_mm, nominal_z_mm, measured_x_mm, measured_z_mm, error_mm, line"
    with store.reading() as connection:
        row = connection.exec_driver_sql(f"SELECT {names} FROM touch").one()
    assert tuple(row) == ("7", "dome", 10.5, -3.25, 10.75, -3.5, -0.125, 9)
