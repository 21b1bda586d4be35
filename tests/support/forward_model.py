"""A machine by plain 4×4 homogeneous transforms, written apart from `trueloop.machine` to judge it.

From the work to the tool every axis contributes its direction (out of square), its travel, then its six errors of
motion as one small rigid motion: rotations turn about the origin on the tool's side. Lengths in mm, angles in rad.
Errors are polynomials that vanish where the axis stands at 0; straightness has a slope of its own.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIRECTION = {"X": 0, "Y": 1, "Z": 2, "A": 0, "B": 1, "C": 2}
SMALL_MM, SMALL_RAD = 0.012, 25e-6


@dataclass(frozen=True)
class ForwardMachine:
    """`letters` from work to tool, `b` the bed. Polynomials by axis: (6, degree) of powers 1, 2, … of the position over
    `reach`. `tilt` (3,) turns the direction of a linear axis; with `shift` (3,) it places the line of a rotary one in
    what carries it. `spindle` displaces and tilts the tool. `waves` (k, 6, 2) of a rotary axis are sines and cosines of
    the angle, twice the angle … that its errors hold beside the polynomials.
    """

    letters: str
    motion: Mapping[str, Array]
    tilt: Mapping[str, Array]
    shift: Mapping[str, Array]
    reach: Mapping[str, float]
    spindle: tuple[Array, Array]
    waves: Mapping[str, Array] = field(default_factory=dict)

    def pose(self, at: Mapping[str, Array], share: float = 1.0) -> Array:
        """Frame of the tool in work coordinates, (n, 4, 4), with `share` of all errors."""
        axes = self.letters.replace("b", "")
        count = len(at[axes[0]])
        whole = np.broadcast_to(np.eye(4), (count, 4, 4))
        for letter in axes:
            whole = whole @ self._axis(letter, at[letter], share)
        posed: Array = whole @ _rigid(*(np.tile(share * v, (count, 1)) for v in self.spindle))
        return posed

    def error_mm(self, at: Mapping[str, Array], tool: Array) -> Array:
        """Actual − commanded position of the tool point, (n, 3)."""
        ends = np.concatenate([tool, np.ones((len(tool), 1))], axis=1)[:, :, None]
        error: Array = ((self.pose(at) - self.pose(at, 0.0)) @ ends)[:, :3, 0]
        return error

    def rotation_rad(self, at: Mapping[str, Array]) -> Array:
        """Actual − commanded rotation of the tool, (n, 3), small."""
        turn = self.pose(at)[:, :3, :3] @ np.swapaxes(self.pose(at, 0.0)[:, :3, :3], -1, -2)
        skew = 0.5 * (turn - np.swapaxes(turn, -1, -2))
        vector: Array = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
        return vector

    def _axis(self, letter: str, position: Array, share: float) -> Array:
        powers = np.stack([(position / self.reach[letter]) ** (k + 1) for k in range(self.motion[letter].shape[1])])
        six = share * (self.motion[letter] @ powers).T
        for k, wave in enumerate(self.waves.get(letter, ()), 1):
            turn = k * position[:, None]
            six = six + share * (wave[:, 0] * np.sin(turn) + wave[:, 1] * (np.cos(turn) - 1.0))
        along = np.zeros((len(position), 3))
        along[:, DIRECTION[letter]] = position
        tilt = np.tile(share * self.tilt[letter], (len(position), 1))
        if letter in "XYZ":
            return _rigid(along + np.cross(tilt, along), 0 * along) @ _rigid(six[:, :3], six[:, 3:])
        line = _rigid(np.tile(share * self.shift[letter], (len(position), 1)), tilt)
        moved = _rigid(0 * along, along) @ _rigid(six[:, :3], six[:, 3:])
        return moved @ line if self.letters.index(letter) < self.letters.index("b") else line @ moved


def random_machine(
    structure: str,
    travel: Mapping[str, tuple[float, float]],
    rng: np.random.Generator,
    *,
    degree: int = 3,
    plane: bool = False,
) -> ForwardMachine:
    """Every error some 10 µm and 25 µrad at the end of travel; `structure` in letters, `w X b Y Z (S) t`.

    In the `plane` of turning there are displacements along X and Z and rotations about Y alone.
    """
    letters = re.sub(r"\(.\)|[wt ]", "", structure)
    axes = letters.replace("b", "")
    mm, rad = np.array([[1, 0, 1], [0, 1, 0]] if plane else np.ones((2, 3))) * [[SMALL_MM], [SMALL_RAD]]
    size = np.concatenate([mm, rad])[:, None]
    return ForwardMachine(
        letters,
        {a: rng.normal(0, 1, (6, degree)) * size / np.arange(1, degree + 1) for a in axes},
        {a: rng.normal(0, 1, 3) * rad for a in axes},
        {a: rng.normal(0, 1, 3) * mm for a in axes},
        {a: max(map(abs, travel[a])) for a in axes},
        (rng.normal(0, 1, 3) * mm, rng.normal(0, 1, 3) * rad * [1, 1, 0]),
    )


def _rigid(shift: Array, vector: Array) -> Array:
    """Homogeneous matrices (n, 4, 4): turned by rotation vectors, then shifted."""
    angle = np.maximum(np.linalg.norm(vector, axis=1), 1e-300)[:, None, None]
    x, y, z = vector.T
    zero = np.zeros_like(x)
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1) / angle
    matrices = np.tile(np.eye(4), (len(shift), 1, 1))
    matrices[:, :3, :3] += np.sin(angle) * cross + 2 * np.sin(angle / 2) ** 2 * (cross @ cross)
    matrices[:, :3, 3] = shift
    return matrices
