"""Which store a command works with: the one that it names, the job's, or the one beside the job."""

from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
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
    """Opens the named store, else the one beside the job, with the types of all products; None: there is none, or none
    is wanted. Raises STO errors.
    """
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
