"""Orders, programs and transfers."""

from dataclasses import dataclass
from datetime import datetime

from trueloop.domain.factory.route import BlockKind
from trueloop.domain.factory.states import PartState, StepState


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
    """What a corrected program was made from: by which correction, from which program, for which part."""

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
