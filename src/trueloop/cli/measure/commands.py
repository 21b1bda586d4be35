"""`trueloop measure`: what gauges and measuring machines are to measure, and what they reported."""

import typer

from trueloop.cli.measure.plan import plan

app = typer.Typer(
    help="Inspection files of gauges and measuring machines, and plans for them.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.callback()(lambda: None)  # a group, also while it has one command
app.command()(plan)
