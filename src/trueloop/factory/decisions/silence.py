"""A cell that is not heard while its machine cuts: `cell_silent`."""

from dataclasses import dataclass
from datetime import datetime

from trueloop.domain.factory.run import Run
from trueloop.domain.factory.states import StepState
from trueloop.factory.changes import Changes
from trueloop.factory.decisions.offer import left_unknown
from trueloop.factory.known import OrderNow
from trueloop.factory.requests import CellSilent
from trueloop.factory.roles import By


@dataclass(frozen=True)
class SilenceFacts:
    """The order, the run of the step that is asked about, and when its machine was heard last; None: never."""

    order: OrderNow
    run: Run | None
    heard_at: datetime | None


def cell_silent(facts: SilenceFacts, request: CellSilent, by: By, now: datetime) -> Changes:
    """The run becomes unknown and its part is held, unless it has ended or its cell was heard meanwhile.

    Asked again it changes nothing. An end that the program witnessed frees the part when the cell is heard again.
    """
    part, step = facts.order.part(request.part), facts.order.step(request.part, request.step)
    if step.state is not StepState.STARTED or facts.run is None or facts.heard_at is None:
        return Changes()
    silent_s = (now - facts.heard_at).total_seconds()
    if silent_s <= request.limit_s:
        return Changes()
    return left_unknown(facts.order, part, facts.run, f"and its cell has been silent for {silent_s:.0f} s", now)
