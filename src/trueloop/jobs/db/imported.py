"""Files into the store: inspections and records; each file in one transaction, whole or not at all."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trueloop.domain.correction import Correction
from trueloop.domain.inspection import Inspection
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import readable
from trueloop.formats.record_file import read_record
from trueloop.jobs.db.inspected import Inspected, read_inspections
from trueloop.jobs.store.found import row_name
from trueloop.storage.store import Kept, Store, find, keep

SHOWN: Final = 20
"""Rows that are listed of one file: nobody reads more."""
HINT: Final = "name an inspection file, a record.json, or what `trueloop db export` wrote"


@dataclass(frozen=True)
class Imported:
    """What came of a file: its values in the store, of which those that were there before are not `new`."""

    path: Path
    kept: tuple[Kept[Any], ...]

    @property
    def words(self) -> str:
        """What came of the file, in a line or a few."""
        lines = [f"  {_name(one)} {'kept' if one.new else 'is there already, not kept again'}" for one in self.kept]
        new = sum(one.new for one in self.kept)
        return "\n".join([f"{self.path}: {new} of {len(self.kept)} new", *lines[:SHOWN]])

    @property
    def as_dict(self) -> dict[str, object]:
        """For machines."""
        rows = [{"row": _name(one), "new": one.new} for one in self.kept]
        return {"file": str(self.path), "new": sum(one.new for one in self.kept), "rows": rows}


def _name(kept: Kept[Any]) -> str:
    return row_name(type(kept.value), kept.row)


def import_files(
    store: Store, paths: Sequence[Path], of: Inspected, say: Callable[[str], None] = lambda _: None
) -> Iterator[Imported]:
    """Files one after the other, each kept when it is yielded; `say` is given what is being done.

    Raises STO errors, and what reading refuses.
    """
    for path in paths:
        say(f"importing {path}")
        yield _imported(store, path, of)


def _imported(store: Store, path: Path, of: Inspected) -> Imported:
    with readable(path, Code.STO_IMPORT, hint=HINT), path.open("rb") as file:
        begins = file.read(1).strip()
    if begins == b"{":
        record = read_record(path)
        inspections = [one for one in record.inspections if one.part.serial]
        return Imported(path, tuple(keep(store, [*inspections, Correction(record, {}, None)])))
    read = read_inspections(path, of)
    for one in read:
        _check_same_part(store, path, one)
    return Imported(path, tuple(keep(store, read)))


def _check_same_part(store: Store, path: Path, inspection: Inspection) -> None:
    """Raises STO-OTHER-PART for a file that is stored already, as an inspection of other parts."""
    stored = find(store, Inspection, file_sha256=inspection.sha256)
    parts = {kept.value.part.identity for kept in stored}
    if not stored or inspection.part.identity in parts:
        return
    before, part = stored[0], inspection.part
    was = before.value.part
    raise TrueloopError(
        Code.STO_OTHER_PART,
        f"{path.name!r} is stored already, as inspection:{before.row} of {was.part_type.name!r} {was.serial!r}, "
        f"not of {part.part_type.name!r} {part.serial!r}",
        hint=f"where the stored part is wrong, replace it: trueloop db replace inspection:{before.row}",
        place=Place(str(path)),
        values={"file": path.name},
    )
