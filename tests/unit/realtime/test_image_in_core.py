"""The reader that runs in the servo thread takes what `image_to_bytes` writes, and refuses as `read_image` does."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.support.bad_images import BAD, PROGRAM, SERIAL, good_image
from tests.unit.realtime.test_bank import LIMITS, RANGES, Asked, asked, bank_for, by_the_model
from tests.unit.realtime.test_image_file import images
from trueloop._core import RealTimeCore, RealTimeRefusal, realtime_names
from trueloop.arrays import Array
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.image import Identity, Image


@pytest.mark.parametrize("what", BAD)
def test_a_bad_one_is_refused_by_the_same_name(what: str) -> None:
    refusal, made = BAD[what]
    with pytest.raises(RealTimeRefusal) as said:
        RealTimeCore(made(image_to_bytes(good_image())), SERIAL, PROGRAM)
    assert said.value.args[1] == refusal


def test_every_refusal_has_a_bad_image() -> None:
    """But `none`, and `missing`, which is no content."""
    known = {name for _, name, _ in realtime_names()["refusals"]}
    assert known - {"none", "missing"} == {refusal for refusal, _ in BAD.values()}


@settings(max_examples=50)
@given(images())
def test_whatever_is_written_is_taken(image: Image) -> None:
    core = RealTimeCore(image_to_bytes(image), image.identity.serial)
    assert core.signals == (len(image.bank.signals) if image.bank else 0)


def in_the_core(at: Asked) -> Array:
    """What is added in the servo thread, (n, 3)."""
    bank = bank_for(at.model, at.tool)
    columns = [list(RANGES).index(signal.name) for signal in bank.signals]
    signals = np.zeros((len(at.positions), 16))
    signals[:, : len(columns)] = at.signals[:, columns]
    core = RealTimeCore(image_to_bytes(Image(Identity("any", ""), LIMITS, bank)))
    places = {"position": at.positions, "travel": at.travel, "tool_offset": at.offset, "signal": signals}
    added: Array = core.wanted(places)["model"]
    return added


@settings(max_examples=40)
@given(asked())
def test_what_is_added_is_minus_the_error_where_the_machine_will_stand(at: Asked) -> None:
    """c = −E(q + c) in two steps, by the model in Python; axes that the machine does not have are asked at 0."""
    here = np.array([axis in at.model.machine.chain.order for axis in "XYZ"])
    added = np.zeros_like(at.positions)
    for _ in range(2):
        added = -by_the_model(replace(at, positions=at.positions + added * here))
    np.testing.assert_allclose(in_the_core(at), added, rtol=0, atol=1e-12)
