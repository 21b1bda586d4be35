"""What `simulate` and `linuxcnc loop` say of a part: truth beside estimate."""

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.simulated.simulated import SimulatedPart
from trueloop.loops.simulated.study import Study
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM


def part_as_dict(part: SimulatedPart) -> dict[str, object]:
    """Everything by gauging point, in µm."""
    return {
        "record_id": part.correction.record.id,
        "true_residual_rms_um": part.residual_rms_mm * UM_PER_MM,
        "points": [
            {"point": name, **{key: value * UM_PER_MM for key, value in row.items()}}
            for name, row in zip(part.touches.point, _rows(part), strict=True)
        ],
    }


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
    inside = float(np.mean(np.abs(part.finish_truth_mm) <= band))
    console.print(
        f"\nTrue residual {part.residual_rms_mm * UM_PER_MM:.2f} µm RMS over {len(touches.point)} points, "
        f"worst {np.max(np.abs(part.finish_truth_mm)) * UM_PER_MM:.2f} µm; {inside:.0%} of them inside the predicted "
        "95 % band."
    )


def study_as_dict(study: Study) -> dict[str, object]:
    """The figures of a study."""
    ways = ("uncorrected_mm", "loop_mm", "path_mm", "raw_mm")
    figures: dict[str, object] = {f"{way.removesuffix('_mm')}_rms_um": study.rms_mm(way) * UM_PER_MM for way in ways}
    return {"parts": len(study.parts), **figures, "coverage_of_95_percent_bands": study.coverage}


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


def _rows(part: SimulatedPart) -> list[dict[str, float]]:
    columns: dict[str, Array] = {
        "semifinish_truth_um": part.semifinish_truth_mm,
        "probed_um": part.touches.error_mm,
        "finish_truth_um": part.finish_truth_mm,
        "cmm_um": part.cmm_mm,
        "half_band_um": part.correction.prediction.expanded_u_mm,
    }
    return [{key: float(column[k]) for key, column in columns.items()} for k in range(len(part.touches.point))]


def _um(values: Array) -> str:
    return f"{rms(values) * UM_PER_MM:.2f}"
