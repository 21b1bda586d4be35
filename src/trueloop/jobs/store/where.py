"""Which store a command works with: the one asked for, the job's, or the one beside the job; else none."""

from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from trueloop.storage.store import Store

BESIDE: Final = "trueloop.db"
"""A store of this name in the job's folder is used without being asked for: `trueloop db init` makes it."""

Choice = str | Literal[False] | None
"""A store as a command names it: a file or a URL; None: the job's or the one beside it; False: no store."""


def place_of_store(job_folder: Path, db: Choice, job_db: str | None) -> str | None:
    """Returns where the store is: `db` as given; `job_db` from the job's folder; None: there is none, or none is
    wanted.
    """
    if db is False:
        return None
    if db:
        return db
    if job_db:
        return job_db if "://" in job_db else str(job_folder / job_db)
    beside = job_folder / BESIDE
    return str(beside) if beside.is_file() else None


def store_of(job_folder: Path, db: Choice, job_db: str | None) -> "Store | None":
    """Opens that store with the types of all products; None: a job without a store. Raises STO errors."""
    place = place_of_store(job_folder, db, job_db)
    if place is None:
        return None
    from trueloop.jobs.store.codec import store_codec  # both are slow to import, and most jobs have no store
    from trueloop.storage.store import open_store

    return open_store(place, codec=store_codec())
