"""A value as the store writes it: its document, what is stored apart from it, and the hash of both."""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any, Generic, TypeVar

from trueloop.domain.codec import Codec
from trueloop.storage.kinds import Kind, joined, searchable, storable
from trueloop.storage.value_rows import FORMS, Piece

T = TypeVar("T")


@dataclass(frozen=True)
class Kept(Generic[T]):
    """A value in the store: its row, when it was kept, and whether this call kept it. `superseded_by`: another row.

    `supersedes` is the row that it replaces, `by` who kept it and `why` it supersedes that row. Rows are
    numbered in the order in which they were kept, whatever the clock said; `clock_back`: when this one was kept, the
    clock stood before the time of the row before.
    """

    row: int
    value: T
    kept_at: datetime
    new: bool = False
    superseded_by: int | None = None
    supersedes: int | None = None
    by: str = ""
    why: str = ""
    clock_back: bool = False


@dataclass(frozen=True)
class Encoded:
    """`rows` by the name of their table, in pieces; `columns` with document, identity and hash."""

    columns: Mapping[str, Any]
    rows: Mapping[str, list[Piece]]


def encoded(codec: Codec, kind: Kind, value: Any) -> Encoded:
    """Encodes a value of this kind. Raises TypeError for what the codec does not know."""
    apart = {kind.aside: getattr(value, kind.aside)} if kind.aside else {}
    rows = {form.table: list(form.pieces(apart["values"])) for form in FORMS} if "values" in apart else {}
    document = storable(codec.to_json(_without(value, kind)))
    payload = {"payload": storable(codec.to_json(apart["payload"]))} if "payload" in apart else {}
    columns = {name: searchable(None if one is None else str(one)) for name, one in kind.columns(value).items()}
    return Encoded(
        {
            "identity": searchable(joined(value.identity)),
            "sha256": digest(
                (document, *payload.values()), (piece.hashed for pieces in rows.values() for piece in pieces)
            ),
            "document": document,
            **payload,
            **columns,
        },
        rows,
    )


def digest(texts: Iterable[str], pieces: Iterable[bytes]) -> str:
    """Returns the hash of a value's texts and then of its rows, table by table (`RowForm.hashed`)."""
    sha = hashlib.sha256()
    for text in texts:
        sha.update(text.encode())
    for piece in pieces:
        sha.update(piece)
    return sha.hexdigest()


def _without(value: Any, kind: Kind) -> Any:
    return value if not kind.aside else replace(value, **{kind.aside: () if kind.aside == "values" else None})
