"""The finish cut that an inspection shows: with which correction, by which of its programs, under which conditions."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from trueloop.domain.life import Cut, CuttingConditions, InspectionLink, Ran, Stage
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, Record, sha256_of
from trueloop.domain.tool import Setting
from trueloop.errors import Code, Finding, Severity
from trueloop.jobs.store.of_this_part import cuts_of
from trueloop.loops.turned import correction as turned
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
    """The last one of them that has what the loop gave, and is for this part."""
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
    """Which program a text is; None: one that its control or a person changed, as its mark alone says."""
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
