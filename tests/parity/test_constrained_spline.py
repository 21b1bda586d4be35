"""The banded kernel against exact arithmetic, and against the report's own formulas."""

import itertools
from fractions import Fraction

import numpy as np
import pytest

from tests.support import exact_spline, truncated_powers
from trueloop.arrays import Array
from trueloop.turned.fit.spline import EndConditions, SplineFit, least_squares_spline

LENGTH_MM = 58.25
ERRORS_MM = 0.01
"""Size of the values: hundredths of a millimetre, as on the parts of [6811]."""

ENDS = (0.0067, 0.0, -0.019, -0.0005)
SUBSETS = list(itertools.product([True, False], repeat=4))


def sample(points: int) -> tuple[Array, Array, Array]:
    """Points, values with noise, and knots at every third point."""
    rng = np.random.default_rng(points)
    s = LENGTH_MM * (np.arange(points) + 0.5) / points
    y = ERRORS_MM * (np.sin(s / 7.0) + 0.1 * rng.standard_normal(points))
    return s, y, s[2::3][s[2::3] < s[-1]]


def fitted(points: int, given: tuple[bool, ...], degree: int = 3) -> SplineFit:
    s, y, t = sample(points)
    ends = EndConditions(*(end if use else None for end, use in zip(ENDS, given, strict=True)))
    return least_squares_spline(s, y, t, LENGTH_MM, degree, ends)


def exact(points: int, given: tuple[bool, ...], number: exact_spline.Number, degree: int = 3) -> Array:
    s, y, t = sample(points)
    first, second, third, fourth = (end if use else None for end, use in zip(ENDS, given, strict=True))
    found = exact_spline.coefficients(
        list(s), list(y), list(t), LENGTH_MM, degree, (first, second, third, fourth), number
    )
    return found.astype(np.float64)


@pytest.mark.parametrize("given", SUBSETS)
def test_every_subset_of_end_conditions_agrees_with_exact_rational_arithmetic(given: tuple[bool, ...]) -> None:
    """B-splines sum to one, so that the curve is off by no more than its coefficients are: 1e-15 mm at most."""
    kernel = fitted(32, given).spline.coefficients_mm
    assert np.max(np.abs(kernel - exact(32, given, Fraction))) < 1e-15


@pytest.mark.parametrize("degree", [1, 2])
def test_lower_degrees_agree_with_exact_rational_arithmetic(degree: int) -> None:
    kernel = fitted(32, (True, False, True, False), degree).spline.coefficients_mm
    assert np.max(np.abs(kernel - exact(32, (True, False, True, False), Fraction, degree))) < 1e-15


@pytest.mark.parametrize("given", [(True, True, True, True), (True, False, False, False), (False,) * 4])
def test_a_thousand_points_agree_with_extended_precision(given: tuple[bool, ...]) -> None:
    kernel = fitted(1000, given).spline.coefficients_mm
    assert np.max(np.abs(kernel - exact(1000, given, np.longdouble))) < 1e-15


def test_extended_precision_agrees_with_exact_arithmetic() -> None:
    """The oracle for a thousand points, held against the oracle that cannot err."""
    given = (True, True, True, True)
    assert np.max(np.abs(exact(32, given, np.longdouble) - exact(32, given, Fraction))) < 1e-17


def test_end_conditions_hold_to_rounding() -> None:
    spline = fitted(1000, (True, True, True, True)).spline
    ends = [0.0, LENGTH_MM]
    np.testing.assert_allclose(spline.of(spline.value_form(ends)), [ENDS[0], ENDS[2]], rtol=0.0, atol=1e-17)
    np.testing.assert_allclose(spline.of(spline.slope_form(ends)), [ENDS[1], ENDS[3]], rtol=0.0, atol=1e-16)


@pytest.mark.parametrize("points", [32, 1000])
def test_the_report_s_solution_agrees_once_mended(points: int) -> None:
    """[6517 Eq. 25] with the rank set to n − 4 and one more Z in front: conventions of this project.

    Its sum of truncated powers is rounded by some ε Σ |power · coefficient|: processors sum in different orders.
    """
    s, y, t = sample(points)
    f = np.array([ENDS[0], ENDS[2], ENDS[1], ENDS[3]])
    c = truncated_powers.mended(s, y, t, 0.0, LENGTH_MM, f)
    spline = fitted(points, (True, True, True, True)).spline
    powers = truncated_powers.design(s, t)
    rounded_mm = 10 * np.finfo(np.float64).eps * np.max(np.abs(powers) @ np.abs(c))
    assert np.max(np.abs(powers @ c - spline.of(spline.value_form(s)))) < rounded_mm < 2e-8


def test_the_report_s_solution_fails_as_printed() -> None:
    """A·Z has four singular values that are zero but for rounding; with a generic tolerance they are inverted.

    Told the rank, the formula holds at 32 points and loses a hundredth of a millimetre and more at 1,000.
    """
    f = np.array([ENDS[0], ENDS[2], ENDS[1], ENDS[3]])
    off = {}
    for points, solve in itertools.product((32, 1000), (truncated_powers.as_printed, truncated_powers.with_rank)):
        s, y, t = sample(points)
        spline = fitted(points, (True, True, True, True)).spline
        curve = truncated_powers.design(s, t) @ solve(s, y, t, 0.0, LENGTH_MM, f)
        off[points, solve.__name__] = float(np.max(np.abs(curve - spline.of(spline.value_form(s)))))
    assert off[32, "as_printed"] > 1e3
    assert off[32, "with_rank"] < 1e-6
    assert off[1000, "with_rank"] > 0.01


def test_pieces_are_the_report_s_compacted_coefficients() -> None:
    """[6517 Eq. 33] in powers of the arc length, ours in powers from each piece's begin: the same polynomials."""
    s, y, t = sample(32)
    c = truncated_powers.mended(s, y, t, 0.0, LENGTH_MM, np.array([ENDS[0], ENDS[2], ENDS[1], ENDS[3]]))
    compacted = truncated_powers.compacted(c, t)
    begins, pieces = fitted(32, (True, True, True, True)).spline.pieces()
    np.testing.assert_allclose(begins, np.concatenate([[0.0], t]))
    ends = np.append(begins[1:], LENGTH_MM)
    for begin, end, piece, row in zip(begins, ends, pieces, compacted, strict=True):
        x = np.linspace(begin, end, 5)
        ours = np.polynomial.polynomial.polyval(x - begin, piece)
        np.testing.assert_allclose(ours, np.polynomial.polynomial.polyval(x, row), atol=1e-12)
