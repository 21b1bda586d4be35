"""Every part may be set up elsewhere: that is taken out of columns and values once, for all hypotheses."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers

SETTING: Final = (0.1, 1.0, 9.0, 80.0, 600.0)
"""Variances of a part's set-up, in variances of the noise: what is tried."""


def set_ups(part: Integers, normal: Array, place_mm: Array | None = None) -> Array:
    """How a part set up elsewhere shows along the normals: a column a part and direction, (n, columns).

    With places (n, 3) the part's frame may be turned as well; turns have the size 1 at the points' mean distance.
    """
    moved = [normal]
    if place_mm is not None:
        arms = place_mm - place_mm.mean(axis=0)
        moved.append(np.cross(arms, normal) / max(float(np.sqrt(np.mean(np.sum(arms**2, axis=1)))), 1e-9))
    ways = np.hstack(moved)
    numbers, where = np.unique(part, return_inverse=True)
    rows = np.zeros((len(part), len(numbers), ways.shape[1]))
    rows[np.arange(len(where)), where] = ways
    flat = rows.reshape(len(where), -1)
    return flat[:, np.any(np.abs(flat) > 1e-12, axis=0)]


@dataclass(frozen=True)
class TakenOut:
    """Products of columns and of values with set-ups of each variance taken out: `gram` (settings, k, k), `right`
    (settings, k), `squares` (settings,); `volume` (settings,) is −½ log det of what they add to the noise.
    """

    gram: Array
    right: Array
    squares: Array
    volume: Array
    count: int


def taken_out(set_up: Array, rows: Array, values: Array) -> TakenOut:
    """Woodbury's identity, once a variance of `SETTING`."""
    both = np.hstack([rows, values[:, None]])
    whole, across, own = both.T @ both, set_up.T @ both, set_up.T @ set_up
    products, volumes = [], []
    for variance in SETTING:
        inside = np.eye(len(own)) + variance * own
        products.append(whole - variance * across.T @ np.linalg.solve(inside, across))
        volumes.append(-0.5 * np.linalg.slogdet(inside)[1])
    left = np.stack(products)
    return TakenOut(left[:, :-1, :-1], left[:, :-1, -1], left[:, -1, -1], np.array(volumes), len(values))
