"""`trueloop machine drift-fit` and `drift-predict`: displacements from the past of temperatures and speeds."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.machine.options import Extrapolate, ModelFile
from trueloop.cli.terminal import AsJson, print_json

LogFile = Annotated[Path, typer.Argument(metavar="LOG.csv", help="time_s, NAME_um, NAME_degC, NAME_rpm.")]


@guarded
def drift_fit(
    log: LogFile,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the results.")],
    hold_out: Annotated[
        float, typer.Option(min=0.05, max=0.9, help="Share of the time, at its end, that is predicted to judge.")
    ] = 0.3,
    as_json: AsJson = False,
) -> None:
    """Find a model of drift, a channel at a time: all inputs, felt late. Writes drift.json and drift.html.

    The end of the log judges it, as read and where an operator's reference zeroes what is left every so many hours.
    """
    from trueloop.errors import in_file
    from trueloop.formats.measurements.history_csv import read_drift
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.drift_file import drift_to_json
    from trueloop.jobs.machine.machine_model import hashes_of
    from trueloop.machine.drift.hold_out import held_out, judged_models
    from trueloop.report.machine.drift import drift_model_page
    from trueloop.report.machine.summary import drift_lines, drift_summary

    test = read_drift(log)
    with in_file(log):
        runs = held_out(test, hold_out)
        models = judged_models(test, runs)
    page = drift_model_page(log.stem, test, models, runs)
    files = {"drift.json": drift_to_json(models, hashes_of([log])).encode(), "drift.html": page.encode()}
    write_all(out, files.items(), inputs=(log,))
    if as_json:
        print_json(drift_summary(models, runs))
        return
    for line in drift_lines(runs, hold_out):
        typer.echo(line)
    typer.echo(f"written: {out / 'drift.json'}, {out / 'drift.html'}")


@guarded
def drift_predict(
    model: Annotated[Path, typer.Argument(metavar="DRIFT.json", help="As `trueloop machine drift-fit` wrote it.")],
    log: LogFile,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="PREDICTED.csv", help="time_s and NAME_um, predicted.")],
    extrapolate: Extrapolate = None,
    as_json: AsJson = False,
) -> None:
    """Predict displacements over a log that begins in equilibrium; where it holds them too, say what is left."""
    from trueloop.errors import in_file
    from trueloop.formats.measurements.history_csv import drift_csv, read_drift
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.drift_file import read_drift_models
    from trueloop.machine.drift.hold_out import compared, predicted_um

    models, test = read_drift_models(model), read_drift(log, displacements=False)
    with in_file(log):
        found = predicted_um(models, test, extrapolate or ())
    write_all(out.parent, [(out.name, drift_csv(test.time_s, found).encode())], inputs=(model, log))
    left = compared(found, test)
    if as_json:
        print_json(
            {"left_um_rms": {name: {"as_read": whole, "without_mean": rest} for name, (whole, rest) in left.items()}}
        )
        return
    for name, (whole, rest) in left.items():
        typer.echo(f"{name:<8} {whole:.2f} µm RMS off what was read, {rest:.2f} when zeroed on its mean")
    typer.echo(f"written: {out}, {len(found)} channels at {len(test.time_s)} times")


@guarded
def add_drift(
    model: ModelFile,
    drift: Annotated[Path, typer.Argument(metavar="DRIFT.json", help="As `trueloop machine drift-fit` wrote it.")],
    channels: Annotated[
        list[str],
        typer.Option(
            "--channel",
            metavar="NAME=ERROR",
            help="Channel and the displacement of place that it is, as z=EZ0S; z=-EZ0S where it reads the other way.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE.json", help="The model with the drift.")],
) -> None:
    """Make drifts terms of a machine model, for `compensate`: a channel is the tool as seen from the work."""
    from trueloop.errors import in_file
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.drift_file import read_drift_models
    from trueloop.formats.tables.model_file import model_to_json, read_model
    from trueloop.jobs.machine.machine_model import hashes_of
    from trueloop.machine.drift.terms import turned, with_drift
    from trueloop.machine.model.names import error_name

    known, drifts = read_model(model), read_drift_models(drift)
    for text in channels:
        channel, _, error = (part.strip() for part in text.partition("="))
        if channel not in drifts:
            raise typer.BadParameter(f"{channel!r} is none of {', '.join(drifts)}", param_hint="--channel")
        one = turned(drifts[channel]) if error.startswith("-") else drifts[channel]
        with in_file(model):
            known = with_drift(known, one, error_name(error.removeprefix("-")))
    made = model_to_json(known, hashes_of([model, drift])).encode()
    write_all(out.parent, [(out.name, made)], inputs=(model, drift))
    typer.echo(f"written: {out}, {len(known.terms)} terms, {len(known.lags)} lags; give `compensate` a log: -t LOG.csv")
