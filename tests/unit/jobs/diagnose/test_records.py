"""Who saw a part, and what corrections took off its errors, from the records of a store."""

from dataclasses import replace

import pytest

from tests.support.stores import cut, link, part, touched
from trueloop.diagnosis.causes.cause import SeenBy
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.life import InspectionLink, Stage
from trueloop.jobs.diagnose.records import read_records
from trueloop.jobs.diagnose.seen_series import of_proposals
from trueloop.loops.post_process.series import identity_of, sizes_of
from trueloop.storage.store import keep, open_store


def test_touches_off_the_machine_are_not_the_machines() -> None:
    store = open_store("sqlite://", create=True)
    on, off, early = (touched(sha256=digit * 64) for digit in "123")
    released = InspectionLink(off.identity, cut().identity, released=True)
    semifinish = cut(stage=Stage.SEMIFINISH)
    keep(store, [on, off, early, cut(), semifinish, link(on, cut()), released, link(early, semifinish)])
    records = read_records(store, None)
    assert [records.seen_by(one) for one in (on, off, early)] == [SeenBy.MACHINE, SeenBy.CMM, None]
    assert records.of_part(part()) == {SeenBy.MACHINE: on, SeenBy.CMM: off}


def test_sizes_read_by_a_gauge_on_the_machine_are_not_its_probes() -> None:
    store = open_store("sqlite://", create=True)
    value = Reading("d1", Quantity.DIAMETER, 40.01, 40.0, feature="journal")
    devices = {"4": "micrometer 25-50 mm", "5": "probe 12", "6": ""}
    by = [replace(Inspection(part(), "readings", n * 64, 1, (value,)), device=name) for n, name in devices.items()]
    keep(store, [*by, cut(), *(link(one, cut()) for one in by)])
    records = read_records(store, None)
    assert [records.seen_by(one) for one in by] == [SeenBy.CMM, SeenBy.MACHINE, SeenBy.CMM]


def test_what_a_later_inspection_did_not_measure_is_kept_if_measured_alike() -> None:
    store = open_store("sqlite://", create=True)
    sizes = (("journal", 40.0), ("seat", 30.0))
    first, second = (Reading(name, Quantity.DIAMETER, size + 0.01, size, feature=name) for name, size in sizes)
    again = replace(first, actual=40.02)
    earlier = Inspection(part(), "readings", "7" * 64, 2, (first, second))
    later = Inspection(part(), "readings", "8" * 64, 1, (again,))
    keep(store, [earlier, later])
    assert read_records(store, None).of_part(part())[SeenBy.CMM].values == (again, second)
    touches = touched(sha256="9" * 64)
    keep(store, [cut(), touches, InspectionLink(touches.identity, cut().identity, released=True)])
    assert read_records(store, None).of_part(part())[SeenBy.CMM].values == touches.values


@pytest.mark.parametrize(("quantity", "share"), [(Quantity.DIAMETER, 0.5), (Quantity.RADIUS, 1.0)])
def test_a_diameters_correction_is_twice_that_of_the_radius(quantity: Quantity, share: float) -> None:
    value = Reading("d1", quantity, 40.01, 40.0, feature="journal")
    seen = Inspection(part(), "readings", "4" * 64, 1, (value,))
    ((asked, _),) = sizes_of(seen)
    series = identity_of(part().part_type, asked)
    found = of_proposals({series: 0.010}, [seen])
    assert found == {("journal", "radius"): pytest.approx(share * 0.010)}
