"""Every way in which what is kept of a part is refused or warned of."""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime

from tests.support.correction import example_correction
from tests.support.kept import EDGE, MADE_AT, TYPE, cut_of, inspected, of_part
from trueloop.domain.life import InspectionLink, Stage
from trueloop.domain.part import Part
from trueloop.errors import Code
from trueloop.jobs.measure.keep_measured import no_edge, require_stage
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.history import errors_of, order_in_doubt
from trueloop.jobs.store.keep_correction import without_inspection
from trueloop.jobs.store.keep_facts import CutStatement, correction_of
from trueloop.jobs.store.of_this_part import other_points, require_later, require_size
from trueloop.loops.turned.made_parts import program_that_ran
from trueloop.loops.turned.provenance import enveloped
from trueloop.storage.store import Store, keep, open_store

SERIAL = "2511.161"
PART = Part(TYPE, SERIAL)
PLAIN = example_correction("modbas2")


def _store() -> Store:
    return open_store("sqlite://", create=True, codec=store_codec())


def _another_stage() -> object:
    store, cut = _store(), cut_of(PLAIN, SERIAL)
    inspection, _ = inspected(PLAIN, cut, 2.0)
    touched = replace(cut, stage=Stage.SEMIFINISH)
    keep(store, [inspection, InspectionLink(inspection.identity, touched.identity)])
    require_stage(store, inspection, cut)
    return None


def _not_inspected() -> object:
    store = _store()
    keep(store, [enveloped(of_part(PLAIN, "2611"))])
    return list(without_inspection(store, EDGE, PART))


def _in_doubt() -> object:
    store = _store()
    for order in (0, 1):
        cut = cut_of(PLAIN, f"251{order}", order=order)
        keep(store, [cut, *inspected(PLAIN, cut, 1.0)])
    return list(order_in_doubt(store, cut_of(PLAIN, "3811.154", order=2), MADE_AT))


def _found(error_um: float, points: int) -> object:
    inspection, _ = inspected(PLAIN, cut_of(PLAIN), error_um)
    after = errors_of(PLAIN.profile, replace(inspection, values=inspection.values[:points]))
    assert after is not None
    if points < inspection.count:
        return list(other_points(PART, PLAIN, after))
    require_size(PLAIN, after)
    return None


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.STO_PROGRAM: lambda: program_that_ran(PLAIN, cut_of(PLAIN, program_sha256="0" * 64)),
    Code.STO_STAGE: _another_stage,
    Code.STO_LINK: lambda: correction_of(_store(), PART, CutStatement()),
    Code.STO_CLOCK: lambda: require_later(
        ("the inspection before the finish cut", datetime(2026, 1, 6, 8, tzinfo=UTC)),
        ("the inspection after it", datetime(2026, 1, 6, 7, tzinfo=UTC)),
    ),
    Code.STO_PATTERN: lambda: _found(2.0, 12),
    Code.STO_UNIT: lambda: _found(250.0, 32),
    Code.STO_EDGE: lambda: no_edge(PART),
    Code.STO_ORDER: _in_doubt,
    Code.STO_OPEN: _not_inspected,
}
