"""Error vectors made up for a profile."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.turned.touches.error_vectors import ErrorVectors

ErrorOf = Callable[[Array, Array], Array]
"""Part error in mm from points (n, 2) and outward normals (n, 2)."""


def touched(profile: Profile, counts: Sequence[int], error_of: ErrorOf, standard_u_mm: float = 0.0) -> ErrorVectors:
    """Evenly spread touches, `counts[i]` on feature i, with the errors that a function of point and normal gives."""
    index = np.repeat(np.arange(len(counts)), counts).astype(np.intp)
    lengths = [feature.length_mm for feature in profile.features]
    along = np.concatenate([lengths[i] * (np.arange(n) + 0.5) / max(n, 1) for i, n in enumerate(counts)])
    points = [profile.features[i].point_mm(s) for i, s in zip(index, along, strict=True)]
    normals = [profile.features[i].outward_normal(s) for i, s in zip(index, along, strict=True)]
    nominal, normal = np.array(points).reshape(-1, 2), np.array(normals).reshape(-1, 2)
    return ErrorVectors(
        tuple(f"p{k}" for k in range(len(index))),
        index,
        along,
        error_of(nominal, normal),
        np.full(len(index), standard_u_mm),
        np.zeros(len(index), dtype=np.bool_),
        nominal,
        normal,
    )


def tool_offsets(dx_mm: float, dz_mm: float) -> ErrorOf:
    """The error of a tool that stands off by (dX, dZ): n · (dX, dZ)."""
    return lambda points, normals: np.asarray(normals @ np.array([dx_mm, dz_mm]))


def noise(sigma_mm: float, seed: int = 1) -> ErrorOf:
    """Independent scatter."""
    return lambda points, normals: sigma_mm * np.random.default_rng(seed).standard_normal(len(points))


def chosen(vectors: ErrorVectors, positions: ArrayLike) -> ErrorVectors:
    """Some of the error vectors."""
    k = np.asarray(positions, dtype=np.intp)
    return ErrorVectors(
        tuple(vectors.point[i] for i in k),
        vectors.feature_index[k],
        vectors.arc_length_mm[k],
        vectors.error_mm[k],
        vectors.standard_u_mm[k],
        vectors.at_reference[k],
        vectors.nominal_mm[k],
        vectors.outward_normal[k],
    )
