"""A simulated part and a study of many as JSON."""

from trueloop.loops.simulated.simulated import SimulatedPart
from trueloop.loops.simulated.study import Study
from trueloop.units import UM_PER_MM


def simulated_part_as_dict(part: SimulatedPart) -> dict[str, object]:
    """A simulated part point by point: truth beside what was measured and predicted, µm."""
    columns_mm = {
        "semifinish_truth_um": part.semifinish_truth_mm,
        "probed_um": part.touches.error_mm,
        "finish_truth_um": part.finish_truth_mm,
        "cmm_um": part.cmm_mm,
        "half_band_um": part.correction.prediction.expanded_u_mm,
    }
    rows = zip(*((column * UM_PER_MM).tolist() for column in columns_mm.values()), strict=True)
    return {
        "record_id": part.correction.record.id,
        "true_residual_rms_um": part.residual_rms_mm * UM_PER_MM,
        "points": [
            {"point": name, **dict(zip(columns_mm, row, strict=True))}
            for name, row in zip(part.touches.point, rows, strict=True)
        ],
    }


def study_as_dict(study: Study) -> dict[str, object]:
    """The figures of a study."""
    ways = ("uncorrected_mm", "loop_mm", "path_mm", "raw_mm")
    figures: dict[str, object] = {f"{way.removesuffix('_mm')}_rms_um": study.rms_mm(way) * UM_PER_MM for way in ways}
    return {"parts": len(study.parts), **figures, "coverage_of_95_percent_bands": study.coverage}
