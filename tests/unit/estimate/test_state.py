"""The state by hand arithmetic, and what an exact update must keep."""

import tracemalloc

import numpy as np
import pytest

from tests.support.cut_places import CYLINDER, FACE, places, touches
from trueloop.arrays import Array
from trueloop.estimate.catalogue import Catalogue, Prior, Term, turned_catalogue
from trueloop.estimate.history import Taken, after_parts
from trueloop.estimate.places import Observed, Places, joined, together
from trueloop.estimate.state import State

CATALOGUE = turned_catalogue()
ANGLES = np.linspace(FACE, CYLINDER, 9)
SPREAD = 0.7 * np.random.default_rng(9).normal(size=(6, len(CATALOGUE.priors)))
"""Logarithms by which sizes differ from their medians, for six histories."""


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


def history_of(seed: int) -> list[list[Observed]]:
    """Nine parts of three types by two edges of a tool, both cuts of most: some measured from a first face, some with a
    gross touch, with a feature that is off by 50 µm or an entry that nobody stated, each cut with a correction.
    """
    rng, cuts = np.random.default_rng(seed), list[list[Observed]]()
    for part in (1, 2, 4, 7, 8, 9, 11, 14, 15):
        kind, edge = f"t{rng.integers(3)}", "first" if part < 9 else "second"
        number = 5 + int(kind[1])
        angle, group = np.linspace(FACE, CYLINDER, 3 * number), np.repeat(np.arange(3), number)
        share, moved = np.tile(np.linspace(0.1, 0.9, number), 3), rng.normal(0, 5, 3)
        cuts.append([])
        for finish in (False, True)[: 1 + (rng.random() < 0.8)]:
            at = places(angle, 30 * np.cos(angle), share, group, part=part, finish=finish, edge=edge, part_type=kind)
            taken_off = np.full(len(at), rng.normal(0, 0.01) * finish)
            at = Places({**at.columns, "taken_off_mm": taken_off, "setting": np.full(len(at), f"{edge} {part // 5}")})
            error = 15 * np.sin(2 * angle + 0.1 * part) + moved[0] * np.sin(angle) + rng.normal(0, 1.5, len(at))
            error += 60.0 * (np.arange(len(at)) == rng.integers(60)) + (rng.random() < 0.2) * 50.0 * (group == 1)
            error += finish * (rng.random() < 0.3) * 20.0 * np.sin(angle)
            seen = touches(at, error, 0.5)
            if rng.random() < 0.3:
                from_first = np.eye(len(at))[1:] - np.eye(len(at))[0]
                shared = np.full((len(at) - 1,) * 2, 0.25e-6)
                seen = Observed(at, seen.value_mm[1:] - seen.value_mm[0], seen.standard_u_mm[1:], from_first, shared)
            cuts[-1].append(seen)
    return cuts


@pytest.mark.parametrize("seed", range(6))
def test_parts_known_beforehand_are_taken_in_as_one_after_the_other(seed: int) -> None:
    """To a millionth of a nanometre: weights, scales, what is left of every value, and the next part of each type, also
    where the state keeps what is of that part alone.
    """
    catalogue, parts = turned_catalogue(several_edges=True), history_of(seed)
    sizes = {
        name: size * factor
        for (name, size), factor in zip(catalogue.medians.items(), np.exp(SPREAD[seed]), strict=True)
    }
    plain, taken = State.before(catalogue, sizes), list[Taken]()
    for one in (cut for part in parts for cut in part):
        updated = plain.given(one)
        plain, noise = updated.state, np.diag(plain.noise_mm2(one))
        left = one.value_mm - one.of(plain.design(one.places)) @ plain.mean
        taken.append(Taken(updated.gross, noise, left, updated.scales))
    whole = after_parts(catalogue, sizes, parts)
    for found, expected in zip((one for part in whole.taken for one in part), taken, strict=True):
        assert found.gross == pytest.approx(expected.gross, abs=1e-9)
        assert found.left_mm == pytest.approx(expected.left_mm, abs=1e-12)
        assert found.noise_mm2 == pytest.approx(expected.noise_mm2, rel=1e-12)
        assert all(scale == pytest.approx(expected.scales[key], rel=1e-8) for key, scale in found.scales.items())
        assert {key for key, scale in expected.scales.items() if abs(scale - 1.0) > 1e-9} <= found.scales.keys()
    for kind in ("t0", "t1", "t2", "new"):
        kept = {"part_type": {kind}, "edge": {"second"}, "setting": {"second 3"}}
        of_kind = after_parts(catalogue, sizes, parts, kept).state
        assert len(of_kind.mean) < len(whole.state.mean)
        for finish in (False, True):
            at = places(np.linspace(0, 2, 9), 7, 0.37, 1, part=16, finish=finish, edge="second", part_type=kind)
            at = Places({**at.columns, "setting": np.full(len(at), "second 3")})
            by_all = plain.predict(at)
            for predicted in (whole.state.predict(at), of_kind.predict(at)):
                assert predicted.mean_mm == pytest.approx(by_all.mean_mm, abs=1e-12)
                assert predicted.standard_u_mm == pytest.approx(by_all.standard_u_mm, abs=1e-12)
                assert predicted.covariance_mm2 == pytest.approx(by_all.covariance_mm2, abs=1e-14)


def test_the_state_does_not_grow_with_the_parts() -> None:
    rng = np.random.default_rng(2)
    seen = [[touches(places(ANGLES, part=k), 15 + rng.normal(0, 2, 9), 0.5)] for k in range(1, 30)]
    one, many = (after_parts(CATALOGUE, CATALOGUE.medians, parts).state for parts in (seen[:1], seen))
    assert one.blocks == many.blocks and len(one.mean) == len(many.mean)


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
    seen = touches(places(ANGLES), np.linspace(30, 10, 9), 0.5)
    state = after_parts(CATALOGUE, CATALOGUE.medians, [[seen]]).state
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
