"""Every way in which the record of a correction is refused."""

import json
from collections.abc import Callable
from functools import partial

import pytest

from tests.support.files import read_as_file
from tests.support.records import TURNED
from trueloop.errors import Code, TrueloopError
from trueloop.formats.record_file import read_record


def _read(text: str) -> object:
    return read_as_file(text, read_record, "record.json")


def _changed(**changed: object) -> str:
    return json.dumps(json.loads(TURNED.to_json()) | changed, indent=2)


def _without(*keys: str) -> str:
    content = json.loads(TURNED.to_json())
    return json.dumps({key: value for key, value in content.items() if key not in keys}, indent=2)


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.REC_FILE: partial(_read, TURNED.to_json()[:200]),
    Code.REC_SCHEMA: partial(_read, _changed(schema=2)),
    Code.REC_KEY: partial(_read, _without("made_by")),
}


@pytest.mark.parametrize("text", ["", "{", "[]", "7", '{"format": "trueloop drift model 1"}', "[" * 100_000])
def test_what_is_no_record_is_refused(text: str) -> None:
    with pytest.raises(TrueloopError) as caught:
        _read(text)
    assert caught.value.code is Code.REC_FILE


def test_a_broken_document_is_refused_where_it_breaks() -> None:
    lines = TURNED.to_json().splitlines()
    with pytest.raises(TrueloopError) as caught:
        _read("\n".join([*lines[:4], '  "made_by": root,', *lines[5:]]))
    assert (caught.value.place.line, caught.value.place.column) == (5, 14)


def test_a_record_of_a_later_version_says_which_wrote_it() -> None:
    with pytest.raises(TrueloopError, match=r"schema 2, written by trueloop 0\.1\.0; this version reads up to 1"):
        _read(_changed(schema=2))


@pytest.mark.parametrize("key", ["id", "made_at", "options", "decision", "changes"])
def test_a_missing_key_is_named(key: str) -> None:
    with pytest.raises(TrueloopError, match=f"'{key}' is missing") as caught:
        _read(_without(key))
    assert caught.value.code is Code.REC_KEY


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"schema": "1"}, "'schema': .* given '1'"),
        ({"product": "grinding"}, "'product': .* given 'grinding'"),
        ({"options": 7}, "'options': .* given 7"),
        ({"changes": [{"line": "N10", "column": 1, "before": "", "after": ""}]}, r"'changes\.0\.line': .* 'N10'"),
        ({"tool": {"number": 1, "schema": 2}}, r"'tool\.schema': .* given 2"),
        ({"inspections": [{}]}, r"'inspections\.0\.part' is missing"),
    ],
)
def test_a_wrong_value_is_named_with_its_line(changed: dict[str, object], said: str) -> None:
    text = _changed(**changed)
    with pytest.raises(TrueloopError, match=said) as caught:
        _read(text)
    (key,) = changed
    assert caught.value.code is Code.REC_KEY
    assert text.splitlines()[(caught.value.place.line or 0) - 1].startswith(f'  "{key}"')
