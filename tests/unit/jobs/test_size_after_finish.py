"""Errors after a finish cut: those of a tool that was moved are kept, those in another unit are not."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.correction import example_correction
from tests.support.kept import cut_of, inspected
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.store.history import errors_of
from trueloop.jobs.store.of_this_part import require_size
from trueloop.turned.error_curve.curve import remembered_only


def size_of(x_um: float, rest_um: float, times: float = 1.0, points: int = 32) -> None:
    """A part whose touches were 3 µm off, and whose finish cut left a tool moved in x, and a wave beside it."""
    plain = example_correction("modbas2")
    vectors = plain.model.vectors
    size = float(np.sqrt(np.mean(vectors.error_mm**2)))
    model = replace(plain.model, vectors=replace(vectors, error_mm=vectors.error_mm * (0.003 / size)))
    budget = remembered_only(np.full(len(vectors.error_mm), 0.0015), None)
    prediction = replace(plain.prediction, budget=budget)
    found = errors_of(plain.profile, inspected(plain, cut_of(plain), 1.0)[0])
    assert found is not None
    found = found.chosen(np.linspace(0, len(found.point) - 1, points).astype(int))
    wave = rest_um * np.sqrt(2.0) * np.sin(2.5 * np.arange(points))
    error = 1e-3 * times * (x_um * found.outward_normal[:, 0] + wave)
    require_size(replace(plain, model=model, prediction=prediction), replace(found, error_mm=error))


@pytest.mark.parametrize("x_um", [-40.0, 25.0])
def test_a_tool_that_was_moved_is_no_other_unit(x_um: float) -> None:
    size_of(x_um, 1.0)


@pytest.mark.parametrize(
    ("x_um", "rest_um", "times", "points"), [(3, 1, 25.4, 32), (0, 20, 1, 32), (25, 1, 1, 5), (150, 1, 1, 32)]
)
def test_what_a_moved_tool_does_not_explain_is_refused(x_um: float, rest_um: float, times: float, points: int) -> None:
    """In inches; a form; of five points two coordinates explain most; further than a tool is moved unnoticed."""
    with pytest.raises(TrueloopError) as refused:
        size_of(x_um, rest_um, times, points)
    assert refused.value.code == Code.STO_UNIT
