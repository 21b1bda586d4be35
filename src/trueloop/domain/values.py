"""The registry of values that are stored: which types a document may hold, and under which names."""

from typing import Final

from trueloop.domain.characteristic import Characteristic, Judged, Judgement, Quantity
from trueloop.domain.codec import Codec
from trueloop.domain.factory import Block, BlockKind, Conditions, FactKind, Route, Run, RunFact, WorkOrder
from trueloop.domain.inspection import BothInspections, CmmPoint, Inspection, MachineStood, Reading, StandardPart, Touch
from trueloop.domain.life import (
    Cut,
    CuttingConditions,
    EdgeEvent,
    EdgeEventKind,
    InspectionLink,
    Quarantine,
    Ran,
    Stage,
)
from trueloop.domain.part import Part, PartType
from trueloop.domain.proposal import (
    Effect,
    HeldTool,
    ModelDecision,
    ModelVersion,
    PartCutWith,
    Proposal,
    ProposalClass,
    ProposalDecision,
    TableRow,
    ToolOffset,
)
from trueloop.domain.record import ChangedWord, Component, CutWith, Product, Program, ProgramText, Record
from trueloop.domain.tool import Edge, Machine, Setting, Tool

CODEC: Final = Codec.of(
    *(PartType, Part, Machine, Tool, Edge, Setting, Program, ProgramText),
    *(ToolOffset, TableRow, HeldTool),
    *(Characteristic, Quantity, Judged, Judgement),
    *(Inspection, Touch, Reading, CmmPoint),
    *(Cut, CutWith, Ran, Stage, CuttingConditions, InspectionLink, Quarantine, EdgeEvent, EdgeEventKind),
    *(Record, ChangedWord, Component, Product),
    *(BothInspections, MachineStood, ModelVersion, ModelDecision, StandardPart),
    *(WorkOrder, Route, Block, BlockKind, Conditions, Run, RunFact, FactKind),
    *(Proposal, ProposalClass, ProposalDecision, Effect, PartCutWith),
)
