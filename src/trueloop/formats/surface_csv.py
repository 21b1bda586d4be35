"""Deviations and patterns of surfaces as tables."""

import json

import numpy as np

from trueloop.error_surface.pattern import Pattern
from trueloop.gauging.surface_deviations import SurfaceDeviations
from trueloop.units import UM_PER_MM

HEADER = "row,column,u,v,x_mm,y_mm,z_mm,nx,ny,nz,error_um"


def deviations_to_csv(deviations: SurfaceDeviations) -> bytes:
    """A row a point: nominal point, outward normal, error in µm, positive where material was left on.

    Row and column are empty for scattered points; holes are left out. The first line says the alignment.
    """
    kind = deviations.alignment.kind
    lines = [f"# {deviations.name}: {kind}, {np.count_nonzero(deviations.measured)} points", HEADER]
    columns = deviations.shape[1] if deviations.shape else 0
    for k in np.flatnonzero(deviations.measured):
        place = f"{k // columns + 1},{k % columns + 1}" if columns else ","
        nominal = ",".join(f"{value:.6f}" for value in deviations.nominal_mm[k])
        normal = ",".join(f"{value:.9f}" for value in deviations.normal[k])
        error = deviations.error_mm[k] * UM_PER_MM
        lines.append(f"{place},{deviations.u[k]:.9f},{deviations.v[k]:.9f},{nominal},{normal},{error:.4f}")
    return ("\n".join(lines) + "\n").encode()


def pattern_to_json(pattern: Pattern) -> bytes:
    """The pattern with its control values in µm, row by row, and those of every part."""
    told = {
        "size": {"rows": pattern.size.rows, "columns": pattern.size.columns, "degree": pattern.size.degree},
        "knots": "clamped, evenly spaced on [0, 1]",
        "sign": "positive: material left on, along the outward normal",
        "random_sigma_um": pattern.sigma_mm * UM_PER_MM,
        "parts": list(pattern.names),
        "outlying": [odd.name for odd in pattern.outlying],
        "control_um": (pattern.mean.coefficients_mm * UM_PER_MM).tolist(),
        "control_of_parts_um": {
            name: (model.coefficients_mm * UM_PER_MM).tolist()
            for name, model in zip(pattern.names, pattern.models, strict=True)
        },
    }
    return (json.dumps(told, indent=1, ensure_ascii=False) + "\n").encode()
