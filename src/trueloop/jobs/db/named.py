"""Reads what a person names (a row, a part by serial number or label, a correction by the id of its record), and
replaces a stored row.
"""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trueloop.domain.inspection import Inspection
from trueloop.domain.labels import NistPart, PartLabel, names_part, read_label
from trueloop.domain.life import Cut, InspectionLink
from trueloop.domain.part import Part
from trueloop.domain.record import Correction
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text
from trueloop.jobs.db.found import NAMES, row_name, row_of
from trueloop.storage.kinds import Kind, joined
from trueloop.storage.store import Kept, Store, find, keep

HINT: Final = "take what `trueloop db show ROW --json` printed, with what was wrong in it changed"


def _refused(file: Path, why: str, line: int | None = None) -> TrueloopError:
    return Code.STO_IMPORT.refusal(f"{file.name!r}: {why}", hint=HINT, place=Place(str(file), line))


ROW: Final = re.compile(r"([a-z-]+):([0-9]{1,15})")


@dataclass(frozen=True)
class NamedRow:
    """A row that was asked for by its name."""

    kind: Kind
    kept: Kept[Any]


def named(store: Store, what: str) -> NamedRow | Part:
    """Finds a row by its name (`inspection:12`) or a record's id; or a part by serial number, TYPE/SERIAL or label.

    Raises STO-UNKNOWN where nothing in the store has that name, STO-SEVERAL where several parts have it.
    """
    if ROW.fullmatch(what):
        return named_row(store, what)
    corrections: list[Kept[Any]] = find(store, Correction, identity=joined((what,)))
    if corrections:
        return NamedRow(NAMES["correction"], corrections[-1])
    parts = {part.identity: part for part in _parts(store, what)}
    if not parts:
        raise _unknown(what)
    if len(parts) > 1:
        listed = [f"{part.part_type.name}/{part.serial}" for part in parts.values()]
        raise Code.STO_SEVERAL.refusal(
            f"{len(parts)} parts are called {what!r}: {', '.join(listed[:10])}",
            hint="name one by its type and serial number: TYPE/SERIAL",
            values={"name": what},
        )
    return next(iter(parts.values()))


def named_row(store: Store, what: str) -> NamedRow:
    """Finds a row by its name, also one that is superseded. Raises STO-UNKNOWN."""
    match = ROW.fullmatch(what)
    kind = NAMES.get(match[1]) if match else None
    if match is None or kind is None:
        raise _unknown(what)
    kept = row_of(store, kind.type, int(match[2]))
    if kept is None:
        raise _unknown(what)
    return NamedRow(kind, kept)


def _parts(store: Store, what: str) -> list[Part]:
    by_serial = [one.value for one in find(store, Part, serial=what)]
    kind, slash, serial = what.rpartition("/")
    typed = find(store, Part, part_type=kind, serial=serial) if slash else []
    return [*by_serial, *(one.value for one in typed), *_labelled(store, what)]


def _labelled(store: Store, what: str) -> list[Part]:
    """Those that a label means; none where it is not a label."""
    try:
        label = read_label(what)
    except TrueloopError:
        return []
    asked: list[dict[str, Any]] = []
    if isinstance(label, NistPart):
        asked = [{"serial": label.number}, {"part_type": label.number, "serial": label.inspection}]
    elif isinstance(label, PartLabel):
        asked = [{"serial": label.copy}] if label.copy else [{"part_type": label.number}]
    return [one.value for by in asked for one in find(store, Part, **by) if names_part(label, one.value)]


def _unknown(what: str) -> TrueloopError:
    return Code.STO_UNKNOWN.refusal(
        f"nothing in the store is called {what!r}",
        hint="name a part by serial number, TYPE/SERIAL or label, a record by its id, a row as `trueloop db find` does",
    )


def shown_row(store: Store, row: NamedRow) -> dict[str, object]:
    """Returns a row as `replace` takes it back: its value in the form of the codec under "value"."""
    kept = row.kept
    stated = {"row": kept.row, "kept_at": kept.kept_at.isoformat(), "by": kept.by, "why": kept.why}
    links = {"supersedes": kept.supersedes, "superseded_by": kept.superseded_by}
    return {"kind": row.kind.table, **stated, **links, "value": store.codec.plain(kept.value)}


def replace_row(store: Store, row: NamedRow, file: Path, *, by: str, why: str) -> Kept[Any]:
    """Keeps the value in a file in the stead of a row.

    Raises STO-IMPORT for a file that holds no value of its kind or the very one that is there, STO-DIFFERS where the
    row is superseded already.
    """
    value = _value(store, file, row)
    if value == row.kept.value:
        raise _refused(file, f"it holds what row {row.kept.row} holds already")
    return keep(store, [value], row.kept.row, by=by, why=why)[0]


def left_behind(store: Store, row: NamedRow, kept: Kept[Any]) -> list[str]:
    """Links that still name a row that was replaced by one of another identity."""
    old = row.kept.value.identity
    if old == kept.value.identity or not isinstance(kept.value, Inspection | Cut):
        return []
    asked: dict[str, Any] = {"identity" if isinstance(kept.value, Inspection) else "cut": joined(old)}
    return [row_name(InspectionLink, one.row) for one in find(store, InspectionLink, **asked)]


def _value(store: Store, file: Path, row: NamedRow) -> Any:
    text = read_text(file, Code.STO_IMPORT, hint=HINT)
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as wrong:
        raise _refused(file, f"no JSON: {str(wrong)!r}", getattr(wrong, "lineno", None)) from wrong
    if not isinstance(content, dict) or "value" not in content:
        raise _refused(file, "an object with a 'value' is wanted")
    with in_file(file):
        value: Any = store.codec.value(content["value"], row.kind.type)
    return value
