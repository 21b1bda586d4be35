"""Cutting tools, their edges, and the settings of an edge in time."""

from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal


@dataclass(frozen=True)
class Tool:
    """A tool with its holder. Lengths in mm; None: not known.

    `number` is that by which programs call it, `name` that of the tool or its holder. `corner_radius_mm` is the nose
    radius of a turning tool and the corner radius of a mill (RE of ISO 13399), `radius_mm` that of a tool that turns
    (half of DC): for a ball end both are equal. A turning tool has no `radius_mm`.
    """

    number: int | None = None
    name: str = ""
    corner_radius_mm: float | None = None
    radius_mm: float | None = None
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """The name; without one the number, which holds for one machine and only until the magazine is loaded anew."""
        return (self.name or ("" if self.number is None else f"T{self.number}"),)


@dataclass(frozen=True)
class Edge:
    """One cutting edge of a tool: of which `insert`, and which `corner` of it. Its form is what it cuts into parts."""

    tool: Tool
    insert: str = ""
    corner: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the identity of the tool, the insert and the corner."""
        return *self.tool.identity, self.insert, self.corner


@dataclass(frozen=True)
class Setting:
    """An edge from one setting of the tool to the next: it was mounted and measured at `set_at`; None: not stated.

    Form and wear belong to the edge and outlast a setting; where the tool's tip lies belongs to the setting.
    """

    edge: Edge
    set_at: datetime | None = None
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the identity of the edge, and when it was set."""
        return *self.edge.identity, "" if self.set_at is None else self.set_at.isoformat()


@dataclass(frozen=True)
class Machine:
    """One machine tool: `name` as the shop calls it or as its maker does, `serial` its number; empty: not stated."""

    name: str
    serial: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns name and serial number: every machine errs in its own way."""
        return self.name, self.serial
