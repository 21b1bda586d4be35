"""What the commands `trueloop tool` have in common."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.terminal import print_json, print_lines

if TYPE_CHECKING:
    from trueloop.domain.edge_life import EdgeLife
    from trueloop.domain.life import EdgeEvent
    from trueloop.domain.machine import Machine
    from trueloop.jobs.tools.events import Happened

ToolName = Annotated[str, typer.Argument(metavar="TOOL", help="Its number, T3 or 3, or the name of its holder.")]
MachineName = Annotated[
    str | None, typer.Option("--machine", help="In which machine, where the store knows tools of several.")
]
Again = Annotated[
    bool, typer.Option("--again", help="This very corner cut before: its form is known, its setting is not.")
]


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

    at: Annotated[
        str | None,
        typer.Option("--at", metavar="TIME", callback=moment, help="When: 2026-03-02T14:30.  [default: now]"),
    ] = None
    machine: MachineName = None
    late: Annotated[
        bool, typer.Option("--late", help="Keep an event that is earlier than others of the tool, or than its cuts.")
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
        from trueloop.jobs.store.opened import opened
        from trueloop.jobs.tools.events import Happened
        from trueloop.jobs.tools.keeping import keep_events
        from trueloop.jobs.user import user_name
        from trueloop.report.tool.summary import event_as_dict, event_line

        now = datetime.now(UTC).replace(microsecond=0).astimezone()
        given = {name: value for name, value in values.items() if value is not None}
        happened = Happened(parsed(self.at) if self.at else now, user_name(), machine_named(self.machine), given)
        events = keep_events(opened(self.db), lambda known: decide(known, happened), now, late=self.late)
        if as_json:
            print_json({"events": [event_as_dict(event) for event in events]})
        else:
            print_lines(f"kept: {event_line(event)}" for event in events)


def machine_named(name: str | None) -> "Machine | None":
    """The machine of that name; None: not stated."""
    from trueloop.domain.machine import Machine

    return Machine(name) if name else None
