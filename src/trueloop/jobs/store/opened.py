"""Stores as the commands `trueloop db` name and open them.

Which store a command works with: the one that it names, the job's, or the one beside the job.

How a command keeps what it found, and what it says where that goes wrong.
"""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

from trueloop.errors import Code, Finding, Severity, TrueloopError

if TYPE_CHECKING:
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.storage.store import Store


BESIDE: Final = "trueloop.db"
"""The store in the job's folder, where neither the command nor the job names one."""

Choice = str | Literal[False] | None
"""A store as a command names it: a file or a URL; None: the job's or the one beside it; False: no store."""

Beside = Literal["used", "made", "unused"]
"""The store beside the job: used where it exists; made by what is kept first; left alone, as for a part without a
serial number, by which parts are kept apart.
"""


def named_store(job_folder: Path, db: Choice, job_db: str | None) -> str | None:
    """Returns where the store is: `db` as given, else `job_db` from the job's folder; None: none is named."""
    if db is False:
        return None
    if db:
        return db
    if job_db:
        return job_db if "://" in job_db else str(job_folder / job_db)
    return None


def store_of(job_folder: Path, db: Choice, job_db: str | None, beside: Beside = "used") -> "Store | None":
    """Opens the named store, else that beside the job, with all types; None: none there or wanted. Raises STO."""
    place, unmade = named_store(job_folder, db, job_db), False
    if place is None and db is not False and beside != "unused":
        file = job_folder / BESIDE
        unmade = beside == "made" and not file.is_file()
        place = str(file) if unmade or file.is_file() else None
    if place is None:
        return None
    from trueloop.jobs.store.codec import store_codec  # both are slow to import, and some jobs have no store
    from trueloop.storage.store import open_store

    return open_store(place, codec=store_codec(), unmade=unmade)


@dataclass(frozen=True)
class Keeping:
    """How a command keeps: in the store `db`; `serial` of the part where the job has none.

    `supersede`: what is stored with another content gives way; `accept`: codes of refusals that are to be warnings.
    """

    db: Choice = None
    serial: str | None = None
    supersede: bool = False
    accept: tuple[str, ...] = ()


@contextmanager
def accepting(codes: Collection[str], findings: list[Finding]) -> Iterator[None]:
    """Turns a refusal of one of these codes into a warning among the findings, if it has an override at all."""
    try:
        yield
    except TrueloopError as refused:
        if refused.code not in codes or refused.override is None:
            raise
        said = (refused.message, refused.hint, refused.place, refused.values)
        findings.append(Finding(Severity.WARNING, refused.code, *said))


@contextmanager
def kept_all_the_same(kept: "KeptFacts | None") -> Iterator[None]:
    """Adds to a refusal to write the outputs that the store has their content; None: there is no store."""
    try:
        yield
    except TrueloopError as refused:
        if kept is None:
            raise
        hint = f"{refused.hint}; {kept.words}: calling it again writes the files and keeps nothing twice"
        where, override, values = refused.place, refused.override, refused.values
        raise refused.code.refusal(
            refused.message, hint=hint, place=where, override=override, values=values
        ) from refused


NO_STORE: Final = "make one by `trueloop db init`, or name one by --db"


def open_store(db: Choice = None, *, read_only: bool = False) -> "Store":
    """Opens a store by its file or URL, else `trueloop.db` in the present folder. Raises STO errors.

    >>> trueloop.make_store("shop.db").close()
    >>> trueloop.open_store("shop.db", read_only=True).where
    'shop.db'
    """
    from trueloop.jobs.store.codec import store_codec
    from trueloop.storage import store

    return store.open_store(_place(db), codec=store_codec(), read_only=read_only)


def _place(db: Choice) -> str:
    if db:
        return db
    if not Path(BESIDE).is_file():
        raise Code.STO_FILE.refusal(f"there is no store '{BESIDE}' in this folder", hint=NO_STORE)
    return BESIDE


def make_store(place: str) -> "Store":
    """Makes a new, empty store: a file, or the URL of a database. Raises STO-EXISTS, STO-FILE and STO-WRITE.

    >>> trueloop.make_store("shop.db").where
    'shop.db'
    """
    from trueloop.jobs.store.codec import store_codec
    from trueloop.storage import store

    if "://" in place:
        _require_no_store(place)
    else:
        require_nothing(Path(place))
    return store.open_store(place, create=True, codec=store_codec())


def require_nothing(path: Path) -> None:
    """Raises STO-EXISTS where something has that name already."""
    if path.exists():
        raise _exists(str(path), f"there is {'a folder' if path.is_dir() else 'a file'} {str(path)!r} already")


def _require_no_store(url: str) -> None:
    from trueloop.storage.keeping import shown
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
