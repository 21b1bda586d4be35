"""What an edge remembers, as it is shown, is what the model says of its parts."""

import numpy as np
import pytest

from tests.support.correction import example_correction
from tests.support.kept import EDGE, MADE_AT, cut_of, inspected, of_part
from trueloop.domain.life import EdgeEvent, EdgeEventKind
from trueloop.errors import Code, TrueloopError
from trueloop.factory.shown.machines import tool_rows
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.history import history_of
from trueloop.jobs.tool_life import tool_memory
from trueloop.loops.turned.provenance import enveloped
from trueloop.memory.edge.learnt import learnt
from trueloop.storage.store import Store, keep, open_store

SERIALS = ("2511", "2611", "2711")


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """Three parts of one edge, inspected after the finish cut."""
    made = open_store(tmp_path_factory.mktemp("memory") / "trueloop.db", create=True, codec=store_codec())
    keep(made, [EdgeEvent(EDGE, EdgeEventKind.MOUNTED, MADE_AT, "otto", values={"x_mm": 1.5})])
    for order, serial in enumerate(SERIALS):
        correction = of_part(example_correction("modbas2"), serial)
        cut = cut_of(correction, serial, order=order)
        keep(made, [enveloped(correction), cut, *inspected(correction, cut, 1.0 + order)])
    return made


def test_curves_and_bands_are_those_of_the_model(store: Store) -> None:
    shown = tool_memory(store, tool_rows(store)[0].id)
    expected = learnt(history_of(store, EDGE), np.radians(shown.contact_angle_deg))
    assert expected is not None
    form, finish = shown.curves
    assert (form.part_type, finish.part_type) == ("", "MODBAS2 B")
    assert form.error_um == pytest.approx(1000 * expected.form.mean_mm)
    assert finish.error_um == pytest.approx(1000 * expected.in_all["MODBAS2 B"].mean_mm)
    assert finish.band_um == pytest.approx(1.96 * 1000 * expected.in_all["MODBAS2 B"].u_mm)
    assert (shown.parts, shown.inspected) == (3, 3)
    assert shown.setting_um == pytest.approx(1000 * expected.setting_mm)


def test_the_inspections_lie_about_the_curve_within_what_parts_scatter(store: Store) -> None:
    """Finish errors had nothing been corrected: their mean over parts at an angle is near the curve there."""
    shown = tool_memory(store, tool_rows(store)[0].id)
    finish = [one for one in shown.points if one.finish]
    assert {one.serial for one in finish} == set(SERIALS)
    at = [one.contact_angle_deg for one in finish]
    curve = np.interp(at, shown.contact_angle_deg, shown.curves[1].error_um)
    assert np.abs(np.array([one.error_um for one in finish]) - curve).max() < 4.0


def test_angles_far_from_all_that_parts_have_shown_are_not_seen(store: Store) -> None:
    shown = tool_memory(store, tool_rows(store)[0].id)
    angles = np.array(shown.contact_angle_deg)
    known = np.array([one.contact_angle_deg for one in shown.points])
    near = np.abs(np.subtract.outer(angles, known)).min(axis=1)
    clear = np.abs(near - 6.0) > 1e-9  # a whole degree away from a line's angle is as near as it may be
    assert np.array_equal(np.array(shown.seen)[clear], (near <= 6.0)[clear])
    assert not shown.seen[0] and not shown.seen[-1]


def test_a_next_part_needs_few_touches_and_fewer_do_not_tell_more(store: Store) -> None:
    (following,) = tool_memory(store, tool_rows(store)[0].id).next_parts
    assert following.part_type == "MODBAS2 B" and following.refusal == ""
    assert 1 <= following.touches < following.of == 31
    assert following.left_um is not None and 0.5 < following.left_um < 5.0


def test_events_are_as_they_were_stated(store: Store) -> None:
    (event,) = tool_memory(store, tool_rows(store)[0].id).events
    assert (event.kind, event.by, event.values, event.at) == ("mounted", "otto", {"x_mm": 1.5}, MADE_AT)


def test_an_edge_that_is_not_there_is_refused(store: Store) -> None:
    with pytest.raises(TrueloopError) as caught:
        tool_memory(store, 999)
    assert caught.value.code is Code.FAC_UNKNOWN
