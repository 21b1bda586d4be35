"""What counts as a profile: tolerances and the chains that must be let through."""

import math

import numpy as np
import pytest

from tests.support.profiles import facetst, modbas2, piecs11, polyline
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import JunctionKind
from trueloop.geometry.validate import checked_profile


def _refused(features: list[Feature], **options: object) -> Code:
    with pytest.raises(TrueloopError) as refusal:
        checked_profile(features, **options)  # type: ignore[arg-type]
    return refusal.value.code


def test_junctions_of_the_published_parts() -> None:
    """[6811 §5]: the dome of MODBAS2 is tangent to its neck, the knob of PIECS11 is not, FACETST has square corners."""
    assert [j.kind for j in modbas2().junctions] == [JunctionKind.CORNER] * 5 + [JunctionKind.TANGENT]
    assert [j.kind for j in piecs11().junctions] == [JunctionKind.CORNER] * 3
    assert [math.degrees(j.turn_rad) for j in facetst().junctions] == pytest.approx([90, -90, 90])


@pytest.mark.parametrize(("gap_mm", "refused"), [(0.0009, False), (0.0011, True)])
def test_gap_of_a_micrometre_is_rounding(gap_mm: float, refused: bool) -> None:
    chain: list[Feature] = [Line("a", (10.0, 0.0), (10.0, 5.0)), Line("b", (10.0 - gap_mm, 5.0), (2.0, 5.0))]
    if refused:
        assert _refused(chain) is Code.GEO_GAP
        checked_profile(chain, gap_mm=0.01)
    else:
        checked_profile(chain)


def test_gap_message_says_where() -> None:
    chain = [Line("a", (10.0, 0.0), (10.0, 5.0)), Line("b", (9.0, 5.0), (2.0, 5.0))]
    with pytest.raises(TrueloopError, match=r"'a' ends at x = 10\.0000 mm, z = 5\.0000 mm, 'b' starts 1\.0000 mm away"):
        checked_profile(chain)


def test_knob_of_more_than_half_a_turn_is_a_profile() -> None:
    neck = Line("neck", (6.0, -20.0), (6.0, -8.0))
    knob = Arc("knob", (6.0, -8.0), (0.0, 10.0), (0.0, 0.0), math.pi / 2 + math.atan2(8, 6))
    checked_profile([neck, knob])


def test_arc_that_dips_below_the_axis_between_its_ends() -> None:
    arc = Arc("hollow", (3.0, -4.0), (3.0, 4.0), (3.0, 0.0), -math.pi)
    assert _refused([arc]) is Code.GEO_AXIS
    lifted = Arc("hollow", (5.0, -4.0), (5.0, 4.0), (5.0, 0.0), -math.pi)
    checked_profile([lifted])


@pytest.mark.parametrize(("sweep_deg", "refused"), [(80.0, False), (90.0, True), (200.0, True)])
def test_arc_that_swings_back_through_the_line_it_stands_on(sweep_deg: float, refused: bool) -> None:
    """Radius √2 mm about (7, −9): from (6, −8) it comes back to the neck at (6, −10) after 90°."""
    neck = Line("neck", (6.0, -20.0), (6.0, -8.0))
    end_angle = math.radians(-45 - sweep_deg)
    end = (7 + math.sqrt(2) * math.sin(end_angle), -9 + math.sqrt(2) * math.cos(end_angle))
    chain: list[Feature] = [neck, Arc("loop", (6.0, -8.0), end, (7.0, -9.0), math.radians(sweep_deg))]
    if refused:
        assert _refused(chain) is Code.GEO_CROSSING
    else:
        checked_profile(chain)


def test_doubling_back_is_a_crossing() -> None:
    assert _refused([Line("a", (10.0, 0.0), (10.0, 5.0)), Line("b", (10.0, 5.0), (10.0, 2.0))]) is Code.GEO_CROSSING


def test_touching_counts_as_crossing() -> None:
    points = [(10.0, 0.0), (10.0, 5.0), (4.0, 5.0), (4.0, 7.0), (7.0, 5.0), (7.0, 9.0)]
    assert _refused(polyline(points)) is Code.GEO_CROSSING


def test_rounded_tangency_is_no_crossing() -> None:
    """The line stands 0.5 µm inside the circle and cuts it 0.2 mm on: rounding, not a loop."""
    neck = Line("neck", (19.9995, -10.0), (19.9995, 0.0))
    dome = Arc("dome", (20.0, 0.0), (0.0, 20.0), (0.0, 0.0), math.pi / 2)
    assert checked_profile([neck, dome]).junctions[0].kind is JunctionKind.TANGENT


def test_design_overrides_what_was_found() -> None:
    profile = modbas2()
    corner = checked_profile(profile.features, {("neck", "dome"): JunctionKind.CORNER})
    assert corner.junctions[-1].kind is JunctionKind.CORNER and corner.junctions[-1].by_design
    assert _refused(list(profile.features), by_design={("cone", "dome"): JunctionKind.CORNER}) is Code.GEO_JUNCTION
    assert _refused(list(profile.features), by_design={("face", "neck"): JunctionKind.TANGENT}) is Code.GEO_JUNCTION


def test_reversed_profile_is_refused() -> None:
    reversed_lines: list[Feature] = [
        Line(f.name, f.end_mm, f.start_mm) for f in reversed(facetst().features) if isinstance(f, Line)
    ]
    assert _refused(reversed_lines) is Code.GEO_ORDER


def test_a_face_alone_runs_inwards_so_that_its_normal_points_out_of_the_material() -> None:
    inwards = checked_profile([Line("face", (20.0, 0.0), (0.0, 0.0))])
    np.testing.assert_allclose(inwards.features[0].outward_normal(5.0), (0.0, 1.0))
    assert _refused([Line("face", (0.0, 0.0), (20.0, 0.0))]) is Code.GEO_ORDER
    assert _refused([Line("a", (5.0, 0.0), (12.0, 3.0)), Line("b", (12.0, 3.0), (20.0, 0.0))]) is Code.GEO_ORDER
