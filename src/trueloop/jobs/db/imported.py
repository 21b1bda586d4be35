"""Files into the store: inspections, records and exports; each file in one transaction, whole or not at all."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trueloop.domain.correction import Correction
from trueloop.errors import Code, in_file
from trueloop.formats.input_file import readable
from trueloop.formats.record_file import read_record
from trueloop.jobs.db.copied import keep_lines
from trueloop.jobs.db.exported import HEAD, is_export, read_export
from trueloop.jobs.db.found import row_name
from trueloop.jobs.db.inspected import Inspected, read_inspections
from trueloop.jobs.store.of_this_part import require_file_of_part
from trueloop.jobs.user import user_name
from trueloop.storage.store import Store, keep

SHOWN: Final = 20
"""Rows that are listed of one file: nobody reads more."""
HINT: Final = "name an inspection file, a record.json, or what `trueloop db export` wrote"


@dataclass(frozen=True)
class Imported:
    """What came of a file: how many values, how many of them new, and the rows; of an export the numbers alone."""

    path: Path
    count: int
    new: int
    rows: tuple[tuple[str, bool], ...]

    @property
    def words(self) -> str:
        """In a line, and one for each of the first rows."""
        lines = [f"  {name} {'kept' if new else 'is there already, not kept again'}" for name, new in self.rows[:SHOWN]]
        more = len(self.rows) - len(lines)
        return "\n".join(
            [f"{self.path}: {self.new} of {self.count} new", *lines, *([f"  … and {more}"] if more else [])]
        )

    @property
    def as_dict(self) -> dict[str, object]:
        """For machines."""
        rows = [{"row": name, "new": new} for name, new in self.rows]
        return {"file": str(self.path), "count": self.count, "new": self.new, "rows": rows}


def import_files(
    store: Store, paths: Sequence[Path], of: Inspected, progress: Callable[[str], None] = lambda _: None
) -> Iterator[Imported]:
    """Files one after the other, each kept when it is yielded; `progress` is given what is being done.

    Raises STO errors, and what reading refuses.
    """
    for path in paths:
        progress(f"importing {path}")
        with readable(path, Code.STO_IMPORT, hint=HINT), path.open("rb") as file:
            beginning = file.read(HEAD)
        yield _of_export(store, path, progress) if is_export(beginning) else _of_values(store, path, beginning, of)


def _of_values(store: Store, path: Path, beginning: bytes, of: Inspected) -> Imported:
    if beginning.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        record = read_record(path)
        known = (one for one in record.inspections if one.part.serial)
        values: list[Any] = [*known, Correction(record, {}, None)]
    else:
        values = list(read_inspections(path, of))
        with in_file(path):
            for one in values:
                require_file_of_part(store, one)
    kept = keep(store, values, by=user_name())
    rows = tuple((row_name(type(one.value), one.row), one.new) for one in kept)
    return Imported(path, len(kept), sum(one.new for one in kept), rows)


def _of_export(store: Store, path: Path, progress: Callable[[str], None]) -> Imported:
    copied = keep_lines(store, read_export(path, store.codec), progress, str(path))
    return Imported(path, copied.count, copied.new, ())
