"""What `simulate` and `linuxcnc loop` say of a part: truth beside estimate."""

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.simulated.simulated import SimulatedPart
from trueloop.loops.simulated.study import Study
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM


def print_part(part: SimulatedPart) -> None:
    """A row a feature, then what became of the promise."""
    from rich.console import Console
    from rich.table import Table

    table = Table("feature", box=None, pad_edge=False)
    for heading in ("touches", "semi-finish\ntruth", "\nprobed", "finish\ntruth", "\nCMM", "\npredicted ±U"):
        table.add_column(heading, justify="right")
    touches, band = part.touches, part.correction.prediction.expanded_u_mm
    for index, name in enumerate(part.correction.profile.names):
        mine = touches.of_feature(index)
        if len(mine):
            values = (part.semifinish_truth_mm, touches.error_mm, part.finish_truth_mm, part.cmm_mm, band)
            table.add_row(name, str(len(mine)), *(_um(column[mine]) for column in values))
    console = Console(highlight=False, soft_wrap=True)
    console.print("RMS in µm over the touches of each feature\n")
    console.print(table)
    console.print(
        f"\nTrue residual {part.residual_rms_mm * UM_PER_MM:.2f} µm RMS over {len(touches.point)} points, "
        f"worst {np.max(np.abs(part.finish_truth_mm)) * UM_PER_MM:.2f} µm; {part.coverage:.0%} of them inside the "
        "predicted 95 % band."
    )


def print_study(study: Study) -> None:
    """The same for people."""
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


def _um(values: Array) -> str:
    return f"{rms(values) * UM_PER_MM:.2f}"
