"""`trueloop simulate`: the whole loop on a virtual machine whose errors are known."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from trueloop.cli.shared_options import Seed, argument, option
from trueloop.cli.terminal import AsJson, Group, busy, guarded, print_json
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop_lab.loops.turned import SimulatedPart, Study

Job = Annotated[Path, argument("The job; its touches say where to touch.", metavar="JOB.toml")]
Machine = Annotated[
    Path | None, option("The virtual machine.  [default: that of NIST]", "--machine", "-m", metavar="M.toml")
]


@guarded
def simulate(
    job: Job,
    machine: Machine = None,
    parts: Annotated[int, option("More than one: a study of so many parts.", "--parts", "-n", min=1)] = 1,
    seed: Seed = 0,
    workers: Annotated[int, option("Processes that a study runs on.", min=1)] = 2,
    as_json: AsJson = False,
) -> None:
    """Run the whole loop on the virtual machine.

    Semi-finish, probe, compensate, finish and measure: truth beside estimate.
    """
    from trueloop_lab.files.virtual_machine_toml import workshop_and_trial
    from trueloop_lab.loops.figures import simulated_part_as_dict, study_as_dict
    from trueloop_lab.loops.turned import simulate as simulate_part

    workshop, trial = workshop_and_trial(job, machine)
    if parts == 1:
        with busy("cutting, probing, correcting"):
            part = simulate_part(trial, workshop, seed)
        print_json(simulated_part_as_dict(part)) if as_json else _print_part(part)
        return
    from rich.console import Console
    from rich.progress import Progress

    from trueloop_lab.loops.turned import study

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
    print_json(study_as_dict(made)) if as_json else _print_study(made)


app = Group("Run the loop on LinuxCNC, headless, with a virtual part.")


@app.command()
def loop(
    job: Job,
    machine: Machine = None,
    seed: Seed = 0,
    feed_override: Annotated[
        float, option("Feed override: cutting speed over the programmed one.", min=0.1, max=10.0)
    ] = 8.0,
    as_json: AsJson = False,
) -> None:
    """Run semi-finish, probing and corrected finish cut in LinuxCNC.

    The part is what LinuxCNC really drove. It runs in namespaces of its own: several loops side by side, and a LinuxCNC
    that is running already, do not meet.
    """
    from rich.console import Console

    from trueloop_lab.files.virtual_machine_toml import workshop_and_trial
    from trueloop_lab.loops.figures import simulated_part_as_dict
    from trueloop_lab.loops.linuxcnc import drive_part

    workshop, trial = workshop_and_trial(job, machine)
    with Console(stderr=True).status("starting") as status:
        part = drive_part(trial, workshop, seed=seed, feed_override=feed_override, say=status.update)
    print_json(simulated_part_as_dict(part)) if as_json else _print_part(part)


def _print_part(part: "SimulatedPart") -> None:
    """A row a feature, then what became of the promise."""
    from rich.console import Console
    from rich.table import Table

    from trueloop_lab.loops.figures import rms_by_feature_um

    table = Table("feature", box=None, pad_edge=False)
    for heading in ("touches", "semi-finish\ntruth", "\nprobed", "finish\ntruth", "\nCMM", "\npredicted ±U"):
        table.add_column(heading, justify="right")
    for name, touches, columns_um in rms_by_feature_um(part):
        table.add_row(name, str(touches), *(f"{value:.2f}" for value in columns_um))
    console = Console(highlight=False, soft_wrap=True)
    console.print("RMS in µm over the touches of each feature\n")
    console.print(table)
    console.print(
        f"\nTrue residual {part.residual_rms_mm * UM_PER_MM:.2f} µm RMS over {len(part.touches.point)} points, "
        f"worst {part.residual_worst_mm * UM_PER_MM:.2f} µm; {part.coverage:.0%} of them inside the "
        "predicted 95 % band."
    )


def _print_study(study: "Study") -> None:
    """Prints a study as text."""
    lines = (
        ("as programmed", "uncorrected_mm"),
        ("the loop", "loop_mm"),
        ("tangent paths (junctions = path)", "path_mm"),
        ("each touch for itself", "raw_mm"),
    )
    print(f"True residual after one compensation, {len(study.parts)} parts, RMS in µm")
    for words, way in lines:
        print(f"  {words:<34} {study.rms_mm(way) * UM_PER_MM:8.2f}")
    print(f"The predicted 95 % bands hold {study.coverage:.1%} of the true residuals.")
