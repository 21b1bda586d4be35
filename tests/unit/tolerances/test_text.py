"""Tolerances as drawings write them, read into absolute limits."""

import pytest

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.tolerances.iso2768 import Edge
from trueloop.tolerances.text import limits_of

PLAIN = Edge(20.0)


@pytest.mark.parametrize(
    ("text", "lower", "upper"),
    [
        ("±0.02", 39.98, 40.02),
        ("+/-0,02", 39.98, 40.02),
        ("+0.01/-0.02", 39.98, 40.01),
        ("−0.02 / +0.01", 39.98, 40.01),
        ("-0.025 -0.050", 39.95, 39.975),
        ("0/-0.016", 39.984, 40.0),
        ("h6", 39.984, 40.0),
        ("40 h6", 39.984, 40.0),
        ("Ø40 H7", 40.0, 40.025),
        ("js7", 39.9875, 40.0125),
        ("p6", 40.026, 40.042),
        ("ISO 2768-m", 39.7, 40.3),
        ("ISO 2768-fH", 39.85, 40.15),
        ("DIN ISO 2768 c", 39.2, 40.8),
        ("2768-v", 38.5, 41.5),
    ],
)
def test_limits_of_a_diameter_of_40(text: str, lower: float, upper: float) -> None:
    assert limits_of(text, 40.0, Quantity.DIAMETER, PLAIN) == pytest.approx((lower, upper))


def test_numbers_are_in_the_drawings_unit_and_classes_in_mm() -> None:
    assert limits_of("±0.001", 25.4, Quantity.LENGTH, PLAIN, 25.4) == pytest.approx((25.3746, 25.4254))
    assert limits_of("h6", 25.4, Quantity.LENGTH, PLAIN, 25.4) == pytest.approx((25.387, 25.4))
    assert limits_of("±0.5", 30.0, Quantity.ANGLE, PLAIN, 25.4) == pytest.approx((29.5, 30.5))


@pytest.mark.parametrize(
    ("side_mm", "name", "minutes"),
    [(10.0, "m", 60), (10.1, "m", 30), (120.0, "f", 20), (120.1, "c", 15), (500.0, "v", 20), (5.0, "v", 180)],
)
def test_general_tolerances_of_angles_go_by_the_shorter_side(side_mm: float, name: str, minutes: int) -> None:
    """ISO 2768-1:1989, Table 3."""
    found = limits_of(f"ISO 2768-{name}", 45.0, Quantity.ANGLE, Edge(side_mm))

    assert found == pytest.approx((45.0 - minutes / 60, 45.0 + minutes / 60))


@pytest.mark.parametrize(
    ("nominal", "name", "deviation"),
    [
        *[(0.5, "f", 0.05), (3.0, "m", 0.1), (3.1, "v", 0.5), (6.0, "c", 0.3), (6.1, "c", 0.5), (30.0, "m", 0.2)],
        *[(30.1, "f", 0.15), (120.1, "m", 0.5), (400.1, "m", 0.8), (1000.1, "f", 0.5), (2000.0, "c", 3.0)],
        *[(2000.1, "m", 2.0), (4000.0, "v", 8.0)],
    ],
)
def test_general_tolerances_of_sizes(nominal: float, name: str, deviation: float) -> None:
    """ISO 2768-1:1989, Table 1."""
    found = limits_of(f"ISO 2768-{name}", nominal, Quantity.LENGTH, PLAIN)

    assert found == pytest.approx((nominal - deviation, nominal + deviation))


@pytest.mark.parametrize(("radius", "name", "deviation"), [(2.0, "m", 0.2), (5.0, "f", 0.5), (6.1, "v", 2.0)])
def test_radii_that_break_an_edge_have_a_table_of_their_own(radius: float, name: str, deviation: float) -> None:
    """ISO 2768-1:1989, Table 2."""
    found = limits_of(f"ISO 2768-{name}", radius, Quantity.RADIUS, Edge(3.0, broken=True))

    assert found == pytest.approx((radius - deviation, radius + deviation))


def test_a_form_has_a_width() -> None:
    assert limits_of("0.01", 0.0, Quantity.FORM, PLAIN) == (0.0, 0.01)


@pytest.mark.parametrize(
    ("text", "quantity", "code"),
    [
        ("", Quantity.DIAMETER, Code.TOL_TEXT),
        ("0.02", Quantity.DIAMETER, Code.TOL_TEXT),
        ("±", Quantity.DIAMETER, Code.TOL_TEXT),
        ("±1.234,5", Quantity.DIAMETER, Code.TOL_TEXT),
        ("+0.01", Quantity.DIAMETER, Code.TOL_TEXT),
        ("ISO 2768-x", Quantity.DIAMETER, Code.TOL_TEXT),
        ("ISO 2768-mX", Quantity.DIAMETER, Code.TOL_TEXT),
        ("h6", Quantity.ANGLE, Code.TOL_TEXT),
        ("±0.01", Quantity.FORM, Code.TOL_TEXT),
        ("ISO 2768-m", Quantity.FORM, Code.TOL_TEXT),
        ("nan", Quantity.DIAMETER, Code.TOL_TEXT),
        ("h66", Quantity.DIAMETER, Code.TOL_FIT),
        ("h600", Quantity.DIAMETER, Code.TOL_FIT),
        ("Js7", Quantity.DIAMETER, Code.TOL_FIT),
        ("30 h6", Quantity.DIAMETER, Code.TOL_SIZE),
    ],
)
def test_what_cannot_be_meant_is_refused(text: str, quantity: Quantity, code: Code) -> None:
    with pytest.raises(TrueloopError) as refused:
        limits_of(text, 40.0, quantity, PLAIN)
    assert refused.value.code is code


@pytest.mark.parametrize(("nominal", "name"), [(0.49, "m"), (4000.1, "m"), (2.0, "v"), (2001.0, "f")])
def test_a_size_outside_of_the_general_tolerances_is_refused(nominal: float, name: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        limits_of(f"ISO 2768-{name}", nominal, Quantity.DIAMETER, PLAIN)
    assert refused.value.code is Code.TOL_SIZE
