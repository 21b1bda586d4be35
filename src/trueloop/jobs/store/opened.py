"""Stores as the commands `trueloop db` name and open them."""

from pathlib import Path
from typing import TYPE_CHECKING, Final

from trueloop.errors import Code, TrueloopError
from trueloop.jobs.store.where import BESIDE, Choice
from trueloop.storage.reading import shown

if TYPE_CHECKING:
    from trueloop.storage.store import Store

NO_STORE: Final = "make one by `trueloop db init`, or name one by --db"


def opened(db: Choice, *, read_only: bool = False) -> "Store":
    """Opens the requested store, else `trueloop.db` in the present folder. Raises STO errors."""
    from trueloop.jobs.store.codec import store_codec
    from trueloop.storage.store import open_store

    return open_store(_place(db), codec=store_codec(), read_only=read_only)


def _place(db: Choice) -> str:
    if db:
        return db
    if not Path(BESIDE).is_file():
        raise Code.STO_FILE.refusal(f"there is no store '{BESIDE}' in this folder", hint=NO_STORE)
    return BESIDE


def migrated(db: str | None) -> tuple[str, str, str]:
    """Brings a store to today's schema: which it had, which it has, and its name. Raises STO errors."""
    from trueloop.storage.engines import engine_of, understood, url_of
    from trueloop.storage.schema import schema_of
    from trueloop.storage.store import open_store

    place = _place(db)
    url = url_of(place)
    with understood(shown(place)), engine_of(url, 1.0, create=False, read_only=True).connect() as connection:
        before = schema_of(connection)
    if before is None:
        open_store(place)  # refuses what is not a store
    with (store := open_store(place, create=True)).reading() as connection:
        after = schema_of(connection)
    return str(before), str(after), store.where


def made(place: str) -> "Store":
    """Makes a new, empty store. Raises STO-EXISTS where there is anything already, STO-FILE and STO-WRITE."""
    from trueloop.jobs.store.codec import store_codec
    from trueloop.storage.store import open_store

    if "://" in place:
        _require_no_store(place)
    else:
        require_nothing(Path(place))
    return open_store(place, create=True, codec=store_codec())


def require_nothing(path: Path) -> None:
    """Raises STO-EXISTS where something has that name already."""
    if path.exists():
        raise _exists(str(path), f"there is {'a folder' if path.is_dir() else 'a file'} {str(path)!r} already")


def _require_no_store(url: str) -> None:
    from trueloop.storage.store import open_store

    try:
        open_store(url).close()
    except TrueloopError as error:
        if error.code is Code.STO_SCHEMA:
            raise _exists(shown(url), f"there is a store of another version at {shown(url)!r} already") from error
    else:
        raise _exists(shown(url), f"there is a store at {shown(url)!r} already")


def _exists(place: str, why: str) -> TrueloopError:
    return Code.STO_EXISTS.refusal(
        f"{why}: nothing was changed",
        hint="name a new one, or work with the one that is there",
        values={"store": place},
    )
