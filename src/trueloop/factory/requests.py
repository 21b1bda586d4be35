"""Requests of people and cells to the factory, each a frozen value: `carry_out` takes any of them.

A part is named by the number of its row in the store, a step by its place in the route (from 0), a program by the
hash of its text.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import Annotated, ClassVar, Final, Literal

from pydantic import Field

from trueloop.domain.factory import Block, Conditions, RunFact
from trueloop.errors import Code
from trueloop.wording import wording


class Role(StrEnum):
    """The role of an account; each may do what those before it may. A cell has requests of its own."""

    VIEWER = "viewer"
    OPERATOR = "operator"
    ENGINEER = "engineer"
    ADMIN = "admin"
    CELL = "cell"
    SERVICE = "service"  # the service itself: tasks and timers


class Request:
    """A request that needs this role; `also_cell`: a cell may make it too, about its own machine."""

    needs: ClassVar[Role]
    also_cell: ClassVar[bool]

    def __init_subclass__(cls, needs: Role, also_cell: bool = False) -> None:
        cls.needs, cls.also_cell = needs, also_cell


Verdict = Literal["made", "not-made", "reject"]


def _unchanged(text: bytes, key: str) -> bytes:
    return text


@dataclass(frozen=True)
class PlanOrder(Request, needs=Role.ENGINEER):
    """Parts of one type, by one route; `job_toml`: the job by which corrections are computed.

    `probe_toml`: the probe that the job names; gauging runs then write the log of `probe_control`. `new_machine`: the
    machine may be one that the store does not know.
    """

    part_type: str
    revision: str
    machine: str
    serials: Annotated[tuple[str, ...], Field(max_length=1000)]
    blocks: Annotated[tuple[Block, ...], Field(max_length=100)]
    job_toml: str = ""
    conditions: Conditions = field(default_factory=Conditions)
    probe_toml: str = ""
    probe_control: Literal["linuxcnc", "fanuc", "haas", "renishaw", "siemens", "ge2000t"] = "linuxcnc"
    new_machine: bool = False


@dataclass(frozen=True)
class NextBlock(Request, needs=Role.CELL):
    """A cell asks what its machine is to do: an `Offer` or None. `as_sent` gives a program's text with its witness."""

    machine: str
    as_sent: Callable[[bytes, str], bytes] = _unchanged


@dataclass(frozen=True)
class RecordFacts(Request, needs=Role.CELL):
    """Facts that witnesses report about runs, in any order and repeatable. Answered with the keys of the runs."""

    facts: tuple[RunFact, ...]


@dataclass(frozen=True)
class RecordTouches(Request, needs=Role.CELL):
    """The file of touches that a gauging run wrote."""

    run: str
    name: str
    content: bytes


@dataclass(frozen=True)
class RecordTemperatures(Request, needs=Role.CELL):
    """Temperatures of a machine by signal, °C; `run` may be empty."""

    machine: str
    signals: Mapping[str, float]
    at: datetime
    run: str = ""


@dataclass(frozen=True)
class Calibrated(Request, needs=Role.OPERATOR, also_cell=True):
    """A machine's probe was calibrated now; `values` are what was found."""

    machine: str
    values: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Hold(Request, needs=Role.OPERATOR):
    """Nothing more happens to a part before a person has decided."""

    order: str
    part: int
    why: str


@dataclass(frozen=True)
class DecideStep(Request, needs=Role.OPERATOR):
    """A person's decision on a step that is unknown, or on a part that is held: what its step has done to the part."""

    order: str
    part: int
    step: int
    verdict: Verdict
    why: str


@dataclass(frozen=True)
class Arm(Request, needs=Role.OPERATOR, also_cell=True):
    """So many parts of an order may be made without a press of Cycle Start; 0 disarms. Only at the machine."""

    order: str
    parts: int
    why: str
    at_machine: bool = False


@dataclass(frozen=True)
class RecordStep(Request, needs=Role.OPERATOR):
    """A person did a step that has no program: removed a part, measured it, released it."""

    order: str
    part: int
    step: int
    why: str


@dataclass(frozen=True)
class StepCorrected(Request, needs=Role.SERVICE):
    """A correction (its record's id) and a program by the step CORRECT; `gauged_by`: the run of its touches."""

    order: str
    part: int
    step: int
    gauged_by: str
    correction: str
    program_sha256: str
    touches_sha256: str


@dataclass(frozen=True)
class CorrectionRefused(Request, needs=Role.SERVICE):
    """The step CORRECT was refused for the touches of a run, by the loop's own code: the part is held."""

    order: str
    part: int
    step: int
    gauged_by: str
    code: str
    said: str


@dataclass(frozen=True)
class CellSilent(Request, needs=Role.SERVICE):
    """Nothing was heard of a machine for longer than `limit_s` while a step of a part was started there."""

    order: str
    part: int
    step: int
    limit_s: float


@dataclass(frozen=True)
class ReleaseProgram(Request, needs=Role.ENGINEER):
    """A program may be sent to machines."""

    program_sha256: str
    why: str


@dataclass(frozen=True)
class RecordTransfer(Request, needs=Role.OPERATOR):
    """A program went to a control or came from it; only a released one is sent."""

    control: str
    program_sha256: str
    name: str
    direction: Literal["to", "from"]
    sent_sha256: str
    read_back_sha256: str
    outcome: str


@dataclass(frozen=True)
class Certify(Request, needs=Role.ENGINEER):
    """A certificate of a part: the page as bytes, with its verdict."""

    part: int
    content: bytes
    verdict: str


@dataclass(frozen=True)
class RaiseAlarm(Request, needs=Role.SERVICE, also_cell=True):
    """Something that a person has to see; `blocks`: no finish cut before it is acknowledged.

    `machine` and `part_type` say what it is about; both empty: everything.
    """

    source: str
    code: str
    said: str
    values: Mapping[str, str] = field(default_factory=dict)
    machine: str = ""
    part_type: str = ""
    blocks: bool = False


@dataclass(frozen=True)
class Acknowledge(Request, needs=Role.OPERATOR):
    """A person has seen an alarm."""

    alarm: int
    why: str


@dataclass(frozen=True)
class DecideProposal(Request, needs=Role.ENGINEER):
    """Accepts or rejects a proposal; `overrides` as `loops.post_process.decide` names them."""

    proposal: str
    verdict: Literal["accepted", "rejected"]
    why: str
    overrides: tuple[str, ...] = ()


@dataclass(frozen=True)
class SetTool(Request, needs=Role.OPERATOR):
    """An edge was set at a time; its memory begins anew where the edge is another."""

    edge: tuple[str, ...]
    set_at: datetime


_RANK: Final = (Role.VIEWER, Role.OPERATOR, Role.ENGINEER, Role.ADMIN)


@dataclass(frozen=True)
class By:
    """Who asks: an account with its role, or the cell of a machine.

    `once`: account and key of a request that is done once; what changes is noted under it in the same transaction.
    """

    name: str
    role: Role
    machine: str = ""
    once: tuple[str, str] | None = None


def allowed(role: Role, request: type[Request]) -> bool:
    """Returns whether a role may make requests of this type."""
    needed = request.needs
    if role is Role.SERVICE or needed in (Role.CELL, Role.SERVICE) or role is Role.CELL:
        return role is needed or (role is Role.CELL and request.also_cell)
    return _RANK.index(role) >= _RANK.index(needed)


def require_role(request: Request, by: By) -> None:
    """Requires that a person may do what is requested. Raises FAC-ROLE."""
    if not allowed(by.role, type(request)):
        raise Code.FAC_ROLE.refusal(
            wording(
                "{by!r} has the role {role!r}; this needs {needs!r}",
                by=by.name,
                role=by.role.value,
                needs=request.needs.value,
            ),
            hint=wording("ask an account with that role, or an administrator for it"),
            values={"role": by.role.value, "needed": request.needs.value},
        )


def require_machine(by: By, machine: str) -> None:
    """Raises FAC-MACHINE where a cell speaks of another machine than its own."""
    if by.role is Role.CELL and by.machine != machine:
        raise Code.FAC_MACHINE.refusal(
            f"the key is that of machine {by.machine!r}, the request is for machine {machine!r}",
            hint="use the key that was made for that machine: trueloop key add",
            values={"machine": machine, "key_of": by.machine},
        )
