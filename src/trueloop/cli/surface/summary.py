"""What `trueloop surface` says of parts, their pattern, and what was written; as text or as JSON."""

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from trueloop.cli.terminal import print_json, wide_console
from trueloop.errors import Finding
from trueloop.loops.surface.figures import headline, support_record
from trueloop.loops.surface.surface import Part, SurfaceModel
from trueloop.surface.deviations.sampling import SamplingAdvice
from trueloop.units import UM_PER_MM


def say_files(files: list[str], findings: Sequence[Finding], as_json: bool) -> None:
    """The files written, and what was noticed in what they hold."""
    if as_json:
        print_json({"findings": _short(findings), "files": files})
        return
    for line in (*findings, *files):
        wide_console().print(str(line), markup=False)


def say_parts(parts: Sequence[Part], files: list[str], as_json: bool) -> None:
    """A line a part: its model and what the tests say of the residuals; findings, and the files."""
    rows = [_part_row(part) for part in parts]
    findings = [finding for part in parts for finding in part.findings]
    if as_json:
        print_json({"parts": rows, "findings": _short(findings), "files": files})
        return
    console = wide_console()
    for row in rows:
        console.print(
            f"{row['name']}: {row['controls']} control points, Moran's I {row['moran_i']:.4f} "
            f"(p {row['moran_p']:.3f}), "
            f"Lilliefors p {row['lilliefors_p']:.3f}, random part {row['random_sigma_um']:.2f} µm",
            markup=False,
        )
    say_files(files, findings, as_json)


def say_pattern(
    found: SurfaceModel, files: list[str], as_json: bool, record: str | None = None, notes: Sequence[str] = ()
) -> None:
    """The pattern in figures, findings, notes, and the files."""
    told, figures = found.pattern, found.figures
    largest, unsure = UM_PER_MM * figures.largest_mm, UM_PER_MM * figures.uncertainty_mm
    if as_json:
        print_json(
            {
                "parts": [_part_row(part) for part in found.parts],
                "controls": str(told.size),
                "largest_um": largest,
                "uncertainty_um": unsure,
                "support": support_record(figures, told),
                "random_sigma_um": told.sigma_mm * UM_PER_MM,
                "parts_needed": found.parts_needed,
                "outlying": [odd.name for odd in told.outlying],
                "findings": _short(found.findings),
                "record": record,
                "notes": list(notes),
                "files": files,
            }
        )
        return
    console = wide_console()
    console.print(
        f"pattern of {told.parts} parts: {told.size} control points, up to {largest:.1f} µm, known to "
        f"± {unsure:.2f} µm (95 %); random part {told.sigma_mm * UM_PER_MM:.2f} µm; {found.parts_needed} parts for ± "
        f"{found.options.target_mm * UM_PER_MM:g} µm",
        markup=False,
    )
    if headline(figures):
        console.print(headline(figures), markup=False)
    for finding in found.findings:
        console.print(str(finding), markup=False)
    for line in (*notes, *files):
        console.print(line, markup=False)


def say_sampling(advice: SamplingAdvice, ball_radius_mm: float, as_json: bool) -> None:
    """The grid, the shortest wave it resolves, and whether the ball reaches into every hollow."""
    hollow = advice.hollow_radius_mm if np.isfinite(advice.hollow_radius_mm) else None
    if as_json:
        print_json({**asdict(advice), "hollow_radius_mm": hollow, "ball_radius_mm": ball_radius_mm})
        return
    print(
        f"grid of {advice.rows} × {advice.columns} points, {advice.step_mm:g} mm apart: it resolves waves of "
        f"{advice.shortest_wave_mm:g} mm and longer"
    )
    if hollow is None:
        print(f"the surface is nowhere concave: a ball of radius {ball_radius_mm:g} mm reaches everywhere")
    else:
        reach = "reaches everywhere" if advice.reaches_everywhere else "does not reach the ground there"
        print(f"smallest concave radius {hollow:.3f} mm: a ball of radius {ball_radius_mm:g} mm {reach}")


def _short(findings: Sequence[Finding]) -> list[str]:
    return [f"{finding.code}: {finding.message}" for finding in findings]


def _part_row(part: Part) -> dict[str, object]:
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
