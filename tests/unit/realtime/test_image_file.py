"""Images written are read back to the last bit, and stand in the file as the page of the format says."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.support import image_reference
from tests.support.bad_images import good_image
from tests.support.refusals import refused
from trueloop._core import RealTimeCore
from trueloop.errors import Code
from trueloop.formats.realtime.image_file import image_to_bytes, read_image
from trueloop.realtime.image import Bank, Block, Body, Identity, Image, RealTimeLimits, Signal

numbers = st.floats(-1e3, 1e3)
above = st.floats(1e-9, 1e3)
texts = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=8)
hashes = st.binary(min_size=32, max_size=32).filter(any).map(bytes.hex)


@st.composite
def spans(draw: st.DrawFn) -> tuple[float, float]:
    low = draw(numbers)
    return low, low + draw(st.floats(1e-3, 1e3))


@st.composite
def bodies(draw: st.DrawFn, signals: int) -> Body:
    breaks = np.cumsum(draw(st.lists(st.floats(0.5, 10), min_size=2, max_size=4)))
    shape = (draw(st.sampled_from([1, 3])), len(breaks) - 1, draw(st.integers(1, 8)), 6)
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    places = sorted(draw(st.sets(st.integers(0, signals - 1), max_size=signals))) if signals else []
    added = tuple((place, rng.normal(0, 1e-12, shape)) for place in places)
    return Body(
        draw(st.integers(0, 2)),
        breaks,
        rng.normal(0, 1e-12, shape),
        added,
        rng.normal(size=3),
        rng.choice([0.0, 1.0], 3),
    )


@st.composite
def images(draw: st.DrawFn) -> Image:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    x, y, z = (draw(spans()) for _ in range(3))
    signals = tuple(
        Signal(draw(texts), draw(st.sampled_from(["°C", "rev/min", ""])), draw(numbers), *draw(spans()), draw(above))
        for _ in range(draw(st.integers(0, 16)))
    )
    carriers = tuple(draw(bodies(len(signals))) for _ in range(draw(st.integers(0, 3))))
    bank = Bank(signals, carriers, rng.normal(0, 1e-6, (1 + len(signals), 3, 3)), tuple(rng.normal(size=3).tolist()))
    lines = sorted(draw(st.sets(st.integers(1, 2**31 - 1), max_size=4)))
    blocks = tuple(Block(line, rng.normal(size=(draw(st.integers(2, 5)), 4))) for line in lines)
    limits = RealTimeLimits((x, y, z), draw(above), draw(above))
    with_model = draw(st.booleans())
    model = draw(hashes) if with_model else ""
    identity = Identity(draw(texts), draw(texts), model, draw(texts), draw(hashes) if blocks else "", draw(texts))
    return Image(identity, limits, bank if with_model else None, blocks)


def read_back(image: Image) -> Image:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "image.img"
        path.write_bytes(image_to_bytes(image))
        return read_image(path)


@given(images())
def test_an_image_is_read_back_to_the_last_bit(image: Image) -> None:
    assert read_back(image) == image


@given(images())
def test_whatever_is_written_is_taken_in_the_servo_thread(image: Image) -> None:
    core = RealTimeCore(image_to_bytes(image), image.identity.serial)
    assert core.signals == (len(image.bank.signals) if image.bank else 0)


def test_it_stands_in_the_file_as_the_page_says() -> None:
    """By a reader written from the page alone."""
    image = good_image()
    found = image_reference.read(image_to_bytes(image))
    identity = image.identity
    assert [found.head[name] for name in ("machine", "serial", "model", "program_hash", "program", "record")] == [
        *(identity.machine, identity.serial, identity.model_sha256),
        *(identity.program_sha256, identity.program, identity.record),
    ]
    assert (found.head["signals"], found.head["units"]) == (["T1", *[""] * 15], ["°C", *[""] * 15])
    words = found.words
    assert (words["limit"], words["gate"]) == (0.15, 0.1)
    assert words["travel"] == [[0.0, 200.0], [-0.15, 0.15], [-300.0, 0.0]]
    assert words["tool"] == [0.0, 0.0, -50.0]
    assert words["signals"] == [[20.0, 15.0, 35.0, 2.0]]
    assert image.bank is not None
    assert words["slopes"] == image.bank.slope.tolist()
    (body,) = words["bodies"]
    assert (body["axis"], body["arm"], body["carries"]) == (2, [0.0, 0.0, 120.0], [1.0, 0.0, 0.0])
    assert body["breaks"] == [-300.0, -100.0, 0.0]
    assert body["rows"] == image.bank.bodies[0].powers.reshape(-1, 6).tolist()
    assert body["added"] == [(0, image.bank.bodies[0].per_unit[0][1].reshape(-1, 6).tolist())]
    assert words["blocks"] == [(1, image.blocks[0].rows.tolist()), (2, image.blocks[1].rows.tolist())]


def test_a_name_that_is_too_long_is_refused() -> None:
    """Cut short it would be another machine's, or another signal's."""
    image = good_image()
    identity = replace(image.identity, serial="ß" * 33)
    said = refused(image_to_bytes, replace(image, identity=identity))
    assert (said.code, said.values["refusal"]) == (Code.RTC_IMAGE, "long")
    assert "66 bytes" in said.message


def test_a_unit_that_is_too_long_is_left_out() -> None:
    image = good_image()
    assert image.bank is not None
    signal = replace(image.bank.signals[0], unit="(rev/min)^2")
    read = read_back(replace(image, bank=replace(image.bank, signals=(signal,))))
    assert read.bank is not None
    assert read.bank.signals == (replace(signal, unit=""),)


def test_what_would_be_refused_is_not_written() -> None:
    image = good_image()
    said = refused(image_to_bytes, replace(image, blocks=image.blocks[::-1]))
    assert (said.code, said.values["refusal"]) == (Code.RTC_IMAGE, "order")
