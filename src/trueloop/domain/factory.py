"""The work of a shop: orders and their routes, runs on machines, and the facts known of each run."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from hashlib import sha256
from typing import Literal

from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Machine


class PartState(StrEnum):
    """Of a part; each but `HELD` follows from the last step that was recorded."""

    PLANNED = "planned"
    ROUGHED = "roughed"
    SEMIFINISHED = "semifinished"
    PROBED = "probed"
    CORRECTED = "corrected"
    FINISHED = "finished"
    INSPECTED = "inspected"  # probed on the machine after its finish cut
    REMOVED = "removed"
    MEASURED = "measured"  # on a measuring machine
    RELEASED = "released"
    REJECTED = "rejected"
    HELD = "held"  # a person decides what happens next


class StepState(StrEnum):
    """Of a step: `STARTED` without an end becomes `UNKNOWN`, and never goes back to `WAITING` by itself."""

    WAITING = "waiting"
    OFFERED = "offered"  # a cell client has asked for it
    SENT = "sent"
    VERIFIED = "verified"  # what the control holds was read back and equals what was sent
    STARTED = "started"
    ENDED = "ended"
    RECORDED = "recorded"  # its data are in the store
    UNKNOWN = "unknown"  # whether the cut was made, or how far, nobody knows
    FAILED = "failed"  # surely not made: it may be tried again


class FactKind(StrEnum):
    """A witness's report of a run."""

    SENT = "sent"
    VERIFIED = "verified"
    STARTED = "started"
    ENDED = "ended"
    RECORDED = "recorded"
    FAILED = "failed"
    UNKNOWN = "unknown"


class BlockKind(StrEnum):
    """The work of one step on a part [4773 §2.2]."""

    ROUGH = "rough"
    SEMIFINISH = "semifinish"
    PROBE = "probe"  # on the machine, before the finish cut
    CORRECT = "correct"  # touches to a corrected program: no motion
    FINISH = "finish"
    INSPECT = "inspect"  # on the machine, after the finish cut
    REMOVE = "remove"
    MEASURE = "measure"  # on a measuring machine
    RELEASE = "release"  # a person, or the rules of release, decide

    @property
    def cuts(self) -> bool:
        """Returns whether metal is removed: such a step is never repeated by itself."""
        return self in (BlockKind.ROUGH, BlockKind.SEMIFINISH, BlockKind.FINISH)

    @property
    def moves(self) -> bool:
        """Returns whether a program runs on the machine."""
        return self.cuts or self in (BlockKind.PROBE, BlockKind.INSPECT)

    @property
    def leaves(self) -> PartState:
        """Returns the part's state once it is recorded."""
        return _LEAVES[self]


_LEAVES = {
    BlockKind.ROUGH: PartState.ROUGHED,
    BlockKind.SEMIFINISH: PartState.SEMIFINISHED,
    BlockKind.PROBE: PartState.PROBED,
    BlockKind.CORRECT: PartState.CORRECTED,
    BlockKind.FINISH: PartState.FINISHED,
    BlockKind.INSPECT: PartState.INSPECTED,
    BlockKind.REMOVE: PartState.REMOVED,
    BlockKind.MEASURE: PartState.MEASURED,
    BlockKind.RELEASE: PartState.RELEASED,
}


@dataclass(frozen=True)
class Block:
    """One step: it cuts or gauges, and the next is offered only once it is recorded [4773 §2.2].

    `program_sha256`: of the program that moves, by the hash of its text in the store; empty where none does, and for a
    finish cut whose program the step CORRECT makes from this one (`corrected`).
    """

    kind: BlockKind
    program_sha256: str = ""
    feature: str = ""
    corrected: bool = False


@dataclass(frozen=True)
class Conditions:
    """Conditions that must hold before a finish cut starts; None: the order's plan does without it.

    Temperatures and the calibration of the probe are not older than this. `model_sha256`: of the image that the
    machine's corrector is to hold; empty: it is to be off; None: as it is.
    """

    temperature_age_s: float | None = 1800.0
    calibration_age_s: float | None = 86_400.0
    model_sha256: str | None = None


@dataclass(frozen=True)
class Route:
    """The steps in order, and the job (a project file's text) by which corrections are computed.

    `probe_toml`: the probe that the job names (`gauging.probe`). With it, what a gauging run writes is the log of the
    control `probe_control`: positions of the ball's centre; without it, touches as the job takes them.
    """

    blocks: tuple[Block, ...]
    job_toml: str = ""
    conditions: Conditions = field(default_factory=Conditions)
    probe_toml: str = ""
    probe_control: str = "linuxcnc"
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def sha256(self) -> str:
        """Returns the hash by which a started order refuses another route."""
        said = [f"{block.kind}\t{block.program_sha256}\t{block.feature}\t{block.corrected}" for block in self.blocks]
        asked = self.conditions
        need = f"{asked.temperature_age_s}\t{asked.calibration_age_s}\t{asked.model_sha256}"
        probe = [self.probe_control, self.probe_toml] if self.probe_toml else []
        return sha256("\n".join([*said, need, self.job_toml, *probe]).encode()).hexdigest()


@dataclass(frozen=True)
class WorkOrder:
    """An order as it was planned; what has become of it is the state of its steps. `serials`: one part each."""

    id: str
    part_type: PartType
    machine: Machine
    serials: tuple[str, ...]
    route: Route
    made_at: datetime
    made_by: str
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the order's id."""
        return (self.id,)

    @property
    def parts(self) -> tuple[Part, ...]:
        """Returns the parts in the order in which they are to be made."""
        return tuple(Part(self.part_type, serial) for serial in self.serials)


@dataclass(frozen=True)
class Run:
    """One attempt at one step of one part: it is executed under this key at most once.

    `program_sha256` is of the program as accepted, `sent_sha256` of the text as sent: with the lines by which it
    witnesses itself. `model_sha256`: of the image that the corrector is to hold; empty: it is to be off.
    """

    key: str
    order: str
    part: Part
    step: int
    attempt: int
    machine: Machine
    program_sha256: str = ""
    sent_sha256: str = ""
    model_sha256: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the key."""
        return (self.key,)


@dataclass(frozen=True)
class RunFact:
    """A fact of a run by a witness (the program itself, the cell client, a person), and its time."""

    run: str
    what: FactKind
    at: datetime
    witness: str
    values: Mapping[str, str] = field(default_factory=dict)
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns run, what, witness and time: reported twice it is one fact."""
        return self.run, self.what, self.witness, self.at.isoformat()
