"""The tool nose of the simulator: round, or worn as a radius error over contact angle."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop._core import NoseSweep
from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.feature import Feature, contact_angle_rad, pieces_within
from trueloop.geometry.profile import Side
from trueloop.nc.program.along import feed_moves, nose_centre_moves
from trueloop.nc.program.tool_path import INVERSE_TIME, PER_MINUTE, ToolPath

MOST_STEP_RAD: Final = math.radians(1.0)
"""No piece of the wear is wider."""


@dataclass(frozen=True)
class Nose:
    """A nose of `radius_mm`, at contact angle φ larger by w(φ) (negative: worn, material is left on).

    w runs through `wear_mm` at `wear_angle_rad` (both (m,), ascending angles) as a cubic spline that is level at its
    ends, and stays constant beyond them. It is the support function of the nose less its radius: where the surface's
    normal points along φ, the surface comes to lie R + w(φ) from the nose centre. The body must be convex,
    R + w + w″ > 0, or parts of the edge would never touch the work.
    """

    radius_mm: float
    wear_angle_rad: tuple[float, ...] = ()
    wear_mm: tuple[float, ...] = ()
    pieces: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", _pieces(self.wear_angle_rad, self.wear_mm))
        _check(self)

    @property
    def step_rad(self) -> float:
        """Returns the width of the pieces, all alike over the range of the wear table; `MOST_STEP_RAD` without one."""
        if not len(self.pieces):
            return MOST_STEP_RAD
        return (self.wear_angle_rad[-1] - self.wear_angle_rad[0]) / len(self.pieces)

    @property
    def first_rad(self) -> float:
        """Returns the contact angle at which the wear table begins."""
        return self.wear_angle_rad[0] if self.wear_angle_rad else 0.0

    def wear_at_mm(self, contact_angle_rad: Array) -> Array:
        """Returns W at contact angles of any shape."""
        if not len(self.pieces):
            return np.zeros_like(contact_angle_rad)
        at = np.clip((contact_angle_rad - self.first_rad) / self.step_rad, 0.0, len(self.pieces) - 1e-12)
        piece = self.pieces[at.astype(np.intp)]
        u = (at - np.floor(at)) * self.step_rad
        value: Array = piece[..., 0] + u * (piece[..., 1] + u * (piece[..., 2] + u * piece[..., 3]))
        return value


def _pieces(angle_rad: tuple[float, ...], wear_mm: tuple[float, ...]) -> Array:
    """Cubics of one width with the spline's values and slopes at their ends: neighbours agree in value and slope."""
    ascending = len(angle_rad) == len(wear_mm) >= 2 and np.all(np.diff(angle_rad) > 0.0)
    if not (ascending and np.all(np.isfinite([*angle_rad, *wear_mm]))):
        if not angle_rad and not wear_mm:
            return np.zeros((0, 4))
        raise Code.SIM_NOSE.refusal(
            f"a worn nose given by {len(angle_rad)} angles and {len(wear_mm)} radius errors",
            hint="give at least two contact angles in ascending order and a radius error for each, all finite",
        )
    from scipy.interpolate import CubicSpline  # only a worn nose needs it

    spline = CubicSpline(angle_rad, wear_mm, bc_type="clamped")
    count = max(1, math.ceil((angle_rad[-1] - angle_rad[0]) / MOST_STEP_RAD - 1e-9))
    ends = np.linspace(angle_rad[0], angle_rad[-1], count + 1)
    value, slope, h = spline(ends), spline(ends, 1), (angle_rad[-1] - angle_rad[0]) / count
    secant = np.diff(value) / h
    second = (3 * secant - 2 * slope[:-1] - slope[1:]) / h
    third = (slope[:-1] + slope[1:] - 2 * secant) / h**2
    return np.ascontiguousarray(np.column_stack([value[:-1], slope[:-1], second, third]))


def _check(nose: Nose) -> None:
    """A radius, angles of one turn, and what the sweep asks of the body: that it is convex."""
    if not (math.isfinite(nose.radius_mm) and nose.radius_mm > 0.0):
        raise Code.SIM_NOSE.refusal(
            f"a nose radius of {nose.radius_mm} mm with {len(nose.wear_mm)} radius errors",
            hint="the simulated nose has a finite radius above 0 mm",
        )
    for angle in nose.wear_angle_rad:
        if not abs(angle) <= math.pi:
            raise Code.SIM_NOSE.refusal(
                f"a radius error at a contact angle of {math.degrees(angle):.1f}°",
                hint="contact angles are degrees from −180 to 180, from +z towards +x",
            )
    try:
        NoseSweep(np.zeros((1, 2)), nose.radius_mm, nose.first_rad, nose.step_rad, nose.pieces)
    except ValueError as hollow:
        raise Code.SIM_NOSE.refusal(
            str(hollow),
            hint="a nose touches the work only where it is convex: make the radius errors smoother over angle",
        ) from hollow


LINE_STEP_MM: Final = 0.05
CHORD_MM: Final = 2.5e-7
"""The largest deviation of a chord from its arc: a quarter of a nanometre."""


@dataclass(frozen=True)
class CentrePath:
    """Positions of the nose centre in cutting order without a break, arrays of shape (n,) and (n, 2).

    `normal` is the unit normal of the path on the side away from the material; `feed_mm_per_rev` NaN where the program
    does not state it.
    """

    centre_mm: Array
    along_mm: Array
    normal: Array
    feed_mm_per_rev: Array


def paths_of_program(tool_path: ToolPath, side: Side = Side.OUTSIDE, *, driven: bool = False) -> tuple[CentrePath, ...]:
    """Returns the uninterrupted chains of feed moves of a program. Rapid moves cut nothing here.

    `driven`: the path is that of the nose's centre also under G41 and G42, run with the tool's nose.
    """
    feed = _feed_mm_per_rev(tool_path)
    moves = feed_moves(tool_path) if driven else nose_centre_moves(tool_path)
    chains = [list(chain) for _, chain in groupby(moves, key=lambda move: move.chain)]
    return tuple(
        path_along([move.path for move in chain], [feed[move.index] for move in chain], side) for chain in chains
    )


def path_along(
    features: Sequence[Feature], feed_mm_per_rev: Sequence[float] | None = None, side: Side = Side.OUTSIDE
) -> CentrePath:
    """Returns the path along consecutive lines and arcs: steps of at most 0.05 mm, chords within 0.25 nm of arcs."""
    feeds = [math.nan] * len(features) if feed_mm_per_rev is None else feed_mm_per_rev
    steps = [np.linspace(0.0, feature.length_mm, _steps(feature) + 1) for feature in features]
    centre = np.concatenate([feature.point_mm(s) for feature, s in zip(features, steps, strict=True)])
    normal = np.concatenate([feature.outward_normal(s) for feature, s in zip(features, steps, strict=True)])
    feed = np.concatenate([np.full(len(s), f) for s, f in zip(steps, feeds, strict=True)])
    return CentrePath(centre, _along(centre), _away_from_material(centre, side) * normal, feed)


def path_of_positions(centre_mm: Array, side: Side = Side.OUTSIDE) -> CentrePath:
    """Returns the path through recorded positions (n, 2); those that repeat the one before are left out."""
    moved = np.concatenate([[True], np.any(np.diff(centre_mm, axis=0) != 0.0, axis=1)])
    centre = np.ascontiguousarray(centre_mm[moved])
    tangent = np.gradient(centre, axis=0) if len(centre) > 1 else np.array([[0.0, 1.0]])
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
    normal = _away_from_material(centre, side) * np.column_stack([tangent[:, 1], -tangent[:, 0]])
    return CentrePath(centre, _along(centre), normal, np.full(len(centre), math.nan))


def _steps(feature: Feature) -> int:
    return max(math.ceil(feature.length_mm / LINE_STEP_MM), pieces_within(feature, CHORD_MM))


def _along(centre: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(centre, axis=0).T))])


def _away_from_material(centre: Array, side: Side) -> float:
    """+1 where the material is on the path's right: it runs inwards, or an outside away from the chuck, a bore to it.

    What goes around the part is given in the order of its profile.
    """
    dx, dz = centre[-1] - centre[0]
    along = {Side.OUTSIDE: dz - dx, Side.INSIDE: -dz - dx, Side.AROUND: 0.0}[side]
    return 1.0 if along >= 0.0 else -1.0


def _feed_mm_per_rev(tool_path: ToolPath) -> Array:
    """Feed a revolution of every move, from mm/rev, or mm/min by the spindle speed."""
    per_minute = tool_path.feed_mode == PER_MINUTE
    speed = np.where(tool_path.spindle_mode == 97, tool_path.spindle_speed, np.nan)
    known = np.where(per_minute, tool_path.feed / np.where(speed > 0, speed, np.nan), tool_path.feed)
    return np.where(tool_path.feed_mode == INVERSE_TIME, np.nan, known)


@dataclass(frozen=True)
class Transfer:
    """Part error that the finish cut adds, over contact angle (0 on a face, 90° on a cylinder): positive = left on.

    Straight between the `error_mm` at `angle_rad` (ascending, as many of each), constant beyond them; none without any.
    It moves the nose along the normal of its path: a loop that measures the cut before it cannot see it. Raises
    SIM-TRANSFER for tables that do not go together.
    """

    angle_rad: tuple[float, ...] = ()
    error_mm: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        ascending = len(self.angle_rad) == len(self.error_mm) and all(np.diff(self.angle_rad) > 0.0)
        if not (ascending and all(math.isfinite(number) for number in (*self.angle_rad, *self.error_mm))):
            raise Code.SIM_TRANSFER.refusal(
                f"what the finish cut does otherwise is given by {len(self.angle_rad)} angles and "
                f"{len(self.error_mm)} errors",
                hint="give contact angles in ascending order and an error for each, or neither",
                values={"angles": len(self.angle_rad), "errors": len(self.error_mm)},
            )

    def displacement_mm(self, path: CentrePath) -> Array:
        """Returns the displacement of the nose centre, (n, 2)."""
        if not self.angle_rad:
            return np.zeros_like(path.centre_mm)
        error = np.interp(contact_angle_rad(path.normal), self.angle_rad, self.error_mm)
        return np.asarray(error[:, None] * path.normal)


SAME: Final = Transfer()
"""A finish cut that does what the cuts before it did."""
