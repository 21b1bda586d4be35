"""`trueloop probe`: where to touch, the program that touches there, and what the control wrote."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from trueloop.cli.options import StoreChoice, kept_as_dict, print_findings
from trueloop.cli.shared_options import argument, option, positive
from trueloop.cli.terminal import AsJson, Group, print_json, put

app = Group("Plan touches, write probing programs, read a control's log.")

Control = Literal["linuxcnc", "fanuc", "haas", "renishaw", "siemens", "ge2000t"]
"""As `trueloop.controllers.probing.WRITERS` has them; a test compares."""

Job = Annotated[Path, argument("The job; its key `gauging.probe` names the probe.", metavar="JOB.toml")]
OfControl = Annotated[Control, option("The control.", "--control", "-c")]
OfSetup = Annotated[
    str | None, option("The set-up in which the part is clamped, where the job has several.", "--setup")
]
Output = Annotated[Path | None, option("File to write.  [default: stdout]", "--output", "-o")]


@app.command()
def plan(job: Job, setup: OfSetup = None, as_json: AsJson = False) -> None:
    """Show every touch and the way there, free of collisions.

    A row is point, feature, contact and approach.
    """
    from trueloop.jobs.measure.probing import read_probing

    probing = read_probing(job, setup=setup)
    touches = probing.plan.touches
    if as_json:
        print_json(probing.plan.as_dict())
        return
    from rich.console import Console
    from rich.table import Table

    table = Table("point", "feature", box=None, pad_edge=False)
    for heading in ("contact\nX mm", "\nZ mm", "approach\nx", "\nz", "way\npoints"):
        table.add_column(heading, justify="right")
    for touch in touches:
        numbers = (*(f"{value:.4f}" for value in touch.contact_mm), *(f"{-value:.4f}" for value in touch.normal))
        table.add_row(touch.point, touch.feature, *numbers, str(len(touch.way_mm)))
    console = Console(highlight=False, soft_wrap=True)
    console.print(table)
    stylus = probing.probe.stylus
    console.print(
        f"\nPositions are the ball's centre at contact, X a radius. {len(touches)} touches with a ball of "
        f"{2 * stylus.ball_radius_mm:.3f} mm; nothing else comes closer than {probing.probe.approach.margin_mm:.2f} mm."
    )


@app.command()
def program(
    job: Job,
    control: OfControl,
    output: Output = None,
    trials: Annotated[int, option("Touch all points in turn so many times.", min=1, max=1000, metavar="N")] = 1,
    setup: OfSetup = None,
) -> None:
    """Write the probing program for a control."""
    from trueloop.controllers.probing import probing_program
    from trueloop.controllers.probing.settings import settings_of
    from trueloop.jobs.measure.probing import read_probing

    probing = read_probing(job, setup=setup, trials=trials)
    text = probing_program(
        probing.plan, control, settings_of(probing.part.name, probing.probe.program, probing.probe.probe)
    )
    put(text, output, probing.files)


@app.command()
def read(
    job: Job,
    log: Annotated[Path, argument("Log of the control.", metavar="LOG")],
    control: OfControl,
    store: StoreChoice,
    output: Output = None,
    serial: Annotated[str | None, option("Serial number of the part.  [default: part.serial of the job]")] = None,
    points: Annotated[
        Path | None, option("List of the points that were touched.  [default: the job's]", metavar="CSV")
    ] = None,
    setup: OfSetup = None,
    as_json: AsJson = False,
) -> None:
    """Turn a control's log into the job's touches.

    Ball, pre-travel and lobing are taken off; rows are matched by place. The touches of a part with a serial number are
    kept as what the semi-finish cut left.
    """
    from trueloop.formats.measurements.touches_csv import touches_to_csv
    from trueloop.jobs.measure.keep_measured import StatedCut, keep_inspections
    from trueloop.jobs.measure.probing import inspection_of_log, read_listed, read_logged_touches, read_probing

    probing = read_probing(job, setup=setup) if points is None else read_listed(job, points, setup)
    matched = read_logged_touches(probing, log, control)
    print_findings(matched.findings)
    inspection, shown = inspection_of_log(log, matched.touches), StatedCut("semifinish")
    kept = keep_inspections([(log.name, inspection)], job, shown, store.keeping(serial))
    if kept is not None:
        typer.echo(kept.words, err=True)
        print_findings(kept.findings)
    if as_json:
        print_json({**matched.as_dict(), **kept_as_dict(kept)})
        return
    put(touches_to_csv(matched.touches), output, (*probing.files, log))


@app.command()
def trials(
    job: Job,
    log: Annotated[Path, argument("Log of the control.", metavar="LOG")],
    control: OfControl,
    output: Annotated[Path | None, option("File for the repeats.", "--output", "-o")] = None,
    setup: OfSetup = None,
    as_json: AsJson = False,
) -> None:
    """Show how well a touch repeats, from the log of `--trials`.

    The file is one that `trueloop diagnose fixture` reads: it finds a drift, a step, a part that moves.
    """
    from trueloop.formats.measurements.inspections_csv import repeats_to_csv
    from trueloop.jobs.measure.probing import read_logged_trials, read_probing
    from trueloop.units import UM_PER_MM

    probing = read_probing(job, setup=setup)
    found = read_logged_trials(probing, log, control)
    by_point = dict(zip(found.points, found.error_mm.T, strict=True))
    if output is not None:
        put(repeats_to_csv(by_point, found.successive_mm), output, (*probing.files, log))
    scatter_um, successive_um = found.pooled_mm() * UM_PER_MM, found.successive_mm * UM_PER_MM
    if as_json:
        rows = [{"point": p.point, "feature": p.feature, "scatter_um": p.scatter_mm * UM_PER_MM} for p in found.scatter]
        print_json(
            {
                "trials": len(found.error_mm),
                "scatter_um": scatter_um,
                "successive_um": successive_um,
                "degrees_of_freedom": found.freedom,
                "points": rows,
            }
        )
        return
    for one in found.scatter:
        scatter, span = one.scatter_mm * UM_PER_MM, one.range_mm * UM_PER_MM
        typer.echo(f"point {one.point} on {one.feature}: standard deviation {scatter:.2f} µm, range {span:.2f} µm")
    for feature in dict.fromkeys(found.features):
        typer.echo(f"{feature}: {found.pooled_mm(feature) * UM_PER_MM:.2f} µm")
    typer.echo(
        f"a touch repeats to {scatter_um:.2f} µm (standard deviation, {found.freedom} degrees of freedom), from trial "
        f"to trial to {successive_um:.2f} µm: `scatter_um` in the probe file's table [calibration]"
    )


@app.command()
def calibrate(
    log: Annotated[Path, argument("Touches on the sphere or ring, as logged.", metavar="LOG")],
    control: OfControl,
    radius_mm: Annotated[float, option("Radius of the sphere or ring.", callback=positive)],
    ring: Annotated[bool, option("A ring, touched from inside.", "--ring")] = False,
    lobes: Annotated[int, option("Legs of the probe's switch.", min=1)] = 3,
    inch: Annotated[bool, option("The log is in inches.", "--inch")] = False,
    x_is: Annotated[Literal["radius", "diameter"], option("X in the log: radius or diameter.")] = "diameter",
) -> None:
    """Print a probe file's [calibration]: ball radius and lobing."""
    from trueloop.formats.jobs.probe_toml import calibration_toml
    from trueloop.formats.measurements.touches_csv import read_probe_log
    from trueloop.probing.calibration import calibrate as fit

    touched = read_probe_log(log, control, inch=inch, diameter=x_is == "diameter")
    found = fit([touch.position_mm for touch in touched], radius_mm, ring=ring, lobes=lobes)
    typer.echo(calibration_toml(found), nl=False)
    for finding in found.findings:
        typer.echo(str(finding.in_file(str(log))), err=True)
