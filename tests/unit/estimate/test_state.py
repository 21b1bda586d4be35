"""The state by hand arithmetic, and what an exact update must keep."""

import tracemalloc

import numpy as np
import pytest

from tests.support.cut_places import CYLINDER, FACE, places, touches
from trueloop.arrays import Array
from trueloop.estimate.catalogue import turned_catalogue
from trueloop.estimate.places import Observed, Places, joined, together
from trueloop.estimate.state import State
from trueloop.estimate.term import Catalogue, Prior, Term

CATALOGUE = turned_catalogue()
ANGLES = np.linspace(FACE, CYLINDER, 9)


def offset_only(step: float = 0.0) -> Catalogue:
    """An offset of 20 µm along x, by so much walking from part to part; repeatability 1 µm."""

    def basis(at: Places) -> Array:
        return np.asarray(np.sin(at.number("contact_angle_rad"))[:, None])

    offset = Term("offset", (), basis, lambda sizes: np.array([sizes["offset"]]), lambda _: np.array([step]))
    prior = {"offset": Prior(0.020, 0.5, "as set")}
    return Catalogue((offset,), lambda at, _: np.full(len(at), 0.001**2), prior)


def test_one_touch_by_hand() -> None:
    """10 µm seen at a cylinder, prior 20 µm, noise 1 µm and 2 µm: 10·400/(400 + 1 + 4) µm, 400·5/405 µm² are left."""
    after = State.before(offset_only()).given(touches(places(CYLINDER), [10.0], 2.0), robust=False).state
    cylinder = after.predict(places(CYLINDER), repeatability=False)
    assert cylinder.mean_mm[0] == pytest.approx(10e-3 * 400 / 405, rel=1e-5)
    assert cylinder.covariance_mm2[0, 0] == pytest.approx(400 * 5 / 405 * 1e-6, rel=1e-5)
    bore = after.predict(places(-CYLINDER), repeatability=False)
    assert bore.mean_mm[0] == pytest.approx(-10e-3 * 400 / 405, rel=1e-5)
    assert after.predict(places(CYLINDER)).covariance_mm2[0, 0] == pytest.approx((400 * 5 / 405 + 1) * 1e-6, rel=1e-5)


@pytest.mark.parametrize("term", ["form along", "group", "group of the part", "tilt of the part"])
def test_a_group_of_features_is_displaced_not_swollen(term: str) -> None:
    """Errors n·d and n'·d of one displacement, equally large along x and z: correlated by the cosine of their angle."""
    at = places([FACE, np.pi / 4, CYLINDER, -CYLINDER], share=0.3)
    covariance = State.before(CATALOGUE).predict(at, terms=(term,)).covariance_mm2
    half = np.sqrt(0.5)
    by_hand = [[1, half, 0, 0], [half, 1, half, -half], [0, half, 1, -1], [0, -half, -1, 1]]
    assert covariance == pytest.approx(covariance[0, 0] * np.array(by_hand), abs=1e-9 * covariance[0, 0])
    assert 1e3 * np.sqrt(covariance[0, 0]) > 0.5


def test_a_random_walk_loses_what_it_knew_by_its_step_a_part() -> None:
    catalogue = offset_only(step=0.003)
    first = State.before(catalogue).given(touches(places(CYLINDER, part=1), [10.0]), robust=False).state
    later = first.predict(places(CYLINDER, part=5), repeatability=False)
    now = first.predict(places(CYLINDER, part=1), repeatability=False)
    assert later.covariance_mm2[0, 0] - now.covariance_mm2[0, 0] == pytest.approx(4 * 9e-6, rel=1e-6)
    assert later.mean_mm == pytest.approx(now.mean_mm)


def test_a_mean_over_ten_thousand_places_costs_no_square_of_their_number() -> None:
    """10 µm on average of a cylinder: the scatter of 1 µm averages out, noise of 2 µm stays; 800 MB would be 10⁴²."""
    n, values = 10_000, touches(places(CYLINDER), [10.0], 2.0)
    everywhere = places(np.full(n, CYLINDER))
    mean = Observed(everywhere, values.value_mm, values.standard_u_mm, np.full((1, n), 1.0 / n))
    tracemalloc.start()
    updated = State.before(offset_only()).given(mean, robust=False)
    expected = updated.state.predict(everywhere, mean.functional)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50e6
    assert updated.innovation.covariance_mm2[0, 0] == pytest.approx((400 + 4 + 1e-4) * 1e-6, rel=1e-6)
    assert expected.mean_mm[0] == pytest.approx(10e-3 * 400 / (404 + 1e-4), rel=1e-5)


def test_one_after_the_other_is_all_at_once() -> None:
    rng = np.random.default_rng(1)
    parts = [touches(places(ANGLES, part=k, finish=k % 2 == 1), rng.normal(0, 20, 9), 0.5) for k in (1, 1, 1)]
    once = State.before(CATALOGUE).given(together(parts), robust=False).state
    each = State.before(CATALOGUE)
    for one in parts:
        each = each.given(one, robust=False).state
    asked = places(np.linspace(0.1, 1.4, 7), finish=True)
    assert each.predict(asked).mean_mm == pytest.approx(once.predict(asked).mean_mm, abs=1e-9)
    assert each.predict(asked).covariance_mm2 == pytest.approx(once.predict(asked).covariance_mm2, abs=1e-11)


def test_one_more_touch_never_widens_a_band() -> None:
    """As long as none of them is weighed: the covariance follows from the places alone."""
    asked, state = places(ANGLES, finish=True), State.before(CATALOGUE)
    before = state.predict(asked).covariance_mm2
    for k in (4, 0, 8, 2, 6):
        state = state.given(touches(places(ANGLES[k]), [10.0], 0.5), robust=False).state
        after = state.predict(asked).covariance_mm2
        assert np.all(np.diag(after) <= np.diag(before) + 1e-15)
        before = after


def test_parts_that_are_over_leave_what_lasts_and_the_state_does_not_grow() -> None:
    state, kept = State.before(CATALOGUE), []
    rng = np.random.default_rng(2)
    with_parts = state
    for k in range(1, 7):
        seen = touches(places(ANGLES, part=k), 15 + rng.normal(0, 2, 9), 0.5)
        with_parts = with_parts.given(seen, robust=False).state
        state = state.given(seen, robust=False).state.without_parts()
        kept.append(len(state.mean))
    asked = places(ANGLES, part=7, finish=True)
    assert len(set(kept)) == 1
    assert state.predict(asked).mean_mm == pytest.approx(with_parts.predict(asked).mean_mm, abs=1e-8)
    assert state.predict(asked).covariance_mm2 == pytest.approx(with_parts.predict(asked).covariance_mm2, abs=1e-10)


def test_what_is_measured_from_a_reference_face_knows_nothing_of_z() -> None:
    """Two faces, z from the first: their difference is what all faces err by against it, whatever dZ is."""
    at = joined([places(FACE, -20, group=0), places([FACE, FACE], [0, 0], [0.3, 0.7], group=1)])
    from_first = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    seen = Observed(at, np.array([0.004, 0.004]), np.full(2, 1e-4), from_first)
    state = State.before(CATALOGUE).given(seen, robust=False).state
    finish = Places({**at.columns, "finish": np.ones(len(at))})
    difference = state.predict(finish, from_first)
    assert difference.mean_mm == pytest.approx([0.004, 0.004], abs=0.0008)
    assert difference.standard_u_mm[0] < 0.5 * state.predict(finish).standard_u_mm[1]


def test_shares_of_the_terms_add_up() -> None:
    state = State.before(CATALOGUE).given(touches(places(ANGLES), np.linspace(30, 10, 9), 0.5)).state
    asked = places(ANGLES)
    shares = [state.predict(asked, terms=(term.name,)).mean_mm for term in CATALOGUE.terms]
    assert np.sum(shares, axis=0) == pytest.approx(state.predict(asked).mean_mm, abs=1e-12)


def test_a_new_insert_has_an_unknown_nose() -> None:
    state = State.before(CATALOGUE).given(touches(places(ANGLES), np.linspace(30, 10, 9), 0.5)).state.without_parts()
    asked, new = places(ANGLES, part=2), places(ANGLES, part=2, edge="new")
    assert np.all(state.predict(new).standard_u_mm > state.predict(asked).standard_u_mm)


def test_unknown_places_have_the_priors_spread() -> None:
    expected = State.before(offset_only()).predict(places([CYLINDER, CYLINDER / 3]), repeatability=False)
    assert expected.mean_mm == pytest.approx([0.0, 0.0])
    assert expected.standard_u_mm == pytest.approx([0.020, 0.010])


def test_groups_are_the_places_of_equal_labels() -> None:
    rng = np.random.default_rng(8)
    tool = np.array(["T1", None, "T2"], dtype=object)[rng.integers(3, size=40)]
    at = Places({"tool": tool, "part": rng.integers(-1, 2, 40), "edge": np.array(["b", "a"])[rng.integers(2, size=40)]})
    for names in [(), ("part",), ("tool", "part"), ("edge", "tool", "part")]:
        labels, groups = at.labels(names), at.groups(names)
        assert list(groups) == list(dict.fromkeys(labels))
        assert all(
            [k for k, one in enumerate(labels) if one == label] == mine.tolist() for label, mine in groups.items()
        )
    assert at.chosen(np.zeros(0, dtype=np.intp)).groups(("tool", "part")) == {}
