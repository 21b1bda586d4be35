"""`trueloop machine`: a machine's own errors: found, looked at, checked, taken out of programs, given to controls."""

import typer

from trueloop.cli.machine_components import decompose
from trueloop.cli.machine_correction import compensate, export
from trueloop.cli.machine_drift import add_drift, drift_fit, drift_predict
from trueloop.cli.machine_model import check, fit, show
from trueloop.cli.machine_plane import plates, points
from trueloop.cli.machine_tests import drift, positioning

app = typer.Typer(
    help="A machine's own errors: found from readings, taken out of programs, handed to the control.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
for command in (
    fit,
    show,
    check,
    compensate,
    export,
    decompose,
    positioning,
    drift,
    drift_fit,
    drift_predict,
    add_drift,
    plates,
    points,
):
    app.command()(command)
