"""`trueloop measure`: what gauges and measuring machines are to measure, and what they reported."""

import typer

from trueloop.cli.measure.convert import convert
from trueloop.cli.measure.map import map_columns
from trueloop.cli.measure.plan import plan
from trueloop.cli.measure.read import read
from trueloop.cli.measure.sheet import sheet

app = typer.Typer(
    help="Inspection files of gauges and measuring machines, and plans for them.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(convert)
app.command()(plan)
app.command()(read)
app.command()(sheet)
app.command("map")(map_columns)
