"""The envelope kernel beside its definition, and beside shapes whose envelope is known exactly."""

import math

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.support.envelope_reference import entries
from trueloop._core import NoseSweep
from trueloop.arrays import Array
from trueloop.geometry.feature import Arc, contact_angle_rad
from trueloop_lab.simulator.machine import Stock, sweep
from trueloop_lab.simulator.nose import Nose, path_along

NANOMETRE = 1e-6
FAR = 100.0
ROUND = Nose(0.8)
WORN = Nose(0.8, tuple(np.radians([-20.0, 10.0, 40.0, 70.0, 110.0])), (0.005, -0.03, -0.06, -0.02, 0.005))


def rays_out_of(points: Array, angle: Array) -> tuple[Array, Array]:
    return np.ascontiguousarray(points), np.column_stack([np.sin(angle), np.cos(angle)])


@example(seed=8618908, nose=WORN, step=0.02)  # grazes a worn edge 0.73 µm deep
@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), nose=st.sampled_from([ROUND, WORN]), step=st.floats(0.001, 0.4))
def test_kernel_and_definition_agree_on_any_path(seed: int, nose: Nose, step: float) -> None:
    rng = np.random.default_rng(seed)
    turning = np.cumsum(rng.normal(0.0, 0.3, 40))
    nodes = np.cumsum(step * np.column_stack([np.sin(turning), np.cos(turning)]), axis=0)
    angle = rng.uniform(-np.pi, np.pi, 5)
    rays = rays_out_of(nodes[rng.integers(0, 40, 5)] + rng.normal(0.0, 0.8, (5, 2)), angle)
    expected = entries(nodes, lambda phi: nose.radius_mm + nose.wear_at_mm(phi), rays, FAR)
    found = sweep(nodes, nose).entries(*rays, np.full(5, FAR), FAR)
    assert np.max(np.abs(found - expected)) < NANOMETRE


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), nose=st.sampled_from([ROUND, WORN]), spread=st.floats(0.0, 0.3))
def test_neighbouring_rays_share_what_they_look_at_and_find_what_each_finds_alone(
    seed: int, nose: Nose, spread: float
) -> None:
    """Any path, folded and crossing itself, and twenty rays of hardly one direction, some already met elsewhere."""
    rng = np.random.default_rng(seed)
    turning = np.cumsum(rng.normal(0.0, 0.1, 400))
    nodes = np.cumsum(0.01 * np.column_stack([np.sin(turning), np.cos(turning)]), axis=0)
    nodes += rng.normal(0.0, 1e-3, nodes.shape) * rng.integers(0, 2)
    angle = rng.uniform(-np.pi, np.pi) + 0.2 * spread * rng.uniform(-1, 1, 20)
    origin = nodes[rng.integers(0, 400)] + rng.normal(0.0, 0.6, 2)
    rays = rays_out_of(origin + spread * np.sort(rng.uniform(-1, 1, 20))[:, None] * rng.normal(0, 1, 2), angle)
    known = np.where(rng.random(20) < 0.2, rng.uniform(-2, 1, 20), FAR)
    swept = sweep(nodes, nose)
    together = swept.entries(*rays, known, FAR)
    alone = [swept.entries(rays[0][[k]], rays[1][[k]], known[[k]], FAR)[0] for k in range(20)]
    assert np.max(np.abs(together - alone)) < 1e-9
    some = rng.integers(0, 20, 1)  # the definition takes its time
    few = (rays[0][some], rays[1][some])
    expected = entries(nodes, lambda phi: nose.radius_mm + nose.wear_at_mm(phi), few, FAR)
    assert np.max(np.abs(together[some] - np.minimum(expected, known[some]))) < NANOMETRE


def test_the_support_of_a_worn_nose_is_what_a_line_leaves() -> None:
    """Along a line of contact angle φ the surface stands R + w(φ) below the path, whatever the rest of the nose."""
    for degrees in (0.0, 17.0, 45.0, 90.0, 100.0):
        phi = math.radians(degrees)
        normal, tangent = np.array([math.sin(phi), math.cos(phi)]), np.array([-math.cos(phi), math.sin(phi)])
        nodes = np.array([30.0, -20.0]) + np.linspace(-5, 5, 30)[:, None] * tangent
        height = sweep(nodes, WORN).entries(np.array([[30.0, -20.0]]) - 0.8 * normal, normal[None], np.ones(1), 1.0)
        assert abs(height[0] + WORN.wear_at_mm(np.array(phi))) < 1e-12


def test_an_arc_is_cut_to_less_than_a_nanometre_on_its_outside_and_behind_its_equator() -> None:
    """A knob of 31.75 mm, cut from 106.85° to its apex: the envelope of the nose is the circle, undercut included."""
    start, radius = math.radians(106.85), 31.75 + 0.8
    knob = Arc("knob", (radius * math.sin(start), radius * math.cos(start)), (0.0, radius), (0.0, 0.0), start)
    stock = Stock((sweep(path_along([knob]).centre_mm, ROUND),))
    angle = np.linspace(0.01, start - 0.01, 2000)
    points, normals = rays_out_of(31.75 * np.column_stack([np.sin(angle), np.cos(angle)]), angle)
    assert np.max(np.abs(stock.height_mm(points, normals))) < NANOMETRE


def test_later_cuts_leave_what_earlier_ones_left_lower() -> None:
    high, low = np.array([[10.8, 0.0], [10.8, 40.0]]), np.array([[10.5, 10.0], [10.5, 20.0]])
    stock = Stock((sweep(high, ROUND),)).cut_by([sweep(low, ROUND)])
    points, normals = rays_out_of(np.array([[10.0, 5.0], [10.0, 15.0], [10.0, 20.4]]), np.full(3, np.pi / 2))
    fillet = 0.5 - math.sqrt(0.8**2 - 0.4**2)
    assert np.allclose(stock.height_mm(points, normals), [0.0, -0.3, min(0.0, fillet)], atol=1e-12)


def test_a_path_that_wavers_is_cut_by_its_lowest_stretches() -> None:
    """±1 µm of noise: each point of the surface is that of the nearest dip, found by looking at every nose position."""
    rng = np.random.default_rng(5)
    nodes = np.column_stack([10.8 + rng.normal(0, 1e-3, 20001), np.linspace(0.0, 50.0, 20001)])
    points, normals = rays_out_of(np.column_stack([np.full(50, 10.0), rng.uniform(2, 48, 50)]), np.full(50, np.pi / 2))
    found = NoseSweep(nodes, 0.8, 0.0, 1.0, np.zeros((0, 4))).entries(points, normals, np.ones(50), 1.0)
    for (x, z), height in zip(points, found, strict=True):
        beside = nodes[:, 1] - z
        near = np.abs(beside) < 0.8
        below = nodes[near, 0] - np.sqrt(0.64 - beside[near] ** 2) - x
        # Between the positions the straight sides lie lower than the circles, by at most a chord's sagitta and slope.
        assert height <= below.min() + 1e-12
        assert below.min() - height < 2e-4
    dense = np.linspace(0, 20000, 400001)
    finer = np.column_stack([np.interp(dense, np.arange(20001), nodes[:, k]) for k in range(2)])
    for (x, z), height in zip(points[:10], found[:10], strict=True):
        beside = finer[:, 1] - z
        near = np.abs(beside) < 0.8
        below = finer[near, 0] - np.sqrt(0.64 - beside[near] ** 2) - x
        assert abs(height - below.min()) < NANOMETRE


def test_contact_angle_of_the_wear_table_is_that_of_the_features() -> None:
    assert math.isclose(float(contact_angle_rad(np.array([1.0, 0.0]))), math.pi / 2)
