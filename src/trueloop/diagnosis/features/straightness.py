"""Straightness and waviness of a feature that is nominally straight [4773 §4.2 f]."""

import numpy as np
from numpy.polynomial import legendre, polynomial
from scipy.stats import chi2

from trueloop.arrays import Array
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError
from trueloop.diagnosis.features.form import Form

GRID = np.linspace(-1.0, 1.0, 201)
SHAPES = legendre.legvander(GRID, 3)[:, 2:]
"""P₂ and P₃: what a cubic has beside a line; no line over the whole range is left in them."""
DIRECTIONS = 24


def straightness_of(form: Form, name: str) -> tuple[FeatureError, ...]:
    """Peak to valley of the cubic without its line, over what was measured, and the waviness; () below six places.

    A size is never negative, so that noise alone has one: what noise has on average is taken out of its square,
    v² = p² − E[p² of noise], 0 where that is negative. u is that of p linearised, and where noise prevails that of a
    normal size. `more` has the polynomial a₀ … a₃ of the distance from the end that is nearer to the chuck, or to the
    axis. Checked by simulation: value ± 2 u holds the true one in 93 % of cases or more, from straight to much bent,
    where points scatter by no more than the device states; with Student's factor else.
    """
    if form.smooth is None:
        return ()
    bent, covariance = form.smooth.coefficients[2:4], form.smooth.covariance[2:4, 2:4]
    peak_to_valley = float(np.ptp(SHAPES @ bent))
    noise = _noise_mm(covariance)
    gradient = _gradient(bent)
    u = max(float(np.sqrt(gradient @ covariance @ gradient)), 0.0 if peak_to_valley > noise else noise / np.sqrt(2.0))
    found = FeatureError(
        name,
        ErrorKind.STRAIGHTNESS,
        float(np.sqrt(max(peak_to_valley**2 - noise**2, 0.0))),
        u,
        form.points.readings,
        form.degrees_of_freedom,
        more=_powers(form),
    )
    return found, _waviness(form, name)


def _gradient(bent: Array) -> Array:
    """How the peak to valley changes with the coefficients, (2,)."""
    shape = SHAPES @ bent
    gradient: Array = SHAPES[int(np.argmax(shape))] - SHAPES[int(np.argmin(shape))]
    return gradient


def _noise_mm(covariance: Array) -> float:
    """Root mean square of the peak to valley of noise: E[R²] = 2 times the mean square over directions."""
    turn = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS
    ways = np.linalg.cholesky(covariance) @ np.stack([np.cos(turn), np.sin(turn)])
    return float(np.sqrt(2.0 * np.mean(np.ptp(SHAPES @ ways, axis=0) ** 2)))


def _powers(form: Form) -> dict[str, float]:
    """a₀ … a₃ in mm of the distance from the first place, mm."""
    assert form.smooth is not None
    low, high = form.ends_mm
    in_t = polynomial.Polynomial(legendre.leg2poly(form.smooth.coefficients[:4]))
    found = in_t(polynomial.Polynomial([-1.0, 2.0 / (high - low)])).coef
    a = np.pad(found, (0, 4 - len(found)))  # coefficients that are zero at the end are left out by the conversion
    names = ("a0_mm", "a1_rad", "a2_per_mm", "a3_per_mm2")
    return {name: float(value) for name, value in zip(names, a, strict=True)} | {"from_mm": low, "to_mm": high}


def _waviness(form: Form, name: str) -> FeatureError:
    """Standard deviation of the points about the smooth form, beyond what the device states.

    u is the largest of s/√(2ν), which a standard deviation s of ν residuals has, and of what makes two of them reach to
    zero as often as noise alone does, and up to τ² + 2 u(τ²). `more` has the interval that χ² gives at 95 %, exact
    where all points are alike: of few residuals it is far from symmetric, and to be preferred.
    """
    smooth, points = form.smooth, form.points
    assert smooth is not None
    spare, tau = max(smooth.spare, 1), smooth.scatter_mm
    device = float(np.mean(points.standard_u_mm**2))
    total = device + tau**2
    low = np.sqrt(max(tau**2 - 2.0 * device * np.sqrt(2.0 / spare), 0.0))
    high = np.sqrt(tau**2 + 2.0 * total * np.sqrt(2.0 / spare))
    u = float(max((tau - low) / 2.0, (high - tau) / 2.0, np.sqrt(total / (2.0 * spare))))
    interval = [np.sqrt(max(spare * total / chi2.ppf(p, spare) - device, 0.0)) for p in (0.975, 0.025)]
    more = {"low_mm": float(interval[0]), "high_mm": float(interval[1])}
    return FeatureError(name, ErrorKind.WAVINESS, tau, u, points.readings, spare, more=more)
