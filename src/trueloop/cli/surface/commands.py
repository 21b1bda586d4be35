"""`trueloop surface`: free-form surfaces, from measured parts to a corrected surface and program."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.numbers import positive
from trueloop.cli.surface.cad import pattern_files, trimmed_file
from trueloop.cli.surface.compare import compare
from trueloop.cli.surface.simulate import simulate
from trueloop.cli.terminal import AsJson, busy
from trueloop.errors import Finding, in_file
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.formats.outputs import Named
    from trueloop.loops.surface.inputs import SurfaceInputs
    from trueloop.loops.surface.surface import Part, SurfaceCorrection, SurfaceModel
    from trueloop.surface.compensation.pattern import WrittenPattern

app = typer.Typer(
    help="Free-form surfaces: deviations, machining pattern, corrected surface and program.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(simulate)
app.command()(compare)

JobFile = Annotated[Path, typer.Argument(metavar="JOB.toml", help="The surface's job; docs/surface.md explains it.")]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", help="Folder for the results.  [default: output.folder of the job]")
]
Workers = Annotated[int, typer.Option("--workers", min=1, help="Local processes to share the parts among.")]
Scheduler = Annotated[
    str | None, typer.Option("--scheduler", metavar="ADDRESS", help="A Dask scheduler, e.g. tcp://host:8786.")
]


@app.command()
@guarded
def deviations(
    job: JobFile, output: Output = None, workers: Workers = 1, scheduler: Scheduler = None, as_json: AsJson = False
) -> None:
    """Deviations along the normals, a CSV file a part."""
    from trueloop.cli.surface.summary import say_files
    from trueloop.formats.measurements.surface_csv import deviations_to_csv
    from trueloop.loops.surface.surface import Work, deviations_of

    inputs = _read(job)
    with busy(f"{len(inputs.parts)} parts") as told:
        work = Work(workers, scheduler, told)
        found = deviations_of(inputs.surface, inputs.parts, inputs.options, trim=inputs.trim, work=work)
        # Each part is written as it comes: thousands of them, or millions of points, are not held together.
        names, findings = [f"{part.name}-deviations.csv" for part in inputs.parts], list[Finding]()

        def next_part() -> bytes:
            part = next(found)
            findings.extend(part.findings)
            return deviations_to_csv(part)

        files = _write(inputs, output, [(name, next_part) for name in names])
    say_files(files, findings, as_json)


@app.command()
@guarded
def model(
    job: JobFile, output: Output = None, workers: Workers = 1, scheduler: Scheduler = None, as_json: AsJson = False
) -> None:
    """What is deterministic and what is random in each part: a table, and a CSV file a part."""
    from trueloop.cli.surface.summary import say_parts
    from trueloop.formats.measurements.surface_csv import separation_to_csv

    inputs = _read(job)
    parts = _parts(inputs, workers, scheduler)
    named = [(part.deviations.name, part.separation) for part in parts]
    files = _write(inputs, output, [(f"{name}-model.csv", separation_to_csv(name, apart)) for name, apart in named])
    say_parts(parts, files, as_json)


@app.command()
@guarded
def pattern(
    job: JobFile,
    output: Output = None,
    magnify: Annotated[
        float,
        typer.Option("--magnify", callback=positive, help="How many times the magnified surface shows the pattern."),
    ] = 100.0,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    as_json: AsJson = False,
) -> None:
    """The machining pattern of all parts: as STEP and IGES, pattern.json, pattern.html, maps.svg, maps as CSV."""
    from trueloop.cli.surface.summary import say_pattern
    from trueloop.loops.surface.surface import pattern_model

    inputs = _read(job)
    parts = _parts(inputs, workers, scheduler)
    with in_file(inputs.job):
        found = pattern_model(inputs.surface, parts, inputs.options, trim=inputs.trim)
    cad, written, notes = pattern_files(inputs, found, magnify)
    contents = [*cad, *_pattern_files(inputs, found, written=written)]
    say_pattern(found, _write(inputs, output, contents), as_json, notes=notes)


@app.command()
@guarded
def compensate(
    job: JobFile, output: Output = None, workers: Workers = 1, scheduler: Scheduler = None, as_json: AsJson = False
) -> None:
    """Correct surface and program by the pattern: all files, or none when anything is wrong."""
    run_surface_job(job, output, workers, scheduler, as_json)


@app.command()
@guarded
def path(
    nominal: Annotated[Path, typer.Argument(metavar="SURFACE", help="STEP, IGES, or a CSV grid of points.")],
    radius_mm: Annotated[float, typer.Option("--radius-mm", callback=positive, help="Radius of the ball-end cutter.")],
    face: Annotated[int | None, typer.Option("--face", help="Which face of the CAD file, from 1.")] = None,
    flip: Annotated[bool, typer.Option("--flip", help="Turn the normals over.")] = False,
    scallop_um: Annotated[
        float, typer.Option("--scallop-um", callback=positive, help="Height of the ridges between passes.")
    ] = 2.0,
    chord_um: Annotated[
        float, typer.Option("--chord-um", callback=positive, help="Chord tolerance along a pass.")
    ] = 1.0,
    feed: Annotated[float, typer.Option("--feed", callback=positive, help="Feed in mm/min.")] = 300.0,
    dialect: Annotated[Literal["linuxcnc"], typer.Option("--dialect", help="How to write it.")] = "linuxcnc",
) -> None:
    """Print a plain zig-zag program for a ball-end cutter, its tip programmed, in mm."""
    from trueloop.loops.surface.inputs import read_nominal
    from trueloop.nc.program.dialect import dialect_named
    from trueloop.surface.compensation.zigzag import ZigzagOptions, program_text, zigzag

    with busy(f"passes over {nominal}"):
        options = ZigzagOptions(radius_mm, scallop_um / UM_PER_MM, chord_um / UM_PER_MM, feed)
        passes = zigzag(read_nominal(nominal, face, flip=flip), options)
    typer.echo(program_text(passes, dialect_named(dialect), options), nl=False)


@app.command()
@guarded
def sampling(
    nominal: Annotated[Path, typer.Argument(metavar="SURFACE", help="STEP, IGES, or a CSV grid of points.")],
    ball_radius_mm: Annotated[
        float, typer.Option("--ball-radius-mm", callback=positive, help="Radius of the stylus tip.")
    ],
    step_mm: Annotated[
        float | None,
        typer.Option("--step-mm", callback=positive, help="Another step of the grid.  [default: the ball's radius]"),
    ] = None,
    face: Annotated[int | None, typer.Option("--face", help="Which face of the CAD file, from 1.")] = None,
    flip: Annotated[bool, typer.Option("--flip", help="Turn the normals over.")] = False,
    as_json: AsJson = False,
) -> None:
    """How densely to touch a surface with a ball, and whether the ball reaches everywhere."""
    from trueloop.cli.surface.summary import say_sampling
    from trueloop.loops.surface.inputs import read_nominal
    from trueloop.surface.deviations.sampling import sampling_advice

    with busy(f"reading {nominal}"):
        surface = read_nominal(nominal, face, flip=flip)
    say_sampling(sampling_advice(surface, ball_radius_mm, step_mm), ball_radius_mm, as_json)


def run_surface_job(job: Path, output: Path | None, workers: int, scheduler: str | None, as_json: bool) -> None:
    """Reads, models, corrects, writes and says what was done."""
    from trueloop.cli.surface.summary import say_pattern
    from trueloop.domain.record import MARK
    from trueloop.loops.surface.correction import correct_job
    from trueloop.loops.surface.surface import Work

    inputs = _read(job)
    with busy(f"correcting by {len(inputs.parts)} parts") as told:
        done = correct_job(inputs, work=Work(workers, scheduler, told))
        correction, record = done.correction, done.record
        contents, notes = _cad_file(inputs, correction, f"{MARK}: record {record.id}")
        if correction.program is not None and inputs.program is not None:
            contents.append((f"corrected{Path(str(inputs.program.file)).suffix}", correction.program.source))
        contents += _pattern_files(inputs, correction.model, correction)
        contents.append(("record.json", record.to_json().encode()))
    say_pattern(correction.model, _write(inputs, output, contents), as_json, record.id, (*done.notes, *notes))


def _cad_file(inputs: "SurfaceInputs", correction: "SurfaceCorrection", mark: str) -> "tuple[list[Named], list[str]]":
    """The corrected surface, trimmed as the nominal face; a note where it had to be left whole."""
    if inputs.cad_file == "none":
        return [], []
    file, notes = trimmed_file(inputs, correction.surface.surface, f"corrected.{inputs.cad_file}", mark)
    return [file], notes


def _pattern_files(
    inputs: "SurfaceInputs",
    found: "SurfaceModel",
    correction: "SurfaceCorrection | None" = None,
    written: "Sequence[WrittenPattern]" = (),
) -> "list[Named]":
    from trueloop.formats.measurements.surface_csv import maps_to_csv, pattern_to_json
    from trueloop.loops.surface.surface import maps_of
    from trueloop.report.surface.page import maps_picture, surface_page

    return [
        ("pattern.json", pattern_to_json(found.pattern)),
        ("pattern.html", surface_page(inputs.name, found, correction, written).encode()),
        ("maps.svg", maps_picture(found).encode()),
        *((f"{maps.name}-maps.csv", maps_to_csv(maps, normal)) for maps, normal in maps_of(found)),
    ]


def _read(job: Path) -> "SurfaceInputs":
    with busy(f"reading {job}"):
        from trueloop.loops.surface.inputs import read_surface_inputs

        return read_surface_inputs(job)


def _parts(inputs: "SurfaceInputs", workers: int, scheduler: str | None) -> "list[Part]":
    from trueloop.loops.surface.surface import Work, model_of

    with busy(f"{len(inputs.parts)} parts") as told:
        work = Work(workers, scheduler, told)
        return model_of(inputs.surface, inputs.parts, inputs.options, trim=inputs.trim, work=work)


def _write(inputs: "SurfaceInputs", output: Path | None, contents: "list[Named]") -> list[str]:
    from trueloop.formats.outputs import write_all

    return [str(file) for file in write_all(output or inputs.output_folder, contents, inputs.files)]
