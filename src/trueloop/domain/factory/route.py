"""The route of a part through its steps, frozen as it is ordered: `Block`, `Route`."""

from dataclasses import dataclass, field
from enum import StrEnum
from hashlib import sha256
from typing import Literal

from trueloop.domain.factory.states import PartState


class BlockKind(StrEnum):
    """What one step does with a part [4773 §2.2]."""

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
        """Whether metal is removed: such a step is never repeated by itself."""
        return self in (BlockKind.ROUGH, BlockKind.SEMIFINISH, BlockKind.FINISH)

    @property
    def moves(self) -> bool:
        """Whether a program runs on the machine."""
        return self.cuts or self in (BlockKind.PROBE, BlockKind.INSPECT)

    @property
    def leaves(self) -> PartState:
        """The part's state once it is recorded."""
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
    """What has to hold before a finish cut starts; None: whoever planned the order does without it.

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
        """By which a started order refuses another route."""
        said = [f"{one.kind}\t{one.program_sha256}\t{one.feature}\t{one.corrected}" for one in self.blocks]
        asked = self.conditions
        need = f"{asked.temperature_age_s}\t{asked.calibration_age_s}\t{asked.model_sha256}"
        probe = [self.probe_control, self.probe_toml] if self.probe_toml else []
        return sha256("\n".join([*said, need, self.job_toml, *probe]).encode()).hexdigest()
