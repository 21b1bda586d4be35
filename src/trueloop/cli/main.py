"""`trueloop`: the commands. Each imports what it needs when it runs, so that `--help` is there at once."""

import os
import sys
from typing import Annotated, Final

import typer

from trueloop.cli import (
    cell,
    db,
    diagnose,
    key,
    link,
    machine,
    monitor,
    mtconnect,
    offsets,
    probe,
    record,
    series,
    simulated,
    surface,
    tool,
    user,
)
from trueloop.cli.docs import docs
from trueloop.cli.examples import examples
from trueloop.cli.explain import explain
from trueloop.cli.failure import ExitStatus, reader_gone, silence_stdout
from trueloop.cli.measure import commands as measure
from trueloop.cli.nc import commands as nc
from trueloop.cli.new import new
from trueloop.cli.realtime import commands as realtime
from trueloop.cli.serve import serve
from trueloop.cli.simulated import simulate
from trueloop.cli.turned import part
from trueloop.cli.turned.compensate import compensate
from trueloop.cli.turned.demo import demo

THREADS: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Threads of numpy's and scipy's linear algebra: one, unless the user says otherwise before the start. Ours are small
problems, which several threads slow down, and two programs side by side would fight for the cores.
"""

app = typer.Typer(
    name="trueloop",
    help="Closed-loop machining: measure the part, model the error, cut the next pass true.",
    epilog="Exit status: 0 done, 1 found what was looked for (a check, a limit), 2 usage, 3 input refused, "
    "4 output not written, 70 internal error, 130 interrupted, 141 stdout closed.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: a third of the time that rich takes
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(new)
app.command()(compensate)
app.command()(demo)
app.command()(examples)
app.add_typer(part.app, name="part")
app.add_typer(nc.app, name="nc")
app.add_typer(probe.app, name="probe")
app.add_typer(measure.app, name="measure")
app.command()(simulate)
app.add_typer(simulated.app, name="linuxcnc")
app.add_typer(machine.app, name="machine")
app.add_typer(realtime.app, name="realtime")
app.add_typer(surface.app, name="surface")
app.add_typer(series.app, name="series")
app.add_typer(monitor.app, name="monitor")
app.add_typer(diagnose.app, name="diagnose")
app.add_typer(offsets.app, name="offsets")
app.add_typer(link.app, name="link")
app.add_typer(mtconnect.app, name="mtconnect")
app.add_typer(tool.app, name="tool")
app.add_typer(record.app, name="record")
app.add_typer(db.app, name="db")
app.command()(serve)
app.add_typer(user.app, name="user")
app.add_typer(key.app, name="key")
app.add_typer(cell.app, name="cell")
app.command()(explain)
app.command()(docs)


def _print_version(wanted: bool) -> None:
    if wanted:
        from trueloop import __version__

        typer.echo(f"trueloop {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


def main() -> None:
    """The entry point of the command `trueloop`."""
    for name in THREADS:
        os.environ.setdefault(name, "1")
    try:
        app()
    except SystemExit as end:  # help and version are printed outside of any command
        if not reader_gone(end):
            raise
        silence_stdout()
        sys.exit(ExitStatus.PIPE)
