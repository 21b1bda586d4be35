"""What a decision changes: `Changes`. The shell writes all of it in one transaction."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from trueloop.domain.factory import Block, Run
from trueloop.factory.known import OrderNow


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
    """What a machine is to do next. `program` is the text as sent; `mode`: press-cycle-start or armed.

    `checks` says what was found in order before it was offered.
    """

    run: Run
    block: Block
    program: bytes
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
