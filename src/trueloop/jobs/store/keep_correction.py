"""A turned part's correction as facts for the store: the part, what was measured, what was cut, what is to be run."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Ran, Stage
from trueloop.domain.part import Part
from trueloop.domain.record import Correction as StoredCorrection
from trueloop.domain.record import sha256_of
from trueloop.domain.tool import Edge, Setting
from trueloop.errors import Code, Finding, Severity
from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts, texts_of
from trueloop.jobs.store.of_this_part import (
    cuts_of,
    finished_already,
    require_file_of_part,
    require_later,
    require_serial,
)
from trueloop.jobs.store.opened import Keeping, accepting
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.provenance import enveloped
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find
from trueloop.wording import first_of


def parts_without_inspection(store: Store, edge: Edge) -> tuple[Part, ...]:
    """Parts with a correction for this edge and no inspection of their finish cut, in the order of corrections."""
    found = find(store, StoredCorrection, edge=joined(edge.identity))
    parts = {
        inspection.part.identity: inspection.part for kept in found for inspection in kept.value.record.inspections
    }
    return tuple(part for part in parts.values() if not _is_inspected(store, part))


def without_inspection(store: Store, edge: Edge, but: Part) -> Iterator[Finding]:
    """Yields a note of the parts of an edge whose finish cut was not inspected, besides the one at hand."""
    parts = [part for part in parts_without_inspection(store, edge) if part.identity != but.identity]
    if parts:
        serials = [part.serial for part in parts]
        yield Finding(
            Severity.NOTE,
            Code.STO_OPEN,
            f"{len(parts)} parts of this edge have a correction and no finish inspection: "
            f"{first_of([*map(repr, serials)], SHOWN)}; they "
            "teach nothing of the finish cut",
            hint="hand it in: `trueloop measure read FILE --job JOB.toml --after finish`, with --ran as-programmed "
            "where the correction was not run",
            values={"serials": serials[:SHOWN]},
        )


SHOWN = 6


def _is_inspected(store: Store, part: Part) -> bool:
    return any(find(store, InspectionLink, cut=joined(cut.identity)) for cut in cuts_of(store, part, Stage.FINISH))


def keep_correction(store: Store, inputs: Inputs, correction: Correction, keeping: Keeping) -> KeptFacts:
    """Keeps a correction with all it is made from, or nothing. Raises STO-PART, STO-OTHER-PART, STO-CLOCK."""
    return keep_corrections(store, [(inputs, correction)], keeping)


def keep_corrections(store: Store, made: Sequence[tuple[Inputs, Correction]], keeping: Keeping) -> KeptFacts:
    """Keeps several corrections, each of a part of its own: all of them or none."""
    facts, findings = list[Any](), list[Finding]()
    for inputs, correction in made:
        part = part_of(inputs)
        require_serial(part, Path(inputs.file or "the job").name)
        noticed = [*_unknown_edge(inputs, part), *finished_already(store, inputs.inspections, inputs.measured_finished)]
        for inspection in inputs.inspections:
            require_file_of_part(store, inspection)
            with accepting(keeping.accept, noticed):
                require_later(
                    ("the setting of the edge", inputs.edge_set_at), ("the inspection", inspection.measured_at)
                )
        if inputs.edge is not None:
            noticed += without_inspection(store, inputs.edge, part)
        findings += noticed
        # The cut whose surface was measured: of a finished part its finish cut, with what was in force. The edge is as
        # the record has it, with the radius that the job states.
        finished, force, record = inputs.measured_finished, inputs.in_force.cut_with, correction.record
        cutting = inputs.program if finished else inputs.semifinish
        sha256 = "" if cutting is None else sha256_of(cutting.source)
        touched = _as_known(
            store,
            Cut(
                part=part_of(inputs),
                stage=Stage.FINISH if finished else Stage.SEMIFINISH,
                setting=None if record.edge is None else Setting(record.edge, record.edge_set_at),
                machine=record.machine,
                program_sha256=force.program_sha256 if force.corrected else sha256,
                correction=force.correction,
                offset_entered=force.ran is Ran.WEAR,
            ),
        )
        facts += facts_of(inputs, correction, touched)
    return keep_facts(store, facts, findings, supersede=keeping.supersede)


def part_of(inputs: Inputs) -> Part:
    """Returns the part that was measured."""
    serials = [inspection.part.serial for inspection in inputs.inspections if inspection.part.serial]
    return Part(inputs.part, serials[0] if serials else "")


def facts_of(inputs: Inputs, correction: Correction, touched: Cut) -> tuple[Any, ...]:
    """Returns the facts that a correction states."""
    semifinish = None if inputs.semifinish is None else inputs.semifinish.source
    texts = (correction.source_program, semifinish, correction.corrected_program, correction.offsets_program)
    return (touched.part, touched, *_inspected(inputs.inspections, touched), *texts_of(texts), enveloped(correction))


def _as_known(store: Store, cut: Cut) -> Cut:
    """The cut as kept with an earlier inspection, if of this program; what was in force as the correction has it."""
    known = next(iter(reversed(cuts_of(store, cut.part, cut.stage))), None)
    if known is None:
        return cut
    if cut.stage is Stage.FINISH:
        return replace(
            known,
            correction=cut.correction,
            program_sha256=cut.program_sha256 or known.program_sha256,
            offset_entered=cut.offset_entered,
        )
    return known if known.program_sha256 == cut.program_sha256 else cut


def _inspected(inspections: tuple[Inspection, ...], cut: Cut) -> Iterator[Inspection | InspectionLink]:
    for inspection in inspections:
        yield inspection
        yield InspectionLink(inspection.identity, cut.identity)


def _unknown_edge(inputs: Inputs, part: Part) -> Iterator[Finding]:
    if inputs.edge is None:
        yield Finding(
            Severity.WARNING,
            Code.STO_EDGE,
            f"the edge that cuts part {part.serial!r} is not stated: the part is kept, and teaches nothing of an edge",
            hint="name it in the job's table [tool]: `name`, `insert`, `corner`",
            values={"serial": part.serial},
        )
