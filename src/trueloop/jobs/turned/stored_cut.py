"""Facts in a store of how a measured part was cut."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from trueloop.domain.life import Cut, Ran, Stage
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, sha256_of
from trueloop.errors import Code, in_file
from trueloop.jobs.store.of_this_part import cuts_of
from trueloop.jobs.turned.cut_with import (
    is_of_cut,
    is_of_edge,
    require_another_part,
    require_later,
    require_tool,
    stored_words,
    with_possible,
)
from trueloop.loops.turned import correction as turned
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.in_force import HINT, InForce, in_force
from trueloop.loops.turned.made_parts import program_that_ran
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find


def with_stored_cut(store: Store, inputs: Inputs, part: Part) -> Inputs:
    """Inputs with what cut the finished part that was measured: as the job states it, else as the store knows it; else
    with the stored corrections of its program by which it may have been cut.

    Raises STO-LINK for a correction that the store does not hold, CMP-CUT-WITH and CMP-OTHER-PROGRAM.
    """
    force = inputs.in_force
    if not inputs.measured_finished:
        return inputs
    if force.stated:
        return replace(inputs, in_force=_with_program(store, force))
    with in_file(inputs.file):
        if force.stored:
            one = _correction(store, force.stored)
            if inputs.called is not None and not is_of_edge(one.record, inputs.called.called):
                return replace(inputs, in_force=InForce(stated=True))
            require_tool(one.record, inputs)
            require_later(one.record, inputs.inspections, Path(inputs.file or ""), time_needed=False)
            found = _of(one, force.by, inputs)
            require_another_part(one.record, inputs.inspections)
            return replace(inputs, in_force=found)
        cut = next(iter(reversed(cuts_of(store, part, Stage.FINISH))), None)
        if cut is not None and (cut.correction or cut.program_sha256):
            return replace(inputs, in_force=_of_cut(store, cut, inputs))
    of_program = find(store, Correction, program_sha256=sha256_of(inputs.program.source))
    known = [one.value.record for one in of_program]
    beside = tuple(one for one in force.possible if not any(of.id in one for of in known))
    stored = with_possible(inputs, [(record, stored_words(record)) for record in known if is_of_cut(record, inputs)])
    notes = inputs.notes if beside else tuple(dict.fromkeys(stored.notes))
    return replace(stored, in_force=replace(force, possible=(*beside, *stored.in_force.possible)), notes=notes)


def _with_program(store: Store, force: InForce) -> InForce:
    """With the hash of the program that ran, where the store holds its correction."""
    cut = force.cut_with
    if not cut.corrected:
        return force
    held = find(store, Correction, identity=joined((cut.correction,)))
    sha256 = _sha256([stored.value for stored in held], cut.ran) or cut.program_sha256
    return replace(force, cut_with=replace(cut, program_sha256=sha256))


def _sha256(held: Sequence[Correction[turned.Correction]], ran: Ran) -> str:
    payloads = [correction.payload for correction in held if isinstance(correction.payload, turned.Correction)]
    return payloads[-1].programs_sha256.get(ran, "") if payloads else ""


def _correction(store: Store, record_id: str) -> Correction[turned.Correction]:
    held = [stored.value for stored in find(store, Correction, identity=joined((record_id,)))]
    if held:
        return held[-1]
    hint = f"{HINT}; of several tools or set-ups the path to their `part.json`"
    raise Code.STO_LINK.refusal(f"{store.where!r} has no correction {record_id!r}", hint=hint, values={"serial": ""})


def _of(correction: Correction[turned.Correction], by: Ran | None, inputs: Inputs) -> InForce:
    found = in_force(correction.record, by, inputs.program, inputs.lines)
    sha256 = _sha256([correction], found.cut_with.ran)
    return replace(found, cut_with=replace(found.cut_with, program_sha256=sha256), stated=True)


def _of_cut(store: Store, cut: Cut, inputs: Inputs) -> InForce:
    """As the cut of this part was kept."""
    if not cut.correction:
        return InForce(stated=True)
    one = _correction(store, cut.correction)
    return _of(one, program_that_ran(one.payload, cut), inputs)
