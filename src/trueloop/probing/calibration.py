"""The probe's calibration: how far from the surface the ball's centre is reported, by direction.

Touches on a sphere (or ring) of known size give the effective ball radius r(θ) = r₀ + a cos kθ + b sin kθ: the ball
less pre-travel and what the control latches too late, with the lobing of a k-legged switch. θ is the contact angle of
the surface that is touched. It holds for the speed, the stylus and the directions it was made with.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.geometry.feature import contact_angle_rad
from trueloop.units import UM_PER_MM

UNKNOWNS: Final = 5
STEPS: Final = 20
LEAST_SPAN_RAD: Final = math.radians(90.0)
LARGEST_SCATTER_MM: Final = 0.05
"""A probe that scatters more is loose, or the artefact is not the one that was named."""

BEYOND_RAD: Final = math.radians(1.0)
"""So little outside of the calibrated range is in it. The directions of the calibration's own touches are known no
better: the largest scatter let through turns one by 1° where the radii of ball and artefact add up to 3 mm."""


@dataclass(frozen=True)
class BallCalibration:
    """A calibrated probe; lengths in mm.

    `cosine_mm` and `sine_mm` are a and b. `scatter_mm` is the standard deviation of the touches about the fit, from
    `lowest_rad` to `highest_rad` of contact angle: what lies between was touched, or is between two touches.
    `radius_u_mm` is the standard uncertainty that the scatter leaves to r, in the touched direction that is known
    worst: ball, lobing and where the artefact stands are the harder to tell apart the smaller the range.
    """

    effective_radius_mm: float
    cosine_mm: float = 0.0
    sine_mm: float = 0.0
    lobes: int = 3
    scatter_mm: float = 0.0
    lowest_rad: float = -math.pi
    highest_rad: float = math.pi
    radius_u_mm: float = 0.0

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Warns where r is known less well than one touch repeats."""
        if self.radius_u_mm <= self.scatter_mm:
            return ()
        low, high = math.degrees(self.lowest_rad), math.degrees(self.highest_rad)
        message = (
            f"the ball's radius is known to {self.radius_u_mm * UM_PER_MM:.2f} µm (one standard deviation), worse than "
            f"a touch: between {low:.0f}° and {high:.0f}° ball, lobing and artefact are hardly separated"
        )
        hint = "touch it over 180° or more, in at least twenty directions"
        return (Finding(Severity.WARNING, Code.PRB_CALIBRATION, message, hint),)

    @property
    def lobing_mm(self) -> float:
        """Returns the amplitude of the lobing."""
        return math.hypot(self.cosine_mm, self.sine_mm)

    def radius_mm(self, outward_normal: Array) -> Array:
        """Returns the effective ball radius for touches on surfaces of these normals, (n, 2) → (n,)."""
        turned = self.lobes * contact_angle_rad(outward_normal)
        radius: Array = self.effective_radius_mm + self.cosine_mm * np.cos(turned) + self.sine_mm * np.sin(turned)
        return radius

    def covers(self, outward_normal: Array) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
        """Returns whether it holds for touches on surfaces of these normals, (n, 2) → (n,): lobing is known there."""
        low, high = self.lowest_rad - BEYOND_RAD, self.highest_rad + BEYOND_RAD
        inside = np.mod(contact_angle_rad(outward_normal) - low, 2 * np.pi) <= high - low
        return np.asarray(inside, dtype=np.bool_)


def calibrate(
    centres_mm: ArrayLike, artefact_radius_mm: float, *, ring: bool = False, lobes: int = 3
) -> BallCalibration:
    """Fits ball radius and lobing to ball centres (n, 2) reported on a sphere, or inside a ring, of known radius.

    The centre of the artefact is fitted as well, so that its position need not be known. Least squares by
    Gauss-Newton. Raises PRB-CALIBRATION with fewer than six touches, touches on less than a quarter of the circle, or
    ones that scatter by more than 0.05 mm about the fit.
    """
    centres = np.asarray(centres_mm, dtype=np.float64)
    if len(centres) <= UNKNOWNS:
        raise _refusal(
            f"{len(centres)} touches on the artefact; {UNKNOWNS + 1} are needed for ball radius, lobing and centre",
            "touch it in at least six directions, better in twenty",
        )
    side = -1.0 if ring else 1.0
    middle, fitted = _circle_centre(centres), np.zeros(3)
    for _ in range(STEPS):
        angle, terms = _terms(centres, middle, side, lobes)
        distance = np.hypot(*(centres - middle).T)
        design = np.column_stack([side * terms, side * np.sin(angle), side * np.cos(angle)])
        solved = np.linalg.lstsq(design, distance - artefact_radius_mm, rcond=1e-10)[0]
        fitted, moved = solved[:3], solved[3:]
        middle = middle + moved
        if float(np.max(np.abs(moved))) < 1e-12:
            break
    angle, terms = _terms(centres, middle, side, lobes)
    residual = np.hypot(*(centres - middle).T) - artefact_radius_mm - side * terms @ fitted
    scatter = float(np.sqrt(residual @ residual / (len(centres) - UNKNOWNS)))
    low, high = _span(angle, lobes)
    _require_good(len(centres), low, high, scatter, float(fitted[0]))
    radius_mm, cosine_mm, sine_mm = fitted.tolist()
    u_mm = scatter * _worst_factor(terms, angle)
    return BallCalibration(
        effective_radius_mm=radius_mm,
        cosine_mm=cosine_mm,
        sine_mm=sine_mm,
        lobes=lobes,
        scatter_mm=scatter,
        lowest_rad=low,
        highest_rad=high,
        radius_u_mm=u_mm,
    )


def _terms(centres: Array, middle: Array, side: float, lobes: int) -> tuple[Array, Array]:
    """Contact angles of the touches, and 1, cos kθ, sin kθ at them."""
    angle = contact_angle_rad(side * (centres - middle))
    return angle, np.column_stack([np.ones(len(angle)), np.cos(lobes * angle), np.sin(lobes * angle)])


def _worst_factor(terms: Array, angle: Array) -> float:
    """The largest standard uncertainty of r at the touches, of touches that scatter by one; centre and r are fitted."""
    triangular = np.linalg.qr(np.column_stack([terms, np.sin(angle), np.cos(angle)]), mode="r")
    of_radius = np.linalg.pinv(triangular)[:3]
    return float(np.sqrt(np.max(np.sum((terms @ of_radius) ** 2, axis=1))))


def _circle_centre(points: Array) -> Array:
    """Centre of the algebraic least-squares circle."""
    design = np.column_stack([2 * points, np.ones(len(points))])
    return np.asarray(np.linalg.lstsq(design, np.sum(points**2, axis=1), rcond=None)[0][:2])


def _span(angle_rad: Array, lobes: int) -> tuple[float, float]:
    """The shortest range of angles that holds all; the whole turn where every gap is less than half a lobe."""
    ascending = np.sort(angle_rad)
    gaps = np.diff(np.append(ascending, ascending[0] + 2 * np.pi))
    widest = int(np.argmax(gaps))
    if gaps[widest] < math.pi / lobes - BEYOND_RAD:
        return -math.pi, math.pi
    low = float(ascending[(widest + 1) % len(ascending)])
    return low, low + 2 * math.pi - float(gaps[widest])


def _require_good(count: int, low: float, high: float, scatter_mm: float, radius_mm: float) -> None:
    if high - low < LEAST_SPAN_RAD - BEYOND_RAD:
        raise _refusal(
            f"{count} touches span {math.degrees(high - low):.0f}° of the artefact; at least 90° are needed",
            "touch it around the directions that the part will be touched in",
        )
    if scatter_mm > LARGEST_SCATTER_MM or radius_mm <= 0.0:
        raise _refusal(
            f"the touches give a ball radius of {radius_mm:.4f} mm and scatter by {scatter_mm:.4f} mm about it",
            "check the artefact's size, ring or sphere, and that the stylus is tight",
        )


def _refusal(message: str, hint: str) -> TrueloopError:
    return Code.PRB_CALIBRATION.refusal(message, hint=hint)
