"""What happens to parts and edges between the files: cuts, what inspections belong to them, and events of an edge.

The links between them are stated, never derived from numbers in labels: "finished = semi-finished + 1" fails on NIST's
own parts [6811 §4.3].
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import Literal, TypeAlias

from trueloop.domain.machine import Machine
from trueloop.domain.part import Part
from trueloop.domain.tool import Edge, Setting

Identity: TypeAlias = tuple[str, ...]
"""By which a stored value is found again and known as the same."""


class Stage(StrEnum):
    """How far a part has come."""

    ROUGH = "rough"
    SEMIFINISH = "semifinish"
    FINISH = "finish"


class Ran(StrEnum):
    """Which program a finish cut ran, of those that a correction gives."""

    CORRECTED = "corrected"  # the contour in the program is corrected
    OFFSETS = "offsets"  # the program that holds tool offsets
    AS_PROGRAMMED = "as-programmed"  # the given program, nothing corrected
    WEAR = "wear"  # the given program, the tool offset entered at the control


@dataclass(frozen=True)
class CuttingConditions:
    """Of one cut: depths and lengths in mm, radius for a depth on X; None: not stated.

    What was learned holds for the depth and feed that it was learned at.
    """

    depth_of_cut_mm: float | None = None
    feed_mm_per_rev: float | None = None
    speed_m_per_min: float | None = None
    time_in_cut_min: float | None = None
    material: str = ""


@dataclass(frozen=True)
class Cut:
    """One cut of one part, as it was made: `setting` is the edge with the time at which it was set.

    `program_sha256` is that of the text that ran, `correction` the id of the record in force; empty: none, as
    programmed. `offset_entered`: the correction is a tool offset that was entered at the control.
    `order` counts the parts of an edge as they were cut; None: by `at`. `order_in_doubt`: other facts contradict it.
    """

    part: Part
    stage: Stage
    setting: Setting | None = None
    machine: Machine | None = None
    program_sha256: str = ""
    correction: str = ""
    at: datetime | None = None
    order: int | None = None
    order_in_doubt: bool = False
    offset_entered: bool = False
    conditions: CuttingConditions = field(default_factory=CuttingConditions)
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns part, stage, and time: a part cut twice has two cuts."""
        return *self.part.identity, self.stage, "" if self.at is None else self.at.isoformat()


@dataclass(frozen=True)
class InspectionLink:
    """That an inspection shows what a cut left: both by their identity.

    `released`: the part had left the machine, so that unclamping and the machine's own errors are in it too.
    """

    inspection: Identity
    cut: Identity
    released: bool = False
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the identity of the inspection: it shows one cut."""
        return self.inspection


@dataclass(frozen=True)
class Quarantine:
    """That a cut is not to teach anything, because an alarm said so or a person did; `lifted`: it may again.

    Of several of one cut the latest counts. The cut and its inspections stay as they are.
    """

    cut: Identity
    at: datetime
    why: str = ""
    by: str = ""
    lifted: bool = False
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the cut and the time."""
        return *self.cut, self.at.isoformat()


class EdgeEventKind(StrEnum):
    """What may happen to an edge."""

    MOUNTED = "mounted"  # a new insert or corner: nothing learned of its form holds any more
    TURNED = "turned"  # the insert indexed: another corner cuts, which is another edge
    SET = "set"  # measured or touched off anew: its form stays, where its tip lies does not
    WORN = "worn"  # flank wear measured
    REMOVED = "removed"


@dataclass(frozen=True)
class EdgeEvent:
    """One event of an edge. `values` by name with the unit in the name: {"flank_wear_mm": 0.12, "minutes_in_cut": 35}.

    Offsets among them are `x_mm`, a radius, and `z_mm`. `machine` tells tools of one number apart, in whose pockets
    they are; None: the store knows one machine.
    """

    edge: Edge
    kind: EdgeEventKind
    at: datetime
    by: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    machine: Machine | None = None
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns edge, kind and time."""
        return *self.edge.identity, self.kind, self.at.isoformat()
