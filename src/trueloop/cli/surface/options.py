"""Options that several commands of `trueloop surface` take."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.terminal import busy

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from trueloop.formats.outputs import Named
    from trueloop.geometry.surface import Surface
    from trueloop.jobs.surface.added import Together
    from trueloop.jobs.surface.job import ReadSurface
    from trueloop.loops.surface.surface import Part, Work

JobFile = Annotated[Path, typer.Argument(metavar="JOB.toml", help="The surface's job; docs/surface.md explains it.")]

KeepOutliers = Annotated[
    bool, typer.Option("--keep-outliers", help="Parts of the store count although they are outlying beyond doubt.")
]


def read(job: Path) -> "ReadSurface":
    """A surface's job, read."""
    with busy(f"reading {job}"):
        from trueloop.jobs.surface.job import read_surface

        return read_surface(job)


@dataclass(frozen=True, kw_only=True)
class EarlierParts:
    """Parts of a store that count with those of the job."""

    db: Annotated[
        str | None,
        typer.Option(
            "--db",
            metavar="FILE|URL",
            help="Store whose parts count too; none: no store.  [default: trueloop.db beside the job]",
        ),
    ] = None
    keep_outliers: KeepOutliers = False

    def read(self, job: Path) -> "Together":
        """A surface's job, read, with the parts of the store."""
        from trueloop.jobs.surface.added import with_store

        return with_store(read(job), self.db, keep_outliers=self.keep_outliers)


@dataclass(frozen=True, kw_only=True)
class Workers:
    """Where the parts of a job are worked off."""

    workers: Annotated[int, typer.Option("--workers", min=1, help="Local processes to share the parts among.")] = 1
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", metavar="ADDRESS", help="A Dask scheduler, e.g. tcp://host:8786.")
    ] = None

    def work(self, progress: "Callable[[str], object]") -> "Work":
        """As a loop takes it."""
        from trueloop.loops.surface.surface import Work

        return Work(self.workers, self.scheduler, progress)


@dataclass(frozen=True, kw_only=True)
class Run:
    """Where the results of a job go, and where its parts are worked off."""

    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for the results.  [default: output.folder of the job]")
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

    nominal: Annotated[Path, typer.Argument(metavar="SURFACE", help="STEP, IGES, or a CSV grid of points.")]
    face: Annotated[int | None, typer.Option("--face", help="Which face of the CAD file, from 1.")] = None
    flip: Annotated[bool, typer.Option("--flip", help="Turn the normals over.")] = False

    def read(self) -> "Surface":
        """The surface."""
        from trueloop.jobs.surface.job import read_nominal

        return read_nominal(self.nominal, self.face, flip=self.flip)
