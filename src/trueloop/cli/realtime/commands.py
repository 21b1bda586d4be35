"""`trueloop realtime`: the machine's errors corrected in the servo thread of LinuxCNC."""

import typer

app = typer.Typer(
    help="The machine's errors corrected in the servo thread of LinuxCNC: image, component, signals, watching.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.callback()
def _real_time() -> None:
    pass
