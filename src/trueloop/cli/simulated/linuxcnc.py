"""`trueloop linuxcnc`: LinuxCNC as the controller of the virtual machine."""

from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.simulated.simulate import Job, Machine, Seed
from trueloop.cli.terminal import AsJson, print_json

app = typer.Typer(no_args_is_help=True, help="Run the loop on LinuxCNC, headless, with a virtual part.")


@app.command()
@guarded
def loop(
    job: Job,
    machine: Machine = None,
    seed: Seed = 0,
    feed_override: Annotated[
        float, typer.Option("--feed-override", min=0.1, max=10.0, help="How much faster than programmed it cuts.")
    ] = 8.0,
    as_json: AsJson = False,
) -> None:
    """LinuxCNC runs semi-finish, probing and corrected finish program; the part is what it really drove.

    It runs in namespaces of its own: several loops side by side, and a LinuxCNC that is running already, do not meet.
    """
    from rich.console import Console

    from trueloop.cli.simulated import summary
    from trueloop.controllers.linuxcnc.loop import drive_part
    from trueloop.jobs.simulated import workshop_and_trial
    from trueloop.report.turned.simulated import simulated_part_as_dict

    workshop, trial = workshop_and_trial(job, machine)
    with Console(stderr=True).status("starting") as status:
        driven = drive_part(trial, workshop, seed=seed, feed_override=feed_override, say=status.update)
    print_json(simulated_part_as_dict(driven.part)) if as_json else summary.print_part(driven.part)
