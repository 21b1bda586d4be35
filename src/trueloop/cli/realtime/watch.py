"""`trueloop realtime watch`: what the corrector does, period by period."""

import signal
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, print_json


@guarded
def watch(
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="Folder of the record.  [default: watch-DATE-TIME]"),
    ] = None,
    image: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The image that the corrector has loaded: names its signals.")
    ] = None,
    seconds: Annotated[float | None, typer.Option("--for", metavar="SECONDS", min=0.1, help="Stop after that.")] = None,
    host: Annotated[str, typer.Option(help="Address at which the live page is served.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port of the live page; 0: a free one.", min=0, max=65535)] = 0,
    rows: Annotated[int, typer.Option(help="Rows of one file of the record.", min=1000)] = 3_600_000,
    keep: Annotated[
        int | None, typer.Option(help="Keep this many files, the last ones.  [default: all]", min=1)
    ] = None,
    cell: Annotated[
        Path | None,
        typer.Option(metavar="CELL.toml", help="Settings of the machine's cell: its service shows the trace too."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Record what the corrector does: attaches to the LinuxCNC on this computer, until Ctrl-C.

    Every servo period goes into samples.csv; a live page shows command, correction by cause, signals, state and times;
    at the end a page of the run is written. LinuxCNC needs a sampler on the corrector: see `realtime hal --watch`.
    """
    from trueloop.jobs.realtime.watched import Order
    from trueloop.jobs.realtime.watched import watch as watched

    folder = out or Path(f"watch-{datetime.now():%Y%m%d-%H%M%S}")
    stop: list[int] = []
    before = {one: signal.signal(one, lambda number, frame: stop.append(number)) for one in STOPS}
    try:
        result = watched(
            Order(folder, image, seconds, host, port, rows, keep, cell),
            lambda: bool(stop),
            lambda words: typer.echo(words, err=True),
        )
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
    if as_json:
        files = [str(file) for file in result.files]
        counts = {"periods": result.periods, "lost": result.lost, "faults": result.faults}
        print_json({"files": files, "page": str(result.page), **counts, "ended": result.ended})
        return
    typer.echo(
        f"{result.ended}: {result.periods} periods recorded, {result.lost} lost, {result.faults} faults or bad signals"
    )
    for file in (*result.files, result.page):
        typer.echo(f"written: {file}")


STOPS = (signal.SIGINT, signal.SIGTERM)
