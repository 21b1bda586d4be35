"""Curves as a job spells them out, against what the same numbers mean by hand."""

import tomllib

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.support.curves import LENS
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.part_tables import PartTable
from trueloop.formats.jobs.profile_of_job import fit_notes, part_table_toml, profile_of_table
from trueloop.geometry.curve import Curve
from trueloop.geometry.validate import checked_profile

H = np.linspace(0.0, 20.0, 51)


def table_of(start: str, to: str, form: str, values: str, head: str = "") -> PartTable:
    """A part of one feature."""
    text = f"""
        name = "p"
        {head}
        start = {start}
        [[feature]]
        name = "curve"
        to = {to}
        [feature.{form}]
        {values}
    """
    return PartTable.model_validate(tomllib.loads(text))


def only(table: PartTable) -> Curve:
    (curve,) = profile_of_table(table).features
    assert isinstance(curve, Curve)
    return curve


@pytest.mark.parametrize(("unit", "mm"), [("mm", 1.0), ("inch", 25.4)])
@pytest.mark.parametrize(("x_is", "of_radius"), [("radius", 1.0), ("diameter", 2.0)])
def test_asphere_in_the_units_of_the_drawing(unit: str, mm: float, x_is: str, of_radius: float) -> None:
    """R and Aᵢ in units of length to 1 − i; h a radius whatever x is."""
    sag = float(LENS.sag_mm(np.array(20.0)))
    table = table_of(
        f"[{20 * of_radius / mm}, {(3 - sag) / mm}]",
        f"[0.0, {3 / mm}]",
        "asphere",
        f"vertex = [0.0, {3 / mm}]\nradius = {40 / mm}\nconic = -0.8\n"
        f"coefficients = {{ 4 = {2e-6 * mm**3}, 6 = {-1e-9 * mm**5} }}",
        f'unit = "{unit}"\nx_is = "{x_is}"',
    )
    curve = only(table)
    s = LENS.arc_length_mm(H)
    assert_allclose(curve.point_mm(s), LENS.point_mm(H) + np.array([0.0, 3.0]), rtol=0, atol=1e-9)
    assert_allclose(curve.outward_normal(s), LENS.normal(H), rtol=0, atol=1e-9)


def test_diameter_that_the_equation_does_not_have() -> None:
    """The end at diameter 20 instead of radius 20."""
    sag = float(LENS.sag_mm(np.array(20.0)))
    values = "vertex = [0.0, 0.0]\nradius = 40.0\nconic = -0.8\ncoefficients = { 4 = 2e-6, 6 = -1e-9 }"
    with pytest.raises(TrueloopError) as refusal:
        profile_of_table(table_of(f"[20.0, {-sag}]", "[0.0, 0.0]", "asphere", values, 'x_is = "diameter"'))
    assert refusal.value.code is Code.GEO_CURVE_END
    assert "x = 10.0000 mm, z = -5.3201 mm" in refusal.value.message


def test_ellipse_polynomial_and_spline_in_diameters() -> None:
    """A quarter ellipse, semi-axes 10 and 20; x = 10 + z²/8; a chord of a straight spline: all with x a diameter."""
    head = 'x_is = "diameter"'
    bowl = only(
        table_of("[40.0, 0.0]", "[20.0, 20.0]", "ellipse", "centre = [20.0, 0.0]\nsemi_axes = [10.0, 20.0]", head)
    )
    assert float(bowl.locate((10 + 10 * 0.6, 20 * 0.8))[1]) == pytest.approx(0.0, abs=1e-10)
    horn = only(table_of("[20.0, 0.0]", "[22.0, 2.0]", "polynomial", "coefficients = [20.0, 0.0, 0.5]", head))
    assert float(horn.locate((10 + 1 / 4, 1.0))[1]) == pytest.approx(0.0, abs=1e-12)
    nozzle = 'coefficients = [4.0, -0.25]\ngives = "z"\norigin = 20.0'  # z = 4 − (x − 20)/4 over the diameter
    cone = only(table_of("[24.0, 3.0]", "[20.0, 4.0]", "polynomial", nozzle, head))
    assert float(cone.locate((11.0, 3.5))[1]) == pytest.approx(0.0, abs=1e-12)
    knots = "control = [[20.0, 0.0], [20.0, 1.0], [24.0, 2.0]]\nknots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]\ndegree = 2"
    spline = only(table_of("[20.0, 0.0]", "[24.0, 2.0]", "spline", knots, head))
    assert float(spline.locate((10.0 + 2 * 0.25, 1.0))[1]) == pytest.approx(0.0, abs=1e-12)  # t = ½: x = 10 + 2 t²


def test_part_of_a_spline_run_from_its_end() -> None:
    knots = "control = [[10.0, 0.0], [12.0, 5.0], [10.0, 10.0]]\nknots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]\ndegree = 2"
    text = knots.replace("[10.0, 0.0], [12.0, 5.0], [10.0, 10.0]", "[10.0, 10.0], [12.0, 5.0], [10.0, 0.0]")
    forwards, from_end = (only(table_of("[10.0, 0.0]", "[11.0, 5.0]", "spline", form)) for form in (knots, text))
    assert forwards.end_mm == pytest.approx((11.0, 5.0), abs=1e-9)
    assert_allclose(from_end.point_mm(2.0), forwards.point_mm(2.0), rtol=0, atol=1e-9)


def test_points_with_a_tolerance_say_how_far_the_curve_is() -> None:
    points = np.round(LENS.point_mm(np.linspace(20.0, 0.0, 81)), 3)
    listed = ", ".join(f"[{x}, {z}]" for x, z in points[1:-1].tolist())
    start, end = points[0].tolist(), points[-1].tolist()
    table = table_of(f"{start}", f"{end}", "points", f"through = [{listed}]\ntolerance = 0.002")
    profile = profile_of_table(table)
    assert np.max(np.abs(profile.features[0].locate(LENS.point_mm(H))[1])) < 2e-3
    (note,) = fit_notes(table, profile)
    assert note.startswith("curve is a curve through 81 points")
    assert "tolerance 2.0 µm" in note


def test_curves_are_spelled_out_as_splines_that_read_back() -> None:
    lens = LENS.curve()
    text = part_table_toml("p", checked_profile([lens]))
    read = only(PartTable.model_validate(tomllib.loads(text)["part"]))
    s = np.linspace(0.0, lens.length_mm, 200)
    assert_allclose(read.point_mm(s), lens.point_mm(s), rtol=0, atol=2e-9)
    assert_allclose(read.tangent(s), lens.tangent(s), rtol=0, atol=1e-7)


def test_a_feature_has_one_form() -> None:
    text = {"name": "f", "to": [1.0, 1.0], "radius": 3.0, "polynomial": {"coefficients": [1.0]}}
    with pytest.raises(ValueError, match="one form, not radius and polynomial"):
        PartTable.model_validate({"name": "p", "start": [0.0, 0.0], "feature": [text]})
