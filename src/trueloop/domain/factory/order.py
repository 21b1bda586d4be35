"""Work orders: which parts are to be made, where, and by which route."""

from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

from trueloop.domain.factory.route import Route
from trueloop.domain.machine import Machine
from trueloop.domain.part import Part, PartType


@dataclass(frozen=True)
class WorkOrder:
    """An order as it was planned; what has become of it is the state of its steps. `serials`: one part each."""

    id: str
    part_type: PartType
    machine: Machine
    serials: tuple[str, ...]
    route: Route
    made_at: datetime
    made_by: str
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Its id."""
        return (self.id,)

    @property
    def parts(self) -> tuple[Part, ...]:
        """In the order in which they are to be made."""
        return tuple(Part(self.part_type, serial) for serial in self.serials)
