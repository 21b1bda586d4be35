"""Lists page by page: a cursor is the number of the last row seen, so that new rows move nothing."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import Any, Final, TypeVar

from sqlalchemy import ColumnElement, Select

from trueloop.errors import Code, TrueloopError
from trueloop.factory.load import Known
from trueloop.factory.views.page import Page
from trueloop.storage.store import Store

LIMIT: Final = 50
MOST: Final = 500
T = TypeVar("T")


@contextmanager
def known_of(store: Store) -> Iterator[Known]:
    """A transaction that reads."""
    with store.reading() as connection:
        yield Known(connection, store.codec)


def before(query: Select[Any], key: ColumnElement[int], limit: int, cursor: str | None) -> Select[Any]:
    """Newest first, from the cursor on, one row more than asked for. Raises FAC-UNKNOWN for no cursor of ours."""
    if cursor is not None:
        if not cursor.isascii() or not cursor.isdigit() or len(cursor) > 18:
            raise TrueloopError(
                Code.FAC_UNKNOWN,
                f"{cursor[:40]!r} is no cursor",
                hint="take the cursor of the page before as it is, or none",
                values={"what": "cursor", "name": cursor[:40]},
            )
        query = query.where(key < int(cursor))
    return query.order_by(key.desc()).limit(size(limit) + 1)


def size(limit: int) -> int:
    """Of a page: at least one row, at most `MOST`."""
    return min(max(limit, 1), MOST)


def page_of(rows: list[Any], limit: int, key: Callable[[Any], int], make: Callable[[Any], T]) -> Page[T]:
    """The rows but the one that was read to know of a next page."""
    shown = rows[: size(limit)]
    more = len(rows) > len(shown)
    return Page(tuple(make(one) for one in shown), str(key(shown[-1])) if more else None)


def time(text: str) -> datetime:
    """A time as the tables have it."""
    return datetime.fromisoformat(text)
