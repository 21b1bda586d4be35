"""Tools and edges as messages and pages call them."""

from datetime import datetime

from trueloop.domain.edge_life import EdgeLife
from trueloop.domain.tool import Edge


def tool_name(edge: Edge) -> str:
    """As it is called: T3, or the holder where no number is known."""
    return f"T{edge.tool.number}" if edge.tool.number is not None else edge.tool.name


def edge_name(edge: Edge) -> str:
    """Tool, holder, insert and corner, as far as they are stated."""
    words = [tool_name(edge)]
    if edge.tool.name and edge.tool.number is not None:
        words.append(edge.tool.name)
    words += [edge.insert] if edge.insert else []
    return " ".join(words + ([f"corner {edge.corner}"] if edge.corner else []))


def time(at: datetime) -> str:
    """A time as messages have it: to the second, with its zone."""
    return at.isoformat(sep=" ", timespec="seconds")


def where(life: EdgeLife) -> str:
    """The edge with its machine."""
    machine = "" if life.machine is None else f" in {life.machine.name}"
    return edge_name(life.edge) + machine
