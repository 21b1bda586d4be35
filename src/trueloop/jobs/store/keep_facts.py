"""Keeping what a command found: in one transaction, the same facts once, and in words what was new."""

from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

from trueloop.domain.inspection import Inspection, StandardPart
from trueloop.domain.life import Cut, Quarantine
from trueloop.domain.model_version import ModelDecision, ModelVersion
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, ProgramText, sha256_of
from trueloop.errors import Code, Finding, TrueloopError
from trueloop.storage.keeping import Keeping
from trueloop.storage.kinds import joined
from trueloop.storage.store import Kept, Store, find

if TYPE_CHECKING:
    from trueloop.loops.turned.outcome import Obtained

T = TypeVar("T")

NAMES: Final[dict[type, tuple[str, str]]] = {
    Part: ("part", "parts"),
    Inspection: ("inspection", "inspections"),
    Cut: ("cut", "cuts"),
    Correction: ("correction", "corrections"),
    ProgramText: ("program", "programs"),
    Quarantine: ("quarantine", "quarantines"),
    ModelVersion: ("version of a model", "versions of a model"),
    ModelDecision: ("decision on a model", "decisions on models"),
    StandardPart: ("standard part", "standard parts"),
}
"""Kinds that are reported as kept, in this order; links and names that the store adds are not reported."""
LIFTED: Final = ("quarantine lifted", "quarantines lifted")


@dataclass(frozen=True)
class KeptFacts:
    """The values that a command kept: the store, the values as stored, and the findings about them.

    `obtained` compares inspections after a finish cut with what was expected of it. `made`: the store was made by it.
    """

    where: str
    kept: tuple[Kept[Any], ...]
    findings: tuple[Finding, ...] = ()
    obtained: "tuple[Obtained, ...]" = ()
    made: bool = False

    @property
    def new(self) -> tuple[Kept[Any], ...]:
        """Returns those that were not there before."""
        return tuple(stored for stored in self.kept if stored.new)

    @property
    def words(self) -> str:
        """Returns one line: what is new, or that nothing is."""
        counts = Counter(_names(stored.value) for stored in self.new)
        said = [f"{counts[names]} {names[counts[names] > 1]}" for names in (*NAMES.values(), LIFTED) if counts[names]]
        if not said:
            return f"{self.where}: all of it is kept already"
        return f"kept in {'the new store ' * self.made}{self.where}: {', '.join(said)}"


def _names(value: object) -> tuple[str, str] | None:
    return LIFTED if isinstance(value, Quarantine) and value.lifted else NAMES.get(type(value))


def keep_facts(
    store: Store, values: Iterable[Any], findings: Iterable[Finding] = (), *, supersede: bool = False
) -> KeptFacts:
    """Keeps values, all or none. With `supersede` a stored one of the same identity and another content gives way.

    A correction that differs from the stored one only in when and by whom it was made is the stored one. Raises
    STO-DIFFERS, STO-WRITE and STO-BUSY.
    """
    given, made = list(values), store.unmade
    store = store.made()
    given = [as_stored(store, one) for one in given]
    rows = [_row_of_other(store, one) if supersede else None for one in given]
    with _naming_override(), store.writing() as connection:
        keeping = Keeping(store.codec, connection, why="--supersede" if supersede else "")
        kept = [keeping.keep(one, row) for one, row in zip(given, rows, strict=True)]
    return KeptFacts(store.where, tuple(kept), tuple(findings), made=made)


@contextmanager
def _naming_override() -> Iterator[None]:
    """Names the override for a value that differs from the stored one."""
    try:
        yield
    except TrueloopError as refused:
        if refused.code is Code.STO_DIFFERS and refused.override is None:
            refused.override = "--supersede"
        raise


def latest(store: Store, value: T) -> Kept[T] | None:
    """Returns the stored value of the same type and identity that counts; None: there is none."""
    identity = joined(tuple(map(str, value.identity)))  # type: ignore[attr-defined]
    return next(iter(reversed(find(store, type(value), identity=identity))), None)


def as_stored(store: Store, value: Any) -> Any:
    """Returns a correction with the time and the name of the stored one, where these are all that differs."""
    known = latest(store, value) if isinstance(value, Correction) else None
    if known is None:
        return value
    old = known.value.record
    # The correction as made then, by that person and version; also in a payload that repeats the record
    record = replace(value.record, made_at=old.made_at, made_by=old.made_by, trueloop_version=old.trueloop_version)
    payload = value.payload
    if getattr(payload, "record", None) == value.record:
        payload = replace(payload, record=record)
    same = replace(value, record=record, payload=payload)
    return same if store.codec.to_json(same) == store.codec.to_json(known.value) else value


def texts_of(programs: Iterable[bytes | None]) -> list[ProgramText]:
    """Programs by their hashes, each once."""
    return [
        ProgramText(sha, text) for sha, text in {sha256_of(program): program for program in programs if program}.items()
    ]


def _row_of_other(store: Store, value: Any) -> int | None:
    """The row of a stored value that has the same identity and another content."""
    known = latest(store, value)
    return None if known is None or store.codec.to_json(known.value) == store.codec.to_json(value) else known.row
