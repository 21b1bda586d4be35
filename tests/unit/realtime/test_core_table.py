"""Rows of the table are those of the nearest place of the program line's block, however dense and fast."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.bad_images import good_image
from trueloop._core import RealTimeCore
from trueloop.arrays import Array
from trueloop.domain.record import sha256_of
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.image import Block, Identity, Image, RealTimeLimits

GATE_MM = 0.1
PERIOD_S = 1e-3
LIMITS = RealTimeLimits(((-1000.0, 1000.0),) * 3, 0.15, GATE_MM)


def core_of(*blocks: Block) -> RealTimeCore:
    image = Image(Identity("any", "", "", "p.ngc", sha256_of(b"p")), LIMITS, None, blocks)
    return RealTimeCore(image_to_bytes(image))


def rows_along(path: Array, seed: int) -> Array:
    """The path with corrections that differ from row to row."""
    rng = np.random.default_rng(seed)
    return np.hstack([path, rng.normal(0, 0.01, path.shape)])


def nearest(rows: Array, x: float, z: float) -> tuple[float, Array]:
    """Distance from the whole polyline, and what is added at the nearest place."""
    start, along = rows[:-1], np.diff(rows, axis=0)
    square = np.maximum((along[:, :2] ** 2).sum(axis=1), 1e-300)
    share = np.clip(((np.array([x, z]) - start[:, :2]) * along[:, :2]).sum(axis=1) / square, 0, 1)
    at = start + share[:, None] * along
    distance = np.hypot(at[:, 0] - x, at[:, 1] - z)
    return float(distance.min()), at[distance.argmin(), 2:]


def places_along(path: Array, feed_mm_per_s: float, from_mm: float = 0.0) -> Array:
    """Where the command is in each of 100,000 periods at most: X, Y, Z, with Y that does not matter."""
    length = np.concatenate([[0.0], np.hypot(*np.diff(path, axis=0).T).cumsum()])
    at = from_mm + feed_mm_per_s * PERIOD_S * np.arange(100_000)
    at = at[at < length[-1]]
    return np.column_stack(
        [np.interp(at, length, path[:, 0]), np.full(len(at), 7.0), np.interp(at, length, path[:, 1])]
    )


@st.composite
def arcs(draw: st.DrawFn) -> Array:
    """An arc of up to half a turn, its rows up to 0.05 mm or up to 2 mm apart and of uneven lengths."""
    radius = draw(st.floats(5, 40))
    apart = draw(st.sampled_from([0.05, 0.5, 2.0]))
    turn = draw(st.floats(0.5, np.pi))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    ends = np.concatenate([[0.0], rng.uniform(0.02, 1.0, int(radius * turn / apart) + 1).cumsum()])
    angle = ends / ends[-1] * turn + draw(st.floats(0, 6))
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


@settings(max_examples=60)
@given(arcs(), st.floats(0.01, 200), st.floats(0, 0.06), st.integers(0, 2**32 - 1))
def test_along_a_block_it_is_the_nearest_place(path: Array, feed: float, off_mm: float, seed: int) -> None:
    """The command is up to 0.06 mm off the path, by a side that it keeps."""
    rows = rows_along(path, seed)
    places = places_along(path, feed)[:3000]
    middle = np.array([0.0, 7.0, 0.0])
    places += off_mm * (places - middle) / np.linalg.norm(places - middle, axis=1)[:, None]
    found = core_of(Block(5, rows)).wanted({"position": places, "line": 5})
    assert found["listed"].all()
    assert found["on_path"].all()
    for place, added in zip(places, found["table"], strict=True):
        np.testing.assert_allclose(added[[0, 2]], nearest(rows, place[0], place[2])[1], rtol=0, atol=1e-12)
    assert not found["table"][:, 1].any()


def figure_of_eight(apart_mm: float) -> Array:
    turn = np.arange(0, 2 * np.pi, apart_mm / 40.0)
    return np.column_stack([30 * np.sin(turn), 20 * np.sin(2 * turn)])


@settings(max_examples=30)
@given(st.sampled_from([0.05, 0.3]), st.floats(5, 200))
def test_a_path_that_crosses_itself_stays_on_its_branch(apart: float, feed: float) -> None:
    """First half +5 µm, second half −5 µm: where they cross (beginning, middle, end) both are as near."""
    path = figure_of_eight(apart)
    half = np.where(np.arange(len(path)) < len(path) // 2, 0.005, -0.005)
    places = places_along(path, feed)
    found = core_of(Block(1, np.column_stack([path, half, half]))).wanted({"position": places, "line": 1})
    assert found["on_path"].all()
    near_middle = int(2 * apart / (feed * PERIOD_S)) + 1
    x = found["table"][:, 0]
    np.testing.assert_allclose(x[: len(x) // 2 - near_middle], 0.005, rtol=1e-12)
    np.testing.assert_allclose(x[len(x) // 2 + near_middle :], -0.005, rtol=1e-12)


@given(st.integers(0, 19), st.floats(0.0, 5.0))
def test_a_block_is_found_from_its_middle_on_within_some_periods(part: int, feed: float) -> None:
    """2000 rows: eight periods at most, each looking at no more than 256."""
    path = np.column_stack([np.full(2000, 25.0), -np.linspace(0, 100, 2000)])
    rows = rows_along(path, 1)
    places = places_along(path, max(feed, 1e-3), 5.0 * part)[:40]
    found = core_of(Block(3, rows)).wanted({"position": places, "line": 3})
    first = int(found["on_path"].argmax())
    assert found["on_path"][first:].all()
    assert first <= 8
    assert not found["table"][:first].any()
    for place, added in zip(places[first:], found["table"][first:], strict=True):
        np.testing.assert_allclose(added[[0, 2]], nearest(rows, place[0], place[2])[1], rtol=0, atol=1e-12)


def test_one_path_cut_three_times_has_three_tables() -> None:
    path = np.array([[25.0, 0.0], [25.0, -40.0]])
    blocks = [Block(line, np.column_stack([path, np.full((2, 2), 1e-3 * line)])) for line in (2, 7, 40)]
    places = np.tile(places_along(path, 50.0), (3, 1))
    lines = np.repeat([2, 40, 7], len(places) // 3)
    found = core_of(*blocks).wanted({"position": places, "line": lines})
    np.testing.assert_allclose(found["table"][:, 0], 1e-3 * lines, rtol=0, atol=1e-15)


def test_off_the_gate_between_blocks_and_on_other_lines_nothing_is_added() -> None:
    path = np.array([[25.0, 0.0], [25.0, -40.0]])
    core = core_of(Block(2, rows_along(path, 3)))
    places = np.array([[25.0 + d, 0.0, -20.0] for d in (0.0, 0.099, 0.101, -0.099, -0.101)])
    found = core.wanted({"position": places, "line": 2})
    assert found["on_path"].tolist() == [True, True, False, True, False]
    assert found["listed"].all()
    for line in (-1, 1, 3):
        found = core.wanted({"position": places, "line": line})
        assert not found["listed"].any()
        assert not found["on_path"].any()
        assert not found["table"].any()


def test_steps_in_parts_are_steps_at_once() -> None:
    """What is remembered of the path and of the corrector lives from call to call."""
    content = image_to_bytes(good_image())
    count = 600
    places = np.column_stack([np.full(count, 25.0), np.zeros(count), -np.linspace(0, 9.9, count)])
    beats = np.arange(count)
    given = {"signal": 20.0, "program": 1, "line": 1}
    whole = RealTimeCore(content).step({"position": places, "heartbeat": beats, **given}, {})
    core = RealTimeCore(content)
    parts = [core.step({"position": places[part], "heartbeat": beats[part], **given}, {}) for part in PARTS]
    for name, column in whole.items():
        np.testing.assert_array_equal(np.concatenate([part[name] for part in parts]), column)
    assert whole["on_path"][-1]
    assert whole["enabled"][-1]


PARTS = (slice(0, 100), slice(100, 101), slice(101, 600))
