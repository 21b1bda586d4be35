"""A wrong row replaced by a right one that names it: the wrong one stays, with who replaced it and why."""

import json
from pathlib import Path
from typing import Any, Final

from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text
from trueloop.jobs.db.found import row_name
from trueloop.jobs.db.named import NamedRow
from trueloop.storage.encoded import Kept
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find, keep

HINT: Final = "take what `trueloop db show ROW --json` printed, with what was wrong in it changed"


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


def _refused(file: Path, why: str, line: int | None = None) -> TrueloopError:
    return TrueloopError(Code.STO_IMPORT, f"{file.name!r}: {why}", hint=HINT, place=Place(str(file), line))
