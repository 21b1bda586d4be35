"""`trueloop measure plan`: a job's gauging points as a list for a measuring machine."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import put

Job = Annotated[Path, typer.Argument(metavar="JOB.toml", help="The job whose points are to be measured.")]
Angles = Annotated[
    list[float] | None,
    typer.Option("--angle", help="Where about the part's axis, degrees from x to y; several times.  [default: 0]"),
]
Diameters = Annotated[
    bool, typer.Option("--diameters", help="Touch cylinders also half a turn further, so that diameters are measured.")
]
Output = Annotated[Path | None, typer.Option("--output", "-o", help="File to write.  [default: the list on stdout]")]


@guarded
def plan(job: Job, angle: Angles = None, diameters: Diameters = False, output: Output = None) -> None:
    """List where a measuring machine is to touch the part, with normals."""
    from trueloop.formats.measurements.cmm_plan_csv import cmm_plan_to_csv
    from trueloop.jobs.measuring import read_measuring

    measuring = read_measuring(job, angle or (0.0,), diameters=diameters)
    put(cmm_plan_to_csv(measuring.plan), output, measuring.files)
