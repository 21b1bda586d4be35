"""`trueloop`: the commands. The module of each is imported when it is called, and imports the rest when it runs."""

import os
import sys
from importlib import import_module
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup
from typer.main import get_group

from trueloop.cli.plain_output import write_what_streams_take

THREADS: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Threads of numpy's and scipy's linear algebra: one, unless the user says otherwise before the start. Ours are small
problems, which several threads slow down, and two programs side by side would fight for the cores.
"""

COMMANDS: Final = {
    "new": "trueloop.cli.new:new",
    "compensate": "trueloop.cli.turned.compensate:compensate",
    "demo": "trueloop.cli.turned.compensate:demo",
    "examples": "trueloop.cli.help:examples",
    "simulate": "trueloop.cli.simulated:simulate",
    "serve": "trueloop.cli.serve:serve",
    "explain": "trueloop.cli.help:explain",
    "docs": "trueloop.cli.help:docs",
    "part": "trueloop.cli.turned.part:app",
    "nc": "trueloop.cli.nc:app",
    "probe": "trueloop.cli.probe:app",
    "measure": "trueloop.cli.measure.commands:app",
    "linuxcnc": "trueloop.cli.simulated:app",
    "machine": "trueloop.cli.machine:app",
    "realtime": "trueloop.cli.realtime:app",
    "surface": "trueloop.cli.surface:app",
    "series": "trueloop.cli.series:app",
    "monitor": "trueloop.cli.monitor:app",
    "diagnose": "trueloop.cli.diagnose:app",
    "offsets": "trueloop.cli.offsets:app",
    "link": "trueloop.cli.link:app",
    "mtconnect": "trueloop.cli.mtconnect:app",
    "tool": "trueloop.cli.tool:app",
    "record": "trueloop.cli.record:app",
    "db": "trueloop.cli.db:app",
    "user": "trueloop.cli.user:app",
    "key": "trueloop.cli.key:app",
    "cell": "trueloop.cli.cell:app",
}
"""Where each command or group of commands is, in the order of `--help`."""


class _Commands(dict[str, Any]):
    """Commands by name; the value None stands for one whose module is not imported yet."""

    def __getitem__(self, name: str) -> Any:
        if super().__getitem__(name) is None:
            self[name] = _imported(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """Returns the command, imported."""
        if name not in self:
            return default
        return self[name]


class _Group(TyperGroup):
    """Imports the module of a command when the command is looked up."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = _Commands(dict.fromkeys(COMMANDS))

    def list_commands(self, ctx: Any) -> list[str]:
        """Returns their names; none is imported for it."""
        return list(self.commands)


def _imported(name: str) -> Any:
    """Imports a command, or a group of commands, and makes of it what typer makes within a group."""
    module, _, attribute = COMMANDS[name].partition(":")
    value = getattr(import_module(module), attribute)
    holder = typer.Typer(rich_markup_mode=None, add_completion=False)
    if isinstance(value, typer.Typer):
        holder.add_typer(value, name=name)
    else:
        holder.command(name)(value)
    return get_group(holder).commands[name]


app = typer.Typer(
    name="trueloop",
    cls=_Group,
    help="Closed-loop machining: measure the part, model the error, cut the next pass true.",
    epilog="Exit status: 0 done, 1 found what was looked for (a check, a limit), 2 usage, 3 input refused, "
    "4 output not written, 70 internal error, 130 interrupted, 141 stdout closed.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: a third of the time that rich takes
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


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
    write_what_streams_take()
    try:
        app()
    except SystemExit as end:  # help and version are printed outside of any command
        from trueloop.cli.terminal import ExitStatus, reader_gone, silence_stdout

        if not reader_gone(end):
            raise
        silence_stdout()
        sys.exit(ExitStatus.PIPE)
