"""Who may do what: one table, `NEEDED`. Who asks is a `By`."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from trueloop.errors import Code
from trueloop.factory import requests as ask


class Role(StrEnum):
    """The role of an account; each may do what those before it may. A cell has requests of its own."""

    VIEWER = "viewer"
    OPERATOR = "operator"
    ENGINEER = "engineer"
    ADMIN = "admin"
    CELL = "cell"
    SERVICE = "service"  # the service itself: tasks and timers


_RANK: Final = (Role.VIEWER, Role.OPERATOR, Role.ENGINEER, Role.ADMIN)

NEEDED: Final[Mapping[type, Role]] = {
    ask.PlanOrder: Role.ENGINEER,
    ask.NextBlock: Role.CELL,
    ask.RecordFacts: Role.CELL,
    ask.RecordTouches: Role.CELL,
    ask.RecordTemperatures: Role.CELL,
    ask.Calibrated: Role.OPERATOR,
    ask.Hold: Role.OPERATOR,
    ask.DecideStep: Role.OPERATOR,
    ask.Arm: Role.OPERATOR,
    ask.RecordStep: Role.OPERATOR,
    ask.StepCorrected: Role.SERVICE,
    ask.CorrectionRefused: Role.SERVICE,
    ask.CellSilent: Role.SERVICE,
    ask.ReleaseProgram: Role.ENGINEER,
    ask.RecordTransfer: Role.OPERATOR,
    ask.Certify: Role.ENGINEER,
    ask.RaiseAlarm: Role.SERVICE,
    ask.Acknowledge: Role.OPERATOR,
    ask.DecideProposal: Role.ENGINEER,
    ask.SetTool: Role.OPERATOR,
}
ALSO_CELL: Final = (ask.Calibrated, ask.Arm, ask.RaiseAlarm)
"""Requests that a cell may make about its own machine, beside those of cells alone."""


@dataclass(frozen=True)
class By:
    """Who asks: an account with its role, or the cell of a machine.

    `once`: account and key of a request that is done once; what changes is noted under it in the same transaction.
    """

    name: str
    role: Role
    machine: str = ""
    once: tuple[str, str] | None = None


def allowed(role: Role, request: type) -> bool:
    """Returns whether a role may make requests of this type."""
    needed = NEEDED[request]
    if role is Role.SERVICE or needed in (Role.CELL, Role.SERVICE) or role is Role.CELL:
        return role is needed or (role is Role.CELL and request in ALSO_CELL)
    return _RANK.index(role) >= _RANK.index(needed)


def require_role(request: ask.Request, by: By) -> None:
    """Requires that a person may do what is requested. Raises FAC-ROLE."""
    if not allowed(by.role, type(request)):
        needed = NEEDED[type(request)]
        raise Code.FAC_ROLE.refusal(
            f"{by.name!r} has the role {by.role.value!r}; this needs {needed.value!r}",
            hint="ask an account with that role, or an administrator for it",
            values={"role": by.role.value, "needed": needed.value},
        )


def require_machine(by: By, machine: str) -> None:
    """Raises FAC-MACHINE where a cell speaks of another machine than its own."""
    if by.role is Role.CELL and by.machine != machine:
        raise Code.FAC_MACHINE.refusal(
            f"the key of machine {by.machine!r} is no key of machine {machine!r}",
            hint="use the key that was made for that machine: trueloop key add",
            values={"machine": machine, "key_of": by.machine},
        )
