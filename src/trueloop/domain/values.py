"""The registry of values that are stored: which types a document may hold, and under which names."""

from typing import Final

from trueloop.domain.both_inspections import BothInspections, MachineStood
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.codec import Codec
from trueloop.domain.cut_with import CutWith
from trueloop.domain.factory import Block, BlockKind, Conditions, FactKind, Route, Run, RunFact, WorkOrder
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.domain.judged import Judged, Judgement
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
from trueloop.domain.machine import Machine
from trueloop.domain.model_version import ModelDecision, ModelVersion
from trueloop.domain.part import Part, PartType
from trueloop.domain.program import Program, ProgramText
from trueloop.domain.proposal import Effect, PartCutWith, Proposal, ProposalClass, ProposalDecision
from trueloop.domain.record import ChangedWord, Component, Product, Record
from trueloop.domain.standard_part import StandardPart
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.domain.tool_offset import HeldTool, TableRow, ToolOffset

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
