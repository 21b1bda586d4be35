"""Curves for tests, and an asphere written down independently of the package: numpy on the equation of ISO 10110-12."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from hypothesis import strategies as st

from trueloop.arrays import Array
from trueloop.geometry.curve import Curve
from trueloop.geometry.curve_kinds import asphere, b_spline, ellipse, power_series
from trueloop.geometry.feature import Arc


@dataclass(frozen=True)
class Lens:
    """R, k and Aᵢ of an asphere with its vertex at (0, z)."""

    radius_mm: float = 40.0
    conic: float = -0.8
    powers: tuple[tuple[int, float], ...] = ((4, 2e-6), (6, -1e-9))
    vertex_z_mm: float = 0.0
    rim_mm: float = 20.0

    def sag_mm(self, h: Array) -> Array:
        """z(h) = h²/(R(1 + √(1 − (1 + k)h²/R²))) + Σ Aᵢ hⁱ."""
        root = np.sqrt(1 - (1 + self.conic) * h**2 / self.radius_mm**2)
        return np.asarray(h**2 / (self.radius_mm * (1 + root)) + sum(a * h**i for i, a in self.powers))

    def slope(self, h: Array) -> Array:
        """dz/dh by hand: h/(R √…) + Σ i Aᵢ hⁱ⁻¹."""
        root = np.sqrt(1 - (1 + self.conic) * h**2 / self.radius_mm**2)
        return np.asarray(h / (self.radius_mm * root) + sum(i * a * h ** (i - 1) for i, a in self.powers))

    def bend_per_mm(self, h: Array) -> Array:
        """d²z/dh² by hand."""
        root = np.sqrt(1 - (1 + self.conic) * h**2 / self.radius_mm**2)
        more = sum(i * (i - 1) * a * h ** (i - 2) for i, a in self.powers)
        return np.asarray(1 / (self.radius_mm * root**3) + more)

    def point_mm(self, h: Array) -> Array:
        """(x, z) of a dome at the free end."""
        return np.stack([h, self.vertex_z_mm - self.sag_mm(h)], axis=-1)

    def normal(self, h: Array) -> Array:
        """Out of the material: (slope, 1), unit."""
        slope = self.slope(h)
        return np.asarray(np.stack([slope, np.ones_like(h)], axis=-1) / np.sqrt(1 + slope**2)[..., None])

    def arc_length_mm(self, h: Array) -> Array:
        """From the rim to h, by Gauss and Legendre."""
        at, weight = np.polynomial.legendre.leggauss(60)
        low = np.asarray(h)[..., None]
        places = low + (self.rim_mm - low) * (1 + at) / 2
        return np.asarray(np.sqrt(1 + self.slope(places) ** 2) @ weight * (self.rim_mm - np.asarray(h)) / 2)

    def curve(self, name: str = "lens") -> Curve:
        """The package's curve, from the rim to the vertex."""
        x, z = (float(value) for value in self.point_mm(np.array(self.rim_mm)))
        ends = ((x, z), (0.0, self.vertex_z_mm))
        return asphere(name, ends, (0.0, self.vertex_z_mm), self.radius_mm, self.conic, dict(self.powers))


LENS: Final = Lens()


def arc_as_curve(arc: Arc) -> Curve:
    """The arc as an ellipse of equal semi-axes."""
    axes = (arc.radius_mm, arc.radius_mm)
    return ellipse(arc.name, (arc.start_mm, arc.end_mm), arc.centre_mm, axes, convex=arc.sweep_rad > 0)


@st.composite
def curves(draw: st.DrawFn) -> Curve:
    """Ellipses, aspheres, polynomials and splines of some centimetres."""
    kind = draw(st.sampled_from(["ellipse", "asphere", "polynomial", "spline"]))
    if kind == "ellipse":
        a, b, turned = draw(st.floats(5, 40)), draw(st.floats(5, 40)), draw(st.floats(-1, 1))
        first = draw(st.floats(-3, 3))
        angles = np.array([first, first + draw(st.floats(0.2, 2.5))])
        across, along = a * np.sin(angles), b * np.cos(angles)
        x = 60 + across * np.cos(turned) + along * np.sin(turned)
        z = along * np.cos(turned) - across * np.sin(turned)
        ends = tuple((float(p), float(q)) for p, q in zip(x, z, strict=True))
        return ellipse("curve", (ends[0], ends[1]), (60.0, 0.0), (a, b), turned, convex=draw(st.booleans()))
    if kind == "asphere":
        rim = draw(st.floats(2, 20))
        powers = ((4, draw(st.floats(-2e-6, 2e-6))), (6, draw(st.floats(-2e-9, 2e-9))))
        return Lens(draw(st.floats(30, 90)), draw(st.floats(-3, 0.5)), powers, draw(st.floats(-50, 50)), rim).curve()
    if kind == "polynomial":
        c = [draw(st.floats(10, 40)), *(draw(st.floats(-1, 1)) * 10.0**-k for k in range(1, 5))]
        low, high = -10.0, draw(st.floats(-8, 10))
        value = np.polynomial.polynomial.polyval([low, high], c)
        return power_series("curve", ((float(value[0]), low), (float(value[1]), high)), c)
    steps = draw(st.lists(st.floats(-2, 2), min_size=4, max_size=9))
    control = [(30.0 + x, 4.0 * k) for k, x in enumerate(steps)]
    inner = range(1, len(control) - 3)
    return b_spline("curve", control, [0, 0, 0, 0, *inner, *[len(control) - 3] * 4], 3)
