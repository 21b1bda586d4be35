"""What a person names: a row, a part by serial number or label, a correction by the id of its record."""

import re
from dataclasses import dataclass
from typing import Any, Final

from trueloop.domain.labels import NistPart, PartLabel, names_part, read_label
from trueloop.domain.part import Part
from trueloop.domain.record import Correction
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.db.found import NAMES, row_of
from trueloop.storage.kinds import Kind, joined
from trueloop.storage.store import Kept, Store
from trueloop.storage.store import find as find_values

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
    corrections: list[Kept[Any]] = find_values(store, Correction, identity=joined((what,)))
    if corrections:
        return NamedRow(NAMES["correction"], corrections[-1])
    parts = {part.identity: part for part in _parts(store, what)}
    if not parts:
        raise _unknown(what)
    if len(parts) > 1:
        listed = [f"{part.part_type.name}/{part.serial}" for part in parts.values()]
        raise TrueloopError(
            Code.STO_SEVERAL,
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
    by_serial = [one.value for one in find_values(store, Part, serial=what)]
    kind, slash, serial = what.rpartition("/")
    typed = find_values(store, Part, part_type=kind, serial=serial) if slash else []
    return [*by_serial, *(one.value for one in typed), *_labelled(store, what)]


def _labelled(store: Store, what: str) -> list[Part]:
    """Those that a label means; none where it is no label."""
    try:
        label = read_label(what)
    except TrueloopError:
        return []
    asked: list[dict[str, Any]] = []
    if isinstance(label, NistPart):
        asked = [{"serial": label.number}, {"part_type": label.number, "serial": label.inspection}]
    elif isinstance(label, PartLabel):
        asked = [{"serial": label.copy}] if label.copy else [{"part_type": label.number}]
    return [one.value for by in asked for one in find_values(store, Part, **by) if names_part(label, one.value)]


def _unknown(what: str) -> TrueloopError:
    return TrueloopError(
        Code.STO_UNKNOWN,
        f"nothing in the store is called {what!r}",
        hint="name a part by serial number, TYPE/SERIAL or label, a record by its id, a row as `trueloop db find` does",
    )
