"""`trueloop realtime`: the machine's errors corrected in the servo thread of LinuxCNC."""

import typer

from trueloop.cli.realtime.check import check, demo
from trueloop.cli.realtime.hal import hal
from trueloop.cli.realtime.image import image, show
from trueloop.cli.realtime.install import install
from trueloop.cli.realtime.signals import signals
from trueloop.cli.realtime.watch import watch

app = typer.Typer(
    help="The machine's errors corrected in the servo thread of LinuxCNC: image, component, signals, watching.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.callback()
def _real_time() -> None:
    pass


for command in (image, install, hal, show, signals, watch, check, demo):
    app.command()(command)
