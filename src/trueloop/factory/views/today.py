"""The page Today and the wall display: what waits for whom, what the machines do, and what was made."""

from dataclasses import dataclass
from datetime import datetime

from trueloop.domain.factory.route import BlockKind
from trueloop.domain.factory.states import StepState


@dataclass(frozen=True)
class Waiting:
    """Something that a person has to do. `action` is one of decide, review, measure, release, acknowledge, start.

    `subject` is what it is done to: `order`, `part`, `proposal`, `alarm`, with its id.
    """

    action: str
    subject: str
    id: str
    machine: str
    part: str
    said: str
    since: datetime
    role: str


@dataclass(frozen=True)
class MachineNow:
    """What a machine does, as last heard at `at`; None: never heard of. `stale`: longer ago than its limit."""

    name: str
    at: datetime | None
    stale: bool
    state: str
    order: str = ""
    part: str = ""
    block: BlockKind | None = None
    step_state: StepState | None = None
    program: str = ""
    line: int | None = None
    progress: float | None = None
    corrector: str = ""
    temperatures_c: dict[str, float] | None = None


@dataclass(frozen=True)
class Cpk:
    """Cpk of a characteristic from its latest `count` parts with one nominal and limits, with its 95 % interval.

    None: of fewer than `needed` parts, or of values that are all equal, it says nothing.
    """

    part_type: str
    characteristic: str
    cpk: float | None
    low: float | None
    high: float | None
    count: int
    needed: int


@dataclass(frozen=True)
class Made:
    """Counts of today's parts; `cpk` of the characteristics of their types, the least first."""

    made: int
    in_tolerance: int
    held: int
    rejected: int
    cpk: tuple[Cpk, ...]


@dataclass(frozen=True)
class Today:
    """The whole page, as of `at`."""

    at: datetime
    waiting: tuple[Waiting, ...]
    machines: tuple[MachineNow, ...]
    made: Made
