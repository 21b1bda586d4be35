"""A pattern as one Gaussian field over faces of a part: shrunk by what one part, or two, cannot tell.

    δ = form + waves,  cov = (τ_f² M(d/L) + τ² M(d/ℓ)) (1 + n·n′ + same)/3,

d the distance in space, n the normals, same 1 between faces that run on into each other: thirds of a field that does
not stop at an edge, of a displacement of the part, and of one that does stop there. No parameters of a surface come in,
so seams, poles and edges between faces need no rule.

One part shows p + q, the pattern and what it alone has. With a share φ of the variance its own, cov(p) = (1 − φ) cov:
the pattern that it is expected to have is (1 − φ) times what kriging expects of the field, known to
(1 − φ)² V + φ (1 − φ) τ². No data of one part tell φ: it is stated, or `OWN_SHARE`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.surface import Surface
from trueloop.surface.on_face import SUPPORT, square
from trueloop.surface.pattern.kriging import (
    FORM_SIDES,
    LEAST_NOISE,
    RATIOS,
    STARTS,
    FieldProcess,
    Kriging,
    Process,
    apart_and_alike,
    likeliest,
    matern,
)
from trueloop.surface.pattern.support import FINE, Support, between, expectations, own_share, pooled
from trueloop.surface.separation.separate import Separation
from trueloop.surface.separation.spline_surface import SplineSurface, fit_grid

OWN_SHARE: Final = 0.04
"""Of the variance of a part's form, what no other part has: a fifth of its size, as in the published experiment, whose
parts differ by 0.8 µm about a pattern of 4.3 µm.
"""
CELLS: Final = 1500
"""Cells of all faces together in which points are averaged."""
SOME: Final = 400
"""Cells that the process is estimated from."""
WAVE: Final = 4.0
"""Lengths of a process in one of its waves."""
COARSE: Final = 41
"""Places a side of a face at which the variance is computed; between them it is interpolated."""


@dataclass(frozen=True, eq=False)
class FaceParts:
    """A face, its parts taken apart there, and the number of its group."""

    surface: Surface
    parts: Sequence[Separation]
    group: int = 0

    def places(self, u: Array, v: Array) -> Array:
        """Returns places of the field (n, 7) at shares (n,) of the face's parameters."""
        (u0, u1), (v0, v1) = self.surface.domain
        at = self.surface.partials(u0 + (u1 - u0) * u, v0 + (v1 - v0) * v)
        return np.column_stack([at.point_mm, self.surface.normal_of(at), np.full(len(u), self.group)])

    def values(self, cells: float) -> tuple[Array, Array]:
        """Returns places and every part's values there, (parts, n), in so many cells."""
        sides = self.parts[0].places.sides_mm
        values = pooled(self.parts, sides, max(1.0, cells))
        return self.places(values.at_mm[:, 0] / sides[0], values.at_mm[:, 1] / sides[1]), values.values_mm


@dataclass(frozen=True, eq=False)
class FaceField:
    """The field on one face: a model a part, how far measurements support them, and by how much (one standard
    deviation) a part's form differs from the pattern, where that is assumed, not seen.
    """

    models: tuple[SplineSurface, ...]
    support: Support
    own_mm: float | None


def fields_of(faces: Sequence[FaceParts], own_mm: float | None, *, seen: bool) -> list[FaceField]:
    """Returns the field on every face, the same parts in the same order on each.

    `seen`: the parts themselves show how much they differ. Else `own_mm` is how much a part's form differs from the
    pattern, or `OWN_SHARE` where it is not stated; models are shrunk by it.
    """
    area_mm2 = [float(np.prod(face.parts[0].places.sides_mm)) for face in faces]
    values = [face.values(CELLS * (area / sum(area_mm2))) for face, area in zip(faces, area_mm2, strict=True)]
    at = np.concatenate([places for places, _ in values])
    measured_mm = np.concatenate([of_parts for _, of_parts in values], axis=1)
    mean_mm, count = np.nanmean(measured_mm, axis=0), len(measured_mm)
    process = fitted_field(at, mean_mm)
    size_mm2 = max(float(np.mean(mean_mm**2)) - process.noise_mm2, 0.0)
    share, each_mm = (0.0, None) if seen else _own(size_mm2, count, own_mm)
    widening, krige = process.widening(sum(area_mm2)), Kriging(process, at)
    (_, u, v), (_, coarse_u, coarse_v) = square(SUPPORT), square(COARSE)
    line, grid = np.linspace(0.0, 1.0, SUPPORT), (SUPPORT, SUPPORT)
    found = []
    for face in faces:
        expected = (1 - share) * expectations(process, at, measured_mm, face.places(u, v))
        variance = between(krige.variance_mm2(face.places(coarse_u, coarse_v)).reshape(COARSE, COARSE), u, v)
        different = {id(part.places): part for part in face.parts}.values()
        near = np.max([own_share(part, part.places.sides_mm, u, v) for part in different], axis=0)
        known = np.maximum(np.clip(1 - variance / (process.waves_mm2 + process.noise_mm2), 0.0, 1.0), near)
        # Far from all points the whole variance is open, that of the pattern, of which a part's own is not.
        deviation = widening * np.sqrt((1 - share) ** 2 * variance + share * (1 - share) * size_mm2)
        support = Support(process, known.reshape(grid), deviation.reshape(grid), np.full(grid, float(count)))
        models = tuple(fit_grid((line, line), values_mm.reshape(grid), FINE) for values_mm in expected)
        found.append(FaceField(models, support, each_mm))
    return found


def _own(size_mm2: float, count: int, own_mm: float | None) -> tuple[float, float]:
    """Returns which share of the variance of the mean of parts is their own, and how much one part differs, mm."""
    if own_mm is None:
        whole = size_mm2 / (1 - OWN_SHARE + OWN_SHARE / count)
        own_mm = (OWN_SHARE * whole) ** 0.5
    own_mm2 = own_mm**2 / count
    return (min(1.0, own_mm2 / size_mm2) if size_mm2 > 0 else 1.0), own_mm


def fitted_field(at: Array, values_mm: Array) -> Process:
    """Returns the likeliest process for values (n,) at places (n, 7). Its lengths are no shorter than half the distance
    of neighbours, and its waves, each of about four lengths, no longer than the faces together: longer is form.
    """
    from scipy.spatial import KDTree  # slow to import

    size = float(np.linalg.norm(np.ptp(at[:, :3], axis=0)))
    step = float(np.median(KDTree(at[:, :3]).query(at[:, :3], k=[2])[0]))
    if len(at) > SOME:
        some = np.random.default_rng(1).choice(len(at), SOME, replace=False)
        at, values_mm = at[some], values_mm[some]
    apart, alike = apart_and_alike(at, at)
    form_of_size, low, high = alike * matern(apart / (FORM_SIDES * size)), np.log(step / 2), np.log(size / WAVE)

    def process(x: Array) -> tuple[FieldProcess, Array]:
        length = float(np.exp(np.clip(x[0], low, high)))
        form, noise = np.exp(np.clip(x[1:], *RATIOS)).tolist()
        found = FieldProcess(1.0, form, max(noise, LEAST_NOISE), (length,), (FORM_SIDES * size,))
        return found, alike * matern(apart / length) + form * form_of_size

    return likeliest(values_mm, process, [np.array([np.log(size * share), 0.0, -4.0]) for share in STARTS])
