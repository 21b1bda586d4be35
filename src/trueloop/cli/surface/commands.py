"""`trueloop surface`: free-form surfaces, from measured parts to a corrected surface and program."""

from dataclasses import dataclass
from typing import Annotated, Literal

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.numbers import positive
from trueloop.cli.store_options import StoreChoice, kept_as_dict
from trueloop.cli.surface.compare import compare
from trueloop.cli.surface.options import EarlierParts, JobFile, KeepOutliers, Nominal, Run, Workers, read
from trueloop.cli.surface.simulate import simulate
from trueloop.cli.terminal import AsJson, busy, print_json, print_lines
from trueloop.errors import Finding
from trueloop.units import UM_PER_MM

app = typer.Typer(
    help="Free-form surfaces: deviations, machining pattern, corrected surface and program.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(simulate)
app.command()(compare)


@app.command()
@guarded
def deviations(job: JobFile, run: Run, as_json: AsJson = False) -> None:
    """Deviations along the normals, a CSV file a part."""
    from trueloop.formats.measurements.surface_csv import deviations_to_csv
    from trueloop.loops.surface.surface import deviations_of
    from trueloop.report.surface.summary import as_words

    given = read(job)
    inputs, findings = given.inputs, list[Finding]()
    with busy(f"{len(inputs.parts)} parts") as progress:
        found = deviations_of(inputs.surface, inputs.parts, inputs.options, trim=inputs.trim, work=run.work(progress))

        # Each part is written as it comes: thousands of them, or millions of points, are not held together.
        def next_part() -> bytes:
            part = next(found)
            findings.extend(part.findings)
            return deviations_to_csv(part)

        files = run.write(given, [(f"{part.name}-deviations.csv", next_part) for part in inputs.parts])
    if as_json:
        print_json({"findings": as_words(findings), "files": files})
    else:
        print_lines([*findings, *files])


@app.command()
@guarded
def model(job: JobFile, run: Run, as_json: AsJson = False) -> None:
    """What is deterministic and what is random in each part: a table, and a CSV file a part."""
    from trueloop.formats.measurements.surface_csv import separation_to_csv
    from trueloop.report.surface.summary import as_words, part_line, part_row

    given = read(job)
    parts = run.parts(given)
    named = [(part.deviations.name, part.separation) for part in parts]
    files = run.write(given, [(f"{name}-model.csv", separation_to_csv(name, apart)) for name, apart in named])
    findings = [finding for part in parts for finding in part.findings]
    if as_json:
        print_json({"parts": list(map(part_row, parts)), "findings": as_words(findings), "files": files})
    else:
        print_lines([*map(part_line, parts), *findings, *files])


@app.command()
@guarded
def pattern(
    job: JobFile,
    earlier: EarlierParts,
    run: Run,
    magnify: Annotated[
        float,
        typer.Option("--magnify", callback=positive, help="How many times the magnified surface shows the pattern."),
    ] = 100.0,
    as_json: AsJson = False,
) -> None:
    """The machining pattern of all parts: as STEP and IGES, pattern.json, pattern.html, maps.svg, maps as CSV."""
    from trueloop.jobs.surface.files import pattern_files
    from trueloop.jobs.surface.job import pattern_of_parts
    from trueloop.report.surface.summary import pattern_lines, pattern_summary

    together = earlier.read(job)
    given = together.read
    found = pattern_of_parts(given, run.parts(given))
    contents, notes = pattern_files(given, found, magnify)
    files, notes = run.write(given, contents), [*together.notes, *notes]
    if as_json:
        print_json(pattern_summary(found, None, notes, files))
    else:
        print_lines(pattern_lines(found, notes, files))


@app.command()
@guarded
def compensate(
    job: JobFile, run: Run, store: StoreChoice, keep_outliers: KeepOutliers = False, as_json: AsJson = False
) -> None:
    """Correct surface and program by the pattern: all files, or none when anything is wrong.

    With a store its parts count too, and the job's parts, what was measured, the programs and the correction are kept.
    """
    from trueloop.jobs.store.keeping import kept_all_the_same
    from trueloop.jobs.surface.added import with_store
    from trueloop.jobs.surface.files import corrected_files
    from trueloop.jobs.surface.job import correct_surface
    from trueloop.jobs.surface.kept import keep_surface
    from trueloop.report.surface.summary import pattern_lines, pattern_summary

    together = with_store(read(job), store.db, keep_outliers=keep_outliers)
    given = together.read
    with busy(f"correcting by {len(given.inputs.parts)} parts") as progress:
        done = correct_surface(given, work=run.work(progress))
        model, (contents, notes) = done.correction.model, corrected_files(given, done)
    kept = keep_surface(given, done, store.keeping(None))
    with kept_all_the_same(kept):
        files, notes = run.write(given, contents), [*together.notes, *done.notes, *notes]
    if as_json:
        print_json({**pattern_summary(model, done.record.id, notes, files), **kept_as_dict(kept)})
    else:
        print_lines([*pattern_lines(model, notes, files), *([] if kept is None else [kept.words])])


@app.command()
@guarded
def add(job: JobFile, run: Workers, db: Db = None, as_json: AsJson = False) -> None:
    """Keep the job's parts in a store, and say what is noticed of each new one given those before it."""
    from trueloop.jobs.store.opened import opened
    from trueloop.jobs.surface.added import add_parts, with_store
    from trueloop.report.surface.summary import added_lines, as_words

    together = with_store(read(job), db)
    store = together.store or opened(db)
    with busy(f"{len(together.read.inputs.parts)} parts") as progress:
        added = add_parts(store, together, run.work(progress))
    if as_json:
        said = {"parts": added.parts, "findings": as_words(added.findings), "notes": list(added.notes)}
        print_json({**said, **kept_as_dict(added.kept)})
    else:
        print_lines(added_lines(added.kept.words, added.parts, added.findings, added.notes))


@dataclass(frozen=True, kw_only=True)
class Passes:
    """How a surface is cut."""

    radius_mm: Annotated[float, typer.Option("--radius-mm", callback=positive, help="Radius of the ball-end cutter.")]
    scallop_um: Annotated[
        float, typer.Option("--scallop-um", callback=positive, help="Height of the ridges between passes.")
    ] = 2.0
    chord_um: Annotated[float, typer.Option("--chord-um", callback=positive, help="Chord tolerance along a pass.")] = (
        1.0
    )
    feed: Annotated[float, typer.Option("--feed", callback=positive, help="Feed in mm/min.")] = 300.0
    dialect: Annotated[Literal["linuxcnc"], typer.Option("--dialect", help="How to write it.")] = "linuxcnc"


@app.command()
@guarded
def path(surface: Nominal, passes: Passes) -> None:
    """Print a plain zig-zag program for a ball-end cutter, its tip programmed, in mm."""
    from trueloop.nc.program.dialect import dialect_named
    from trueloop.surface.compensation.zigzag import ZigzagOptions, program_text, zigzag

    with busy(f"passes over {surface.nominal}"):
        options = ZigzagOptions(
            passes.radius_mm, passes.scallop_um / UM_PER_MM, passes.chord_um / UM_PER_MM, passes.feed
        )
        made = zigzag(surface.read(), options)
    typer.echo(program_text(made, dialect_named(passes.dialect), options), nl=False)


@app.command()
@guarded
def sampling(
    surface: Nominal,
    ball_radius_mm: Annotated[
        float, typer.Option("--ball-radius-mm", callback=positive, help="Radius of the stylus tip.")
    ],
    step_mm: Annotated[
        float | None,
        typer.Option("--step-mm", callback=positive, help="Another step of the grid.  [default: the ball's radius]"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """How densely to touch a surface with a ball, and whether the ball reaches everywhere."""
    from trueloop.report.surface.summary import sampling_lines, sampling_summary
    from trueloop.surface.deviations.sampling import sampling_advice

    with busy(f"reading {surface.nominal}"):
        nominal = surface.read()
    advice = sampling_advice(nominal, ball_radius_mm, step_mm)
    if as_json:
        print_json(sampling_summary(advice, ball_radius_mm))
    else:
        print_lines(sampling_lines(advice, ball_radius_mm))
