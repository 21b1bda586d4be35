"""`trueloop tool`: cutting edges, what happened to them, and what they have taught."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.shared_options import Db, argument, option
from trueloop.cli.terminal import AsJson, Group, busy, print_json, print_lines, put

if TYPE_CHECKING:
    from trueloop.domain.life import EdgeEvent, EdgeLife
    from trueloop.domain.tool import Machine
    from trueloop.jobs.tools import Happened

ToolName = Annotated[str, argument("Its number, T3 or 3, or the name of its holder.", metavar="TOOL")]
MachineName = Annotated[str | None, option("In which machine, where the store knows tools of several.", "--machine")]
Again = Annotated[bool, option("This very corner cut before: its form is known, its setting is not.", "--again")]


def moment(text: str | None) -> str | None:
    """Refuses, as a usage error, a time that is none."""
    if text is not None:
        parsed(text)
    return text


def parsed(text: str) -> datetime:
    """A time of ISO 8601; without a zone it is the clock on the wall here."""
    try:
        return datetime.fromisoformat(text).astimezone()
    except (ValueError, OverflowError, OSError):
        raise typer.BadParameter(f"{text!r} is no date with time: 2026-03-02T14:30, with +01:00 for a zone") from None


@dataclass(frozen=True, kw_only=True)
class When:
    """When an event happened, in which machine, and in which store it is kept."""

    at: Annotated[str | None, option("When: 2026-03-02T14:30.  [default: now]", metavar="TIME", callback=moment)] = None
    machine: MachineName = None
    late: Annotated[
        bool, option("Keep an event that is earlier than others of the tool, or than its cuts.", "--late")
    ] = False
    db: Db = None

    def keep(
        self,
        decide: "Callable[[Sequence[EdgeLife], Happened], tuple[EdgeEvent, ...]]",
        values: dict[str, float | None],
        *,
        as_json: bool,
    ) -> None:
        """Keeps what is decided of the lives known, and prints it. `values` that are None are not stated."""
        from trueloop.jobs.store.opened import open_store
        from trueloop.jobs.tools import Happened, keep_events
        from trueloop.jobs.user import user_name
        from trueloop.report.tool import event_as_dict, event_line

        now = datetime.now(UTC).replace(microsecond=0).astimezone()
        given = {name: value for name, value in values.items() if value is not None}
        happened = Happened(parsed(self.at) if self.at else now, user_name(), machine_named(self.machine), given)
        events = keep_events(open_store(self.db), lambda known: decide(known, happened), now, late=self.late)
        if as_json:
            print_json({"events": [event_as_dict(event) for event in events]})
        else:
            print_lines(f"kept: {event_line(event)}" for event in events)


def machine_named(name: str | None) -> "Machine | None":
    """The machine of that name; None: not stated."""
    from trueloop.domain.tool import Machine

    return Machine(name) if name else None


app = Group("Edges of tools in the store: mounted, turned, set, worn. Also removed, and what each edge has taught.")


@dataclass(frozen=True, kw_only=True)
class Offsets:
    """Where the tip was measured."""

    x_mm: Annotated[float | None, option("Its offset on X as a radius, kept with it.")] = None
    z_mm: Annotated[float | None, option("Its offset on Z, kept with it.")] = None

    def values(self) -> dict[str, float | None]:
        """Returns x and z by name, mm; None where not stated."""
        return {"x_mm": self.x_mm, "z_mm": self.z_mm}


@dataclass(frozen=True, kw_only=True)
class Mounted:
    """The edge that is mounted."""

    holder: Annotated[str, option("Name of the holder; no two alike.")] = ""
    insert: Annotated[str, option("The insert: its designation, or the number on it.")] = ""
    corner: Annotated[str, option("Which corner of the insert cuts.")] = ""
    nose_radius_mm: Annotated[float | None, option("Nose radius; 0 for a pointed tool.")] = None
    offsets: Offsets


@app.command()
def mount(tool: ToolName, mounted: Mounted, when: When, again: Again = False, as_json: AsJson = False) -> None:
    """Mount a new insert, or with --again a removed one.

    The insert that was in its holder is removed with it.
    """
    from trueloop.jobs.tools import Mounting, mounting

    wanted = Mounting(
        tool=tool,
        holder=mounted.holder,
        insert=mounted.insert,
        corner=mounted.corner,
        nose_radius_mm=mounted.nose_radius_mm,
        again=again,
    )
    when.keep(lambda known, happened: mounting(known, wanted, happened), mounted.offsets.values(), as_json=as_json)


@app.command()
def turn(
    tool: ToolName,
    corner: Annotated[str, option("The corner that cuts from now on.")],
    offsets: Offsets,
    when: When,
    again: Again = False,
    as_json: AsJson = False,
) -> None:
    """Index the insert: another corner cuts.

    Nothing is known yet of the new corner.
    """
    from trueloop.jobs.tools import turning

    when.keep(
        lambda known, happened: turning(known, tool, corner, happened, again=again), offsets.values(), as_json=as_json
    )


@app.command()
def set_(tool: ToolName, offsets: Offsets, when: When, as_json: AsJson = False) -> None:
    """State that the tool was measured or touched off anew.

    The form of the edge stays; the place of its tip does not.
    """
    _keep(tool, "set", when, offsets.values(), as_json=as_json)


@app.command()
def wear(
    tool: ToolName,
    when: When,
    flank_mm: Annotated[float | None, option("Width of flank wear land, VB of ISO 3685.")] = None,
    minutes_in_cut: Annotated[float | None, option("Time in cut since the edge was mounted.")] = None,
    as_json: AsJson = False,
) -> None:
    """Wear measured, or time in cut read from the control."""
    values = {"flank_wear_mm": flank_mm, "minutes_in_cut": minutes_in_cut}
    _keep(tool, "worn", when, values, as_json=as_json)


@app.command()
def remove(tool: ToolName, when: When, as_json: AsJson = False) -> None:
    """Remove an edge from the machine.

    It cuts no more parts until it is mounted again.
    """
    _keep(tool, "removed", when, {}, as_json=as_json)


@app.command()
def show(
    tool: ToolName,
    corner: Annotated[str | None, option("Of this corner.  [default: the last one]")] = None,
    machine: MachineName = None,
    output: Annotated[Path | None, option("Write a page with pictures.", "--output", "-o")] = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Show the life of an edge and what it has taught.

    Form, transfer to the finish cut, setting, part types.
    """
    from trueloop.jobs.store.opened import open_store
    from trueloop.jobs.tool_life import shown_edge
    from trueloop.report.tool import edge_as_dict, edge_lines, edge_page

    with busy(f"parts of {tool}"):
        shown = shown_edge(open_store(db), tool, corner, machine_named(machine))
    if output is not None:
        put(edge_page(shown), output, ())
    if as_json:
        print_json(edge_as_dict(shown))
    else:
        print_lines(edge_lines(shown))


@app.command()
def list_(
    every: Annotated[bool, option("Also edges that were turned away or removed.", "--all")] = False,
    machine: MachineName = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """The edges that are mounted."""
    from trueloop.jobs.store.opened import open_store
    from trueloop.jobs.tool_life import listed
    from trueloop.report.tool import life_as_dict, life_line

    known = listed(open_store(db), machine_named(machine), every=every)
    if as_json:
        print_json({"edges": [life_as_dict(life) for life in known]})
    else:
        print_lines([life_line(life) for life in known] or ["no edge is mounted"])


def _keep(tool: str, kind: str, when: When, values: dict[str, float | None], *, as_json: bool) -> None:
    """An event of the edge that is mounted."""
    from trueloop.domain.life import EdgeEventKind
    from trueloop.jobs.tools import of_mounted

    when.keep(lambda known, happened: of_mounted(known, tool, EdgeEventKind(kind), happened), values, as_json=as_json)
