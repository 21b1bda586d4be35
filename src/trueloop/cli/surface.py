"""`trueloop surface`: free-form surfaces, from measured parts to a corrected surface and program."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy, print_json, wide_console

if TYPE_CHECKING:
    from trueloop.loops.surface import Part, SurfaceModel
    from trueloop.loops.surface_inputs import SurfaceInputs

app = typer.Typer(
    help="Free-form surfaces: deviations, machining pattern, corrected surface and program.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

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
    from trueloop.formats.surface_csv import deviations_to_csv
    from trueloop.loops.surface import deviations_of

    inputs = _read(job)
    with busy(f"{len(inputs.parts)} parts"):
        found = deviations_of(inputs.surface, inputs.parts, inputs.options, workers=workers, scheduler=scheduler)
    _write(inputs, output, {f"{d.name}-deviations.csv": deviations_to_csv(d) for d in found}, as_json)


@app.command()
@guarded
def model(
    job: JobFile, output: Output = None, workers: Workers = 1, scheduler: Scheduler = None, as_json: AsJson = False
) -> None:
    """What is deterministic and what is random in each part: a table, and a CSV file a part."""
    from trueloop.formats.surface_csv import deviations_to_csv

    inputs = _read(job)
    parts = _parts(inputs, workers, scheduler)
    files = _write_files(
        inputs, output, {f"{p.deviations.name}-deviations.csv": deviations_to_csv(p.deviations) for p in parts}
    )
    if as_json:
        print_json({"parts": [_part_row(part) for part in parts], "files": files})
        return
    console = wide_console()
    for part in parts:
        row = _part_row(part)
        console.print(
            f"{row['name']}: {row['controls']} control points, Moran's I {row['moran_i']:.4f} "
            f"(p {row['moran_p']:.3f}), "
            f"Lilliefors p {row['lilliefors_p']:.3f}, random part {row['random_sigma_um']:.2f} µm",
            markup=False,
        )


@app.command()
@guarded
def pattern(
    job: JobFile, output: Output = None, workers: Workers = 1, scheduler: Scheduler = None, as_json: AsJson = False
) -> None:
    """The machining pattern of all parts: pattern.json and pattern.html."""
    from trueloop.formats.surface_csv import pattern_to_json
    from trueloop.loops.surface import pattern_model
    from trueloop.report.surface_page import surface_page

    inputs = _read(job)
    found = pattern_model(inputs.surface, _parts(inputs, workers, scheduler), inputs.options)
    page = surface_page(inputs.name, found).encode()
    files = _write_files(inputs, output, {"pattern.json": pattern_to_json(found.pattern), "pattern.html": page})
    _say_pattern(found, files, as_json)


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
    radius_mm: Annotated[float, typer.Option("--radius-mm", help="Radius of the ball-end cutter.")],
    face: Annotated[int | None, typer.Option("--face", help="Which face of the CAD file, from 1.")] = None,
    flip: Annotated[bool, typer.Option("--flip", help="Turn the normals over.")] = False,
    scallop_um: Annotated[float, typer.Option("--scallop-um", help="Height of the ridges between passes.")] = 2.0,
    chord_um: Annotated[float, typer.Option("--chord-um", help="Chord tolerance along a pass.")] = 1.0,
    feed: Annotated[float, typer.Option("--feed", help="Feed in mm/min.")] = 300.0,
    dialect: Annotated[Literal["linuxcnc"], typer.Option("--dialect", help="How to write it.")] = "linuxcnc",
) -> None:
    """Print a plain zig-zag program for a ball-end cutter, its tip programmed, in mm."""
    from trueloop.compensation.surface_zigzag import ZigzagOptions, program_text, zigzag
    from trueloop.loops.surface_inputs import read_nominal
    from trueloop.nc.dialect import dialect_named

    with busy(f"passes over {nominal}"):
        options = ZigzagOptions(radius_mm, scallop_um / 1000, chord_um / 1000, feed)
        passes = zigzag(read_nominal(nominal, face, flip=flip), options)
    typer.echo(program_text(passes, dialect_named(dialect), options), nl=False)


def run_surface_job(job: Path, output: Path | None, workers: int, scheduler: str | None, as_json: bool) -> None:
    """Reads, models, corrects, writes and says what was done."""
    from trueloop.compensation.record import record_id, sha256_of
    from trueloop.formats.surface_csv import pattern_to_json
    from trueloop.loops.surface import correct, pattern_model
    from trueloop.report.surface_page import surface_page

    inputs = _read(job)
    found = pattern_model(inputs.surface, _parts(inputs, workers, scheduler), inputs.options)
    hashes = {file.name: sha256_of(file.read_bytes()) for file in inputs.files}
    record = record_id(hashes, {})
    with busy("correcting"):
        done = correct(found, inputs.program, inputs.cutter, record)
        contents = {"pattern.json": pattern_to_json(found.pattern)}
        if inputs.cad_file != "none":
            from trueloop.formats.cad import surface_to_bytes

            contents[f"corrected.{inputs.cad_file}"] = surface_to_bytes(done.surface.surface, inputs.cad_file)
        if done.program is not None and inputs.program is not None:
            contents[f"corrected{Path(str(inputs.program.file)).suffix}"] = done.program.source
        contents["pattern.html"] = surface_page(inputs.name, found, done).encode()
    _say_pattern(found, _write_files(inputs, output, contents), as_json)


def _read(job: Path) -> "SurfaceInputs":
    with busy(f"reading {job}"):
        from trueloop.loops.surface_inputs import read_surface_inputs

        return read_surface_inputs(job)


def _parts(inputs: "SurfaceInputs", workers: int, scheduler: str | None) -> "list[Part]":
    from trueloop.loops.surface import model_of

    with busy(f"{len(inputs.parts)} parts"):
        return model_of(inputs.surface, inputs.parts, inputs.options, workers=workers, scheduler=scheduler)


def _part_row(part: "Part") -> dict[str, object]:
    chosen = part.separation.chosen
    return {
        "name": part.deviations.name,
        "alignment": part.deviations.alignment.kind,
        "controls": str(chosen.size),
        "moran_i": chosen.moran_i,
        "moran_p": chosen.moran_p,
        "permutation_p": part.separation.permutation_p,
        "lilliefors_p": chosen.normality.lilliefors_p,
        "ks_p": chosen.normality.ks_p,
        "random_sigma_um": part.separation.sigma_mm * 1000,
    }


def _write_files(inputs: "SurfaceInputs", output: Path | None, contents: dict[str, bytes]) -> list[str]:
    from trueloop.formats.outputs import write_all

    return [str(file) for file in write_all(output or inputs.output_folder, contents, inputs.files)]


def _write(inputs: "SurfaceInputs", output: Path | None, contents: dict[str, bytes], as_json: bool) -> None:
    files = _write_files(inputs, output, contents)
    if as_json:
        print_json({"files": files})
    else:
        for file in files:
            typer.echo(file)


def _say_pattern(found: "SurfaceModel", files: list[str], as_json: bool) -> None:
    import numpy as np

    at = np.linspace(0.0, 1.0, 41)
    told = found.pattern
    largest = 1000 * float(np.max(np.abs(told.mean.grid_mm(at, at))))
    unsure = 1000 * float(np.mean(told.uncertainty_grid_mm(at, at)))
    if as_json:
        print_json(
            {
                "parts": [_part_row(part) for part in found.parts],
                "controls": str(told.size),
                "largest_um": largest,
                "uncertainty_um": unsure,
                "random_sigma_um": told.sigma_mm * 1000,
                "parts_needed": found.parts_needed,
                "outlying": [odd.name for odd in told.outlying],
                "findings": [f"{finding.code}: {finding.message}" for finding in found.findings],
                "files": files,
            }
        )
        return
    console = wide_console()
    console.print(
        f"pattern of {told.parts} parts: {told.size} control points, up to {largest:.1f} µm, known to "
        f"± {unsure:.2f} µm (95 %); random part {told.sigma_mm * 1000:.2f} µm; {found.parts_needed} parts for ± "
        f"{found.options.target_mm * 1000:g} µm",
        markup=False,
    )
    for finding in found.findings:
        console.print(f"{finding.severity} {finding.code}: {finding.message}\n  hint: {finding.hint}", markup=False)
    for file in files:
        console.print(file, markup=False)
