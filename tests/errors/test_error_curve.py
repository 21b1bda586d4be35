"""Every refusal of a fit."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.support.profiles import modbas2
from tests.support.touched import noise, touched
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.between_cuts import BetweenCuts
from trueloop.turned.fit.nose_fit import fit_nose_model, nose_touches
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors

PROFILE = modbas2()
DOME = 6
VECTORS = touched(PROFILE, [0, 0, 5, 5, 1, 1, 12], noise(0.01))


def fit(vectors: ErrorVectors = VECTORS, profile: Profile = PROFILE, **options: object) -> object:
    return fit_profile(profile, vectors, FitOptions(**options))  # type: ignore[arg-type]


def moved(k: int, arc_length_mm: float) -> ErrorVectors:
    along = VECTORS.arc_length_mm.copy()
    along[k] = arc_length_mm
    return replace(VECTORS, arc_length_mm=along)


def with_error(error_mm: float) -> ErrorVectors:
    errors = VECTORS.error_mm.copy()
    errors[3] = error_mm
    return replace(VECTORS, error_mm=errors)


def nose_asked_outside_its_range() -> object:
    nose = fit_nose_model([nose_touches("a", PROFILE, VECTORS)])
    return nose.w_mm(np.radians(120.0))


def nose_of_one_touch() -> object:
    single = touched(PROFILE, [0, 0, 0, 0, 0, 0, 1], noise(0.01))
    return fit_nose_model([nose_touches("a", PROFILE, single)])


REFUSALS: list[tuple[Code, Callable[[], object]]] = [
    (Code.FIT_POINTS, lambda: fit(touched(PROFILE, [0] * 7, noise(0.01)))),
    (Code.FIT_POINTS, lambda: fit(knot_every=2, vectors=touched(PROFILE, [0, 0, 5, 5, 1, 1, 3], noise(0.01)))),
    (Code.FIT_POINTS, nose_of_one_touch),
    (Code.FIT_POINTS, lambda: fit_nose_model([])),
    (Code.FIT_VALUE, lambda: fit(with_error(float("nan")))),
    (Code.FIT_VALUE, lambda: fit(replace(VECTORS, standard_u_mm=-VECTORS.standard_u_mm - 1.0))),
    (Code.FIT_ORDER, lambda: fit(moved(1, float(VECTORS.arc_length_mm[0])))),
    (Code.FIT_ORDER, lambda: fit(moved(2, 0.0))),
    (Code.FIT_OUTSIDE, lambda: fit(moved(0, -5.0))),
    (Code.FIT_VALUE, lambda: fit(repeatability_mm=-0.001)),
    (Code.FIT_VALUE, lambda: fit(alike_over_mm=-1.0)),
    (Code.FIT_VALUE, lambda: fit(between_cuts=BetweenCuts(-0.001, 0.0, "stated"))),
    (Code.FIT_VALUE, lambda: fit(between_cuts=BetweenCuts(0.0, -0.002, "stated"))),
    (Code.FIT_KNOTS, lambda: fit(knot_every=1)),
    (Code.FIT_KNOTS, lambda: fit(knot_every_on={"no such feature": 3})),
    (Code.FIT_ANGLE, nose_asked_outside_its_range),
    (Code.FIT_CONDITIONS, lambda: fit(prescribed={"dome": EndConditions(start_value_mm=0.5)})),
    (Code.FIT_CONDITIONS, lambda: fit(prescribed={"cone": EndConditions(start_slope=0.0, end_slope=0.0)})),
    (Code.FIT_CONDITIONS, lambda: fit(prescribed={"no such feature": EndConditions(start_value_mm=0.0)})),
    (Code.FIT_CONDITIONS, lambda: fit(prescribed={"cone": EndConditions(start_value_mm=float("inf"))})),
]
PRODUCERS: dict[Code, Callable[[], object]] = dict(REFUSALS)


@pytest.mark.parametrize(("code", "produce"), REFUSALS)
def test_refused_with_its_code(code: Code, produce: Callable[[], object]) -> None:
    with pytest.raises(TrueloopError) as caught:
        produce()
    assert caught.value.code is code
    assert caught.value.hint
