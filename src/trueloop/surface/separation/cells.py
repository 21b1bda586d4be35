"""Scans averaged over the cells of a grid: the randomness of a million points cannot be looked at singly."""

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.surface import Surface
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.separation.places import Places


def averaged_over_cells(
    surface: Surface, deviations: SurfaceDeviations, cells: tuple[int, int]
) -> tuple[Places, Array]:
    """Mean errors over cells of equal parameters, at the cells' centres; empty cells are left out.

    A full grid stays a grid. The scatter of a cell's mean is that of its points over the root of their number, where
    those are independent; waves shorter than two cells are lost. Raises SRF-HOLES when a quarter of the cells is empty.
    """
    (u0, u1), (v0, v1) = surface.domain
    there = deviations.measured
    u, v = (deviations.u[there] - u0) / (u1 - u0), (deviations.v[there] - v0) / (v1 - v0)
    rows, columns = cells
    cell = np.minimum((u * rows).astype(int), rows - 1) * columns + np.minimum((v * columns).astype(int), columns - 1)
    count = np.bincount(cell, minlength=rows * columns)
    total = np.bincount(cell, deviations.error_mm[there], minlength=rows * columns)
    filled = count > 0
    if np.mean(filled) < 0.75:
        raise TrueloopError(
            Code.SRF_HOLES,
            f"{np.count_nonzero(~filled)} of {rows} × {columns} cells hold no point of {deviations.name!r}",
            hint="take fewer cells: model.cells in the job",
            values={"part": deviations.name, "missing": int(np.count_nonzero(~filled))},
        )
    at_u, at_v = (np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns
    points = surface.grid_mm(u0 + (u1 - u0) * at_u, v0 + (v1 - v0) * at_v).reshape(-1, 3)
    everywhere = Places(points, np.repeat(at_u, columns), np.tile(at_v, rows), at_u, at_v)
    if np.all(filled):
        return everywhere, total / count
    return Places(points[filled], everywhere.u[filled], everywhere.v[filled]), total[filled] / count[filled]
