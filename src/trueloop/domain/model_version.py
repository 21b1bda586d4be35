"""Versions of a machine's model: each names its parent and the reason, and none is in force before it is accepted."""

from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

from trueloop.domain.life import Identity
from trueloop.domain.tool import Machine


@dataclass(frozen=True)
class ModelVersion:
    """One version of a machine's model as a file: `text` is all of it, `sha256` its hash.

    `parent_sha256` is that of the version it was refined from, empty for a model that was fitted. `errors` are the
    names of the axis errors whose coefficients changed. `reason` says why in words, `judged` what parts left
    out said of it.
    """

    machine: Machine
    sha256: str
    text: str
    parent_sha256: str
    errors: tuple[str, ...]
    reason: str
    judged: str
    made_at: datetime
    made_by: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the hash of the model."""
        return (self.sha256,)


@dataclass(frozen=True)
class ModelDecision:
    """The decision on an offered version, made once: by whom, why and when. `model` is its hash."""

    model: str
    verdict: Literal["accepted", "rejected"]
    who: str
    at: datetime
    why: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the identity of the version."""
        return (self.model,)
