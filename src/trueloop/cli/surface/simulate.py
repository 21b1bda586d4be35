"""`trueloop surface simulate`: the loop of a surface on a virtual mill whose errors are known."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.simulated.simulate import Seed
from trueloop.cli.terminal import AsJson, busy, print_json

Job = Annotated[Path, typer.Argument(metavar="JOB.toml", help="The surface's job; its measured parts are made anew.")]
Machine = Annotated[
    Path | None, typer.Option("--machine", "-m", metavar="M.toml", help="The mill.  [default: published variability]")
]


@guarded
def simulate(
    job: Job,
    machine: Machine = None,
    parts: Annotated[int, typer.Option("--parts", "-n", min=3, help="Parts to be cut and measured.")] = 10,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Cut parts on a virtual mill, measure, correct, cut the next part: truth beside estimate."""
    from trueloop.jobs.simulated import mill_and_trial
    from trueloop.loops.simulated.simulated_surface import simulate_surface

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
