"""Values that outlive a run come back equal: from JSON, from a pickle, and a record from its own file too."""

import pickle

from hypothesis import given

from tests.support.files import read_as_file
from tests.support.records import records, values
from trueloop.domain.record import Record
from trueloop.domain.values import CODEC
from trueloop.formats.record_file import read_record


@given(values)
def test_a_value_comes_back_from_json(value: object) -> None:
    back = CODEC.from_json(CODEC.to_json(value), type(value))
    assert back == value
    assert CODEC.to_json(back) == CODEC.to_json(value)


@given(values)
def test_a_value_comes_back_from_a_pickle(value: object) -> None:
    assert pickle.loads(pickle.dumps(value)) == value


@given(records)
def test_a_record_comes_back_from_its_file(record: Record) -> None:
    back = read_as_file(record.to_json(), read_record, "record.json")
    assert back == record
    assert back.to_json() == record.to_json()
