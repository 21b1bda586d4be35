"""What a round nose leaves, by geometry alone: the union of discs along a path, written apart from the product.

A surface is found on the normal through a nominal point, as the place nearest to the material that any disc reaches.
It knows no side: an outside, a bore and a back face are all air where discs were.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tests.support.linuxcnc import Move

Array = NDArray[np.float64]
STEP_MM = 0.002


def centres_of(moves: Sequence[Move]) -> Array:
    """Places of the nose's centre along the cutting moves of LinuxCNC's interpreter, (n, 2) as (x, z)."""
    return np.concatenate([_along(move) for move in moves if move.kind != "rapid"])


def _along(move: Move) -> Array:
    start, end = (np.array([at[0], at[2]]) for at in (move.start_mm, move.end_mm))
    if move.centre_mm is None:
        count = max(2, math.ceil(float(np.linalg.norm(end - start)) / STEP_MM))
        return np.asarray(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))
    centre = np.array([move.centre_mm[0], move.centre_mm[2]])
    arm, sweep = start - centre, float(move.sweep_rad or 0.0)
    count = max(3, math.ceil(abs(sweep) * float(np.linalg.norm(arm)) / STEP_MM))
    turned = math.atan2(arm[0], arm[1]) - np.linspace(0.0, sweep, count)
    return np.asarray(centre + np.linalg.norm(arm) * np.column_stack([np.sin(turned), np.cos(turned)]))


def left_on_mm(centres: Array, radius_mm: float, nominal: Array, normal: Array, reach_mm: float = 0.5) -> Array:
    """Where the material ends on the outward normal through each nominal point, (n,): positive is left on."""
    found = np.full(len(nominal), math.inf)
    for k, (point, out) in enumerate(zip(nominal, normal, strict=True)):
        near = centres[np.linalg.norm(centres - point, axis=1) < radius_mm + 2.0 * reach_mm]
        along = (near - point) @ out
        across = (near - point) @ np.array([out[1], -out[0]])
        hit = np.abs(across) < radius_mm
        found[k] = np.min(along[hit] - np.sqrt(radius_mm**2 - across[hit] ** 2))
    return found


def moved(centres: Array, error_mm: Callable[[Array], Array]) -> Array:
    """The same cut by a machine that stands elsewhere than it was sent, by (x, z) `error_mm` at each place."""
    return np.asarray(centres + error_mm(centres))
