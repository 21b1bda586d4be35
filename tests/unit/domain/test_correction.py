"""The envelope of corrections is one value with its payload: equal by content, in pickles and in JSON."""

import pickle
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import given

from tests.support.records import records
from trueloop.arrays import Array
from trueloop.domain.record import Correction, Record
from trueloop.domain.values import CODEC as VALUES


@dataclass(frozen=True)
class Moved:
    by_mm: Array


CODEC = VALUES.with_more(Correction, Moved)


@given(records)
def test_it_survives_json_and_pickle(record: Record) -> None:
    correction = Correction(record, {"size_mm": 0.15}, Moved(np.array([0.1, -0.0, np.nan])))
    assert CODEC.from_json(CODEC.to_json(correction), Correction) == correction
    assert pickle.loads(pickle.dumps(correction)) == correction
    assert replace(correction, payload=Moved(np.zeros(3))) != correction
    assert correction.source_sha256 == (record.program.sha256 if record.program else "")
