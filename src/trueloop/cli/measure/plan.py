"""`trueloop measure plan`: a job's gauging points for a measuring machine, as a list or as a program."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

import typer

from trueloop.cli.shared_options import positive
from trueloop.cli.terminal import guarded, put

Job = Annotated[Path, typer.Argument(metavar="JOB.toml", help="The job whose points are to be measured.")]
Angles = Annotated[
    list[float] | None,
    typer.Option("--angle", help="Where about the part's axis, degrees from x to y; several times.  [default: 0]"),
]
Diameters = Annotated[
    bool, typer.Option("--diameters", help="Touch cylinders also half a turn further, so that diameters are measured.")
]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="File to write: .dms a DMIS program, .csv a list.  [default: list on stdout]"),
]
PROGRAMS: Final = (".dms", ".dmi", ".dmis")
LISTS: Final = (".csv", ".txt")


@dataclass(frozen=True, kw_only=True)
class Moves:
    """How a program leads the ball."""

    ball_radius_mm: Annotated[
        float, typer.Option("--ball-radius-mm", callback=positive, help="Radius of the ball that the moves are for.")
    ] = 1.0
    approach_mm: Annotated[
        float, typer.Option("--approach-mm", callback=positive, help="How far before the surface a touch begins.")
    ] = 3.0
    clearance_mm: Annotated[
        float, typer.Option("--clearance-mm", callback=positive, help="How far moves between points keep outside.")
    ] = 10.0


@guarded
def plan(job: Job, moves: Moves, angle: Angles = None, diameters: Diameters = False, output: Output = None) -> None:
    """List where a measuring machine is to touch the part, with normals, or write a DMIS program that does."""
    if output is not None and output.suffix.lower() not in (*PROGRAMS, *LISTS):
        kinds = ", ".join(PROGRAMS), ", ".join(LISTS)
        raise typer.BadParameter(f"{output.name!r} ends with none of {kinds[0]} (program), {kinds[1]} (list)")
    from trueloop.formats.measurements.cmm_plan_csv import cmm_plan_to_csv
    from trueloop.jobs.measure.probing import program_of, read_measuring
    from trueloop.probing.cmm_plan import CmmApproach

    measuring = read_measuring(job, angle or (0.0,), diameters=diameters)
    if output is None or output.suffix.lower() in LISTS:
        put(cmm_plan_to_csv(measuring.touches), output, measuring.files)
        return
    approach = CmmApproach(moves.ball_radius_mm, moves.approach_mm, moves.clearance_mm, measuring.allowance_mm)
    put(program_of(measuring, approach, job.name), output, measuring.files)
