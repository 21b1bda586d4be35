"""An edge's parts come out of a store as they went in, in the order in which they were cut."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.correction import example_correction, example_inputs
from tests.support.kept import EDGE, MADE_AT, TYPE, cut_of, inspected, of_part
from trueloop.domain.life import Cut, Quarantine
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import Component
from trueloop.domain.tool import Edge
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.history import Dated, cutting_order, history_of
from trueloop.jobs.store.opened import named_store, store_of
from trueloop.jobs.store.tool_history import history_of_tool, with_history
from trueloop.loops.turned.correction import Composed, Correction
from trueloop.loops.turned.made_parts import made_part
from trueloop.loops.turned.provenance import enveloped
from trueloop.memory.edge import predict
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.storage.store import Store, find, keep, open_store
from trueloop.turned.touches.error_vectors import ErrorVectors

SERIALS = ("2511", "2611", "2711")


@pytest.fixture
def store() -> Store:
    return open_store("sqlite://", create=True, codec=store_codec())


def corrections() -> dict[str, Correction]:
    return {serial: of_part(example_correction("modbas2"), serial) for serial in SERIALS}


def keep_part(store: Store, correction: Correction, cut: Cut, left_um: float | None, hours: float = 0.5) -> None:
    after = () if left_um is None else inspected(correction, cut, left_um, hours)
    keep(store, [enveloped(correction), cut, *after])


def test_parts_come_back_in_cutting_order(store: Store) -> None:
    made = corrections()
    for order, serial in [(2, "2711"), (0, "2511"), (1, "2611")]:
        keep_part(store, made[serial], cut_of(made[serial], serial, order=order), 10.0 * order + 1.0)
    history = history_of(store, EDGE)
    assert [part.serial for part in history] == list(SERIALS)
    assert [part.order for part in history] == [0, 1, 2]
    assert [part.minutes_in_cut for part in history] == [0.0, 3.0, 6.0]
    assert not any(part.order_in_doubt for part in history)
    for left_um, part in zip((1.0, 11.0, 21.0), history, strict=True):
        assert part.finish is not None and part.finish.error_mm == pytest.approx(left_um / 1000, abs=1e-12)
        assert len(part.finish) == 32


def test_a_part_out_of_the_store_is_the_part_that_was_kept(store: Store) -> None:
    """The whole correction goes through JSON: S and C come back to the last bit."""
    correction = corrections()["2511"]
    cut = cut_of(correction, "2511", order=0)
    keep_part(store, correction, cut, 2.0)
    (found,) = history_of(store, EDGE)
    own = made_part(correction, cut, _all_of_finish(correction))
    assert found.semifinish == own.semifinish
    assert found.correction_mm is not None and own.correction_mm is not None
    np.testing.assert_allclose(found.correction_mm, own.correction_mm, atol=1e-12)


def _all_of_finish(correction: Correction) -> ErrorVectors:
    touches = correction.touches
    return replace(touches, error_mm=np.full(32, 0.002), at_reference=np.zeros(32, dtype=np.bool_))


def test_parts_with_and_without_known_errors_of_the_machine_teach_their_own_kind(store: Store) -> None:
    """Touches of the latter have the machine's errors in them, those of the former do not."""
    made = corrections()
    for order, serial in enumerate(SERIALS):
        correction = made[serial]
        if serial == "2611":
            nothing = np.zeros(len(correction.touches.point))
            composed, components = Composed(nothing, nothing, nothing, nothing), [Component.of("", "", 0.0, 0.0)]
            record = replace(correction.record, components=components)
            correction = replace(correction, composed=composed, record=record)
        keep_part(store, correction, cut_of(correction, serial, order=order), 1.0)
    history = history_of(store, EDGE)
    assert [(part.serial, part.order, part.minutes_in_cut) for part in history] == [("2511", 0, 0.0), ("2711", 1, 6.0)]
    of_machine = history_of_tool(store, EDGE, of_machine=True)
    assert [(part.serial, part.minutes_in_cut) for part in of_machine] == [("2611", 3.0)]
    inputs = with_history(store, replace(example_inputs("modbas2"), edge=EDGE))
    assert [part.serial for part in inputs.history] == ["2511", "2711"]
    assert any("known errors of the machine: 1. Today's touches contain these." in note for note in inputs.notes)


def test_of_a_long_history_the_parts_that_predict_the_next_are_read(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The latest one, and the latest two of its type, with their place and age among all; of others no curve is."""
    monkeypatch.setattr(predict, "REMEMBERED", 1)
    monkeypatch.setattr(predict, "OF_TYPE", 2)
    for order, (serial, correction) in enumerate(corrections().items()):
        keep_part(store, correction, cut_of(correction, serial, order=order), 1.0 + order)
    every = history_of(store, EDGE)
    with store.writing() as connection:
        connection.exec_driver_sql("DROP TRIGGER correction_no_update")
        connection.exec_driver_sql("UPDATE correction SET payload = '[]' WHERE serial = '2511'")
    inputs, of_type = replace(example_inputs("modbas2"), edge=EDGE), every[0].part_type
    found = with_history(store, replace(inputs, part=TYPE)).history
    assert found == every[1:] == predict.latest(every, of_type)
    assert [(part.serial, part.order, part.minutes_in_cut) for part in found] == [("2611", 1, 3.0), ("2711", 2, 6.0)]
    assert with_history(store, replace(inputs, part=PartType("other"))).history == every[2:]
    assert history_of_tool(store, EDGE, until=(of_type, "new")) == every[1:]
    monkeypatch.setattr(predict, "OF_TYPE", 1)
    assert history_of_tool(store, EDGE, until=(of_type, "2711")) == every[1:]
    frozen = replace(inputs, memory=MemoryOptions(memory="frozen", last_part="2511"))
    with pytest.raises(AttributeError):  # the curves of 2511 are wanted
        with_history(store, frozen)


def test_a_part_not_yet_inspected_has_no_finish_and_another_edge_nothing(store: Store) -> None:
    correction = corrections()["2511"]
    keep_part(store, correction, cut_of(correction, "2511", order=0), None)
    (part,) = history_of(store, EDGE)
    assert part.finish is None and part.correction_mm is None
    assert history_of(store, Edge(EDGE.tool, EDGE.insert, "3")) == ()


def test_a_cut_as_programmed_has_the_touches_of_its_part_and_no_correction(store: Store) -> None:
    correction = corrections()["2511"]
    keep_part(store, correction, replace(cut_of(correction, "2511", order=0), correction=""), 60.0)
    (part,) = history_of(store, EDGE)
    assert part.correction_mm == pytest.approx(0.0, abs=1e-3) and len(part.semifinish) == 31


def test_a_cut_of_no_known_correction_teaches_nothing(store: Store) -> None:
    keep(store, [cut_of(corrections()["2511"], "2511", order=0)])
    assert history_of(store, EDGE) == ()


def test_quarantine_leaves_a_part_out_until_it_is_lifted(store: Store) -> None:
    correction = corrections()["2511"]
    cut = cut_of(correction, "2511", order=0)
    keep_part(store, correction, cut, 2.0)
    keep(store, [Quarantine(cut.identity, MADE_AT, "gain 2.1")])
    assert history_of(store, EDGE) == ()
    keep(store, [Quarantine(cut.identity, MADE_AT + timedelta(hours=1), "looked at", lifted=True)])
    assert len(history_of(store, EDGE)) == 1


def test_the_latest_inspection_of_a_cut_counts_and_a_superseded_cut_does_not(store: Store) -> None:
    correction = corrections()["2511"]
    cut = cut_of(correction, "2511", order=0)
    keep_part(store, correction, cut, 2.0)
    keep(store, inspected(correction, cut, 3.0))
    (part,) = history_of(store, EDGE)
    assert part.finish is not None and part.finish.error_mm == pytest.approx(0.003)
    (row,) = [kept.row for kept in keep(store, [cut])]
    keep(store, [replace(cut, correction="", order=5)], supersedes=row)
    (part,) = history_of(store, EDGE)
    assert part.correction_mm == pytest.approx(0.0, abs=1e-3)


def test_a_part_inspected_before_one_that_was_cut_earlier_is_in_doubt(store: Store) -> None:
    """NIST's 3811 carries the highest number of five parts and the lowest inspection number [6811 Tables 10-11]."""
    made = corrections()
    for order, serial in enumerate(SERIALS):
        hours = -3.0 if serial == "2711" else 0.5
        keep_part(store, made[serial], cut_of(made[serial], serial, order=order), 1.0, hours)
    assert [part.order_in_doubt for part in history_of(store, EDGE)] == [False, False, True]


def dated(orders: Sequence[int | None], inspected_at: Sequence[float]) -> list[Dated]:
    cut = cut_of(example_correction("modbas2"))
    return [
        Dated(replace(cut, order=order), MADE_AT + timedelta(hours=hours), k)
        for k, (order, hours) in enumerate(zip(orders, inspected_at, strict=True))
    ]


@given(st.lists(st.integers(0, 6), min_size=1, max_size=7))
def test_the_fewest_parts_are_in_doubt(hours: list[int]) -> None:
    """By trying every choice of parts: those left over rise, and no larger choice does."""
    found = cutting_order(dated(range(len(hours)), hours))
    assert list(found.places) == list(range(len(hours)))
    left = [hour for hour, doubt in zip(hours, found.in_doubt, strict=True) if not doubt]
    chosen = [[h for k, h in enumerate(hours) if mask >> k & 1] for mask in range(2 ** len(hours))]
    assert left == sorted(left)
    assert len(left) == max(len(one) for one in chosen if one == sorted(one))


def test_of_nists_piecs11_parts_3811_is_in_doubt() -> None:
    """Numbers of parts and of inspections as printed in [6811 Tables 10 and 11]: 3811 was inspected first."""
    parts = {"3511": 158, "3611": 160, "3711": 162, "3811": 154, "3812": 165, "3911": 167}
    cut = cut_of(example_correction("modbas2"))
    cuts = [
        Dated(replace(cut, part=replace(cut.part, serial=serial)), MADE_AT + timedelta(hours=number), k)
        for k, (serial, number) in enumerate(parts.items())
    ]
    found = cutting_order(cuts)
    assert [list(parts)[k] for k in found.places] == ["3811", "3511", "3611", "3711", "3812", "3911"]
    assert [list(parts)[k] for k, doubt in zip(found.places, found.in_doubt, strict=True) if doubt] == ["3811"]


def test_parts_without_order_and_time_are_taken_as_they_were_kept_and_doubted() -> None:
    cuts = [replace(one, inspected_at=None) for one in dated([None, None], [1, 2])]
    found = cutting_order(cuts)
    assert found.places == (0, 1) and found.in_doubt == (True, True)


def test_which_store_is_used(tmp_path: Path) -> None:
    assert named_store(tmp_path, None, "parts.db") == str(tmp_path / "parts.db")
    assert named_store(tmp_path, None, "postgresql://plant/parts") == "postgresql://plant/parts"
    assert named_store(tmp_path, "other.db", "parts.db") == "other.db"
    assert store_of(tmp_path, None, None) is None and store_of(tmp_path, False, None, "made") is None
    unmade, beside = store_of(tmp_path, None, None, "made"), tmp_path / "trueloop.db"
    assert unmade is not None and unmade.where == str(beside) and not beside.exists()
    keep(unmade.made(), [Part(PartType("SHAFT"), "1")])
    (found,) = find(open_store(beside), Part)
    assert found.value.serial == "1" and store_of(tmp_path, None, None, "unused") is None
