"""Files that people hand over: kept for a day, read as often as asked, and forgotten. No name of theirs is a path."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime, timedelta
from hashlib import sha256
from typing import Final

from sqlalchemy import delete, insert, select

from trueloop.factory.known import unknown
from trueloop.factory.load import Known, order_of
from trueloop.jobs.factory.job_folder import programs_of, unnamed_folder
from trueloop.jobs.factory.upload_read import Asked, Handed
from trueloop.storage.factory_tables import UPLOAD, stamp
from trueloop.storage.store import Store

KEPT: Final = timedelta(days=1)
_UNSAFE: Final = re.compile(r"[^A-Za-z0-9._-]+")
_LONGEST: Final = 100


@dataclass(frozen=True)
class Upload:
    """A file as it was handed over, under the name that its owner gave it."""

    name: str
    sha256: str
    content: bytes


def add_upload(store: Store, name: str, content: bytes, by: str, now: datetime) -> Upload:
    """Keeps a file, and forgets those of more than a day ago."""
    hashed = sha256(content).hexdigest()
    row = {"by": by, "name": name, "sha256": hashed, "created_at": stamp(now), "content": content}
    with store.writing() as connection:
        connection.execute(delete(UPLOAD).where(UPLOAD.c.created_at < stamp(now - KEPT)))
        connection.execute(insert(UPLOAD).values(**row))
    return Upload(name, hashed, content)


def upload_of(store: Store, sha256: str, by: str) -> Upload:
    """Returns this account's upload by its hash: a number might be given to another file later. Raises FAC-UNKNOWN."""
    mine = (UPLOAD.c.sha256 == sha256) & (UPLOAD.c.by == by)
    with store.reading() as connection:
        row = connection.execute(select(UPLOAD).where(mine).order_by(UPLOAD.c.id.desc()).limit(1)).one_or_none()
    if row is None:
        raise unknown("upload", sha256, "hand the file over again: it is kept for a day")
    return Upload(row.name, row.sha256, bytes(row.content))


@contextmanager
def handed(store: Store, upload: Upload, asked: Asked) -> Iterator[Handed]:
    """Yields the file in a temporary folder of its own, with what the store knows of the order that is requested.

    Its name there has letters, digits and `._-`, and the end of its own. Raises FAC-UNKNOWN.
    """
    order, programs = None, dict[str, bytes]()
    if asked.order:
        with store.reading() as connection:
            known = Known(connection, store.codec)
            order = order_of(known, asked.order).order
            programs = programs_of(known, order)
    with unnamed_folder() as folder:
        path = folder / (_UNSAFE.sub("_", upload.name)[-_LONGEST:].lstrip(".") or "file")
        path.write_bytes(upload.content)
        yield Handed(str(path), upload.name, upload.sha256, asked, order, programs)
