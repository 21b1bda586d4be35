"""`trueloop realtime signals`: temperatures and speeds brought to the corrector."""

import signal
import sys
import threading
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import ExitStatus, guarded
from trueloop.cli.terminal import AsJson, print_json, wide_console

if TYPE_CHECKING:
    from trueloop.controllers.linuxcnc.realtime.signals.checking import Checked

ConfigFile = Annotated[
    Path, typer.Argument(metavar="CONFIG.toml", help="Sources, and which signal is found where in them.")
]


@guarded
def signals(
    file: ConfigFile,
    check: Annotated[
        bool, typer.Option("--check", help="Read every source once, print values and ages; needs no LinuxCNC.")
    ] = False,
    wait_s: Annotated[
        float, typer.Option("--wait", metavar="S", min=0.1, max=600, help="How long --check waits for a source, s.")
    ] = 5.0,
    as_json: AsJson = False,
) -> None:
    """The component rtec-signals: gives the corrector its signals, their ages, and which program runs.

    LinuxCNC starts it: `loadusr -Wn rtec-signals trueloop realtime signals CONFIG.toml` in its HAL file.
    """
    from trueloop.jobs.realtime import signals as job

    if check:
        found = job.check(file, wait_s)
        _print(found, as_json=as_json)
        if any(one.fault for one in found):
            raise typer.Exit(ExitStatus.FINDINGS)
        return
    stop = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.set())
    job.run(file, stop, lambda text: print(f"rtec-signals: {text}", file=sys.stderr, flush=True))


def _print(found: "list[Checked]", *, as_json: bool) -> None:
    if as_json:
        print_json({"signals": [asdict(one) for one in found]})
        return
    from rich.table import Table

    table = Table("signal", "source", "value", "age, s", "range", "")
    for one in found:
        value, age = ("-" if number is None else f"{number:.3f}" for number in (one.value, one.age_s))
        table.add_row(one.name, one.source, value, age, f"{one.low:g} … {one.high:g}", one.fault or "good")
    wide_console().print(table)
