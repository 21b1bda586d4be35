"""Keeps the results of a command in one transaction, each fact once, and reports what was new.

The finish cut that an inspection shows: with which correction, by which of its programs, under which conditions.

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
from trueloop.domain.life import Cut, CuttingConditions, InspectionLink, Quarantine, Ran, Stage
from trueloop.domain.part import Part
from trueloop.domain.proposal import ModelDecision, ModelVersion
from trueloop.domain.record import Correction, ProgramText, Record, sha256_of
from trueloop.domain.tool import Setting
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.jobs.store.history import LivedPart, finish_errors, quarantine_of
from trueloop.jobs.store.of_this_part import cuts_of, link_of
from trueloop.jobs.store.tool_history import history_of_tool
from trueloop.jobs.user import user_name
from trueloop.loops.turned import correction as turned
from trueloop.loops.turned.made_parts import name_of
from trueloop.loops.turned.outcome import Obtained, obtained
from trueloop.memory.noticing import PartChanges, notice_part, of_left_out
from trueloop.storage.keeping import Keeping
from trueloop.storage.kinds import joined
from trueloop.storage.store import Kept, Store, find


@dataclass(frozen=True)
class CutStatement:
    """A person's statements on a finish cut; None: as stored before, else as in the correction.

    `record` is the id of its correction, `program` the text that ran, as the control has it. `minutes` of the edge in
    the cut; `order` counts the parts of the edge as they were cut.
    """

    record: str | None = None
    program: bytes | None = None
    ran: Ran | None = None
    minutes: float | None = None
    order: int | None = None


def correction_of(store: Store, part: Part, statement: CutStatement) -> Correction[turned.Correction]:
    """Returns the stored correction that a part was finished with: by the id, by the program's mark or hash, else as
    its finish cut is known, else its last one.

    Raises STO-LINK where there is none, or where the one named was made for another part.
    """
    if statement.record is not None:
        named = [stored.value for stored in find(store, Correction, identity=joined((statement.record,)))]
        return _whole(store, part, named, f"with the id {statement.record!r}")
    found = find(store, Correction, part_type=part.part_type.name, serial=part.serial)
    of_part = [stored.value for stored in found if _is_about(stored, part)]
    if statement.program is not None:
        marked = [stored.value for stored in find(store, Correction) if _is_of(stored.value, statement.program)]
        own = [
            correction
            for correction in marked
            if any(i.part.identity == part.identity for i in correction.record.inspections)
        ]
        return _whole(store, part, own or marked, "whose program this is")
    cut = next(iter(reversed(cuts_of(store, part, Stage.FINISH))), None)
    if statement.ran is None and cut is not None and cut.correction:
        named = [stored.value for stored in find(store, Correction, identity=joined((cut.correction,)))]
        return _whole(store, part, named or of_part, f"with the id {cut.correction!r}")
    return _whole(store, part, of_part, "of its own")


def said_of_each(store: Store, part_types: Sequence[str], statement: CutStatement) -> list[CutStatement]:
    """Divides what is stated of the cuts of several edges or set-ups by their part types: a record and a program
    are of those that have a correction which it is. Where none has, it is stated of all, and refused there.
    """
    known = [_knows(store, one, statement) for one in part_types]
    if not any(known):
        return [statement] * len(known)
    return [statement if its else replace(statement, record=None, program=None) for its in known]


def _knows(store: Store, part_type: str, statement: CutStatement) -> bool:
    kept: list[Kept[Correction[Any]]] = find(store, Correction, part_type=part_type)
    return any(
        (statement.record is None or stored.value.record.id == statement.record)
        and (statement.program is None or _is_of(stored.value, statement.program))
        for stored in kept
    )


def finish_cut(store: Store, part: Part, correction: Correction[turned.Correction], statement: CutStatement) -> Cut:
    """Makes the finish cut of a part; one that is stored already gets what is stated now. Raises STO-PROGRAM.

    The feed is that of the program; depth of cut and material are given by whoever knows the job.
    """
    record, made = correction.record, correction.payload
    known = next(iter(reversed(cuts_of(store, part, Stage.FINISH))), None)
    ran = statement.ran or (None if statement.program is None else _by_text(made, statement.program))
    new = Cut(
        part=part,
        stage=Stage.FINISH,
        setting=None if record.edge is None else Setting(record.edge, record.edge_set_at),
        machine=record.machine,
        program_sha256=_sha256(made, ran, part),
        correction="" if ran is Ran.AS_PROGRAMMED else record.id,
        offset_entered=(ran or made.recommended) is Ran.WEAR,
    )
    if known is not None and ran is None and statement.record in (None, known.correction):
        new = replace(
            new, correction=known.correction, program_sha256=known.program_sha256, offset_entered=known.offset_entered
        )
    if known is not None and new.correction not in ("", known.correction) and _shown_by(store, known, record):
        raise Code.STO_LINK.refusal(
            f"correction {record.id} was made from an inspection of the finish cut that part {part.serial!r} is stored "
            "with: it was not in force in that cut",
            hint="a part that was cut again is a part of its own in the store: state another serial number in the "
            f"file, as {part.serial}-2, and the correction that ran: --record {record.id}",
            values={"serial": part.serial},
        )
    before = CuttingConditions() if known is None else known.conditions
    order = None if known is None else known.order
    minutes = before.time_in_cut_min if statement.minutes is None else statement.minutes
    return replace(
        new,
        at=None if known is None else known.at,
        order=order if statement.order is None else statement.order,
        order_in_doubt=known is not None and known.order_in_doubt,
        conditions=replace(before, time_in_cut_min=minutes),
    )


def _shown_by(store: Store, cut: Cut, record: Record) -> bool:
    """Returns whether an inspection that a record is from shows this cut."""
    links = [
        link
        for inspection in record.inspections
        for link in find(store, InspectionLink, identity=joined(inspection.identity))
    ]
    return any(joined(link.value.cut) == joined(cut.identity) for link in links)


def made_for_other(store: Store, correction: Correction[Any], part: Part) -> str | None:
    """Returns the serial number of another part whose semi-finished surface gave a correction; None: of none."""
    inspections = correction.record.inspections
    if not inspections or any(inspection.part.identity == part.identity for inspection in inspections):
        return None
    semifinish = {joined(cut.identity) for cut in cuts_of(store, inspections[0].part, Stage.SEMIFINISH)}
    links = find(store, InspectionLink, identity=joined(inspections[0].identity))
    return inspections[0].part.serial if any(joined(link.value.cut) in semifinish for link in links) else None


def _is_about(kept: Kept[Correction[Any]], part: Part) -> bool:
    return any(inspection.part.identity == part.identity for inspection in kept.value.record.inspections)


def _is_of(correction: Correction[Any], program: bytes) -> bool:
    return correction.record.id.encode() in program or (
        isinstance(correction.payload, turned.Correction)
        and sha256_of(program) in correction.payload.programs_sha256.values()
    )


def _whole(
    store: Store, part: Part, corrections: Iterable[Correction[Any]], which: str
) -> Correction[turned.Correction]:
    """Returns the latest of them that holds a result of the loop and is for this part."""
    whole = [correction for correction in corrections if isinstance(correction.payload, turned.Correction)]
    if not whole:
        raise Code.STO_LINK.refusal(
            f"{store.where!r} has no correction {which} for part {part.serial!r}",
            hint="keep it: `trueloop compensate JOB.toml --serial NUMBER`; or name its id by --record",
            values={"serial": part.serial},
        )
    other = made_for_other(store, whole[-1], part)
    if other is not None:
        raise Code.STO_LINK.refusal(
            f"correction {whole[-1].record.id} was made from touches of part {other!r}, not of part {part.serial!r}",
            hint="name the serial number of the part that was inspected, or the record of its own correction",
            values={"serial": part.serial},
        )
    return whole[-1]


def _by_text(made: turned.Correction, program: bytes) -> Ran | None:
    """Returns the program that a text is; None where it was changed after its correction: only its mark is left."""
    sha256, hashes = sha256_of(program), made.programs_sha256
    return next((ran for ran in (made.recommended, *Ran) if hashes.get(ran) == sha256), None)


def _sha256(made: turned.Correction, ran: Ran | None, part: Part) -> str:
    hashes = made.programs_sha256
    ran = ran or made.recommended
    if ran not in hashes:
        raise Code.STO_PROGRAM.refusal(
            f"correction {made.record.id} of part {part.serial!r} has no program {str(ran)!r}",
            hint=f"it has {', '.join(map(str, hashes))}",
            values={"serial": part.serial, "correction": made.record.id},
        )
    return hashes[ran]


def is_changed(correction: Correction[turned.Correction], part: Part, statement: CutStatement) -> Iterator[Finding]:
    """Yields a warning where the text that ran has the correction's mark and is not one of its programs."""
    if statement.program is not None and _by_text(correction.payload, statement.program) is None:
        record = correction.record.id
        yield Finding(
            Severity.WARNING,
            Code.STO_PROGRAM,
            f"the program that part {part.serial!r} was finished with has the mark of correction {record}, and is none "
            "of its programs: it was changed, by the control or by hand",
            hint="`trueloop nc diff` shows whether its path is another; it is taken for the one that was to be run",
            values={"serial": part.serial, "correction": record},
        )


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
