"""Kinds of values that a store keeps: type, table, the columns by which it is searched, and what it refers to.

A row holds the value as a JSON document (`domain.codec`), so that nothing is lost and every type is stored alike;
columns repeat what it is searched by. A new type of value is one line in `KINDS` and in
`SEARCHED`.
"""

import hashlib
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from trueloop.domain.factory import Run, RunFact, WorkOrder
from trueloop.domain.inspection import BothInspections, Inspection, StandardPart
from trueloop.domain.life import Cut, EdgeEvent, InspectionLink, Quarantine
from trueloop.domain.part import Part, PartType
from trueloop.domain.proposal import ModelDecision, ModelVersion, PartCutWith, Proposal, ProposalDecision
from trueloop.domain.record import Correction, Program, ProgramText
from trueloop.domain.tool import Edge, Machine, Setting, Tool

Columns = Mapping[str, str | None]

LONGEST: Final = 500
"""Characters of a column's text: an index of PostgreSQL takes 2,700 bytes. A longer one is known by its hash."""

HALVES: Final = re.compile("[\ud800-\udfff]")
"""Characters that no text of a database may have, besides U+0000."""


@dataclass(frozen=True)
class Kind:
    """A type of value and its table.

    `columns` gives what a value is found by, all of it text. `refers` gives the values named inside it that are kept
    with it. `aside` is a field that is stored apart from the document, since few who look for the value want it.
    """

    table: str
    type: type
    columns: Callable[[Any], Columns]
    refers: Callable[[Any], Iterable[Any]] = lambda _: ()
    aside: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Returns the names of the columns."""
        return SEARCHED[self.table]

    @property
    def words(self) -> str:
        """Returns its name in a message."""
        return self.table.replace("_", " ")


def joined(identity: tuple[str, ...]) -> str:
    """Returns an identity as one text: different identities are different texts."""
    return "\x1f".join(str(one).replace("\\", "\\\\").replace("\x1f", "\\u001f") for one in identity)


def searchable(text: str | None) -> str | None:
    """Returns a text in the form of a column: its hash where it is too long for an index or no text of a database."""
    if text is None or (len(text) <= LONGEST and "\x00" not in text and not HALVES.search(text)):
        return text
    return "sha256:" + hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def storable(document: str) -> str:
    """Returns a JSON document as a database takes it: half a character of UTF-16, as in file names, is escaped."""
    return HALVES.sub(lambda half: f"\\u{ord(half[0]):04x}", document)


def _of_part(part: Part) -> Columns:
    return {"part_type": part.part_type.name, "serial": part.serial}


def _of_cut(cut: Cut) -> Columns:
    edge = None if cut.setting is None else joined(cut.setting.edge.identity)
    return {**_of_part(cut.part), "stage": cut.stage, "edge": edge, "correction": cut.correction}


def _of_correction(correction: Correction[Any]) -> Columns:
    record = correction.record
    first = record.inspections[0].part if record.inspections else None
    return {
        "part_type": None if record.part_type is None else record.part_type.name,
        "serial": None if first is None else first.serial,
        "edge": None if record.edge is None else joined(record.edge.identity),
        "program_sha256": correction.source_sha256,
        "product": record.product,
    }


def _named_in_correction(correction: Correction[Any]) -> Iterable[Any]:
    record = correction.record
    named = (record.part_type, record.machine, record.tool, record.edge, record.program)
    return *(one for one in named if one is not None), *(inspection.part for inspection in record.inspections)


SEARCHED: Final[Mapping[str, tuple[str, ...]]] = {
    "part_type": ("part_type",),
    "part": ("part_type", "serial"),
    "machine": ("machine",),
    "tool": ("tool",),
    "edge": ("tool",),
    "setting": ("edge",),
    "program": ("program_sha256",),
    "program_text": ("program_sha256",),
    "cut": ("part_type", "serial", "stage", "edge", "correction"),
    "inspection": ("part_type", "serial", "file_sha256"),
    "inspection_link": ("cut",),
    "quarantine": ("cut",),
    "edge_event": ("edge", "event"),
    "correction": ("part_type", "serial", "edge", "program_sha256", "product"),
    "proposal": ("part_type", "changes"),
    "proposal_decision": ("verdict",),
    "part_cut_with": (),
    "both_inspections": ("part_type", "serial", "machine"),
    "model_version": ("machine", "parent_sha256"),
    "model_decision": ("verdict",),
    "standard_part": ("part_type", "serial"),
    "work_order": ("part_type", "machine"),
    "run": ("work_order", "machine", "part_type", "serial"),
    "run_fact": ("run",),
}

KINDS: Final[tuple[Kind, ...]] = (
    Kind("part_type", PartType, lambda one: {"part_type": one.name}),
    Kind("part", Part, _of_part, lambda one: (one.part_type,)),
    Kind("machine", Machine, lambda one: {"machine": one.name}),
    Kind("tool", Tool, lambda one: {"tool": one.identity[0]}),
    Kind("edge", Edge, lambda one: {"tool": one.tool.identity[0]}, lambda one: (one.tool,)),
    Kind("setting", Setting, lambda one: {"edge": joined(one.edge.identity)}, lambda one: (one.edge,)),
    Kind("program", Program, lambda one: {"program_sha256": one.sha256}),
    Kind("program_text", ProgramText, lambda one: {"program_sha256": one.sha256}),
    Kind("cut", Cut, _of_cut, lambda one: [named for named in (one.part, one.setting, one.machine) if named]),
    Kind(
        "inspection",
        Inspection,
        lambda one: {**_of_part(one.part), "file_sha256": one.sha256},
        lambda one: (one.part,),
        "values",
    ),
    Kind("inspection_link", InspectionLink, lambda one: {"cut": joined(one.cut)}),
    Kind("quarantine", Quarantine, lambda one: {"cut": joined(one.cut)}),
    Kind(
        "edge_event",
        EdgeEvent,
        lambda one: {"edge": joined(one.edge.identity), "event": one.kind},
        lambda one: [named for named in (one.edge, one.machine) if named],
    ),
    Kind("correction", Correction, _of_correction, _named_in_correction, "payload"),
    Kind(
        "proposal",
        Proposal,
        lambda one: {"part_type": one.part_type.name, "changes": one.changes},
        lambda one: (one.part_type,),
    ),
    Kind("proposal_decision", ProposalDecision, lambda one: {"verdict": one.verdict}),
    Kind("part_cut_with", PartCutWith, lambda one: {}),
    Kind(
        "both_inspections",
        BothInspections,
        lambda one: {**_of_part(one.part), "machine": one.machine.name},
        lambda one: (one.part, one.machine),
    ),
    Kind(
        "model_version",
        ModelVersion,
        lambda one: {"machine": one.machine.name, "parent_sha256": one.parent_sha256},
        lambda one: (one.machine,),
    ),
    Kind("model_decision", ModelDecision, lambda one: {"verdict": one.verdict}),
    Kind("standard_part", StandardPart, lambda one: _of_part(one.part), lambda one: (one.part,)),
    Kind(
        "work_order",
        WorkOrder,
        lambda one: {"part_type": one.part_type.name, "machine": one.machine.name},
        lambda one: (one.part_type, one.machine, *one.parts),
    ),
    Kind(
        "run",
        Run,
        lambda one: {"work_order": one.order, "machine": one.machine.name, **_of_part(one.part)},
        lambda one: (one.part, one.machine),
    ),
    Kind("run_fact", RunFact, lambda one: {"run": one.run}),
)


def kind_of(type_: type) -> Kind:
    """Returns the kind of a type of value. Raises TypeError for one that no store keeps."""
    for kind in KINDS:
        if kind.type is type_:
            return kind
    raise TypeError(f"a store keeps no {type_.__name__}")
