"""Proposals of the post-process loop, and what was decided of them: records, never changed, found by id.

A proposal changes tool offsets, what is remembered, or weights: never an NC program, never values of real time
[4773 §5]. There is no class for those.
"""

from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import Literal

from trueloop.domain.life import Identity
from trueloop.domain.part import PartType
from trueloop.domain.tool import Machine

ExpandedU = tuple[float | None, float | None]
"""Of an offset's X and Z; None: not determined."""


@dataclass(frozen=True)
class TableRow:
    """A row of a control's tool table as it was read: its numbers as they stand in the file.

    `x`, `z` are in the table's `unit`, x a radius or a diameter as the table counts it; None: not in the table.
    """

    file: str
    kind: Literal["geometry", "wear"]
    x: str | None
    z: str | None
    unit: Literal["mm", "inch"]


@dataclass(frozen=True)
class HeldTool:
    """The finishing tool as the control knows it: name, edge, row of its table. `edge` 0: that of the finish pass."""

    name: str = ""
    edge: int = 1
    row: TableRow | None = None


@dataclass(frozen=True)
class ToolOffset:
    """The change of one tool's offset, mm, x as a radius, rounded to the control's step.

    A tool stands at machine = program + work offset + tool offset: by what is added to its offset, the tool moves.
    `makes_the_correction`: the offset is the correction; else the contour is, and the offset takes its place only by
    choice. `x_is` says how the control counts its offsets on X, `unit` and `decimals` are those of its numbers,
    `blocks` its own words for the change. `measured_sha256` names the measurements it comes from: what was measured
    before an offset was changed says nothing of the part after it. `expanded_u_mm` (95 %; x as a radius, z) is how well
    both are known, None of an axis that the measurements do not determine; None: not stated.
    """

    tool: int
    x_radius_mm: float
    z_mm: float
    makes_the_correction: bool
    x_is: Literal["radius", "diameter"]
    unit: Literal["mm", "inch"]
    measured_sha256: str = ""
    held: HeldTool = field(default_factory=HeldTool)
    decimals: int = 4
    blocks: tuple[str, ...] = ()
    expanded_u_mm: ExpandedU | None = None
    schema: Literal[1] = field(default=1, kw_only=True)


class ProposalClass(StrEnum):
    """The kinds of change that a proposal makes."""

    TOOL_OFFSET = "tool offset"  # where the next part's cut lies
    MEMORY = "memory"  # from which part on the parts of a series are learned from
    WEIGHT = "weight"  # which share of what was learned is acted on


@dataclass(frozen=True)
class Effect:
    """The predicted effect of a proposal on one characteristic of the next part.

    Errors are actual less nominal size: of a shaft positive where material is left on, a diameter's twice the radial
    one. `error_before_mm` is expected without the proposal, `error_after_mm` with it, both ± `standard_u_mm` (one
    standard deviation of one part, scatter included). `size_change_mm` is what the proposal adds to the size.
    Probabilities are those of being inside the limits; None: there are none. `weight` is the share of what the last
    part showed unexpectedly that the proposal acts on, `in_force_mm` what earlier proposals take off the size already.
    """

    characteristic: str
    series: Identity
    parts: int
    size_change_mm: float
    error_before_mm: float
    error_after_mm: float
    standard_u_mm: float
    probability_in_before: float | None = None
    probability_in_after: float | None = None
    weight: float = 1.0
    in_force_mm: float = 0.0


@dataclass(frozen=True)
class Proposal:
    """One change that the parts of a series suggest for the next part. It is not in force before it is accepted.

    `last_serial` is the last part behind it: a later part supersedes it. `tool_offset` says it in a tool's offset where
    a job names the tool; `control` is that of the job's program. `weight` is the new factor of a proposal of that
    class, `from_serial` the part with which learning begins anew of one of memory. `alarms` were open when it was made,
    and `why` says what it comes from.
    """

    id: str
    changes: ProposalClass
    part_type: PartType
    effects: tuple[Effect, ...]
    last_serial: str
    made_at: datetime
    made_by: str
    tool_offset: ToolOffset | None = None
    control: str = ""
    weight: float | None = None
    from_serial: str = ""
    alarms: tuple[str, ...] = ()
    why: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the id: of what it was made from."""
        return (self.id,)

    @property
    def characteristics(self) -> tuple[str, ...]:
        """Returns the names of the characteristics that it changes."""
        return tuple(effect.characteristic for effect in self.effects)


@dataclass(frozen=True)
class ProposalDecision:
    """The decision on a proposal, made once: by whom, why and when.

    `automatic`: its class was switched to automatic, and nobody was asked. `overrides` are the refusals that were
    overridden, by their codes.
    """

    proposal: str
    verdict: Literal["accepted", "rejected"]
    who: str
    at: datetime
    why: str = ""
    automatic: bool = False
    overrides: tuple[str, ...] = ()
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the identity of the proposal: it is decided once."""
        return (self.proposal,)


@dataclass(frozen=True)
class PartCutWith:
    """Which accepted proposals were in force when a part was cut, stated as its inspection was added to a series."""

    inspection: Identity
    proposals: tuple[str, ...]
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the identity of the inspection."""
        return self.inspection


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
