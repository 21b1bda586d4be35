"""An order, its parts and steps as known before a decision, and after it."""

from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from pydantic import PlainSerializer

from trueloop.domain.factory import Block, BlockKind, PartState, Run, StepState, WorkOrder
from trueloop.domain.part import Part
from trueloop.errors import Code, TrueloopError
from trueloop.wording import wording


@dataclass(frozen=True)
class StepNow:
    """One step of a part. `run`: key of the attempt that counts; of a step CORRECT the id of the correction."""

    no: int
    kind: BlockKind
    state: StepState = StepState.WAITING
    run: str = ""
    program_sha256: str = ""
    attempts: int = 0
    version: int = 1


@dataclass(frozen=True)
class PartNow:
    """One part of an order: `row` is its number in the store."""

    row: int
    value: Part
    state: PartState
    steps: tuple[StepNow, ...]
    held_why: str = ""
    version: int = 1

    @property
    def reached(self) -> PartState:
        """Returns the state that its recorded steps have led to."""
        done = [step.kind.leaves for step in self.steps if step.state is StepState.RECORDED]
        return done[-1] if done else PartState.PLANNED

    @property
    def next(self) -> StepNow | None:
        """Returns the first step that is not recorded."""
        return next((step for step in self.steps if step.state is not StepState.RECORDED), None)

    @property
    def rejected(self) -> bool:
        """Returns whether nothing more is done to it."""
        return self.state is PartState.REJECTED

    @property
    def on_machine(self) -> bool:
        """Returns whether it is in the machine: a program has been offered for it, and it was not taken out."""
        if self.rejected or not any(step.kind.moves and step.attempts for step in self.steps):
            return False
        out = [step for step in self.steps if step.kind is BlockKind.REMOVE] or [s for s in self.steps if s.kind.moves]
        return any(step_now.state is not StepState.RECORDED for step_now in out)

    def gauged_by(self, step: int) -> str:
        """Returns the run by whose touches a step CORRECT corrects: that of the last gauging before it; empty: none."""
        return next((step_now.run for step_now in reversed(self.steps[:step]) if step_now.kind is BlockKind.PROBE), "")

    def with_step(self, step: StepNow) -> "PartNow":
        """Returns the part with one step as it is now."""
        return replace(self, steps=tuple(step if step_now.no == step.no else step_now for step_now in self.steps))

    def held(self, code: Code, why: str) -> "PartNow":
        """Returns the part held: nothing more happens to it before a person has decided."""
        return replace(self, state=PartState.HELD, held_why=f"{code}: {why}")

    def freed(self) -> "PartNow":
        """Returns the part in the state that its steps have led to."""
        return replace(self, state=self.reached, held_why="")


@dataclass(frozen=True)
class OrderNow:
    """An order with all its parts. `number` counts the orders of the store."""

    order: WorkOrder
    number: int
    parts: tuple[PartNow, ...]
    state: str = "planned"
    armed_parts: int = 0
    version: int = 1

    def part(self, row: int) -> PartNow:
        """Returns the row of that number. Raises FAC-UNKNOWN."""
        found = next((part_now for part_now in self.parts if part_now.row == row), None)
        if found is None:
            raise unknown(wording("part"), str(row), f"order {self.order.id!r} has {len(self.parts)} parts")
        return found

    def block(self, step: int) -> Block:
        """Returns the block of the route for a step."""
        return self.order.route.blocks[step]

    def step(self, row: int, no: int) -> StepNow:
        """Returns the row of that number. Raises FAC-UNKNOWN."""
        steps = self.part(row).steps
        if not 0 <= no < len(steps):
            raise unknown(wording("step"), str(no), f"the route has {len(steps)} steps, counted from 0")
        return steps[no]

    def with_part(self, part: PartNow) -> "OrderNow":
        """Returns the order with one part as it is now, and the order's own state as follows from its parts."""
        parts = tuple(part if part_now.row == part.row else part_now for part_now in self.parts)
        held = part.state is PartState.HELD
        return replace(self, parts=parts, state=_state(parts), armed_parts=0 if held else self.armed_parts)


def _state(parts: tuple[PartNow, ...]) -> str:
    if any(part.state is PartState.HELD for part in parts):
        return "held"
    if all(part.rejected or part.next is None for part in parts):
        return "done"
    begun = any(step.state is not StepState.WAITING for part in parts for step in part.steps)
    return "running" if begun else "planned"


def unknown(what: str, name: str, why: str) -> TrueloopError:
    """Returns the error FAC-UNKNOWN."""
    return Code.FAC_UNKNOWN.refusal(
        wording("there is no {what} {name!r}: {why}", what=what, name=name, why=why),
        hint=wording("look it up in the list; another may have changed it meanwhile"),
        values={"what": what, "name": name},
    )


@dataclass(frozen=True)
class Event:
    """A line of the event log; `subject` is `order:ID`, `part:ROW`, `program:HASH`, `alarm:ID` or their like."""

    what: str
    subject: str
    values: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class NewTask:
    """Slow work that follows."""

    kind: str
    subject: str
    values: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Offer:
    """The next task of a machine. `program` is the text as sent, in JSON as base64; `mode`: press-cycle-start or armed.

    `checks` says what was found in order before it was offered.
    """

    run: Run
    block: Block
    program: Annotated[bytes, PlainSerializer(lambda text: b64encode(text).decode(), return_type=str)]
    checks: tuple[str, ...]
    mode: str


@dataclass(frozen=True)
class Changes:
    """`orders` as they are to be; `keep`: values; `rows`: of append-only tables by name; `answer`: to who asked."""

    orders: tuple[OrderNow, ...] = ()
    keep: tuple[Any, ...] = ()
    rows: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    events: tuple[Event, ...] = ()
    tasks: tuple[NewTask, ...] = ()
    answer: Any = None
