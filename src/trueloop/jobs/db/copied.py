"""Rows from one store into another as they are: of an export, a backup, or a store itself."""

import os
import sqlite3
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import readable
from trueloop.jobs.db.exported import HEAD, Line, is_export, read_export
from trueloop.jobs.store.opened import made, opened, require_nothing
from trueloop.storage.integrity import damage
from trueloop.storage.keeping import Keeping
from trueloop.storage.store import Kept, Store, copy_rows

SAID: Final = 1000
"""Rows between two words on how far it is."""
HINT: Final = "name a backup that `trueloop db backup` made, or what `trueloop db export` wrote"
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Copied:
    """How many rows were copied, and how many of them the store did not have."""

    count: int
    new: int


def keep_lines(store: Store, lines: Iterable[Line], progress: Progress, source: str) -> Copied:
    """Keeps rows as they were: who kept them, when and why, and what they supersede. All or none.

    Raises STO-EXPORT for one that supersedes what does not stand before it, and what keeping refuses.
    """
    renumbered: dict[tuple[str, int], int] = {}
    count = new = 0
    with store.writing() as connection:
        keeping = Keeping(store.codec, connection)
        for line in lines:
            kept = _kept_as_it_was(keeping, line, renumbered, source)
            renumbered[line.table, line.kept.row] = kept.row
            count, new = count + 1, new + kept.new
            if count % SAID == 0:
                progress(f"{source}: {count} rows")
    return Copied(count, new)


def back_up(store: Store, path: Path, progress: Progress) -> None:
    """Copies the store to a SQLite file, whole or not at all, while others go on writing.

    Raises STO-EXISTS where there is such a file, OUT-FOLDER where it cannot be written.
    """
    require_nothing(path)
    with _appearing(path) as part:
        if store.engine.dialect.name == "sqlite":
            with store.reading() as connection, closing(sqlite3.connect(part)) as target:
                raw: Any = connection.connection.dbapi_connection
                raw.backup(target)
                target.execute("PRAGMA journal_mode = DELETE")  # one file: what is in a log is not in the copy
        else:
            copy = made(str(part))
            copy_rows(store, copy, _told(progress, store.where))
            copy.close()


def restore(path: Path, place: str, progress: Progress) -> Copied:
    """Makes a new store from a backup or an export: of a backup everything, of an export the values.

    Raises STO-EXISTS, STO-EXPORT, STO-FILE, and STO-DAMAGED for a backup that is not as it was written.
    """
    with readable(path, Code.STO_IMPORT, hint=HINT), path.open("rb") as file:
        beginning = file.read(HEAD)
    if "://" in place:
        return _restored(path, made(place), progress, export=is_export(beginning))
    require_nothing(Path(place))
    with _appearing(Path(place)) as part:
        store = made(str(part))
        copied = _restored(path, store, progress, export=is_export(beginning))
        store.close()
    return copied


def _restored(path: Path, store: Store, progress: Progress, *, export: bool) -> Copied:
    if export:
        return keep_lines(store, read_export(path, store.codec), progress, str(path))
    backup = opened(str(path), read_only=True)
    _require_whole(backup)
    count = copy_rows(backup, store, _told(progress, str(path)))
    return Copied(count, count)


def _told(progress: Progress, source: str) -> Callable[[int], None]:
    return lambda count: progress(f"{source}: {count} rows")


def _require_whole(backup: Store) -> None:
    for one in damage(backup):
        row = f"{one.table}:{one.row}" if one.row is not None else one.table
        raise Code.STO_DAMAGED.refusal(
            f"{row or 'the file'} is damaged: {one.why}",
            hint="restore another backup: nothing was made; `trueloop db check` names all that is damaged",
            place=Place(backup.where),
            values={"row": row},
        )


@contextmanager
def _appearing(path: Path) -> Iterator[Path]:
    """A file that is made beside its place and gets its name when it is whole; after an error there is none."""
    try:
        handle, name = tempfile.mkstemp(prefix=".trueloop-", dir=path.parent)
    except OSError as error:
        raise _not_written(path, error) from error
    os.close(handle)
    part = Path(name)
    part.unlink()
    try:
        yield part
        _named(part, path)
    except OSError as error:
        raise _not_written(path, error) from error
    finally:
        for suffix in ("", "-wal", "-shm", "-journal"):
            part.with_name(part.name + suffix).unlink(missing_ok=True)


def _named(part: Path, path: Path) -> None:
    """Gives a file its name, by a link where the disk has them: it never takes the place of another file."""
    try:
        os.link(part, path)
    except OSError:
        if path.exists():
            raise
        part.rename(path)


def _not_written(path: Path, error: OSError) -> TrueloopError:
    return Code.OUT_FOLDER.refusal(
        f"nothing was written to {str(path)!r}: {error.strerror or error}",
        hint="name a file in a folder that takes it, on a disk with room",
        place=Place(str(path)),
    )


def _kept_as_it_was(keeping: Keeping, line: Line, renumbered: dict[tuple[str, int], int], source: str) -> Kept[Any]:
    given = line.kept
    if given.supersedes is not None and (line.table, given.supersedes) not in renumbered:
        raise Code.STO_EXPORT.refusal(
            f"line {line.number}: it supersedes row {given.supersedes}, which does not stand before it",
            hint="export the store again: nothing was kept",
            place=Place(source, line.number),
            values={"line": line.number},
        )
    supersedes = None if given.supersedes is None else renumbered[line.table, given.supersedes]
    keeping.by, keeping.why = given.by, given.why
    return keeping.keep(given.value, supersedes, given.kept_at)
