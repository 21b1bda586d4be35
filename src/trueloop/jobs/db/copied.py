"""Rows from one store into another as they are: of an export, a backup, or a store itself.

A store as a text file: one value a line, in the form of the codec, for any program and any later version to read.

    {"format": "trueloop store", "version": 1, "trueloop": "0.1.0"}
    {"kind": "part_type", "row": 1, "kept_at": "…", "by": "", "why": "", "supersedes": null, "value": {…}}
    …
    {"end": 1}

Kinds stand in the order of `KINDS`, so that what a value names stands before it, and rows in the order in which they
were kept. The last line counts the values: a file that was cut off is known, wherever it was. Row numbers hold inside
the file alone; `supersedes` is one of them.
"""

import json
import os
import sqlite3
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from trueloop.domain.codec import Codec
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import readable
from trueloop.formats.outputs import written_as_it_comes
from trueloop.jobs.store.opened import make_store, open_store, require_nothing
from trueloop.storage.integrity import damage
from trueloop.storage.keeping import Keeping, Query, found
from trueloop.storage.kinds import KINDS
from trueloop.storage.store import Kept, Store, copy_rows

FORMAT: Final = "trueloop store"
VERSION: Final = 1
WHOLE: Final = "export the store again, or take a copy that is whole: nothing was kept"
MARK: Final = f'"{FORMAT}"'.encode()
HEAD: Final = 4096
"""Bytes of a file by which it is known."""
ROW_KEYS: Final = {"kind", "row", "kept_at", "by", "why", "supersedes", "value"}


@dataclass(frozen=True)
class Line:
    """A value of an export with its line in the file; `kept` has the row and those numbers that hold in the file."""

    number: int
    table: str
    kept: Kept[Any]


def export(store: Store, path: Path) -> int:
    """Writes the store into a file, whole or not at all, and returns how many values. Raises OUT and STO errors."""
    with written_as_it_comes(path, [Path(store.where)]) as file:
        file.write(_text({"format": FORMAT, "version": VERSION, "trueloop": version("trueloop")}))
        count = 0
        for line in lines_of(store):
            file.write(_text(_of_row(store.codec, line)))
            count += 1
        file.write(_text({"end": count}))
    return count


def lines_of(store: Store) -> Iterator[Line]:
    """Yields all rows of a store as an export has them, as they are at one moment."""
    number = 1
    with store.reading() as connection:
        for kind in KINDS:
            for kept in found(connection, store.codec, Query(kind, superseded=True)):
                number += 1
                yield Line(number, kind.table, kept)


def is_export(beginning: bytes) -> bool:
    """Returns whether a file that begins so was written by `export`."""
    return beginning.lstrip(b"\xef\xbb\xbf \r\n").startswith(b"{") and MARK in beginning.split(b"\n")[0]


def read_export(path: Path, codec: Codec) -> Iterator[Line]:
    """Yields an export's values in order. Raises STO-EXPORT with the line, STO-SCHEMA (a later version), VAL-FORM."""
    count, number, ended = 0, 0, False
    with path.open("rb") as file:
        for number, line in enumerate(file, 1):
            if ended and line.strip():
                raise _refused(path, number, "there is more after the last line")
            try:
                content = json.loads(line)
            except (ValueError, RecursionError) as wrong:
                cut = "" if line.endswith(b"\n") else "; the file ends here"
                raise _refused(path, number, f"no JSON: {str(wrong)!r}{cut}") from wrong
            if not isinstance(content, dict):
                raise _refused(path, number, f"{type(content).__name__!r} instead of an object")
            if number == 1:
                if content.get("format") != FORMAT or not isinstance(content.get("version"), int):
                    raise _refused(path, 1, f"no head {{'format': {FORMAT!r}, 'version': …}}")
                if content["version"] > VERSION:
                    raise Code.STO_SCHEMA.refusal(
                        f"an export of version {content['version']}, written by trueloop {content.get('trueloop')}; "
                        f"this one reads up to version {VERSION}",
                        hint="import it with the version of trueloop that wrote it, or a later one",
                        place=Place(str(path), 1),
                    )
            elif "end" in content:
                ended = True
                if content["end"] != count:
                    raise _refused(path, number, f"it counts {content['end']!r} values where {count} are")
            else:
                count += 1
                yield _line(path, number, content, codec)
    if not ended:
        raise _refused(path, number + 1, f"the file is cut off after {count} values: this line, or its end, is missing")


def _of_row(codec: Codec, line: Line) -> dict[str, object]:
    kept = line.kept
    stated = {"kind": line.table, "row": kept.row, "kept_at": kept.kept_at.isoformat(), "by": kept.by, "why": kept.why}
    return {**stated, "supersedes": kept.supersedes, "value": codec.plain(kept.value)}


def _text(line: object) -> bytes:
    """ASCII, so that no text of a value ends a line or fails to be one."""
    return json.dumps(line, allow_nan=False).encode() + b"\n"


def _line(path: Path, number: int, content: dict[str, Any], codec: Codec) -> Line:
    kind = next((one for one in KINDS if one.table == content.get("kind")), None)
    if kind is None or content.keys() != ROW_KEYS:
        raise _refused(path, number, f"no row of a kind that is known: {content.get('kind')!r}")
    try:
        at = datetime.fromisoformat(content["kept_at"])
        row, supersedes = int(content["row"]), content["supersedes"]
        texts = str(content["by"]), str(content["why"])
    except (TypeError, ValueError) as wrong:
        raise _refused(path, number, f"no row: {str(wrong)!r}") from wrong
    with in_file(path, number):
        value: Any = codec.value(content["value"], kind.type)
    return Line(number, kind.table, Kept(row, value, at, supersedes=supersedes, by=texts[0], why=texts[1]))


def _refused(path: Path, line: int, why: str) -> TrueloopError:
    return Code.STO_EXPORT.refusal(
        f"line {line}: {why}", hint=WHOLE, place=Place(str(path), line), values={"line": line}
    )


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
    """Keeps rows with who, when, why and what they supersede, or none. Raises STO-EXPORT, and what keeping refuses."""
    renumbered: dict[tuple[str, int], int] = {}
    count = new = 0
    with store.writing() as connection:
        keeping = Keeping(store.codec, connection)
        for line in lines:
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
            kept = keeping.keep(given.value, supersedes, given.kept_at)
            renumbered[line.table, line.kept.row] = kept.row
            count, new = count + 1, new + kept.new
            if count % SAID == 0:
                progress(f"{source}: {count} rows")
    return Copied(count, new)


def back_up(store: Store, path: Path, progress: Progress) -> None:
    """Copies the store to a SQLite file, whole or not at all, during writes. Raises STO-EXISTS, OUT-FOLDER."""
    require_nothing(path)
    with _appearing(path) as part:
        if store.engine.dialect.name == "sqlite":
            with store.reading() as connection, closing(sqlite3.connect(part)) as target:
                raw: Any = connection.connection.dbapi_connection
                raw.backup(target)
                target.execute("PRAGMA journal_mode = DELETE")  # one file: what is in a log is not in the copy
        else:
            copy = make_store(str(part))
            copy_rows(store, copy, _told(progress, store.where))
            copy.close()


def restore(path: Path, place: str, progress: Progress) -> Copied:
    """Makes a new store from a backup or an export: of a backup everything, of an export the values.

    Raises STO-EXISTS, STO-EXPORT, STO-FILE, and STO-DAMAGED for a backup that is not as it was written.
    """
    with readable(path, Code.STO_IMPORT, hint=HINT), path.open("rb") as file:
        beginning = file.read(HEAD)
    if "://" in place:
        return _restored(path, make_store(place), progress, export=is_export(beginning))
    require_nothing(Path(place))
    with _appearing(Path(place)) as part:
        store = make_store(str(part))
        copied = _restored(path, store, progress, export=is_export(beginning))
        store.close()
    return copied


def _restored(path: Path, store: Store, progress: Progress, *, export: bool) -> Copied:
    if export:
        return keep_lines(store, read_export(path, store.codec), progress, str(path))
    backup = open_store(str(path), read_only=True)
    for one in damage(backup):
        row = f"{one.table}:{one.row}" if one.row is not None else one.table
        raise Code.STO_DAMAGED.refusal(
            f"{row or 'the file'} is damaged: {one.why}",
            hint="restore another backup: nothing was made; `trueloop db check` names all that is damaged",
            place=Place(backup.where),
            values={"row": row},
        )
    count = copy_rows(backup, store, _told(progress, str(path)))
    return Copied(count, count)


def _told(progress: Progress, source: str) -> Callable[[int], None]:
    return lambda count: progress(f"{source}: {count} rows")


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
