"""`trueloop db`: the store of parts, tools, inspections and corrections."""

import typer

from trueloop.cli.db.check import check
from trueloop.cli.db.copies import backup, migrate, restore
from trueloop.cli.db.export import export
from trueloop.cli.db.find import find
from trueloop.cli.db.import_ import import_
from trueloop.cli.db.init import init
from trueloop.cli.db.replace import replace
from trueloop.cli.db.show import show

app = typer.Typer(
    help="The store: parts, edges, inspections, cuts and corrections, kept for the next part.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(init)
app.command("import")(import_)
app.command()(export)
app.command()(find)
app.command()(show)
app.command()(check)
app.command()(replace)
app.command()(backup)
app.command()(restore)
app.command()(migrate)
