"""What `simulate` and `linuxcnc loop` say of a part: truth beside estimate."""

from trueloop.loops.simulated.simulated import SimulatedPart
from trueloop.loops.simulated.study import Study
from trueloop.report.turned.simulated import rms_by_feature_um
from trueloop.units import UM_PER_MM


def print_part(part: SimulatedPart) -> None:
    """A row a feature, then what became of the promise."""
    from rich.console import Console
    from rich.table import Table

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


def print_study(study: Study) -> None:
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
