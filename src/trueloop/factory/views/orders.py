"""Orders, programs and transfers."""

from dataclasses import dataclass
from datetime import datetime
from typing import Generic, TypeVar

from trueloop.domain.factory import BlockKind, PartState, StepState


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
    """The state of a machine as last reported at `at`; None: unknown. `stale`: longer ago than its limit."""

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


T = TypeVar("T")


@dataclass(frozen=True)
class Page(Generic[T]):
    """`next` is the cursor of the next page; None: this was the last."""

    items: tuple[T, ...]
    next: str | None = None


@dataclass(frozen=True)
class OrderRow:
    """An order in a list. `state`: planned, running, held, done."""

    id: str
    part_type: str
    machine: str
    quantity: int
    finished: int
    held: int
    state: str
    made_at: datetime
    made_by: str


@dataclass(frozen=True)
class OrderPart:
    """One part of an order: the states of its steps in the route's order."""

    id: int
    serial: str
    state: PartState
    steps: tuple[StepState, ...]
    held_why: str


@dataclass(frozen=True)
class OrderBlock:
    """A step of the route."""

    no: int
    kind: BlockKind
    program: str
    program_sha256: str
    feature: str


@dataclass(frozen=True)
class OrderView:
    """A whole order; `armed_parts` is how many parts may still start without a press of Cycle Start."""

    row: OrderRow
    etag: str
    route_sha256: str
    blocks: tuple[OrderBlock, ...]
    parts: tuple[OrderPart, ...]
    armed_parts: int


@dataclass(frozen=True)
class CorrectedFrom:
    """The origin of a corrected program: its correction, the source program, the part."""

    correction: str
    name: str
    source_sha256: str
    part_type: str
    revision: str
    serial: str


@dataclass(frozen=True)
class ProgramRow:
    """A program of the store. `name` is empty where no file brought it; `corrected`: of one that a correction wrote."""

    sha256: str
    name: str
    dialect: str
    unit: str
    released: bool
    corrected: CorrectedFrom | None
    kept_at: datetime


@dataclass(frozen=True)
class DiffLine:
    """One line of a difference; `change`: same, before, after."""

    change: str
    before_line: int | None
    after_line: int | None
    text: str


@dataclass(frozen=True)
class ProgramDiff:
    """Two programs compared by the lossless reader; `differences` counts changed words."""

    before: ProgramRow
    after: ProgramRow
    differences: int
    lines: tuple[DiffLine, ...]


@dataclass(frozen=True)
class TransferView:
    """One transfer to or from a control."""

    id: int
    at: datetime
    who: str
    control: str
    program: str
    direction: str
    sent_sha256: str
    read_back_sha256: str
    outcome: str


@dataclass(frozen=True)
class LinkView:
    """The link to a control: its name, what it is (empty: the service reads no settings of it) and where it points.

    `machine`: whether a machine of that name is known; `last`: the latest transfer that was recorded.
    """

    control: str
    kind: str
    where: str
    machine: bool
    last: TransferView | None


@dataclass(frozen=True)
class LinksView:
    """All of them, by name. `settings`: whether the service has a file of their settings (`trueloop serve --links`)."""

    settings: bool
    items: tuple[LinkView, ...]
