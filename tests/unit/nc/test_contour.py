"""The profile read back from a finish program."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scripts.nist_parts import EXAMPLES
from tests.support.feed_moves import backwards, cut, to
from tests.support.profiles import NOSE_RADIUS_MM, facetst, modbas2, piecs11, polyline, profiles, simple
from tests.support.programs import ge2000t_text, linuxcnc_text
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.jobs.profile_of_job import profile_of_table
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.nc.check.rapid import sides_of_cuts
from trueloop.nc.match.contour import ProgramContour, contour_of_program
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import read_program


def same(found: Profile, nominal: Profile, atol_mm: float) -> None:
    """Same kinds of features, each on its nominal one; ends agree, less well along a tangency."""
    assert [type(f) for f in found.features] == [type(f) for f in nominal.features]
    for feature, expected in zip(found.features, nominal.features, strict=True):
        off = expected.locate(feature.point_mm(np.linspace(0, feature.length_mm, 21)))[1]
        assert np.abs(off).max() < atol_mm
    for i, junction in enumerate(nominal.junctions):
        slack = 1 / abs(math.sin(junction.turn_rad)) if abs(junction.turn_rad) > 0.05 else math.inf
        apart = math.dist(found.features[i].end_mm, nominal.features[i].end_mm)
        assert apart < max(2 * slack * atol_mm, atol_mm)


def contour_of_text(text: bytes, dialect: str, **parameters: float) -> ProgramContour:
    path = read_program(text, dialect).run(parameters)
    return contour_of_program(feed_moves(path), NOSE_RADIUS_MM, lines=(1, path.line[-1]))


WRITERS: list[tuple[Callable[[list[Feature]], bytes], str]] = [(linuxcnc_text, "linuxcnc"), (ge2000t_text, "ge2000t")]


@pytest.mark.parametrize(("write", "dialect"), WRITERS, ids=["linuxcnc", "ge2000t"])
@given(profile=profiles(), towards_chuck=st.booleans())
def test_profile_to_program_and_back(
    write: Callable[[list[Feature]], bytes], dialect: str, profile: Profile, towards_chuck: bool
) -> None:
    """Coordinates rounded to 1e-6 mm and 1e-7 in."""
    path = list(nose_centre_path(profile, NOSE_RADIUS_MM).features)
    found = contour_of_text(write(backwards(path) if towards_chuck else path), dialect)
    same(found.profile, profile, atol_mm=1e-5)
    lines = range(2 + len(path), 2, -1) if towards_chuck else range(3, 3 + len(path))
    if dialect == "linuxcnc":
        assert found.lines == tuple(lines)


def test_the_published_parts_names_and_lines() -> None:
    for profile, names in (
        (facetst(), ["cylinder-1", "face-1", "cylinder-2", "face-2"]),
        (modbas2(), ["cylinder-1", "face-1", "cone-1", "cylinder-2", "face-2", "cylinder-3", "arc-1"]),
        (piecs11(), ["cylinder-1", "face-1", "cone-1", "arc-1"]),
    ):
        path = nose_centre_path(profile, NOSE_RADIUS_MM).features
        contour = contour_of_program(cut(path), NOSE_RADIUS_MM)
        assert list(contour.profile.names) == names
        assert contour.lines == tuple(10 * (k + 1) for k in range(len(path)))
        same(contour.profile, profile, atol_mm=1e-9)


def test_moves_beside_the_contour_are_left_out_and_named() -> None:
    """FACETST as cut [6811 §A.2.3]: plunge, four features, the last 0.397 mm past the axis, pull-out, return."""
    path = list(nose_centre_path(facetst(), NOSE_RADIUS_MM).features)
    start, past = path[0].start_mm, (-0.396875, path[3].end_mm[1])
    path[3] = to(path[3].start_mm, past)
    moves = cut([to((79.5, start[1]), start), *path, to(past, (-0.396875, 3.3))])
    moves += cut([to((79.5, 3.3), (386.0, 50.8))], first=7, chain=1)
    for program in (moves, cut(backwards([m.path for m in moves[:6]]))):
        contour = contour_of_program(program, NOSE_RADIUS_MM)
        same(contour.profile, facetst(), atol_mm=1e-9)
        assert contour.profile.features[-1].end_mm == (0.0, 0.0)
        notes = " ".join(contour.notes)
        for words in ("was taken for the way in", "starts at or beyond the spindle axis", "runs beyond the axis"):
            assert words in notes
    assert "Lines 10–60 were taken" in contour_of_program(moves, NOSE_RADIUS_MM).notes[0]


def test_face_alone_is_read_inwards_either_way() -> None:
    face = to((30.0, 0.8), (-0.5, 0.8))
    for moves in (cut([face]), cut([face.reversed()])):
        feature = contour_of_program(moves, 0.8).profile.features[0]
        np.testing.assert_allclose([feature.start_mm, feature.end_mm], [(30, 0), (0, 0)], atol=1e-12)
        np.testing.assert_allclose(feature.outward_normal(1.0), [0, 1], atol=1e-12)


def test_pull_out_at_the_free_end_is_no_cone() -> None:
    """A ring's face, then away at 45°; a chamfer at the same place leads inwards and stays."""
    ring = checked_profile(polyline([(20.0, -30.0), (20.0, 0.0), (10.0, 0.0)]))
    path = nose_centre_path(ring, NOSE_RADIUS_MM).features
    x, z = path[-1].end_mm
    pulled_out = contour_of_program(cut([*path, to((x, z), (x + 2, z + 2))]), NOSE_RADIUS_MM)
    assert pulled_out.profile.names == ("cylinder-1", "face-1")
    assert "way in or out at the free end" in " ".join(pulled_out.notes)
    chamfered = contour_of_program(cut([*path, to((x, z), (x - 2, z + 2))]), NOSE_RADIUS_MM)
    assert chamfered.profile.names == ("cylinder-1", "face-1", "cone-1")


LED_IN = b"""G21 G40 G80 G99
T0303
G00 X20. Z3.
G01 {on}Z{front} F0.1
X28. ,C1.5
Z-22.
X36.
Z-48.
G40 X64.
M30
"""


@pytest.mark.parametrize(("on", "front_mm"), [(b"G42 ", 0.0), (b"", NOSE_RADIUS_MM)])
def test_lead_in_along_z_in_front_of_the_face_is_no_cylinder(on: bytes, front_mm: float) -> None:
    text = LED_IN.replace(b"{on}", on).replace(b"{front}", f"{front_mm:.5f}".encode())
    contour = contour_of_program(feed_moves(read_program(text, "fanuc-lathe").run()), NOSE_RADIUS_MM)
    assert contour.profile.names == ("cylinder-1", "face-1", "cylinder-2", "cone-1", "face-2")
    assert contour.profile.features[-1].end_mm[1] == pytest.approx(0.0, abs=1e-9)
    assert "Line 4 was taken for the way in or out at the free end, not for a cylinder." in contour.notes


@pytest.mark.parametrize(
    ("cuts", "last"),
    [
        (b"X28. Z-4.\nZ-22.", ("cylinder-2", "cone-1")),  # a chamfer of 45 degrees from the face on
        (b"X28. Z-30.", ("face-1", "cone-1")),  # a slim taper
        (b"Z-22.", ("face-1", "cylinder-2")),  # straight on
    ],
)
def test_lead_in_along_z_up_to_the_face_is_no_cylinder_whatever_is_cut_first(
    cuts: bytes, last: tuple[str, str]
) -> None:
    text = LED_IN.replace(b"{on}", b"G42 ").replace(b"{front}", b"0.").replace(b"X28. ,C1.5\nZ-22.", cuts)
    contour = contour_of_program(feed_moves(read_program(text, "fanuc-lathe").run()), NOSE_RADIUS_MM)
    assert contour.profile.names[-2:] == last
    assert contour.profile.features[-1].end_mm == pytest.approx((10.0, 0.0), abs=1e-9)
    assert "Line 4 was taken for the way in or out at the free end, not for a cylinder." in contour.notes


def test_pin_that_reaches_behind_the_first_face_stays() -> None:
    """The first cut runs from in front of the part to a shoulder at z -15, as on a part that is faced already."""
    text = LED_IN.replace(b"{on}", b"G42 ").replace(b"{front}", b"-15.")
    contour = contour_of_program(feed_moves(read_program(text, "fanuc-lathe").run()), NOSE_RADIUS_MM)
    assert contour.profile.names[-1] == "cylinder-3"


def test_named_lines_keep_the_approach_as_a_face() -> None:
    path = nose_centre_path(facetst(), NOSE_RADIUS_MM).features
    start = path[0].start_mm
    moves = cut([to((79.5, start[1]), start), *path])
    contour = contour_of_program(moves, NOSE_RADIUS_MM, lines=(10, 30))
    assert contour.profile.names == ("face-1", "cylinder-1", "face-2")
    assert contour.lines == (10, 20, 30)


def test_last_of_two_equal_passes_is_the_finish_pass() -> None:
    profile = piecs11()
    semifinish, finish = (nose_centre_path(profile, NOSE_RADIUS_MM + a).features for a in (0.254, 0.0))
    contour = contour_of_program([*cut(semifinish), *cut(finish, first=4, chain=1)], NOSE_RADIUS_MM)
    same(contour.profile, profile, atol_mm=1e-9)
    assert contour.lines == (50, 60, 70, 80)


def test_arc_about_an_edge_is_no_feature() -> None:
    profile = facetst()
    path = list(nose_centre_path(profile, NOSE_RADIUS_MM).features)
    edge = profile.features[0].end_mm
    path[0] = replace(simple(path[0]), end_mm=(edge[0] + NOSE_RADIUS_MM, edge[1]))
    path[1] = replace(simple(path[1]), start_mm=(edge[0], edge[1] + NOSE_RADIUS_MM))
    about = Arc("", path[0].end_mm, path[1].start_mm, edge, math.pi / 2)
    contour = contour_of_program(cut([path[0], about, *path[1:]]), NOSE_RADIUS_MM)
    same(contour.profile, profile, atol_mm=1e-9)
    assert contour.lines == (10, 30, 40, 50)
    assert "Line 20 only turns the nose about an edge: no feature." in contour.notes


def test_arc_with_rounded_centre_becomes_round() -> None:
    """Start 1 µm too far out for the centre: the arc keeps its ends and gets one radius."""
    neck, dome = Line("", (38.0, -60.0), (38.0, -37.0)), Arc("", (38.0, -37.0), (0.0, 0.999), (0.0, -37.0), math.pi / 2)
    arc = contour_of_program(cut([neck, dome]), 0.8).profile.features[1]
    assert isinstance(arc, Arc)
    assert math.dist(arc.end_mm, arc.centre_mm) == pytest.approx(math.dist(arc.start_mm, arc.centre_mm), abs=1e-9)
    assert math.dist(arc.end_mm, (0.0, 0.199)) < 1e-4


def test_cone_that_ends_in_a_point_on_the_axis() -> None:
    profile = checked_cone()
    path = nose_centre_path(profile, NOSE_RADIUS_MM).features
    x, z = path[-1].end_mm
    dx, dz = path[-1].tangent(0.0)
    longer = replace(simple(path[-1]), end_mm=(float(x + 2 * dx), float(z + 2 * dz)))
    contour = contour_of_program(cut([*path[:-1], longer]), NOSE_RADIUS_MM)
    same(contour.profile, profile, atol_mm=1e-9)
    assert contour.profile.features[-1].end_mm == pytest.approx((0.0, 0.0), abs=1e-9)


def checked_cone() -> Profile:
    return checked_profile(polyline([(10.0, -30.0), (10.0, -10.0), (0.0, 0.0)], ["shank", "point"]))


def test_examples_give_their_own_profiles() -> None:
    """From the example programs, the features of the example jobs, to the 1e-5 in that the programs are written to."""
    for part, lines in (("facetst", None), ("modbas2", None), ("piecs11", (20, 24))):
        job = read_turned_job(EXAMPLES / part / "job.toml")
        text = (EXAMPLES / part / "finish.nc").read_bytes()
        moves = feed_moves(read_program(text, "ge2000t").run(job.own_programs.parameters))
        contour = contour_of_program(moves, NOSE_RADIUS_MM, lines=lines)
        same(contour.profile, profile_of_table(job.part), atol_mm=1.3e-4)


def test_nothing_to_read() -> None:
    for moves, lines in (([], None), (cut(facetst().features), (900, 950))):
        with pytest.raises(TrueloopError) as refusal:
            contour_of_program(moves, NOSE_RADIUS_MM, lines=lines)
        assert refusal.value.code is Code.NC_NO_CONTOUR


BORE = """G21 G18 G8 G40 G90 G94
G0 X10 Z3
{} G0 X22 Z1
G1 X20 Z-1 F100
Z-30
X15
Z-60
G40 G0 X13
Z5
M2
"""


@pytest.mark.parametrize(
    ("mode", "why"), [("G41", "G41 keeps the nose on the other"), ("", "rapid moves beside it and")]
)
def test_a_bore_is_not_taken_for_a_part_with_its_material_at_the_axis(mode: str, why: str) -> None:
    """Taken so, its material left on would be more left on after the correction."""
    path = read_program(BORE.format(mode).encode(), "linuxcnc").run()
    with pytest.raises(TrueloopError, match=why) as refused:
        contour_of_program(feed_moves(path), 0.4, shown=sides_of_cuts(path))
    assert (refused.value.code, refused.value.place.line) == (Code.NC_BORE, 4)


def test_the_same_contour_turned_outside_is_read() -> None:
    outside = BORE.format("").replace("X10 Z3", "X30 Z3").replace("G40 G0 X13", "G0 X30")
    path = read_program(outside.replace("X15\nZ-60", "X25\nZ-60").encode(), "linuxcnc").run()
    assert not sides_of_cuts(path).boring
    assert contour_of_program(feed_moves(path), 0.4, shown=sides_of_cuts(path)).profile.features


AWAY = """G21 G18 G8 G40 G90 G94
G0 X40 Z-60
{} G0 X26 Z-58
G1 X25 Z-57 F100
Z-30
X20
Z-1
G40 G0 X40
Z5
M2
"""


def test_a_pass_away_from_the_chuck_is_outside_under_g41_and_a_bore_under_g42() -> None:
    path = read_program(AWAY.format("G41").encode(), "linuxcnc").run()
    assert contour_of_program(feed_moves(path), 0.4, shown=sides_of_cuts(path)).profile.features
    path = read_program(AWAY.format("G42").encode(), "linuxcnc").run()
    with pytest.raises(TrueloopError, match="G42 keeps the nose on") as refused:
        contour_of_program(feed_moves(path), 0.4, shown=sides_of_cuts(path))
    assert (refused.value.code, refused.value.place.line) == (Code.NC_BORE, 4)
