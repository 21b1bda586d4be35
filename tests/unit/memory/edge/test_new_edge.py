"""What earlier edges of a tool teach the first part of a new one, on parts made up by another model."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tests.support.cut_places import CYLINDER, places
from tests.unit.memory.edge.parts import ANGLES, errors, series
from trueloop.errors import Code, TrueloopError
from trueloop.estimate.catalogue import SHARED, turned_catalogue
from trueloop.estimate.places import joined
from trueloop.estimate.state import State
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.memory.edge.predict import expect
from trueloop.memory.made_part import CutErrors, Expected, MadePart

CHANGED_MM = 0.006 * np.cos(2.0 * ANGLES) - 0.012 * np.sin(ANGLES)
"""The new edge's form and setting, less those of the edge before."""


def of_new_edge(part: MadePart, order: float) -> MadePart:
    """The part as the new edge cuts it: both of its cuts err otherwise, by the same."""
    assert part.finish is not None and part.correction_mm is not None
    touched = replace(part.semifinish, error_mm=part.semifinish.error_mm + CHANGED_MM)
    correction = touched.error_mm
    finish = replace(part.finish, error_mm=part.finish.error_mm + part.correction_mm + CHANGED_MM - correction)
    changed = replace(part, semifinish=touched, finish=finish, correction_mm=correction)
    return replace(changed, edge="new", setting="new", order=order)


def expected(history: Sequence[MadePart], today: MadePart, at: CutErrors | None = None) -> Expected:
    asked = CutErrors.asked(ANGLES, "dome") if at is None else at
    return expect(history, replace(today, finish=None, correction_mm=None), asked, MemoryOptions())


def test_the_first_part_of_a_new_edge_knows_what_the_finish_cut_does_otherwise() -> None:
    *history, today = series(7)
    today, before = of_new_edge(today, 6.0), [replace(part, order=part.order - 6.0) for part in history]
    alone, found, uncorrected = expected((), today), expected(before, today), today.uncorrected_mm
    assert uncorrected is not None and alone.own_fit and not found.own_fit
    left, own = (np.sqrt(np.mean((uncorrected - mm) ** 2)) for mm in (found.mean_mm, today.semifinish.error_mm))
    assert left < 0.0022 < own
    wide, narrow = (np.sqrt(np.mean(np.diag(one.covariance_mm2))) for one in (alone, found))
    assert narrow < 0.75 * wide
    assert np.mean(np.abs(uncorrected - found.mean_mm) <= 1.96 * np.sqrt(np.diag(found.covariance_mm2))) >= 0.9
    assert "what earlier edges show" in " ".join(found.notes)


@pytest.mark.parametrize("name", SHARED)
def test_half_of_the_variance_is_the_tools_and_one_edge_alone_is_as_before(name: str) -> None:
    at = joined([places([CYLINDER, 1.0], edge=edge, finish=True) for edge in ("old", "new")])
    at.columns["setting"][2:] = "other"
    whole = State.before(turned_catalogue()).predict(at, terms=(name,)).covariance_mm2
    both = State.before(turned_catalogue(several_edges=True)).predict(at, terms=(name, f"{name} of the tool"))
    assert both.covariance_mm2[:2, :2] == pytest.approx(whole[:2, :2], rel=1e-9)
    assert both.covariance_mm2[:2, 2:] == pytest.approx(0.5 * whole[:2, :2], rel=1e-9)
    assert whole[:2, 2:] == pytest.approx(np.zeros((2, 2)), abs=1e-15)


def test_a_new_edge_is_corrected_by_itself_where_its_touches_do_not_reach() -> None:
    """Earlier edges saw 5° to 85°, today's touches 5° to 45°: the new nose's form beyond is nobody's knowledge."""
    *history, today = series(5)
    few = of_new_edge(today, 5.0)
    few = replace(few, semifinish=errors(few.semifinish.error_mm[:9], ANGLES[:9]))
    assert expected(history, few).own_fit
    assert not expected(history, few, CutErrors.asked(ANGLES[:9], "dome")).own_fit
    with pytest.raises(TrueloopError) as refused:
        expected(history, replace(few, semifinish=CutErrors.none()))
    assert refused.value.code == Code.MEM_SETTING
