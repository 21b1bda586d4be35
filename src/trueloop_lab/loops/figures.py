"""A simulated part and a study of many as JSON."""

from trueloop.arrays import Array
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM
from trueloop_lab.loops.turned import SimulatedPart, Study


def simulated_part_as_dict(part: SimulatedPart) -> dict[str, object]:
    """Converts a simulated part point by point: truth beside what was measured and predicted, µm."""
    columns_um = _columns_um(part)
    rows = zip(*(column.tolist() for column in columns_um.values()), strict=True)
    return {
        "record_id": part.correction.record.id,
        "true_residual_rms_um": part.residual_rms_mm * UM_PER_MM,
        "points": [
            {"point": name, **dict(zip(columns_um, row, strict=True))}
            for name, row in zip(part.touches.point, rows, strict=True)
        ],
    }


def rms_by_feature_um(part: SimulatedPart) -> list[tuple[str, int, list[float]]]:
    """Returns every touched feature's name, number of touches, and RMS of each column of `_columns_um`."""
    columns = _columns_um(part).values()
    rows = [(name, part.touches.of_feature(i)) for i, name in enumerate(part.correction.profile.names)]
    return [(name, len(mine), [rms(column[mine]) for column in columns]) for name, mine in rows if len(mine)]


def _columns_um(part: SimulatedPart) -> dict[str, Array]:
    """Returns columns in µm, a row a touch."""
    columns_mm = {
        "semifinish_truth_um": part.semifinish_truth_mm,
        "probed_um": part.touches.error_mm,
        "finish_truth_um": part.finish_truth_mm,
        "cmm_um": part.cmm_mm,
        "half_band_um": part.correction.prediction.expanded_u_mm,
    }
    return {name: column * UM_PER_MM for name, column in columns_mm.items()}


def study_as_dict(study: Study) -> dict[str, object]:
    """Returns the figures of a study."""
    ways = ("uncorrected_mm", "loop_mm", "path_mm", "raw_mm")
    figures: dict[str, object] = {f"{way.removesuffix('_mm')}_rms_um": study.rms_mm(way) * UM_PER_MM for way in ways}
    return {"parts": len(study.parts), **figures, "coverage_of_95_percent_bands": study.coverage}
