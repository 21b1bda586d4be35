"""A length between faces of two edges as an observation of one of them, by hand."""

import math

import numpy as np
import pytest

from trueloop.turned.readings.vectors import own_seen, shared_words
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen

DATUM = Seen.at("front (datum)", ((0, 5.0, 1.0),), 0.0, 0.0)
FIRST = Seen.at("L1", ((1, 2.0, 1.0), (0, 5.0, -1.0)), 0.012, 0.003)
SECOND = Seen.at("L2", ((2, 1.0, -1.0), (1, 2.0, 1.0)), 0.020, 0.004)
"""e1 − e0 = 12 µm and e1 − e2 = 20 µm: e1 = +12 and e2 = −8 µm."""
ALL = (DATUM, FIRST, SECOND)


def vectors(*seen: Seen, touched: tuple[tuple[int, float], ...] = ()) -> ErrorVectors:
    """Readings, and touches of features by index with their errors; each ±1 µm."""
    n = len(touched)
    return ErrorVectors(
        point=tuple(f"t{k}" for k in range(n)),
        feature_index=np.array([index for index, _ in touched], dtype=np.intp),
        arc_length_mm=np.full(n, 0.5),
        error_mm=np.array([error_mm for _, error_mm in touched]),
        standard_u_mm=np.full(n, 0.001),
        at_reference=np.zeros(n, dtype=np.bool_),
        nominal_mm=np.zeros((n, 2)),
        outward_normal=np.tile([0.0, 1.0], (n, 1)),
        seen=seen,
    )


def test_the_face_of_another_edge_is_taken_out_with_its_uncertainty() -> None:
    (of_first,) = own_seen(vectors(*ALL), {1})
    assert of_first.feature_index.tolist() == [1] and of_first.arc_length_mm.tolist() == [2.0]
    assert (of_first.value_mm, of_first.standard_u_mm) == pytest.approx((0.012, 0.003))
    (of_second,) = own_seen(vectors(*ALL), {2})
    assert of_second.weight.tolist() == [-1.0]
    assert (of_second.value_mm, of_second.standard_u_mm) == pytest.approx((0.008, math.hypot(0.004, 0.003)))


def test_a_length_is_not_counted_twice() -> None:
    """e2 is known by L2 alone, which therefore states nothing of e1 that L1 does not."""
    assert [one.name for one in own_seen(vectors(*ALL), {0, 1})] == ["front (datum)", "L1"]
    assert [one.name for one in own_seen(vectors(*ALL), {0, 1, 2})] == ["front (datum)", "L1", "L2"]


def test_a_length_between_faces_that_nothing_places_corrects_none_of_them() -> None:
    assert own_seen(vectors(SECOND), {2}) == () and own_seen(vectors(SECOND), {1}) == ()
    (words,) = shared_words(vectors(SECOND), ({1}, {2}), ("front", "shoulder", "back"))
    assert words.startswith("L2: between features that are not cut together, and corrects none of them")
    (words,) = shared_words(vectors(*ALL), ({0, 1}, {2}), ("front", "shoulder", "back"))
    assert words == "L2: taken as the error of back, counted from shoulder."


def test_a_touched_face_of_another_edge_places_the_face_that_a_length_counts_from_it() -> None:
    """e1 is touched at +15 µm, and e1 − e2 is read as 20: e2 is −5 µm, with both uncertainties."""
    touched = vectors(SECOND, touched=((1, 0.015),))
    (of_second,) = own_seen(touched, {2})
    assert of_second.value_mm / of_second.weight.item() == pytest.approx(-0.005)
    assert of_second.standard_u_mm == pytest.approx(math.hypot(0.004, 0.001))
    (words,) = shared_words(touched, ({1}, {2}), ("front", "shoulder", "back"))
    assert words == "L2: taken as the error of back, counted from shoulder."
