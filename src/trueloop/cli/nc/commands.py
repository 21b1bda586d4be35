"""`trueloop nc`: where a program sends the tool, what is odd about it, and how far two programs lie apart."""

import typer

from trueloop.cli.nc.check import check_program
from trueloop.cli.nc.difference import difference_of_programs
from trueloop.cli.nc.features import features_of_job
from trueloop.cli.nc.map import map_program_file
from trueloop.cli.nc.path import path_of_program
from trueloop.cli.nc.time import time_of_program

app = typer.Typer(
    help="NC programs: their tool path, and what is odd about them.", no_args_is_help=True, rich_markup_mode=None
)
app.command("features")(features_of_job)
app.command("map")(map_program_file)
app.command("time")(time_of_program)
app.command("path")(path_of_program)
app.command("check")(check_program)
app.command("diff")(difference_of_programs)


@app.command("translate", hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def _translate() -> None:
    raise typer.BadParameter(
        "nc translate was removed: post the program for the other control, and correct it with nc map"
    )
