"""Parts of a surface, their pattern and how to measure it, in lines for people and as JSON."""

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from trueloop.errors import Finding
from trueloop.loops.surface.figures import headline, support_record
from trueloop.loops.surface.surface import Part, SurfaceCorrection, SurfaceModel
from trueloop.surface.deviations.deviations import SamplingAdvice
from trueloop.units import UM_PER_MM


def as_words(findings: Sequence[Finding]) -> list[str]:
    """Findings as JSON has them."""
    return [f"{finding.code}: {finding.message}" for finding in findings]


def part_row(part: Part) -> dict[str, object]:
    """Summarizes a part's model, the tests of its residuals, and its worst touch."""
    chosen = part.separation.chosen
    return {
        "name": part.deviations.name,
        "alignment": part.deviations.alignment.kind,
        "left_with_datums": list(part.deviations.alignment.left),
        "controls": str(chosen.size),
        "moran_i": chosen.moran_i,
        "moran_p": chosen.moran_p,
        "permutation_p": part.permutation_p,
        "geary_c": part.separation.geary_c,
        "expected_geary_c": part.separation.expected_geary_c,
        "lilliefors_p": chosen.normality.lilliefors_p,
        "ks_p": chosen.normality.ks_p,
        "random_sigma_um": part.separation.sigma_mm * UM_PER_MM,
        "worst_touch": {
            "name": part.worst.name,
            "line": part.worst.place.line,
            "off_um": part.worst.found.off_mm * UM_PER_MM,
            "p": part.worst.found.p_value,
        },
    }


def part_line(part: Part) -> str:
    """Returns a part's figures as a line of text."""
    chosen = part.separation.chosen
    return (
        f"{part.deviations.name}: {chosen.size} control points, Moran's I {chosen.moran_i:.4f} "
        f"(p {chosen.moran_p:.3f}), Lilliefors p {chosen.normality.lilliefors_p:.3f}, "
        f"random part {part.separation.sigma_mm * UM_PER_MM:.2f} µm"
    )


def pattern_summary(
    made: SurfaceModel | SurfaceCorrection, record: str | None, notes: Sequence[str], files: Sequence[str]
) -> dict[str, object]:
    """Summarizes the pattern: figures, findings, notes, and files written. `record`: the id of the correction by it."""
    model = made.model if isinstance(made, SurfaceCorrection) else made
    further = made.further if isinstance(made, SurfaceCorrection) else ()
    return {
        **_model_summary(model),
        **({"further_faces": [_model_summary(face.model) for face in further]} if further else {}),
        "findings": as_words(made.findings),
        "record": record,
        "notes": list(notes),
        "files": list(files),
    }


def _model_summary(model: SurfaceModel) -> dict[str, object]:
    pattern, figures = model.pattern, model.figures
    return {
        **({} if model.face is None else {"face": model.face}),
        "parts": [part_row(part) for part in model.parts],
        "controls": str(pattern.size),
        "largest_um": UM_PER_MM * figures.largest_mm,
        "uncertainty_um": UM_PER_MM * figures.uncertainty_mm,
        "support": support_record(figures, pattern),
        "random_sigma_um": pattern.sigma_mm * UM_PER_MM,
        "parts_needed": model.parts_needed,
        "outlying": [odd.name for odd in pattern.outlying],
    }


def added_lines(kept: str, parts: int, findings: Sequence[Finding], notes: Sequence[str]) -> list[str]:
    """Parts added to a store, with what was noticed of them."""
    noticed = [str(finding) for finding in findings] or ["nothing unusual was noticed of the new parts"]
    return [kept, f"{parts} parts of this surface by now", *noticed, *(f"- {note}" for note in notes)]


def pattern_lines(made: SurfaceModel | SurfaceCorrection, notes: Sequence[str], files: Sequence[str]) -> list[str]:
    """Returns a pattern, or the correction by it, as lines of text."""
    models = [face.model for face in made.faces] if isinstance(made, SurfaceCorrection) else [made]
    of_models = [line for model in models for line in _model_lines(model)]
    return [*of_models, *map(str, made.findings), *notes, *files]


def _model_lines(model: SurfaceModel) -> list[str]:
    pattern, figures, known = model.pattern, model.figures, headline(model.figures)
    return [
        f"{model.of_face}pattern of {pattern.of_parts}: {pattern.size} control points, up to "
        f"{UM_PER_MM * figures.largest_mm:.1f} µm, known to ± {UM_PER_MM * figures.uncertainty_mm:.2f} µm (95 %); "
        f"random part {pattern.sigma_mm * UM_PER_MM:.2f} µm; {model.parts_needed} parts for ± "
        f"{model.options.target_mm * UM_PER_MM:g} µm",
        *([model.of_face + known] if known else []),
    ]


def sampling_summary(advice: SamplingAdvice, ball_radius_mm: float) -> dict[str, object]:
    """Summarizes the grid, the shortest wave it resolves, and whether the ball reaches into every hollow."""
    hollow = advice.hollow_radius_mm if np.isfinite(advice.hollow_radius_mm) else None
    return {**asdict(advice), "hollow_radius_mm": hollow, "ball_radius_mm": ball_radius_mm}


def sampling_lines(advice: SamplingAdvice, ball_radius_mm: float) -> list[str]:
    """Returns the advice on sampling as lines of text."""
    grid = (
        f"grid of {advice.rows} × {advice.columns} points, {advice.step_mm:g} mm apart: it resolves waves of "
        f"{advice.shortest_wave_mm:g} mm and longer"
    )
    if not np.isfinite(advice.hollow_radius_mm):
        return [grid, f"the surface is nowhere concave: a ball of radius {ball_radius_mm:g} mm reaches everywhere"]
    reach = "reaches everywhere" if advice.reaches_everywhere else "does not reach the ground there"
    hollow = f"smallest concave radius {advice.hollow_radius_mm:.3f} mm"
    return [grid, f"{hollow}: a ball of radius {ball_radius_mm:g} mm {reach}"]
