"""What the store keeps: each type of value, its table, and the columns by which it is found.

A row holds the value whole as a JSON document (`domain.codec`), so that nothing is lost and every type is stored alike;
columns repeat what it is searched by. A new type of value is one line in `KINDS`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from trueloop.domain.correction import Correction
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, EdgeEvent, InspectionLink, Quarantine
from trueloop.domain.machine import Machine
from trueloop.domain.part import Part, PartType
from trueloop.domain.program import Program, ProgramText
from trueloop.domain.proposal import Proposal, ProposalDecision
from trueloop.domain.tool import Edge, Setting, Tool

Columns = Mapping[str, str | None]


@dataclass(frozen=True)
class Kind:
    """A type of value and its table. `columns` gives what a value is found by, all of it text."""

    table: str
    type: type
    columns: Callable[[Any], Columns]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the columns."""
        return SEARCHED[self.table]


def joined(identity: tuple[str, ...]) -> str:
    """An identity as one text: no part of it may hold the separator, and JSON's quotes would cost an index bytes."""
    return "\x1f".join(identity)


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
}

KINDS: Final[tuple[Kind, ...]] = (
    Kind("part_type", PartType, lambda one: {"part_type": one.name}),
    Kind("part", Part, _of_part),
    Kind("machine", Machine, lambda one: {"machine": one.name}),
    Kind("tool", Tool, lambda one: {"tool": one.identity[0]}),
    Kind("edge", Edge, lambda one: {"tool": one.tool.identity[0]}),
    Kind("setting", Setting, lambda one: {"edge": joined(one.edge.identity)}),
    Kind("program", Program, lambda one: {"program_sha256": one.sha256}),
    Kind("program_text", ProgramText, lambda one: {"program_sha256": one.sha256}),
    Kind("cut", Cut, _of_cut),
    Kind("inspection", Inspection, lambda one: {**_of_part(one.part), "file_sha256": one.sha256}),
    Kind("inspection_link", InspectionLink, lambda one: {"cut": joined(one.cut)}),
    Kind("quarantine", Quarantine, lambda one: {"cut": joined(one.cut)}),
    Kind("edge_event", EdgeEvent, lambda one: {"edge": joined(one.edge.identity), "event": one.kind}),
    Kind("correction", Correction, _of_correction),
    Kind("proposal", Proposal, lambda one: {"part_type": one.part_type.name, "changes": one.changes}),
    Kind("proposal_decision", ProposalDecision, lambda one: {"verdict": one.verdict}),
)
