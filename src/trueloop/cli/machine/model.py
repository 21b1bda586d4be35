"""`trueloop machine fit`, `show` and `check`: a model of a machine from readings."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.machine.options import (
    Extrapolate,
    HistoryFile,
    MachineFile,
    ModelFile,
    ReadingFiles,
    Temperatures,
    signals_of,
)
from trueloop.cli.terminal import AsJson, print_json

if TYPE_CHECKING:
    from trueloop.machine.identify.hold_out import HeldOut


@guarded
def fit(
    machine: MachineFile,
    readings: ReadingFiles,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the results.")],
    history: HistoryFile = None,
    robust: Annotated[bool, typer.Option(help="Let outliers count less.")] = True,
    as_json: AsJson = False,
) -> None:
    """Find the model of a machine from readings. Writes model.json and machine.html."""
    from trueloop.jobs.machine.machine_model import fit_machine
    from trueloop.report.machine.summary import fit_lines, fit_summary

    made = fit_machine(machine, readings, history, robust=robust)
    made.write(out)
    summarised = (made.found, made.chosen, made.held, len(made.data))
    if as_json:
        print_json(fit_summary(*summarised))
        return
    for line in fit_lines(*summarised):
        typer.echo(line)
    for finding in made.found.findings:
        typer.echo(str(finding), err=True)
    typer.echo(f"written: {out / 'model.json'}, {out / 'machine.html'}")


@guarded
def show(
    model: ModelFile, temperatures: Temperatures = None, extrapolate: Extrapolate = None, as_json: AsJson = False
) -> None:
    """Print every error of a model: its range over the travel and its largest standard uncertainty."""
    from trueloop.errors import in_file
    from trueloop.formats.tables.model_file import read_model
    from trueloop.machine.model.overview import overview
    from trueloop.machine.model.validity import check_signals
    from trueloop.report.machine.summary import lag_line

    known = read_model(model, offered=True)
    signals = signals_of(known, temperatures)
    with in_file(model):
        check_signals(known, signals, extrapolate or ())
        rows = overview(known, signals)
    if as_json:
        print_json({"terms": [row.__dict__ for row in rows], "lags": [lag.__dict__ for lag in known.lags]})
        return
    for lag in known.lags:
        typer.echo(lag_line(lag))
    for row in rows:
        typer.echo(f"{row.error:<5} {row.least:+9.2f} to {row.most:+9.2f} {row.unit:<5} u {row.largest_u:.2f}")


@guarded
def check(
    model: ModelFile,
    readings: ReadingFiles,
    history: HistoryFile = None,
    limit_um: Annotated[float | None, typer.Option(help="Refuse when the RMS of the lengths is larger.")] = None,
    limit_urad: Annotated[float | None, typer.Option(help="Refuse when the RMS of the angles is larger.")] = None,
    extrapolate: Extrapolate = None,
    as_json: AsJson = False,
) -> None:
    """Compare a model with readings it was not made from. Exit status 1 when beyond a limit."""
    from dataclasses import asdict

    from trueloop.cli.failure import ExitStatus
    from trueloop.errors import in_file
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.machine.machine_model import readings_of
    from trueloop.machine.identify.hold_out import compare
    from trueloop.machine.model.validity import check_state

    known = read_model(model, offered=True)
    data = readings_of(readings, known.machine.chain, history).with_lags(known.lags)
    with in_file(readings[0] if len(readings) == 1 else model):
        check_state(known, data.state, extrapolate or ())
    result = compare(known, data)
    beyond = [_beyond(result, "µm", "--limit-um", limit_um), _beyond(result, "µrad", "--limit-urad", limit_urad)]
    if as_json:
        print_json(asdict(result))
    else:
        for unit, left in result.by_unit.items():
            typer.echo(f"{left.readings} readings: {left.raw:.2f} {unit} RMS, after the model {left.rms:.2f} {unit}")
    if any(beyond):
        raise typer.Exit(ExitStatus.FINDINGS)


def _beyond(result: "HeldOut", unit: str, option: str, limit: float | None) -> bool:
    """A limit on what was not read would always pass: it is refused as a mistyped option."""
    if limit is None:
        return False
    if unit not in result.by_unit:
        raise typer.BadParameter(f"no reading is in {unit}, {limit:g} limits nothing", param_hint=option)
    return not result.by_unit[unit].rms <= limit
