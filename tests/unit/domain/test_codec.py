"""Values survive JSON, whatever they hold; what is no document of theirs is refused."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta, timezone
from enum import IntEnum, StrEnum
from typing import Any, Generic, Literal, TypeVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from trueloop.arrays import Array, same_content
from trueloop.domain.codec import Codec
from trueloop.errors import Code, TrueloopError
from trueloop.realtime.image import Block

P = TypeVar("P")


class Way(StrEnum):
    UP = "up"
    DOWN = "down"


class Level(IntEnum):
    LOW = 1


@dataclass(frozen=True)
class Inner:
    values_mm: Array
    name: str = "a"


@dataclass(frozen=True)
class Whole(Generic[P]):
    inner: tuple[Inner, ...]
    way: Way
    pair: tuple[float, float]
    by_name: Mapping[str, int | None]
    payload: P
    unit: Literal["mm", "inch"] = "mm"
    when: datetime | None = None
    words: list[str] = field(default_factory=list)


@dataclass
class Thawed:
    a: int


CODEC = Codec.of(Inner, Whole, Way, Level)

scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary()
times = st.datetimes(timezones=st.none() | st.integers(-720, 720).map(lambda m: timezone(timedelta(minutes=m))))
arrays_of_all = arrays.arrays(
    st.sampled_from([np.float64, np.float32, np.int64, np.uint8, np.bool_]), arrays.array_shapes(min_dims=0, min_side=0)
)
values = st.recursive(
    scalars | times | arrays_of_all | st.sampled_from([*Way, *Level]) | st.builds(Inner, arrays_of_all, st.text()),
    lambda inner: (
        st.lists(inner)
        | st.lists(inner).map(tuple)
        | st.dictionaries(st.text() | st.just("type") | st.tuples(st.integers(), st.text()), inner)
    ),
)


@given(values)
def test_what_comes_back_from_json_is_the_same(value: object) -> None:
    back = CODEC.from_json(CODEC.to_json(value), object)
    assert type(back) is type(value) or isinstance(value, float)
    assert same_content(back, value)


@given(values, values)
def test_other_content_is_another_document(one: object, other: object) -> None:
    """Equality by content and the document agree, but for what `==` takes for equal: 0 and −0, 1 and True."""
    if CODEC.to_json(one) == CODEC.to_json(other):
        assert same_content(one, other)


NAN = {"type": "number", "value": "nan"}
WHOLE = Whole(
    (Inner(np.array([0.1, np.nan])), Inner(np.zeros((0, 2)), "b")), Way.UP, (1.0, 2.5), {"k": None}, Inner(np.eye(2)),
    when=datetime(2026, 1, 31, 8, 15, tzinfo=UTC), words=["ä"],
)  # fmt: skip


def test_a_document_is_plain_json_with_types() -> None:
    plain = json.loads(CODEC.to_json(WHOLE))
    assert plain["type"] == "Whole"
    assert plain["way"] == {"type": "Way", "value": "up"}
    assert plain["pair"] == [1.0, 2.5]
    assert plain["inner"][0]["values_mm"] == {"type": "array", "of": "float64", "shape": [2], "values": [0.1, NAN]}
    assert same_content(CODEC.from_json(CODEC.to_json(WHOLE), Whole), WHOLE)


def test_a_field_that_an_older_document_lacks_takes_its_default() -> None:
    plain = CODEC.plain(WHOLE)
    del plain["unit"], plain["inner"][0]["name"]
    assert same_content(CODEC.value(plain, Whole), WHOLE)


TODAY = {"type": "datetime", "value": "today"}


def _changed(change: Callable[[dict[str, Any]], object]) -> str:
    plain = CODEC.plain(WHOLE)
    change(plain)
    return json.dumps(plain)


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ("{", "the document", "line 1 column 2"),
        ("[" * 100_000, "the document", "recursion"),
        ("NaN", "the document", "NaN"),
        ("3", "the document", "int instead of a Whole"),
        ('{"type": "os.system", "value": "ls"}', "the document", "os.system"),
        ('{"type": ["Whole"]}', "the document", "Whole"),
        (_changed(lambda plain: plain.update(spare=1)), "the document", "'spare'"),
        (_changed(lambda plain: plain.pop("way")), "the document", "'way'"),
        (_changed(lambda plain: plain.update(way="up")), "the document", "Whole.way cannot be 'up'"),
        (_changed(lambda plain: plain["way"].update(value="left")), "the document.way", "left"),
        (_changed(lambda plain: plain["inner"][1].update(name=7)), "the document.inner[1]", "Inner.name cannot be 7"),
        (_changed(lambda plain: plain.update(pair=[1.0])), "the document", "pair"),
        (_changed(lambda plain: plain.update(pair=[1.0, True])), "the document", "pair"),
        (_changed(lambda plain: plain.update(unit="ft")), "the document", "unit"),
        (_changed(lambda plain: plain.update(by_name={"k": "1"})), "the document", "by_name"),
        (_changed(lambda plain: plain.update(when=TODAY)), "the document.when", "today"),
        (_changed(lambda plain: plain["inner"][0]["values_mm"].update(shape=[3])), "inner[0].values_mm", "shape"),
        (_changed(lambda plain: plain["inner"][0]["values_mm"].update(of="object")), "inner[0].values_mm", "object"),
        (_changed(lambda plain: plain["inner"][0]["values_mm"].update(of="int64")), "inner[0].values_mm", "int64"),
        (_changed(lambda plain: plain["inner"][0]["values_mm"].pop("of")), "inner[0].values_mm", "of"),
    ],
)
def test_what_is_no_such_document_is_refused_with_its_place(text: str, where: str, what: str) -> None:
    with pytest.raises(TrueloopError) as caught:
        CODEC.from_json(text, Whole)
    assert caught.value.code is Code.VAL_FORM
    assert where in caught.value.message and what in caught.value.message


@pytest.mark.parametrize("value", [{1, 2}, object(), Thawed(1), np.array(["a"]), 1j, Whole])
def test_what_is_no_value_is_not_written(value: object) -> None:
    with pytest.raises(TypeError):
        CODEC.to_json(value)


OTHER_INNER: Any = dataclass(frozen=True)(type("Inner", (), {"__annotations__": {"a": int}}))


def test_the_registry_takes_values_only_and_no_name_twice() -> None:
    for types in [(Thawed,), (Inner, OTHER_INNER), (Inner, Inner), (int,)]:
        with pytest.raises(TypeError):
            Codec.of(*types)
    with pytest.raises(TypeError):
        CODEC.with_more(OTHER_INNER)
    with pytest.raises(TypeError):
        CODEC.with_more(AnotherInner=Inner)


def test_a_type_of_a_name_that_is_taken_goes_under_another() -> None:
    codec = CODEC.with_more(AnotherInner=OTHER_INNER)
    both = (OTHER_INNER(3), Inner(np.zeros(1)))
    assert [one["type"] for one in codec.plain(both)] == ["AnotherInner", "Inner"]
    assert same_content(codec.from_json(codec.to_json(both), tuple), both)


def test_equality_by_content_looks_into_arrays() -> None:
    assert same_content(WHOLE, Whole(*(getattr(WHOLE, name) for name in Whole.__dataclass_fields__)))
    assert not same_content(Inner(np.zeros(2)), Inner(np.zeros(3)))
    assert not same_content(Inner(np.zeros(2)), Inner(np.array([0.0, 1.0])))
    assert not same_content(Inner(np.zeros(2)), Inner(np.zeros(2), "b"))
    assert not same_content(Inner(np.zeros(2)), np.zeros(2))
    assert not same_content(np.zeros(2), np.zeros(2, dtype=np.int64))
    assert not same_content((1.0,), (1.0, 2.0))
    assert not same_content({"a": 1}, {"b": 1})


def test_a_value_compared_by_content_is_unlike_what_is_of_another_type() -> None:
    block = Block(1, np.zeros((2, 4)))
    assert block == Block(1, np.zeros((2, 4)))
    assert all(block != other for other in (None, 1, "", (1, np.zeros((2, 4))), np.zeros(2)))


def test_an_array_that_was_read_cannot_be_changed_in_place() -> None:
    read = CODEC.from_json(CODEC.to_json(Inner(np.eye(2))), Inner)
    with pytest.raises(ValueError, match="read-only"):
        read.values_mm[0, 0] = 5.0
