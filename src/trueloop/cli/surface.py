"""`trueloop surface`: free-form surfaces, from measured parts to a corrected surface and program."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.options import NoStore, StoreChoice, chosen, kept_as_dict
from trueloop.cli.shared_options import Db, Seed, argument, option, positive
from trueloop.cli.terminal import AsJson, Group, busy, print_json, print_lines
from trueloop.errors import Finding
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from trueloop.formats.outputs import Named
    from trueloop.geometry.surface import Surface
    from trueloop.jobs.surface.job import ReadSurface
    from trueloop.jobs.surface.kept_parts import Together
    from trueloop.loops.surface.surface import Part, Work


def compare(
    before: Annotated[Path, argument("The job of the parts cut before.", metavar="BEFORE.toml")],
    after: Annotated[Path, argument("The job of the parts cut after.", metavar="AFTER.toml")],
    output: Annotated[
        Path | None, option("Folder for the results.  [default: output.folder of the job after]", "--output", "-o")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compare parts cut after a correction with those before.

    Deterministic, random and worst deviations.
    """
    from trueloop.formats.outputs import write_all
    from trueloop.jobs.surface.job import compare_jobs, read_surface
    from trueloop.loops.surface.surface import Work
    from trueloop.report.surface.compare_page import compare_page, comparison_json, comparison_lines, comparison_summary

    with busy(f"comparing {before} and {after}") as progress:
        jobs = read_surface(before), read_surface(after)
        found = compare_jobs(*jobs, Work(progress=progress))
        contents = [("compare.html", compare_page(found).encode()), ("compare.json", comparison_json(found))]
        files = write_all(output or jobs[1].output_folder, contents, (*jobs[0].files, *jobs[1].files))
    if as_json:
        print_json({**comparison_summary(found), "files": list(map(str, files))})
        return
    for line in (*comparison_lines(found), *found.findings, *files):
        print(line)


JobFile = Annotated[Path, argument("The surface's job; docs/surface.md explains it.", metavar="JOB.toml")]

KeepOutliers = Annotated[bool, option("Parts count although they are outlying beyond doubt.", "--keep-outliers")]


def read(job: Path, *, several: bool = False) -> "ReadSurface":
    """A surface's job, read; of `several` faces, or of one."""
    with busy(f"reading {job}"):
        from trueloop.jobs.surface.job import read_surface, require_one_face

        found = read_surface(job)
        return found if several else require_one_face(found)


@dataclass(frozen=True, kw_only=True)
class EarlierParts:
    """Parts of a store that count with those of the job."""

    db: Annotated[
        str | None, option("Store whose parts count too.  [default: trueloop.db beside the job]", metavar="FILE|URL")
    ] = None
    no_store: NoStore = False
    keep_outliers: KeepOutliers = False

    def read(self, job: Path) -> "Together":
        """A surface's job, read, with the parts of the store."""
        from trueloop.jobs.surface.kept_parts import with_store

        return with_store(read(job), chosen(self.db, self.no_store), keep_outliers=self.keep_outliers)


@dataclass(frozen=True, kw_only=True)
class Workers:
    """Where the parts of a job are worked off."""

    workers: Annotated[int, option("Local processes to share the parts among.", min=1)] = 1
    scheduler: Annotated[str | None, option("A Dask scheduler, e.g. tcp://host:8786.", metavar="ADDRESS")] = None

    def work(self, progress: "Callable[[str], object]") -> "Work":
        """As a loop takes it."""
        from trueloop.loops.surface.surface import Work

        return Work(self.workers, self.scheduler, progress)


@dataclass(frozen=True, kw_only=True)
class Run:
    """Where the results of a job go, and where its parts are worked off."""

    output: Annotated[
        Path | None, option("Folder for the results.  [default: output.folder of the job]", "--output", "-o")
    ] = None
    workers: Workers

    def work(self, progress: "Callable[[str], object]") -> "Work":
        """As a loop takes it."""
        return self.workers.work(progress)

    def parts(self, job: "ReadSurface") -> "list[Part]":
        """Every part of the job, taken apart."""
        from trueloop.loops.surface.surface import model_of

        inputs = job.inputs
        with busy(f"{len(inputs.parts)} parts") as progress:
            return model_of(inputs.surface, inputs.parts, inputs.options, trim=inputs.trim, work=self.work(progress))

    def write(self, job: "ReadSurface", contents: "Sequence[Named]") -> list[str]:
        """The files written, all or none."""
        from trueloop.formats.outputs import write_all

        return [str(file) for file in write_all(self.output or job.output_folder, contents, job.files)]


@dataclass(frozen=True, kw_only=True)
class Nominal:
    """A nominal surface without a job."""

    nominal: Annotated[Path, argument("STEP, IGES, or a CSV grid of points.", metavar="SURFACE")]
    face: Annotated[int | None, option("Which face of the CAD file, from 1.")] = None
    flip: Annotated[bool, option("Turn the normals over.", "--flip")] = False

    def read(self) -> "Surface":
        """Returns the surface."""
        from trueloop.jobs.surface.job import read_nominal

        return read_nominal(self.nominal, self.face, flip=self.flip)


Job = Annotated[Path, argument("The surface's job; its measured parts are made anew.", metavar="JOB.toml")]
Machine = Annotated[
    Path | None, option("The mill.  [default: published variability]", "--machine", "-m", metavar="M.toml")
]


def simulate(
    job: Job,
    machine: Machine = None,
    parts: Annotated[int, option("Parts to be cut and measured.", "--parts", "-n", min=3)] = 10,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Cut, measure and correct parts on a virtual mill.

    Then cut the next part: truth beside estimate.
    """
    from trueloop_lab.files.virtual_machine_toml import mill_and_trial
    from trueloop_lab.loops.surface import simulate_surface

    with busy(f"cutting, measuring and correcting {parts} parts"):
        mill, trial = mill_and_trial(job, machine)
        figures = simulate_surface(trial, mill, parts, seed).figures
    print_json(figures) if as_json else _say(figures)


def _say(figures: dict[str, object]) -> None:
    rows = (
        (f"{figures['parts']} parts as programmed", "programmed_truth_um", "programmed_measured_um", None),
        ("what they have alike", "pattern_truth_um", "pattern_found_um", None),
        ("the next part, corrected", "corrected_truth_um", "corrected_measured_um", "corrected_predicted_um"),
        ("the program without errors", "ridges_um", None, None),
    )
    print(f"{'Deviation, RMS in µm':<28}{'truth':>8}{'found':>8}{'predicted':>11}")
    for words, *keys in rows:
        cells = [f"{figures[key]:.2f}" if key else "" for key in keys]
        print(f"{words:<28}{cells[0]:>8}{cells[1]:>8}{cells[2]:>11}".rstrip())
    print(
        f"\nTruth at {figures['places_told']} places, measured at {figures['places_measured']}. The pattern is known "
        f"to ± {figures['pattern_u95_um']:.2f} µm (95 %); that holds at {figures['pattern_inside_u95']:.0%} of "
        f"the places with truth, and at {figures['pattern_inside_u95_without_ridges']:.0%} of them with the "
        "program's own ridges taken off: the band is that of a smooth pattern, "
        "and ridges between the passes come on top."
    )


app = Group("Free-form surfaces: deviations, pattern, corrected program.")
app.add_all(simulate, compare)


@app.command()
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
def model(job: JobFile, run: Run, as_json: AsJson = False) -> None:
    """Show the deterministic and random deviations of each part.

    A table, and one CSV file per part.
    """
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
def pattern(
    job: JobFile,
    earlier: EarlierParts,
    run: Run,
    magnify: Annotated[
        float, option("Magnification of the pattern in the magnified surface.", callback=positive)
    ] = 100.0,
    as_json: AsJson = False,
) -> None:
    """Write the machining pattern that all parts have in common.

    As STEP and IGES, pattern.json, pattern.html, maps.svg and maps as CSV.
    """
    from trueloop.jobs.surface.job import pattern_files, pattern_of_parts
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
def compensate(
    job: JobFile, run: Run, store: StoreChoice, keep_outliers: KeepOutliers = False, as_json: AsJson = False
) -> None:
    """Correct surface and program by the pattern.

    Writes all files, or none if anything is wrong. With a store its parts count too, and the job's parts, what was
    measured, the programs and the correction are kept.
    """
    from trueloop.jobs.store.opened import kept_all_the_same
    from trueloop.jobs.surface.job import correct_surface, corrected_files
    from trueloop.jobs.surface.kept_parts import keep_surface, with_store
    from trueloop.report.surface.summary import pattern_lines, pattern_summary

    together = with_store(read(job, several=True), store.choice, keep_outliers=keep_outliers)
    given = together.read
    with busy(f"correcting by {len(given.inputs.parts)} parts") as progress:
        done = correct_surface(given, work=run.work(progress))
        contents, notes = corrected_files(given, done)
    kept = keep_surface(together, done, supersede=store.supersede)
    with kept_all_the_same(kept):
        files, notes = run.write(given, contents), [*together.notes, *done.notes, *notes]
    if as_json:
        print_json({**pattern_summary(done.correction, done.record.id, notes, files), **kept_as_dict(kept)})
    else:
        print_lines([*pattern_lines(done.correction, notes, files), *([] if kept is None else [kept.words])])


@app.command()
def add(job: JobFile, run: Workers, db: Db = None, as_json: AsJson = False) -> None:
    """Keep the job's parts in a store.

    What is noticed of each new part, beside those before it, is printed. The store is trueloop.db beside the
    job, which is made, where none is named. From then on its parts count.
    """
    from trueloop.jobs.surface.kept_parts import add_parts, with_store
    from trueloop.report.surface.summary import added_lines, as_words

    together = with_store(read(job), db, "made")
    with busy(f"{len(together.read.inputs.parts)} parts") as progress:
        added = add_parts(together, run.work(progress))
    if as_json:
        said = {"parts": added.parts, "findings": as_words(added.findings), "notes": list(added.notes)}
        print_json({**said, **kept_as_dict(added.kept)})
    else:
        print_lines(added_lines(added.kept.words, added.parts, added.findings, added.notes))


@dataclass(frozen=True, kw_only=True)
class Passes:
    """How a surface is cut."""

    radius_mm: Annotated[float, option("Radius of the ball-end cutter.", callback=positive)]
    scallop_um: Annotated[float, option("Height of the ridges between passes.", callback=positive)] = 2.0
    chord_um: Annotated[float, option("Chord tolerance along a pass.", callback=positive)] = 1.0
    feed: Annotated[float, option("Feed in mm/min.", callback=positive)] = 300.0
    dialect: Annotated[Literal["linuxcnc"], option("Dialect of the program.")] = "linuxcnc"


@app.command()
def path(surface: Nominal, passes: Passes) -> None:
    """Print a zig-zag program for a ball-end cutter, in mm.

    Its tip is programmed.
    """
    from trueloop.nc.program.dialect import dialect_named
    from trueloop_lab.simulator.zigzag import ZigzagOptions, program_text, zigzag

    with busy(f"passes over {surface.nominal}"):
        options = ZigzagOptions(
            passes.radius_mm, passes.scallop_um / UM_PER_MM, passes.chord_um / UM_PER_MM, passes.feed
        )
        made = zigzag(surface.read(), options)
    typer.echo(program_text(made, dialect_named(passes.dialect), options), nl=False)


@app.command()
def sampling(
    surface: Nominal,
    ball_radius_mm: Annotated[float, option("Radius of the stylus tip.", callback=positive)],
    step_mm: Annotated[
        float | None, option("Another step of the grid.  [default: the ball's radius]", callback=positive)
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compute how densely to touch a surface with a ball.

    Also whether the ball reaches everywhere.
    """
    from trueloop.report.surface.summary import sampling_lines, sampling_summary
    from trueloop.surface.deviations.deviations import sampling_advice

    with busy(f"reading {surface.nominal}"):
        nominal = surface.read()
    advice = sampling_advice(nominal, ball_radius_mm, step_mm)
    if as_json:
        print_json(sampling_summary(advice, ball_radius_mm))
    else:
        print_lines(sampling_lines(advice, ball_radius_mm))
