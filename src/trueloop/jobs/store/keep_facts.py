"""Keeping what a command found: in one transaction, the same facts once, and in words what was new.

Finished parts are judged by the earlier parts of their edge before they are kept.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any, Final, TypeVar

from scipy.special import ndtr

from trueloop.domain.inspection import Inspection, StandardPart
from trueloop.domain.life import Cut, Quarantine, Stage
from trueloop.domain.part import Part
from trueloop.domain.proposal import ModelDecision, ModelVersion
from trueloop.domain.record import Correction, ProgramText, sha256_of
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.jobs.store.history import LivedPart, finish_errors, quarantine_of
from trueloop.jobs.store.of_this_part import link_of
from trueloop.jobs.store.tool_history import history_of_tool
from trueloop.jobs.user import user_name
from trueloop.loops.turned.made_parts import name_of
from trueloop.loops.turned.outcome import Obtained, obtained
from trueloop.memory.noticing import PartChanges, notice_part, of_left_out
from trueloop.storage.keeping import Keeping
from trueloop.storage.kinds import joined
from trueloop.storage.store import Kept, Store, find

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
    obtained: tuple[Obtained, ...] = ()
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


BY: Final = "trueloop"
"""Who quarantines here. What a person said of a cut is not changed by judging the same inspection again."""

LEARNED: Final = "look what happened before the next part is cut: this one is kept, and later parts learn from it"
IN_QUARANTINE: Final = (
    "it is kept in quarantine: nothing is learned from it. Where the correction was not run, or another program was, "
    f"state that with --ran or --program and --supersede; --accept {Code.MEM_ALARM} learns from it as it is"
)


def judged_parts(
    store: Store, parts: Sequence[LivedPart], accept: Collection[str]
) -> tuple[list[Obtained], list[Finding], list[Quarantine]]:
    """Judges parts that are about to be kept, one after the other: one in quarantine teaches nothing of the next.

    Each by the parts that its edge cut before it. With MEM-ALARM among `accept` a part is learned from all the same.
    Returns expected against obtained, alarms, and quarantines to keep.
    """
    compared, findings, words, learned = list[Obtained](), list[Finding](), list[Quarantine](), list[LivedPart]()
    for lived in parts:
        seen = _noticed(store, lived, learned)
        word = _word(store, lived, seen, Code.MEM_ALARM in accept)
        last = word or quarantine_of(store, lived.cut)
        learns = last is None or last.lifted
        found = finish_errors(lived)
        shown = None if found is None else obtained(lived.correction.payload, lived.cut, found)
        compared += [] if shown is None else [shown]
        findings += alarms_of(lived.cut.part.serial, seen, learns)
        words += [] if word is None else [word]
        learned += [lived] if learns else []
    return compared, findings, words


def _noticed(store: Store, lived: LivedPart, earlier: Sequence[LivedPart]) -> PartChanges:
    """Returns what the finish inspection shows beyond earlier parts; nothing where no edge is stated."""
    if lived.cut.setting is None or finish_errors(lived) is None:
        return PartChanges()
    edge, part = lived.cut.setting.edge, lived.cut.part
    others = [other for other in earlier if other.cut.identity != lived.cut.identity]
    own = (name_of(part.part_type), part.serial)
    history = history_of_tool(store, edge, [*others, lived], lived.of_machine, own)
    at = next((k for k, one in enumerate(history) if one.order >= 0 and (one.part_type, one.serial) == own), None)
    return PartChanges() if at is None else notice_part(history[:at], history[at]).get(Stage.FINISH, PartChanges())


def _word(store: Store, lived: LivedPart, changes: PartChanges, accepted: bool) -> Quarantine | None:
    """Returns the quarantine to keep for the cut; None: it stays as it is."""
    last, cut, now = quarantine_of(store, lived.cut), lived.cut.identity, datetime.now(UTC)
    held = last is not None and not last.lifted
    by_person = last is not None and last.by != BY
    if accepted:
        lifts = held or (changes.quarantine and not by_person)
        return Quarantine(cut, now, f"--accept {Code.MEM_ALARM}", user_name(), lifted=True) if lifts else None
    if changes.quarantine:
        known = lived.finish is not None and link_of(store, lived.finish) is not None
        return None if held or (by_person and known) else Quarantine(cut, now, _says(changes), BY)
    lifts = held and not by_person
    return Quarantine(cut, now, "as it is kept now, it is as predicted", BY, lifted=True) if lifts else None


def alarms_of(serial: str, changes: PartChanges, learns: bool) -> Iterator[Finding]:
    """Yields a warning with what may have happened; of a part that teaches, a note of touches all others contradict."""
    if changes.alarms:
        chance = changes.alarms[0].probability
        yield Finding(
            Severity.WARNING,
            Code.MEM_ALARM,
            f"part {serial!r}: {_says(changes)} (by chance with a probability of {chance:.1e})",
            hint=LEARNED if learns else IN_QUARANTINE,
            values={"serial": serial, "probability": chance},
        )
    if changes.left_out and learns:
        chance = float(2 * ndtr(-max(abs(touch.deviations) for touch in changes.left_out)))
        yield Finding(
            Severity.NOTE,
            Code.MEM_ALARM,
            f"part {serial!r}: {'; '.join(of_left_out(touch) for touch in changes.left_out)}",
            hint="the part was judged without it, and it is kept; where it was dirt, inspect again",
            values={"serial": serial, "probability": chance},
        )


def _says(changes: PartChanges) -> str:
    """Returns possible causes, the likeliest first; a correction that did not arrive explains all else."""
    return "; or: ".join(alarm.says for alarm in (changes.alarms[:1] if changes.quarantine else changes.alarms))
