"""Halves of a view by hand: where an arc is cut by the axis, and what is drawn on both sides of it."""

import math

import numpy as np

from trueloop.formats.cad.dxf_cells import Half, halves
from trueloop.formats.cad.dxf_edges import Edges
from trueloop.geometry.feature import Arc, Line


def test_an_arc_is_cut_where_it_crosses_the_axis() -> None:
    """Radius 5 about x = 3: by 3, 4, 5 it crosses at z = 4."""
    arc = Arc("", (8.0, 0.0), (-2.0, 0.0), (3.0, 0.0), math.pi)
    above, below = halves(Edges.of([arc], ["0"]), 1e-3)
    np.testing.assert_allclose([above.edges.start_mm[0], above.edges.end_mm[0]], [(8, 0), (0, 4)], atol=1e-9)
    np.testing.assert_allclose([below.edges.start_mm[0], below.edges.end_mm[0]], [(0, 4), (2, 0)], atol=1e-9)
    np.testing.assert_allclose(below.edges.centre_mm[0], (-3, 0), atol=1e-12)
    assert above.edges.sweep_rad[0] > 0 > below.edges.sweep_rad[0]


def test_a_line_is_cut_where_it_crosses_the_axis_and_an_arc_is_as_long_as_its_turn() -> None:
    """From x = 6 to x = −3 over 9 mm: two thirds of the way, at z = 6."""
    above, below = halves(Edges.of([Line("", (6.0, 0.0), (-3.0, 9.0))], ["0"]), 1e-3)
    np.testing.assert_allclose([above.edges.end_mm[0], below.edges.start_mm[0]], [(0, 6), (0, 6)], atol=1e-9)
    arc = Arc("", (8.0, 0.0), (-2.0, 0.0), (3.0, 0.0), math.pi)
    np.testing.assert_allclose(Edges.of([arc], ["0"]).length_mm, 5 * math.pi)


def test_a_place_is_mirrored_within_the_tolerance_of_a_twin() -> None:
    twin = Edges.of([Line("", (10.0, 0.0), (10.0, 40.0))], ["0"])
    places = np.array([(10.0, 20.0), (10.0005, 20.0), (10.0, -0.0005), (10.002, 20.0), (10.0, 40.002)])
    assert Half(twin, twin, 0).are_mirrored(places, 1e-3).tolist() == [True, True, True, False, False]
