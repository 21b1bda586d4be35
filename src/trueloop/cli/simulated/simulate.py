"""`trueloop simulate`: the whole loop on a virtual machine whose errors are known."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy, print_json

Job = Annotated[Path, typer.Argument(metavar="JOB.toml", help="The job; its touches say where to touch.")]
Machine = Annotated[
    Path | None, typer.Option("--machine", "-m", metavar="M.toml", help="The virtual machine.  [default: that of NIST]")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of the random errors: the same gives the same part.")]


@guarded
def simulate(
    job: Job,
    machine: Machine = None,
    parts: Annotated[int, typer.Option("--parts", "-n", min=1, help="More than one: a study of so many parts.")] = 1,
    seed: Seed = 0,
    workers: Annotated[int, typer.Option("--workers", min=1, help="Processes that a study runs on.")] = 2,
    as_json: AsJson = False,
) -> None:
    """Semi-finish, probe, compensate, finish and measure on the virtual machine: truth beside estimate."""
    from trueloop.cli.simulated import summary
    from trueloop.jobs.simulated import workshop_and_trial
    from trueloop.loops.simulated.simulated import simulate as simulate_part
    from trueloop.report.turned.simulated import simulated_part_as_dict, study_as_dict

    workshop, trial = workshop_and_trial(job, machine)
    if parts == 1:
        with busy("cutting, probing, correcting"):
            part = simulate_part(trial, workshop, seed)
        print_json(simulated_part_as_dict(part)) if as_json else summary.print_part(part)
        return
    from rich.console import Console
    from rich.progress import Progress

    from trueloop.loops.simulated.study import study

    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task("parts", total=parts)
        made = study(
            trial,
            workshop,
            parts,
            first_seed=seed,
            workers=workers,
            progress=lambda done: progress.update(task, completed=done),
        )
    print_json(study_as_dict(made)) if as_json else summary.print_study(made)
