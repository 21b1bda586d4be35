"""What a worn edge does to the error over contact angle: flats, notches, another radius. Angles rad, lengths mm.

All are errors of the part, positive where material is left on; the contact angle is that of the outward normal
(sin φ, cos φ).
"""

import numpy as np

from trueloop.arrays import Array

FLAT_DEG, NOTCH_DEG, NOTCH_WIDTH_DEG = (15.0, 75.0), (5.0, 85.0), (8.0, 16.0)
"""Where on the nose wear is drawn from, uniformly, and how wide a notch is."""


def flat(angle_rad: Array, at_rad: float, depth_mm: float, nose_mm: float = 0.8) -> Array:
    """A flat worn into a nose, perpendicular to the normal at an angle: what the nose no longer reaches, it leaves on.

    Beside its middle the flat's corner cuts, at arccos(1 − depth/R) from it: a roof with its ridge at the middle.
    """
    corner = np.arccos(1 - depth_mm / nose_mm)
    return np.asarray(nose_mm * (1 - np.cos(np.maximum(corner - np.abs(angle_rad - at_rad), 0.0))))


def notch(angle_rad: Array, at_rad: float, depth_mm: float, width_rad: float) -> Array:
    """A notch at the depth of cut: a groove with straight flanks."""
    return np.asarray(depth_mm * np.maximum(1 - np.abs(angle_rad - at_rad) / width_rad, 0.0))


def other_radius(angle_rad: Array, smaller_mm: float) -> Array:
    """A nose whose radius is smaller than the nominal one, touched off along X and Z: it cuts too deep between.

    The centre lies nearer to the work by the difference in both directions, the nose less far before it.
    """
    return np.asarray(smaller_mm * (1 - np.sin(angle_rad) - np.cos(angle_rad)))


def drawn_place(rng: np.random.Generator) -> tuple[float, float, float]:
    """Angles of a flat and of a notch, and the notch's width, rad."""
    flat_deg, notch_deg, width_deg = (rng.uniform(*span) for span in (FLAT_DEG, NOTCH_DEG, NOTCH_WIDTH_DEG))
    return float(np.radians(flat_deg)), float(np.radians(notch_deg)), float(np.radians(width_deg))


def other_form(angle_rad: Array, rng: np.random.Generator, size_mm: float) -> Array:
    """By which another edge differs: flats and notches of either sign and another radius, of that RMS, (n,)."""
    drawn = other_radius(angle_rad, rng.normal())
    for _ in range(2):
        at, notched, width = drawn_place(rng)
        drawn = drawn + rng.normal() * flat(angle_rad, at, 0.03) / 0.03
        drawn = drawn + rng.normal() * notch(angle_rad, notched, 1.0, 2 * width)
    return np.asarray(size_mm * drawn / np.sqrt(np.mean(drawn**2)))
