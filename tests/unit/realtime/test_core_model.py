"""What the core adds by a model is minus the model's error where the machine will stand, whoever computes it."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support import image_reference
from tests.support.banks import Asked, any_asked, any_image, bank_for, by_the_model, columns
from trueloop._core import RealTimeCore
from trueloop.arrays import Array
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.image import Identity, Image, RealTimeLimits

LIMITS = RealTimeLimits(((-300.0, 400.0),) * 3)


def by_the_core(image: bytes, at: Asked, signals: Array) -> Array:
    places = {"position": at.positions, "travel": at.travel, "signal": signals, "tool_offset": at.offset}
    return RealTimeCore(image).wanted(places)["model"]


@settings(max_examples=60)
@given(any_asked())
def test_it_is_the_model_in_two_steps(at: Asked) -> None:
    bank = bank_for(at.model, at.tool)
    once = -by_the_model(at)
    twice = -by_the_model(replace(at, positions=at.positions + once))
    found = by_the_core(image_to_bytes(Image(Identity("any", ""), LIMITS, bank)), at, columns(bank, at))
    np.testing.assert_allclose(found, twice, rtol=0, atol=1e-12 * max(1.0, np.abs(twice).max()))


@settings(max_examples=60)
@given(any_image(), st.integers(0, 2**32 - 1))
def test_any_image_is_evaluated_as_the_page_of_the_format_says(image: Image, seed: int) -> None:
    """Up to 16 signals that come and go, positions that stay in a segment or leave it, and go beyond both ends."""
    rng = np.random.default_rng(seed)
    content = image_to_bytes(image)
    count, signals = 40, len(image.bank.signals) if image.bank else 0
    steps = rng.choice([0.0, 0.01, 30.0], (count, 3)) * rng.normal(size=(count, 3))
    positions = np.cumsum(steps, axis=0)
    travel = rng.choice([-1.0, 0.0, 1.0], (count, 3))
    kept = rng.random((count, signals)) < 0.8
    values = rng.normal(20.0, 5.0, (count, signals))
    for k in range(1, count):
        values[k] = np.where(kept[k], values[k - 1], values[k])
    offset = rng.normal(0, 50, (count, 3)) * (rng.random((count, 1)) < 0.5)
    places = {"position": positions, "travel": travel, "signal": values, "tool_offset": offset}
    found = RealTimeCore(content).wanted(places)["model"]
    read = image_reference.read(content)

    def error(k: int, q: Array) -> Array:
        return np.array(
            image_reference.error_mm(read, q.tolist(), *(part[k].tolist() for part in (travel, values, offset)))
        )

    expected = np.array([-error(k, positions[k] - error(k, positions[k])) for k in range(count)])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * max(1.0, np.abs(expected).max()))
