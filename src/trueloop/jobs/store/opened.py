"""Stores as the commands `trueloop db` name and open them."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from trueloop.errors import Code, TrueloopError
from trueloop.jobs.store.where import BESIDE, place_of_store

if TYPE_CHECKING:
    from trueloop.storage.store import Store

PASSWORD: Final = re.compile(r"(?<=://)([^/@:]*):[^@]*@")
NO_STORE: Final = "make one by `trueloop db init`, or name one by --db"


def shown(place: str) -> str:
    """A store's file or URL as it may be printed: without the password.

    >>> shown("postgresql://ana:secret@plant/parts")
    'postgresql://ana:***@plant/parts'
    """
    return PASSWORD.sub(r"\1:***@", place)


def opened(db: str | None) -> "Store":
    """The store asked for, else `trueloop.db` in the present folder. Raises STO errors."""
    from trueloop.jobs.store.codec import store_codec
    from trueloop.storage.store import open_store

    place = place_of_store(Path(), db, None)
    if place is None:
        raise TrueloopError(Code.STO_FILE, f"there is no store '{BESIDE}' in this folder", hint=NO_STORE)
    return open_store(place, codec=store_codec())


def made(place: str) -> "Store":
    """A new, empty store. Raises STO-EXISTS where there is anything already, STO-FILE and STO-WRITE."""
    from trueloop.jobs.store.codec import store_codec
    from trueloop.storage.store import open_store

    if "://" not in place and Path(place).exists():
        raise TrueloopError(
            Code.STO_EXISTS,
            f"there is {'a folder' if Path(place).is_dir() else 'a file'} {place!r} already: nothing was changed",
            hint="name a new file, or work with the store that is there: --db",
            values={"store": place},
        )
    return open_store(place, create=True, codec=store_codec())
