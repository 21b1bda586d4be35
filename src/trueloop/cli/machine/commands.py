"""`trueloop machine`: a machine's own errors: found, looked at, checked, taken out of programs, given to controls."""

import typer

from trueloop.cli.machine.accept import accept
from trueloop.cli.machine.compensate import compensate
from trueloop.cli.machine.components import decompose
from trueloop.cli.machine.drift import add_drift, drift_fit, drift_predict
from trueloop.cli.machine.export import export
from trueloop.cli.machine.model import check, fit, show
from trueloop.cli.machine.plane import plates, points
from trueloop.cli.machine.tests import drift, positioning

app = typer.Typer(
    help="A machine's own errors: found from readings, taken out of programs, handed to the control.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
for command in (
    fit,
    show,
    check,
    accept,
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
