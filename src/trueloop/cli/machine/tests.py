"""`trueloop machine positioning` and `drift`: tests of a machine after ISO 230-2 and ISO 230-3."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.numbers import positive
from trueloop.cli.terminal import AsJson, print_json
from trueloop.units import UM_PER_MM

Page = Annotated[Path | None, typer.Option("--out", "-o", metavar="PAGE.html", help="Page with the plots.")]


@guarded
def positioning(
    test: Annotated[Path, typer.Argument(metavar="TEST.csv", help="Target, approach, cycle, actual.")],
    out: Page = None,
    as_json: AsJson = False,
) -> None:
    """Analyse a positioning test after ISO 230-2: A, R, E, B, M, and every raw deviation on a page."""
    from trueloop.formats.measurements.positioning_data import read_positioning
    from trueloop.formats.outputs import write_all
    from trueloop.report.machine.positioning import positioning_page
    from trueloop.report.machine.summary import positioning_lines, positioning_summary

    found = read_positioning(test)
    if out is not None:
        write_all(out.parent, [(out.name, positioning_page(test.stem, found).encode())], inputs=(test,))
    if as_json:
        print_json(positioning_summary(found))
        return
    for line in positioning_lines(found):
        typer.echo(line)
    if out is not None:
        typer.echo(f"written: {out}")


@guarded
def drift(
    log: Annotated[Path, typer.Argument(metavar="LOG.csv", help="time_s, NAME_um, NAME_degC, NAME_rpm.")],
    out: Page = None,
    window_h: Annotated[
        float, typer.Option(callback=positive, help="Time over which the largest drift is looked for, h.")
    ] = 1.0,
    as_json: AsJson = False,
) -> None:
    """Analyse a drift test after ISO 230-3: ranges over all and within a time, plots beside the temperatures."""
    from trueloop.formats.measurements.history_csv import read_drift
    from trueloop.formats.outputs import write_all
    from trueloop.machine.drift.drift import drift as analysed
    from trueloop.report.machine.positioning import drift_page

    test = read_drift(log)
    found = [analysed(test.time_s, values, name, 3600 * window_h) for name, values in test.displacement_mm.items()]
    if out is not None:
        write_all(out.parent, [(out.name, drift_page(log.stem, test, found).encode())], inputs=(log,))
    if as_json:
        print_json({"channels": [item.__dict__ for item in found]})
        return
    for item in found:
        over_all_um, within_um = UM_PER_MM * item.total_range, UM_PER_MM * item.window_range
        typer.echo(
            f"{item.channel:<8} {over_all_um:9.2f} µm over all, {within_um:.2f} within {window_h:g} h from "
            f"{item.window_start_s / 3600:.2f} h"
        )
    if out is not None:
        typer.echo(f"written: {out}")
