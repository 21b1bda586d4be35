"""Runs: single attempts at a step, each under a key of its own, and what witnesses say of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

from trueloop.domain.factory.states import FactKind
from trueloop.domain.machine import Machine
from trueloop.domain.part import Part


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
        """The key."""
        return (self.key,)


@dataclass(frozen=True)
class RunFact:
    """What a witness (the program itself, the cell client, a person) says of a run, and when it happened."""

    run: str
    what: FactKind
    at: datetime
    witness: str
    values: Mapping[str, str] = field(default_factory=dict)
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Run, what, witness and time: told twice it is one fact."""
        return self.run, self.what, self.witness, self.at.isoformat()
