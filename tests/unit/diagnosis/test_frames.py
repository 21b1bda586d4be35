"""Part frames of machine and CMM over many parts, against motions by rotation matrices."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.refusals import refused
from trueloop.arrays import Array, Integers
from trueloop.diagnosis.frames import reconcile_frames
from trueloop.errors import Code


@dataclass
class Seen:
    part: Integers
    point: Array
    normal: Array
    difference: Array


COMMON = np.array([0.006, -0.004, 0.009])
TURN = np.array([3e-5, -5e-5, 4e-5])


def block(parts: int = 12, seed: int = 0, moved: int = -1, own_mm: float = 0.002, left_mm: float = 0.003) -> Seen:
    """A block with 48 points on all sides. Each part is found elsewhere; the model left something at each point."""
    rng = np.random.default_rng(seed)
    normal = np.repeat(np.vstack([np.eye(3), -np.eye(3)]), 8, axis=0)
    point = rng.uniform(-80, 80, (48, 3))
    point[np.arange(48), np.abs(normal).argmax(axis=1)] = 80.0 * normal.sum(axis=1)
    left = rng.normal(0, left_mm, 48)
    difference = []
    for k in range(parts):
        shift = COMMON + rng.normal(0, own_mm, 3) + (np.array([0.08, 0.0, -0.05]) if k == moved else 0.0)
        seen = Rotation.from_rotvec(TURN).apply(point) + shift
        difference.append(np.sum(normal * (seen - point), axis=1) + left + rng.normal(0, 0.0005, 48))
    whole = np.tile(point, (parts, 1)), np.tile(normal, (parts, 1))
    return Seen(np.repeat(np.arange(parts), 48), *whole, np.concatenate(difference))


def test_what_all_parts_have_in_common_is_found() -> None:
    z = []
    for seed in range(12):
        seen = block(seed=seed)
        found = reconcile_frames(seen.part, seen.point, seen.normal, seen.difference)
        off = np.concatenate([found.common.shift_mm - COMMON, found.common.turn_rad - TURN])
        z.append(off / found.common.standard_u)
        assert not found.moved and not found.findings
    assert 0.6 < np.sqrt(np.mean(np.square(z))) < 1.5
    assert np.abs(np.mean(z)) < 0.5


def test_what_each_part_has_besides_is_found() -> None:
    first, second = block(2, left_mm=0.0), block(2, left_mm=0.0)
    inside = second.part == 1
    second.difference[inside] += second.normal[inside] @ np.array([0.010, 0.0, 0.0])
    apart = []
    for seen in (first, second):
        found = reconcile_frames(seen.part, seen.point, seen.normal, seen.difference)
        apart.append(found.own[1].shift_mm[0] - found.own[0].shift_mm[0])
    assert apart[1] - apart[0] == pytest.approx(0.010, abs=0.0006)


def test_what_stays_at_the_places_is_told_from_motions() -> None:
    """With random errors at 48 places only what looks like a rigid motion by chance is missing."""
    seen = block(seed=4, left_mm=0.004)
    found = reconcile_frames(seen.part, seen.point, seen.normal, seen.difference)
    left = np.random.default_rng(4)
    left.uniform(-80, 80, (48, 3))
    truth = np.tile(left.normal(0, 0.004, 48), 12)
    assert np.corrcoef(found.left_mm, truth)[0, 1] > 0.9
    assert float(np.sqrt(np.mean((found.left_mm - truth) ** 2))) < 2.5 * float(np.sqrt(np.mean(found.u_left_mm**2)))
    assert "cannot be told" in found.words and "12 parts" in found.words


def test_a_part_that_was_moved_is_named_and_left_out() -> None:
    seen = block(seed=2, moved=5)
    found = reconcile_frames(seen.part, seen.point, seen.normal, seen.difference)
    assert found.moved == (5,)
    assert [one.code for one in found.findings] == [Code.DIA_MOVED]
    assert found.own[5].shift_mm == pytest.approx([0.08, 0.0, -0.05], abs=0.007)
    assert found.common.shift_mm == pytest.approx(COMMON, abs=0.003)
    assert not found.left_mm[seen.part == 5].any()


def test_motions_that_no_point_sees_are_not_known() -> None:
    """Of a turned part probed in the plane X Z nobody knows Y, or turns about X and Z."""
    n = 20
    z = np.linspace(0, 80, n)
    normal = np.tile([[1.0, 0, 0], [0, 0, 1.0]], (n // 2, 1))
    point = np.column_stack([30 + 0.2 * z, np.zeros(n), z])
    part = np.repeat(np.arange(4), n)
    rng = np.random.default_rng(0)
    difference = np.tile(normal @ [0.003, 0, -0.002], 4) + rng.normal(0, 0.0003, 4 * n)
    found = reconcile_frames(part, np.tile(point, (4, 1)), np.tile(normal, (4, 1)), difference)
    assert np.isnan(found.common.standard_u).tolist() == [False, True, False, True, False, True]
    assert found.common.shift_mm[1] == found.common.turn_rad[0] == found.common.turn_rad[2] == 0.0


def test_bad_input() -> None:
    seen = block(1)
    assert refused(reconcile_frames, seen.part, seen.point, seen.normal, seen.difference).code is Code.DIA_FEW
    seen = block(3)
    assert refused(reconcile_frames, seen.part, seen.point[:-1], seen.normal, seen.difference).code is Code.MCH_SHAPE
    seen.difference[3] = np.nan
    assert refused(reconcile_frames, seen.part, seen.point, seen.normal, seen.difference).code is Code.MCH_SHAPE
