"""`trueloop series`: finished parts as inspected, what was expected of them, and proposals for the next part."""

import typer

from trueloop.cli.series.add import add
from trueloop.cli.series.propose import accept, propose, reject
from trueloop.cli.series.status import replay, simulate, status

app = typer.Typer(
    help="Series of parts: inspections of finished parts, proposals for the next one.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(add)
app.command()(status)
app.command()(propose)
app.command()(accept)
app.command()(reject)
app.command()(replay)
app.command()(simulate)
