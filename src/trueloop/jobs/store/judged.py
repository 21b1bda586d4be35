"""A finished part judged by what its edge's earlier parts predict of it: alarms, and what is not to be learned from."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

from scipy.special import ndtr

from trueloop.domain.life import Quarantine, Stage
from trueloop.errors import Code, Finding, Severity
from trueloop.jobs.store.history import LivedPart, errors_of, quarantine_of
from trueloop.jobs.store.of_this_part import link_of
from trueloop.jobs.store.tool_history import history_of_tool
from trueloop.jobs.user import user_name
from trueloop.loops.turned.made_parts import name_of
from trueloop.loops.turned.outcome import Obtained, obtained
from trueloop.memory.noticing.notice import PartChanges, notice_part, of_left_out
from trueloop.storage.store import Store

BY: Final = "trueloop"
"""Who quarantines here. What a person said of a cut is not changed by judging the same inspection again."""

LEARNED: Final = "look what happened before the next part is cut: this one is kept, and later parts learn from it"
IN_QUARANTINE: Final = (
    "it is kept in quarantine: nothing is learned from it. Where the correction was not run, or another program was, "
    f"--ran or --program says so, with --supersede; --accept {Code.MEM_ALARM} learns from it as it is"
)


@dataclass(frozen=True)
class JudgedParts:
    """The judgement of one call's finished parts: expected against obtained, alarms, and quarantines to keep."""

    obtained: tuple[Obtained, ...] = ()
    findings: tuple[Finding, ...] = ()
    words: tuple[Quarantine, ...] = ()


def judged_parts(store: Store, parts: Sequence[LivedPart], accept: Collection[str]) -> JudgedParts:
    """Judges parts that are about to be kept, one after the other: one in quarantine teaches nothing of the next.

    Each by the parts that its edge cut before it. With MEM-ALARM among `accept` a part is learned from all the same.
    """
    compared, findings, words, learned = list[Obtained](), list[Finding](), list[Quarantine](), list[LivedPart]()
    for lived in parts:
        seen = _noticed(store, lived, learned)
        word = _word(store, lived, seen, Code.MEM_ALARM in accept)
        last = word or quarantine_of(store, lived.cut)
        learns = last is None or last.lifted
        compared += _compared(lived)
        findings += alarms_of(lived.cut.part.serial, seen, learns)
        words += [] if word is None else [word]
        learned += [lived] if learns else []
    return JudgedParts(tuple(compared), tuple(findings), tuple(words))


def _noticed(store: Store, lived: LivedPart, earlier: Sequence[LivedPart]) -> PartChanges:
    """Returns what the finish inspection shows beyond earlier parts; nothing where no edge is stated."""
    if lived.cut.setting is None or lived.finish is None:
        return PartChanges()
    edge, part = lived.cut.setting.edge, lived.cut.part
    others = [lived_part for lived_part in earlier if lived_part.cut.identity != lived.cut.identity]
    own = (name_of(part.part_type), part.serial)
    history = history_of_tool(store, edge, [*others, lived], lived.of_machine, own)
    at = next(
        (
            k
            for k, made_part in enumerate(history)
            if made_part.order >= 0 and (made_part.part_type, made_part.serial) == own
        ),
        None,
    )
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


def _compared(lived: LivedPart) -> Iterator[Obtained]:
    profile = lived.correction.payload.profile
    found = None if lived.finish is None else errors_of(profile, lived.finish)
    compared = None if found is None else obtained(lived.correction.payload, lived.cut, found)
    if compared is not None:
        yield compared


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
