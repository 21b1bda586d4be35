"""`trueloop cell`: the program beside a machine's LinuxCNC that runs what the service offers."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from trueloop.cli.shared_options import argument, option
from trueloop.cli.terminal import AsJson, Group, print_json

if TYPE_CHECKING:
    from trueloop.controllers.linuxcnc.cell.journal import JournalState, RunNow

app = Group("Run a service's orders beside a machine's LinuxCNC. Each run is carried out once.")
Settings = Annotated[Path, option("The cell's settings.", "--settings", metavar="CELL.toml")]
CELL = Path("cell.toml")


@app.command()
def run(settings: Settings = CELL) -> None:
    """Work until Ctrl-C or SIGTERM. What the machine does then goes on, and is found again."""
    import signal
    import threading

    from trueloop.jobs.cell import opened
    from trueloop.jobs.cell import run as work

    stop = threading.Event()
    for signals in (signal.SIGINT, signal.SIGTERM):
        signal.signal(signals, lambda *_: stop.set())
    work(opened(settings), stop, _said)


def _said(words: str) -> None:
    from datetime import datetime

    typer.echo(f"{datetime.now():%H:%M:%S} {words}", err=True)


@app.command()
def status(settings: Settings = CELL, as_json: AsJson = False) -> None:
    """Show the journal: the run in hand, waiting, refused.

    Waiting: reports that the service has not got yet. Refused: by the service.
    """
    from trueloop.controllers.linuxcnc.cell.journal import known, read
    from trueloop.errors import Code
    from trueloop.formats.cell_toml import HINT, read_cell
    from trueloop.formats.input_file import read_input

    found = read_cell(settings).model.cell
    file = settings.parent / found.journal
    now = known(read(read_input(file, Code.CEL_JOURNAL, hint=HINT), file)[0])
    if as_json:
        print_json(_row(found.machine, now))
        return
    typer.echo(f"machine {found.machine}: {_in_hand(now.run)}; {len(now.over)} runs are over")
    typer.echo(f"{len(now.waiting)} entries wait for the service")
    for one in now.refused:
        typer.echo(f"refused: {one['said']}")


def _in_hand(run: "RunNow | None") -> str:
    if run is None:
        return "no run in hand"
    return f"run {run.key}, {', '.join(sorted(run.facts)) or 'nothing done yet'}"


def _row(machine: str, now: "JournalState") -> dict[str, Any]:
    run = None
    if now.run is not None:
        run = {"key": now.run.key, "sent_sha256": now.run.sent_sha256, "facts": sorted(now.run.facts)}
    refused = [one["said"] for one in now.refused]
    return {"machine": machine, "run": run, "over": len(now.over), "waiting": len(now.waiting), "refused": refused}


@app.command()
def arm(
    order: Annotated[str, argument("The order's number.", metavar="ORDER")],
    parts: Annotated[int, option("Number of its parts.", min=1)],
    why: Annotated[str, option("Who stands at the machine, and why; it is kept.")],
    settings: Settings = CELL,
) -> None:
    """Let the next parts of an order start without Cycle Start.

    Entered at the machine.
    """
    from trueloop.jobs.cell import opened

    opened(settings).service.arm(order, parts, why)
    typer.echo(f"armed: order {order}, {parts} parts", err=True)
