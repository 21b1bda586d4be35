"""`trueloop db`: the store of parts, tools, inspections and corrections."""

import typer

from trueloop.cli.db.find import find
from trueloop.cli.db.import_ import import_
from trueloop.cli.db.init import init

app = typer.Typer(
    help="The store: parts, edges, inspections, cuts and corrections, kept for the next part.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(init)
app.command("import")(import_)
app.command()(find)
