"""A store as a text file: one value a line, in the form of the codec, for any program and any later version to read.

    {"format": "trueloop store", "version": 1, "trueloop": "0.1.0"}
    {"kind": "part_type", "row": 1, "kept_at": "…", "by": "", "why": "", "supersedes": null, "value": {…}}
    …
    {"end": 1}

Kinds stand in the order of `KINDS`, so that what a value names stands before it, and rows in the order in which they
were kept. The last line counts the values: a file that was cut off is known, wherever it was. Row numbers hold inside
the file alone; `supersedes` is one of them.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from trueloop.domain.codec import Codec
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.outputs import written_as_it_comes
from trueloop.storage.encoded import Kept
from trueloop.storage.kinds import KINDS
from trueloop.storage.reading import Query, found
from trueloop.storage.store import Store

FORMAT: Final = "trueloop store"
VERSION: Final = 1
HINT: Final = "export the store again, or take a copy that is whole: nothing was kept"
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
    """Yields the values of an export, in its order, read one by one.

    Raises STO-EXPORT with the line where the file is not whole, STO-SCHEMA for that of a later version, VAL-FORM.
    """
    count, number, ended = 0, 0, False
    with path.open("rb") as file:
        for number, line in enumerate(file, 1):
            if ended and line.strip():
                raise _refused(path, number, "there is more after the last line")
            content = _parsed(path, number, line)
            if number == 1:
                _check_head(path, content)
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


def _parsed(path: Path, number: int, line: bytes) -> dict[str, Any]:
    try:
        content = json.loads(line)
    except (ValueError, RecursionError) as wrong:
        cut = "" if line.endswith(b"\n") else "; the file ends here"
        raise _refused(path, number, f"no JSON: {str(wrong)!r}{cut}") from wrong
    if not isinstance(content, dict):
        raise _refused(path, number, f"{type(content).__name__!r} instead of an object")
    return content


def _check_head(path: Path, content: dict[str, Any]) -> None:
    if content.get("format") != FORMAT or not isinstance(content.get("version"), int):
        raise _refused(path, 1, f"no head {{'format': {FORMAT!r}, 'version': …}}")
    if content["version"] > VERSION:
        raise Code.STO_SCHEMA.refusal(
            f"an export of version {content['version']}, written by trueloop {content.get('trueloop')}; "
            f"this one reads up to version {VERSION}",
            hint="import it with the version of trueloop that wrote it, or a later one",
            place=Place(str(path), 1),
        )


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
        f"line {line}: {why}", hint=HINT, place=Place(str(path), line), values={"line": line}
    )
