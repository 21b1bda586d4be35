"""A part's life: its cuts, inspections, links and corrections, and nothing of another part."""

from dataclasses import replace

from tests.support.records import TURNED
from tests.support.stores import AT, TYPE, cut, link, part, touched
from trueloop.domain.life import Stage
from trueloop.domain.part import Part
from trueloop.domain.record import Correction
from trueloop.storage.store import keep, life, open_store


def test_a_part_has_its_own_records_in_the_order_in_which_they_were_kept() -> None:
    store = open_store("sqlite://", create=True)
    semi, finish = cut("17", Stage.SEMIFINISH), cut("17", correction="c0ffee")
    first, second = touched("17"), touched("17", sha256="3" * 64)
    keep(store, [finish, second, link(second, finish)])
    keep(store, [semi, first, link(first, semi)])
    for serial in ("16", "18"):
        other = replace(TURNED, id=serial, inspections=(touched(serial),))
        keep(store, [cut(serial), touched(serial), link(touched(serial), cut(serial)), Correction(other, {}, None)])
    from_touches = replace(TURNED, id="f00d", inspections=(first,))
    keep(
        store, [Correction(replace(TURNED, id="c0ffee", inspections=()), {}, None), Correction(from_touches, {}, None)]
    )
    of_17 = life(store, part("17"))
    assert [one.value for one in of_17.cuts] == [finish, semi]
    assert [one.value for one in of_17.inspections] == [second, first]
    assert [one.value for one in of_17.links] == [link(second, finish), link(first, semi)]
    assert [one.value.id for one in of_17.corrections] == ["c0ffee", "f00d"]
    assert of_17.cut_of(first) == semi
    assert of_17.cut_of(touched("16")) is None


def test_the_same_serial_of_another_revision_or_type_is_another_part() -> None:
    store = open_store("sqlite://", create=True)
    keep(store, [cut("17"), touched("17")])
    for other in (replace(TYPE, revision="C"), replace(TYPE, name="sleeve")):
        assert life(store, Part(other, "17")).cuts == ()
    assert life(store, part("18")) == life(store, part("18"))
    assert life(store, part("18")).inspections == ()


def test_what_is_superseded_is_no_longer_of_the_part() -> None:
    store = open_store("sqlite://", create=True)
    (wrong,) = keep(store, [touched("17")])
    keep(store, [touched("18")], supersedes=wrong.row)
    assert life(store, part("17")).inspections == ()
    assert [one.value.measured_at for one in life(store, part("18")).inspections] == [AT]
