"""`trueloop surface simulate`: the loop of a surface on a virtual mill whose errors are known."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.simulate import Seed
from trueloop.cli.terminal import AsJson, busy, print_json

if TYPE_CHECKING:
    from trueloop.loops.simulated.simulated_surface import SimulatedSurface

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
    from trueloop.loops.simulated.simulated_surface import mill_and_trial, simulate_surface

    with busy(f"cutting, measuring and correcting {parts} parts"):
        mill, trial = mill_and_trial(job, machine)
        made = simulate_surface(trial, mill, parts, seed)
    told = _told(made)
    print_json(told) if as_json else _say(told)


def _told(made: "SimulatedSurface") -> dict[str, object]:
    """RMS in µm, of true and of measured deviations."""
    import numpy as np

    from trueloop.statistics import rms
    from trueloop.units import UM_PER_MM

    off_mm = np.abs(made.pattern_mm - made.pattern_truth_mm)
    smooth_mm = np.abs(made.pattern_mm - (made.pattern_truth_mm - made.ridges_mm))
    return {
        "record_id": made.recorded.record.id,
        "parts": len(made.truth_mm),
        "places_measured": made.measured_mm.shape[1],
        "places_told": made.truth_mm.shape[1],
        "programmed_truth_um": rms(made.truth_mm) * UM_PER_MM,
        "programmed_measured_um": rms(made.measured_mm) * UM_PER_MM,
        "corrected_truth_um": rms(made.corrected_truth_mm) * UM_PER_MM,
        "corrected_measured_um": rms(made.corrected_measured_mm) * UM_PER_MM,
        "corrected_predicted_um": rms(made.predicted_mm) * UM_PER_MM,
        "pattern_truth_um": rms(made.pattern_truth_mm) * UM_PER_MM,
        "pattern_found_um": rms(made.pattern_mm) * UM_PER_MM,
        "pattern_u95_um": float(np.mean(made.pattern_u95_mm)) * UM_PER_MM,
        "pattern_inside_u95": float(np.mean(off_mm <= made.pattern_u95_mm)),
        "pattern_inside_u95_without_ridges": float(np.mean(smooth_mm <= made.pattern_u95_mm)),
        "ridges_um": rms(made.ridges_mm) * UM_PER_MM,
    }


def _say(told: dict[str, object]) -> None:
    rows = (
        (f"{told['parts']} parts as programmed", "programmed_truth_um", "programmed_measured_um", None),
        ("what they have alike", "pattern_truth_um", "pattern_found_um", None),
        ("the next part, corrected", "corrected_truth_um", "corrected_measured_um", "corrected_predicted_um"),
        ("the program without errors", "ridges_um", None, None),
    )
    print(f"{'Deviation, RMS in µm':<28}{'truth':>8}{'found':>8}{'predicted':>11}")
    for words, *keys in rows:
        cells = [f"{told[key]:.2f}" if key else "" for key in keys]
        print(f"{words:<28}{cells[0]:>8}{cells[1]:>8}{cells[2]:>11}".rstrip())
    print(
        f"\nTold at {told['places_told']} places, measured at {told['places_measured']}. The pattern is known to "
        f"± {told['pattern_u95_um']:.2f} µm (95 %); that holds at {told['pattern_inside_u95']:.0%} of the places told, "
        f"and at {told['pattern_inside_u95_without_ridges']:.0%} of them with the program's own ridges taken off: "
        "the band is that of a smooth pattern, and ridges between the passes come on top."
    )
