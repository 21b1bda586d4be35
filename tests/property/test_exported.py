"""An export imported into an empty store gives an equal store; any file that was cut off or changed is refused."""

import json
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support import records
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.db.copied import export, keep_lines, read_export
from trueloop.storage.kinds import KINDS, joined
from trueloop.storage.store import Kept, Store, find, keep, open_store

stored = st.one_of(
    *(records.part_types, records.parts, records.machines, records.tools, records.edges),
    *(records.settings_of_edges, records.programs, records.inspections),
)


def filled(values: list[object]) -> Store:
    """A store with the values; one of an identity that is there already supersedes that."""
    store = open_store("sqlite://", create=True)
    for value in values:
        try:
            keep(store, [value], by="ana")
        except TrueloopError as error:
            assert error.code is Code.STO_DIFFERS
            there = find(store, type(value), identity=joined(value.identity))  # type: ignore[attr-defined]
            keep(store, [value], there[-1].row, by="ben", why="was wrong")
    return store


def content(store: Store) -> list[object]:
    """All that a store says, without the numbers of rows: what a row supersedes by its place among its kind."""
    said: list[object] = []
    for kind in KINDS:
        rows: list[Kept[object]] = find(store, kind.type, superseded=True)
        place = {one.row: k for k, one in enumerate(rows)}
        for one in rows:
            superseded = [None if row is None else place[row] for row in (one.supersedes, one.superseded_by)]
            said.append((kind.table, one.value, one.kept_at, one.by, one.why, superseded))
    return said


@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(st.lists(stored, max_size=8))
def test_an_export_imported_into_an_empty_store_gives_an_equal_store(values: list[object]) -> None:
    store, other = filled(values), open_store("sqlite://", create=True)
    with tempfile.TemporaryDirectory() as folder:
        first, second = Path(folder) / "first.jsonl", Path(folder) / "second.jsonl"
        count = export(store, first)
        copied = keep_lines(other, read_export(first, other.codec), print, "first.jsonl")
        assert (copied.count, copied.new) == (count, count)
        assert content(other) == content(store)
        assert keep_lines(other, read_export(first, other.codec), print, "first.jsonl").new == 0
        assert content(other) == content(store)
        export(other, second)
        assert second.read_bytes() == first.read_bytes()


EMPTY = open_store("sqlite://", create=True)
"""Of what is refused nothing is kept: it stays so."""
WHOLE = filled([records.TURNED.inspections[0], records.TURNED.program, records.PART])


@given(st.data())
def test_an_export_that_was_cut_off_anywhere_is_refused_and_nothing_is_kept(data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "all.jsonl"
        export(WHOLE, file)
        whole = file.read_bytes()
        cut = data.draw(st.integers(0, len(whole) - 2), "bytes kept: without its last newline it is whole")
        file.write_bytes(whole[:cut])
        with pytest.raises(TrueloopError) as refused:
            keep_lines(EMPTY, read_export(file, EMPTY.codec), print, str(file))
        lines = whole[:cut].count(b"\n") + 1
        assert refused.value.code is Code.STO_EXPORT
        assert refused.value.place.line in (lines, lines + 1), "the line that is cut, or misses"
    assert content(EMPTY) == []


@given(st.data())
def test_an_export_without_one_of_its_lines_is_refused(data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "all.jsonl"
        export(WHOLE, file)
        lines = file.read_text(encoding="ascii").splitlines(keepends=True)
        del lines[data.draw(st.integers(0, len(lines) - 1))]
        file.write_text("".join(lines), encoding="ascii")
        with pytest.raises(TrueloopError, match="STO-EXPORT"):
            keep_lines(EMPTY, read_export(file, EMPTY.codec), print, str(file))
    assert content(EMPTY) == []


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"version": 2}, Code.STO_SCHEMA),
        ({"format": "trueloop shop"}, Code.STO_EXPORT),
        ({"version": "1"}, Code.STO_EXPORT),
    ],
)
def test_the_head_of_an_export_says_who_may_read_it(change: dict[str, object], code: Code, tmp_path: Path) -> None:
    file = tmp_path / "all.jsonl"
    export(WHOLE, file)
    head, _, rest = file.read_text(encoding="ascii").partition("\n")
    file.write_text(json.dumps(json.loads(head) | change) + "\n" + rest, encoding="ascii")
    with pytest.raises(TrueloopError) as refused:
        list(read_export(file, WHOLE.codec))
    assert (refused.value.code, refused.value.place.line) == (code, 1)
