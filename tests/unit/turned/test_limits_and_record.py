"""Refusals of a correction, its table, and its record."""

import math
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import cast

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.domain.option import Limits, check_age
from trueloop.domain.record import check_same_program, check_uncorrected, record_id, sha256_of
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import Profile, junctions_of
from trueloop.turned.compensation.displaced import CentrePiece, ShiftedFeature, centre_pieces, shifted_contour
from trueloop.turned.compensation.limits import check_limits, check_nose, check_offset, cut_mm
from trueloop.turned.compensation.shift import ZERO, Shift, constant, sampled
from trueloop.turned.compensation.targets import correction_table, predict
from trueloop.turned.error_curve.curve import Budget

from .shapes import FEATURES, NOSE_RADIUS_MM, PART

NOW = datetime(2026, 1, 2, 12, tzinfo=UTC)


def on_cylinder(start_mm: float, end_mm: float) -> list[Shift]:
    taper = sampled(np.array([0.0, FEATURES[1].length_mm]), np.array([start_mm, end_mm]))
    return [ZERO, taper, ZERO, ZERO, ZERO]


def refused(shifts: list[Shift], limits: Limits) -> TrueloopError:
    pieces = centre_pieces(PART, shifted_contour(PART, shifts, NOSE_RADIUS_MM))
    with pytest.raises(TrueloopError) as caught:
        check_limits(pieces, shifts, limits)
    return caught.value


def test_too_large_a_correction_is_refused_with_place_and_override() -> None:
    error = refused(on_cylinder(0.0, -0.2), Limits())
    assert error.code is Code.CMP_SIZE
    assert "'cylinder' reaches 200.0 µm at x 44.704 mm" in error.message
    assert "max_correction_um" in (error.override or "")


def test_too_steep_a_correction_is_refused() -> None:
    error = refused(on_cylinder(-0.05, 0.05), Limits(slope=0.001))
    assert error.code is Code.CMP_SLOPE
    assert "1.4 µm/mm" in error.message


FILLET: tuple[Feature, ...] = (
    Line("face", (20.0, 0.0), (10.82, 0.0)),
    Arc("fillet", (10.82, 0.0), (10.0, 0.82), (10.82, 0.82), -math.pi / 2),
    Line("cylinder", (10.0, 0.82), (10.0, 30.0)),
)


def fillet_pieces(*shift_mm: float) -> tuple[CentrePiece, ...]:
    """A fillet of radius 0.82 mm, moved out of the material by that much along it, for a nose of 0.8 mm."""
    profile = Profile(FILLET, junctions_of(FILLET))
    along = np.linspace(0.0, FILLET[1].length_mm, len(shift_mm))
    shifts = [ZERO, sampled(along, np.array(shift_mm)), ZERO]
    return centre_pieces(profile, shifted_contour(profile, shifts, 0.8))


@pytest.mark.parametrize("shift_mm", [(0.021,), (0.0, 0.05, 0.0), (0.05, 0.05, 0.0)])
def test_a_fillet_bent_tighter_than_the_nose_is_refused_by_its_name(shift_mm: tuple[float, ...]) -> None:
    """0.82 - 0.021 mm is less than 0.8; bent in its middle alone its centre paths cross nowhere near it."""
    with pytest.raises(TrueloopError) as caught:
        check_nose(fillet_pieces(*shift_mm))
    assert caught.value.code is Code.GEO_NOSE
    assert "(radius 0.8000 mm) does not fit into 'fillet'" in caught.value.message
    assert "0.8200 mm" in caught.value.message


CHAMFER = Line("chamfer", (10.0, 0.0), (10.3, 0.4))
"""0.5 mm long."""


@pytest.mark.parametrize(("start_mm", "end_mm"), [(0.0, 0.5), (0.2, 0.3), (-0.4, 0.1), (0.49, 3.0)])
def test_a_feature_of_which_any_part_is_cut_passes_however_short_it_is(start_mm: float, end_mm: float) -> None:
    check_nose([CentrePiece(ShiftedFeature(CHAMFER, ZERO, 0.8), start_mm, end_mm)])


@pytest.mark.parametrize(("start_mm", "end_mm"), [(0.3, 0.3), (0.3, 0.2), (0.6, 1.0), (-1.0, 0.0)])
def test_a_feature_of_which_nothing_is_cut_is_refused(start_mm: float, end_mm: float) -> None:
    """Its piece of the centre path is empty, or lies beyond one of its ends."""
    with pytest.raises(TrueloopError, match="does not fit into 'chamfer'") as caught:
        check_nose([CentrePiece(ShiftedFeature(CHAMFER, ZERO, 0.8), start_mm, end_mm)])
    assert caught.value.code is Code.GEO_NOSE


@pytest.mark.parametrize("shift_mm", [(0.019,), (-0.05,), (0.0, 0.01, 0.0)])
def test_a_fillet_that_stays_wider_than_the_nose_passes(shift_mm: tuple[float, ...]) -> None:
    check_nose(fillet_pieces(*shift_mm))


@pytest.mark.parametrize("offset_mm", [(0.0, -0.1502), (0.1502, 0.0), (-0.1502, 0.0)])
def test_an_offset_is_too_large_in_either_direction(offset_mm: tuple[float, float]) -> None:
    with pytest.raises(TrueloopError) as refusal:
        check_offset(offset_mm, Limits(correction_mm=0.15))
    assert refusal.value.code is Code.CMP_SIZE
    assert refusal.value.values == pytest.approx({"size_um": 150.2, "limit_um": 150.0})
    check_offset((0.1499, -0.1499), Limits(correction_mm=0.15))


def test_what_is_looked_at_is_what_the_nose_cuts_of_the_feature_itself() -> None:
    (piece, *_) = fillet_pieces(0.0)
    length_mm = piece.shifted.feature.length_mm
    beyond = CentrePiece(piece.shifted, -1.0, length_mm + 1.0)
    assert (cut_mm(beyond)[0], cut_mm(beyond)[-1]) == (0.0, length_mm)
    within = CentrePiece(piece.shifted, 0.1, length_mm - 0.1)
    assert (cut_mm(within)[0], cut_mm(within)[-1]) == (0.1, length_mm - 0.1)


def test_a_correction_within_limits_passes() -> None:
    shifts = on_cylinder(-0.1, 0.1)
    check_limits(centre_pieces(PART, shifted_contour(PART, shifts, NOSE_RADIUS_MM)), shifts, Limits())


EDGE: tuple[Feature, ...] = (
    Line("cylinder", (10.0, -30.0), (10.0, -0.4)),
    Arc("edge", (10.0, -0.4), (9.6, 0.0), (9.6, -0.4), math.pi / 2),
    Line("face", (9.6, 0.0), (2.0, 0.0)),
)


def edge_check(on_cylinder_mm: float, on_edge: Callable[[Array], Array], on_face_mm: float) -> None:
    """`check_limits` of a shaft whose edge is rounded with 0.4 mm; on it the shift by the angle from the x axis."""
    profile = Profile(EDGE, junctions_of(EDGE))
    along = np.linspace(0.0, EDGE[1].length_mm, 201)
    shifts = [sampled(np.array([0.0, 1.0]), np.full(2, value)) for value in (on_cylinder_mm, on_face_mm)]
    shifts.insert(1, sampled(along, on_edge(along / 0.4)))
    check_limits(centre_pieces(profile, shifted_contour(profile, shifts, 0.8)), shifts, Limits(slope=0.04))


def test_the_slope_of_a_tool_that_stands_off_is_no_steepness() -> None:
    """By hand: n·d of d = (−15, +6) µm reaches a slope of 15/0.4 = 40 µm/mm and more on the edge."""
    edge_check(-0.015, lambda phi: -0.015 * np.cos(phi) + 0.006 * np.sin(phi), 0.006)
    edge_check(-0.05, lambda phi: -0.05 * np.cos(phi), 0.0)


def test_a_bump_on_the_edge_alone_is_as_steep_as_ever() -> None:
    """20 µm · sin(2φ) over an arc of 0.4 mm: 100 µm/mm at its ends."""
    with pytest.raises(TrueloopError) as caught:
        edge_check(0.0, lambda phi: 0.02 * np.sin(2 * phi), 0.0)
    assert caught.value.code is Code.CMP_SLOPE and "'edge'" in caught.value.message


def test_the_shift_of_the_tool_is_that_of_most_of_the_part() -> None:
    """An edge of 0.63 mm that alone stands off by 20 µm, beside 30 mm of a cylinder that does not: 50 µm/mm."""
    with pytest.raises(TrueloopError) as caught:
        edge_check(0.0, lambda phi: -0.02 * np.cos(phi), 0.0)
    assert caught.value.code is Code.CMP_SLOPE
    assert caught.value.values["slope_um_per_mm"] == pytest.approx(50.0, rel=0.05)


@pytest.mark.parametrize("off_by", [0.0, 1e-4])
def test_the_shift_of_the_tool_weighs_features_by_the_length_that_is_cut(off_by: float) -> None:
    """0.4 mm that stand off by 10 µm and 1.6 mm that do not are moved by 2 µm along X: so is an edge of 0.2 mm, whose
    slopes of (2, 3) µm / 0.2 mm count for nothing then, but for 0.1 µm more those of 0.5 µm/mm do.
    """
    first, second = Line("a", (20.0, -10.0), (20.0, -9.0)), Line("b", (20.0, -8.0), (20.0, -5.0))
    edge = Arc("edge", (20.0, 0.0), (19.8, 0.2), (19.8, 0.0), math.pi / 2)
    s = np.linspace(0.0, edge.length_mm, 2001)
    moved = sampled(s, (0.002 + off_by) * np.cos(s / 0.2) + 0.003 * np.sin(s / 0.2))
    shifts = [constant(0.01), ZERO, moved]
    pieces = [
        CentrePiece(ShiftedFeature(first, shifts[0], 0.8), 0.3, 0.7),
        CentrePiece(ShiftedFeature(second, shifts[1], 0.8), 0.5, 2.1),
        CentrePiece(ShiftedFeature(edge, shifts[2], 0.8), 0.0, edge.length_mm),
    ]
    limits = Limits(correction_mm=0.01, slope=4e-5)
    if not off_by:
        check_limits(pieces, shifts, limits)
        return
    with pytest.raises(TrueloopError) as caught:
        check_limits(pieces, shifts, limits)
    assert caught.value.code is Code.CMP_SLOPE


def test_what_is_at_its_limit_is_allowed() -> None:
    check_offset((0.02, -0.02), Limits(correction_mm=0.02))
    with pytest.raises(TrueloopError):
        check_offset((0.02, -0.0201), Limits(correction_mm=0.02))


def test_the_next_cut_errs_by_the_process_less_the_weight_times_its_fit() -> None:
    """10 and −4 µm of process, fitted as 8 and −6, as 6 and −2 without the own reading; half of it is taken out."""
    process, fitted, left_out = np.array([0.010, -0.004]), np.array([0.008, -0.006]), np.array([0.006, -0.002])
    found = predict(np.array([0.012, -0.001]), process, fitted, left_out, cast(Budget, None), 0.5)
    np.testing.assert_allclose(found.before_mm, [0.012, -0.001])
    np.testing.assert_allclose(found.after_mm, [0.006, -0.001], atol=1e-15)
    np.testing.assert_allclose(found.leave_one_out_mm, [0.007, -0.003], atol=1e-15)


@pytest.mark.parametrize(
    ("age_hours", "said", "override"),
    [
        (25, "25.0 h ago", "compensation.max_age_hours in the job"),
        (-16.4, "16.4 h in the future", None),
        (-1 / 60, "1.0 min in the future", None),
    ],
)
def test_old_touches_are_refused_and_those_from_the_future_whatever_the_limit(
    age_hours: float, said: str, override: str | None
) -> None:
    with pytest.raises(TrueloopError, match=said) as caught:
        check_age(NOW - timedelta(hours=age_hours), NOW, Limits())
    assert (caught.value.code, caught.value.override) == (Code.CMP_AGE, override)


def test_touches_of_today_pass() -> None:
    check_age(NOW - timedelta(hours=23), NOW, Limits())


def test_a_corrected_program_is_not_corrected_again() -> None:
    with pytest.raises(TrueloopError) as caught:
        check_uncorrected(b"N0010 (ID)\nN0011 ! trueloop corrected: record 0123\nN0020 G01 X1\n")
    assert caught.value.code is Code.CMP_TWICE
    assert caught.value.place.line == 2
    check_uncorrected(b"N0010 (ID)\n")


@pytest.mark.parametrize("mark", [b"(TRUELOOP CORRECTED: RECORD 1234)", b"; Trueloop  corrected"])
def test_the_mark_is_known_as_controls_give_it_back(mark: bytes) -> None:
    with pytest.raises(TrueloopError) as caught:
        check_uncorrected(b"%\n" + mark + b"\nM30\n")
    assert caught.value.code is Code.CMP_TWICE
    assert caught.value.place.line == 2


def test_touches_of_another_program_are_refused() -> None:
    check_same_program(b"G01", sha256_of(b"G01").upper())
    with pytest.raises(TrueloopError) as caught:
        check_same_program(b"G01", sha256_of(b"G00"))
    assert caught.value.code is Code.CMP_OTHER_PROGRAM


def test_record_id_depends_on_inputs_and_options_alone() -> None:
    one = record_id({"finish": "a"}, {"weight": 1.0})
    assert one == record_id({"finish": "a"}, {"weight": 1.0})
    assert one != record_id({"finish": "a"}, {"weight": 0.75})
    assert len(one) == 16


def test_table_adds_the_correction_to_the_commanded_path() -> None:
    """On the cylinder the row says −20 µm in x (a radius) and nothing in z; corners of both paths share a row."""
    plain = centre_pieces(PART, shifted_contour(PART, [ZERO] * 5, NOSE_RADIUS_MM))
    moved = centre_pieces(PART, shifted_contour(PART, on_cylinder(-0.02, -0.02), NOSE_RADIUS_MM))
    table = correction_table(plain, moved)
    middle = next(
        k
        for k, (n, p) in enumerate(zip(table.feature, table.commanded_mm, strict=True))
        if n == "cylinder" and p[1] > -80
    )
    assert table.commanded_mm[middle][0] == pytest.approx(44.704 + NOSE_RADIUS_MM)
    assert table.correction_mm[middle][0] == pytest.approx(-0.02, abs=1e-12)
    first = table.feature.index("cylinder")
    assert abs(table.correction_mm[middle][1]) < abs(table.correction_mm[first][1])  # the corner's slide, tapering off
    last = len(table.feature) - 1 - table.feature[::-1].index("cylinder")
    assert table.commanded_mm[last] == pytest.approx(table.commanded_mm[last + 1])
    assert table.correction_mm[last] == pytest.approx(table.correction_mm[last + 1], abs=1e-9)
