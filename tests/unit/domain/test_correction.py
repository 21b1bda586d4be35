"""The envelope of corrections is one value with its payload: equal by content, in pickles and in JSON."""

import pickle
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.codec import Codec
from trueloop.domain.correction import Correction, Product


@dataclass(frozen=True)
class Moved:
    by_mm: Array


CODEC = Codec.of(Correction, Product, Moved)
CORRECTION = Correction(
    "0123456789abcdef", Product.POINTS, {"program": "ab" * 32}, "ab" * 32, {"size_mm": 0.15}, ("X and Y",),
    Moved(np.array([0.1, -0.0, np.nan])),
)  # fmt: skip


def test_it_survives_json_and_pickle() -> None:
    back = CODEC.from_json(CODEC.to_json(CORRECTION), Correction)
    assert back == CORRECTION == pickle.loads(pickle.dumps(CORRECTION))
    assert back.product is Product.POINTS


def test_another_payload_is_another_correction() -> None:
    assert replace(CORRECTION, payload=Moved(np.zeros(3))) != CORRECTION
    assert replace(CORRECTION, product=Product.MACHINE) != CORRECTION
