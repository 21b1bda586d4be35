"""`trueloop machine fit`, `show` and `check`: a model of a machine from readings."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.machine_options import (
    Extrapolate,
    HistoryFile,
    MachineFile,
    ModelFile,
    ReadingFiles,
    Temperatures,
    lag_text,
    readings_of,
    signals_of,
)
from trueloop.cli.terminal import AsJson, print_json

if TYPE_CHECKING:
    pass


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
    from trueloop.compensation.record import sha256_of
    from trueloop.formats.input_file import in_file
    from trueloop.formats.machine_toml import read_machine
    from trueloop.formats.model_file import model_to_json
    from trueloop.formats.outputs import write_all
    from trueloop.machine.form import fit_form
    from trueloop.machine.hold_out import hold_out
    from trueloop.report.machine_page import machine_page

    named, form = read_machine(machine)
    data = readings_of(readings, named.chain, history)
    with in_file(machine):
        found, chosen = fit_form(named, form, data, robust=robust)
    held = hold_out(data, lambda others: fit_form(named, form, others, robust=robust)[0].model)
    sources = (machine, *readings, *([history] if history else ()))
    made_from = {path.name: sha256_of(path.read_bytes()) for path in sources}
    page = machine_page(found, chosen, data.with_lags(found.model.lags), held)
    contents = {"model.json": model_to_json(found.model, made_from).encode(), "machine.html": page.encode()}
    write_all(out, contents, inputs=sources)
    if as_json:
        constants = {lag.name: [lag.constant_s, lag.u_relative * lag.constant_s] for lag in found.model.lags}
        scatter = {"scatter": found.scatter, "readings": len(data), "findings": [f.message for f in found.findings]}
        scatter |= {"chosen": [f"{c.error}·{c.signal}" for c in chosen], "constants_s_and_u": constants}
        print_json(scatter | {"held_out_rms_mm": {run.run: run.rms for run in held}})
        return
    typer.echo(f"{len(found.model.terms)} terms from {len(data)} readings; scatter {found.scatter:.3g}")
    for taken in chosen:
        typer.echo(f"  {taken.error} takes {taken.signal}: left out {taken.rms_without:.3g} → {taken.rms_with:.3g} RMS")
    for lag in found.model.lags:
        typer.echo(f"  {lag_text(lag)}")
    for run in held:
        typer.echo(
            f"  run {run.run!r} predicted from the others: {1e3 * run.rms:.2f} µm RMS, without {1e3 * run.raw:.2f}"
        )
    for finding in found.findings:
        typer.echo(f"{finding.severity}: {finding.code}: {finding.message}", err=True)
    typer.echo(f"written: {out / 'model.json'}, {out / 'machine.html'}")


@guarded
def show(model: ModelFile, temperatures: Temperatures = None, as_json: AsJson = False) -> None:
    """Print every error of a model: its range over the travel and its largest standard uncertainty."""
    from trueloop.formats.model_file import read_model
    from trueloop.machine.overview import overview

    known = read_model(model)
    rows = overview(known, signals_of(known, temperatures))
    if as_json:
        print_json({"terms": [row.__dict__ for row in rows], "lags": [lag.__dict__ for lag in known.lags]})
        return
    for lag in known.lags:
        typer.echo(lag_text(lag))
    for row in rows:
        typer.echo(f"{row.error:<5} {row.least:+9.2f} to {row.most:+9.2f} {row.unit:<5} u {row.largest_u:.2f}")


@guarded
def check(
    model: ModelFile,
    readings: ReadingFiles,
    history: HistoryFile = None,
    limit_um: Annotated[float | None, typer.Option(help="Refuse when the RMS is larger.")] = None,
    extrapolate: Extrapolate = None,
    as_json: AsJson = False,
) -> None:
    """Compare a model with readings it was not made from. Exit status 1 when beyond the limit."""
    from trueloop.cli.failure import ExitStatus
    from trueloop.formats.input_file import in_file
    from trueloop.formats.model_file import read_model
    from trueloop.machine.hold_out import compare
    from trueloop.machine.validity import check_state

    known = read_model(model)
    data = readings_of(readings, known.machine.chain, history).with_lags(known.lags)
    with in_file(readings[0] if len(readings) == 1 else model):
        check_state(known, data.state, extrapolate or ())
    result = compare(known, data)
    if as_json:
        print_json(result.__dict__)
    else:
        typer.echo(f"{len(data)} readings: {1e3 * result.raw:.2f} µm RMS, after the model {1e3 * result.rms:.2f} µm")
    if limit_um is not None and 1e3 * result.rms > limit_um:
        raise typer.Exit(ExitStatus.FINDINGS)
