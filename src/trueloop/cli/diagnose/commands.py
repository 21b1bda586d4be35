"""`trueloop diagnose`: from errors of parts to their causes."""

import typer

from trueloop.cli.diagnose.fixture import fixture
from trueloop.cli.diagnose.machine import machine
from trueloop.cli.diagnose.parts import part, series
from trueloop.cli.diagnose.refine import refine
from trueloop.cli.diagnose.standard import standard

app = typer.Typer(
    help="From errors of parts to their causes: tool, probe, set-up, process, or the model of the machine.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
for command in (part, series, fixture, machine, refine, standard):
    app.command()(command)
