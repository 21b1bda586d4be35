"""Every part may be set up elsewhere: that is taken out of columns and values once, for all hypotheses.

A turned part lies on the measuring machine closer across its axis, which is its datum, than along it: so the variances
of set-ups along X, Y and Z and of turns are tried apart. One for all makes much of what a few parts share by chance.
"""

from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers

FINE: Final = (0.2, 2.0, 20.0, 300.0)
COARSE: Final = (0.3, 8.0, 200.0)
"""Variances of a part's set-up in one way, in variances of the noise: what is tried with up to two ways, with more."""
TURN: Final = 3
"""Ways are X, Y, Z and turns, these together."""


@dataclass(frozen=True)
class SetUps:
    """How parts set up elsewhere show along the normals: `rows` (n, columns), `way` (columns,) of each, 0 to `TURN`."""

    rows: Array
    way: Integers

    @property
    def tried(self) -> Array:
        """Variances that are tried, (settings, TURN + 1); 0 in ways in which nothing shows."""
        present = sorted({int(way) for way in self.way})
        grid = FINE if len(present) <= 2 else COARSE
        found = np.zeros((len(grid) ** len(present), TURN + 1))
        found[:, present] = list(product(grid, repeat=len(present)))
        return found


def set_ups(part: Integers, normal: Array, place_mm: Array | None = None) -> SetUps:
    """A column a part and direction in which it may be moved.

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
    way = np.tile(np.minimum(np.arange(ways.shape[1]), TURN), len(numbers))
    shows = np.any(np.abs(flat) > 1e-12, axis=0)
    return SetUps(flat[:, shows], way[shows])


@dataclass(frozen=True)
class TakenOut:
    """Products of columns and of values with set-ups of each setting taken out.

    `gram` (settings, k, k), `right` (settings, k), `squares` (settings,); `volume` (settings,) is −½ log det of what
    they add to the noise, `variances` (settings, ways) are theirs, `tried` is how many settings there were.
    """

    gram: Array
    right: Array
    squares: Array
    volume: Array
    count: int
    variances: Array
    tried: int

    def only(self, which: Flags) -> "TakenOut":
        """With some of the settings alone."""
        gram, right, squares, volume = self.gram[which], self.right[which], self.squares[which], self.volume[which]
        return TakenOut(gram, right, squares, volume, self.count, self.variances[which], self.tried)


def taken_out(set_up: SetUps, rows: Array, values: Array, scatter: Array) -> TakenOut:
    """Woodbury's identity, once a setting; everything is divided by `scatter` (n,)."""
    both, own_rows = np.hstack([rows, values[:, None]]) / scatter[:, None], set_up.rows / scatter[:, None]
    whole, across, own = both.T @ both, own_rows.T @ both, own_rows.T @ own_rows
    products, volumes = [], []
    for variances in set_up.tried:
        root = np.sqrt(variances[set_up.way])
        inside = np.eye(len(own)) + root[:, None] * own * root
        scaled = root[:, None] * across
        products.append(whole - scaled.T @ np.linalg.solve(inside, scaled))
        volumes.append(-0.5 * np.linalg.slogdet(inside)[1])
    left, volume = np.stack(products), np.array(volumes)
    return TakenOut(
        left[:, :-1, :-1], left[:, :-1, -1], left[:, -1, -1], volume, len(values), set_up.tried, len(volume)
    )
