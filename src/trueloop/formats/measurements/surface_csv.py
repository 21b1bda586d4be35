"""Deviations and patterns of surfaces as tables."""

import json
from dataclasses import asdict
from io import StringIO
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.pattern.part_maps import PartMaps
from trueloop.surface.pattern.pattern import Pattern
from trueloop.surface.separation.places import Places
from trueloop.surface.separation.separate import Separation
from trueloop.units import UM_PER_MM

HEADER: Final = "row,column,u,v,x_mm,y_mm,z_mm,nx,ny,nz,error_um"
PLACE: Final = ("u", "v", "x_mm", "y_mm", "z_mm")
NORMAL: Final = ("nx", "ny", "nz")
SHOWN: Final = (
    "measured_um", "deterministic_um", "random_um", "pattern_um", "predicted_um", "variability_um", "uncertainty_um",
)  # fmt: skip


def deviations_to_csv(deviations: SurfaceDeviations) -> bytes:
    """Returns a row a point: nominal point, outward normal, error in µm, positive where material was left on.

    Row and column are empty for scattered points; holes are left out. The first line states the alignment, and
    which motions it left.
    """
    kind, there = deviations.alignment.kind, np.flatnonzero(deviations.measured)
    left = "".join(f"; left with the datums: {motion}" for motion in deviations.alignment.left)
    head = [f"# {deviations.name}: {kind}, {len(there)} points{left}", HEADER]
    values = [deviations.u, deviations.v, deviations.nominal_mm, deviations.normal, deviations.error_mm * UM_PER_MM]
    rows, form = np.column_stack(values)[there], ",,%.9f,%.9f,%.6f,%.6f,%.6f,%.9f,%.9f,%.9f,%.4f"
    if deviations.shape is not None:
        place = np.stack(np.divmod(there, deviations.shape[1]), axis=1) + 1
        rows, form = np.concatenate([place, rows], axis=1), "%d,%d" + form[1:]
    return _lines(head, form, rows)


def separation_to_csv(name: str, apart: Separation) -> bytes:
    """Returns a row a place of one part: parameters on [0, 1], nominal point, and the separated errors, in µm."""
    columns = {"measured_um": apart.measured_mm, "deterministic_um": apart.measured_mm - apart.random_mm}
    return _table(name, apart.places, [], columns | {"random_um": apart.random_mm})


def maps_to_csv(maps: PartMaps, normal: Array) -> bytes:
    """Returns a row a place of one part: parameters on [0, 1], nominal point, outward normal (n, 3), maps in µm."""
    columns = {name: getattr(maps, name.replace("_um", "_mm")) for name in SHOWN}
    return _table(maps.name, maps.places, [normal], columns)


def _table(name: str, places: Places, more: list[Array], errors_mm: dict[str, Array]) -> bytes:
    head = ",".join([*PLACE, *NORMAL * len(more), *errors_mm])
    at = np.column_stack([places.u, places.v, places.points_mm, *more])
    errors = np.column_stack([values * UM_PER_MM for values in errors_mm.values()])
    form = ",".join(["%.9g"] * at.shape[1] + ["%.4f"] * errors.shape[1])
    first = f"# {name}: {len(places.u)} places; positive is material left on"
    return _lines([first, head], form, np.concatenate([at, errors], axis=1))


def _lines(head: list[str], form: str, rows: Array) -> bytes:
    """The head, then a line a row, formed by `%`: of a million rows no slower way is bearable."""
    text = StringIO()
    text.writelines(f"{line}\n" for line in head)
    text.writelines(f"{form}\n" % tuple(row) for row in rows.tolist())
    return text.getvalue().encode()


def pattern_to_json(pattern: Pattern) -> bytes:
    """Returns the pattern with its control values in µm, row by row, and those of every part."""
    document = {
        "size": asdict(pattern.mean.size),
        "size_of_parts_splines": asdict(pattern.size),
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
    return (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode()
