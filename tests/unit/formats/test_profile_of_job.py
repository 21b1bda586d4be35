"""Profiles as jobs spell them out: units, diameters, the four arcs of a radius, junctions by design."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from tests.support.profiles import modbas2, piecs11, profiles, turned_on
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.part_tables import PartTable
from trueloop.formats.jobs.profile_of_job import part_table_toml, profile_of_table
from trueloop.geometry.feature import Arc
from trueloop.geometry.profile import TANGENT_WITHIN_RAD, JunctionKind, Profile
from trueloop.geometry.validate import checked_profile


def _table(text: str) -> PartTable:
    return PartTable.model_validate(tomllib.loads(text)["part"])


def _arc(turn: str, more_than_half: bool) -> Arc:
    text = f"""
        [part]
        name = "ball"
        start = [3.0, -4.0]
        [[part.feature]]
        name = "arc"
        to = [3.0, 4.0]
        radius = 5.0
        turn = "{turn}"
        more_than_half = {str(more_than_half).lower()}
    """
    arc = profile_of_table(_table(text)).features[0]
    assert isinstance(arc, Arc)
    return arc


@pytest.mark.parametrize("unit, factor", [("mm", 1.0), ("inch", 25.4)])
@pytest.mark.parametrize("x_is, x_factor", [("radius", 1.0), ("diameter", 0.5)])
def test_coordinates_come_in_mm_with_x_a_radius(unit: str, factor: float, x_is: str, x_factor: float) -> None:
    table = _table(f"""
        [part]
        name = "step"
        unit = "{unit}"
        x_is = "{x_is}"
        start = [4.0, 0.0]
        feature = [{{ name = "cylinder", to = [4.0, 2.5] }}, {{ name = "face", to = [1.0, 2.5] }}]
    """)
    cylinder, face = profile_of_table(table).features
    assert cylinder.start_mm == (4.0 * x_factor * factor, 0.0)
    assert face.end_mm == (1.0 * x_factor * factor, 2.5 * factor)


@pytest.mark.parametrize("x_is, x_factor", [("radius", 1.0), ("diameter", 2.0)])
def test_the_radius_of_an_arc_is_never_a_diameter_and_its_centre_x_follows_x_is(x_is: str, x_factor: float) -> None:
    """Quarter of a dome, 10 mm: x of start and centre double in diameter mode, the radius does not."""
    for arc_is in ("radius = 10.0", f"centre = [{1.0 * x_factor}, 0.0]"):
        table = _table(f"""
            [part]
            name = "dome"
            x_is = "{x_is}"
            start = [{11.0 * x_factor}, 0.0]
            feature = [{{ name = "dome", to = [{1.0 * x_factor}, 10.0], {arc_is} }}]
        """)
        (dome,) = profile_of_table(table).features
        assert isinstance(dome, Arc)
        assert np.allclose(dome.centre_mm, (1.0, 0.0), atol=1e-12)
        assert dome.sweep_rad == pytest.approx(math.pi / 2, abs=1e-12)


@pytest.mark.parametrize(
    "turn, more_than_half, centre, sweep",
    [
        ("convex", False, (0.0, 0.0), 2 * math.asin(0.8)),
        ("convex", True, (6.0, 0.0), 2 * math.pi - 2 * math.asin(0.8)),
        ("concave", False, (6.0, 0.0), -2 * math.asin(0.8)),
    ],
)
def test_arcs_of_one_radius(turn: str, more_than_half: bool, centre: tuple[float, float], sweep: float) -> None:
    """Chord of 8, radius 5: the 3-4-5 triangle puts the centre 3 from it, on the material's side when convex."""
    arc = _arc(turn, more_than_half)
    assert np.allclose(arc.centre_mm, centre, atol=1e-12)
    assert arc.sweep_rad == pytest.approx(sweep, abs=1e-12)
    assert np.allclose(arc.point_mm(arc.length_mm), arc.end_mm, atol=1e-12)


def test_a_concave_arc_of_more_than_half_a_turn_is_refused_where_it_goes_beyond_the_axis() -> None:
    """Its centre is (0, 0) and it swings down to x = −5."""
    with pytest.raises(TrueloopError) as refusal:
        _arc("concave", True)
    assert refusal.value.code is Code.GEO_AXIS


def test_a_radius_smaller_than_half_the_chord_is_refused_with_both_lengths() -> None:
    table = _table("""
        [part]
        name = "ball"
        start = [3.0, -4.0]
        feature = [{ name = "arc", to = [3.0, 4.0], radius = 3.9 }]
    """)
    with pytest.raises(TrueloopError, match=r"'arc' has a radius of 3\.9000 mm, but its ends are 8\.0000 mm apart"):
        profile_of_table(table)


def test_junctions_by_design_override_the_geometry() -> None:
    table = _table("""
        [part]
        name = "step"
        start = [4.0, 0.0]
        feature = [{ name = "cylinder", to = [4.0, 2.5] }, { name = "land", to = [4.0, 5.0] }]
        junctions = { "cylinder/land" = "corner" }
    """)
    (junction,) = profile_of_table(table).junctions
    assert junction.kind is JunctionKind.CORNER
    assert junction.by_design


def test_a_junction_of_features_that_do_not_meet_is_refused() -> None:
    table = _table("""
        [part]
        name = "step"
        start = [4.0, 0.0]
        feature = [{ name = "cylinder", to = [4.0, 2.5] }, { name = "land", to = [4.0, 5.0] }]
        junctions = { "cylinder-land" = "corner" }
    """)
    with pytest.raises(TrueloopError) as refusal:
        profile_of_table(table)
    assert refusal.value.code is Code.GEO_JUNCTION


def _same(read: Profile, written: Profile) -> bool:
    """Points to a picometre; sweeps, which are found again from the rounded centre, to what that makes of them."""
    sweeps = [[getattr(f, "sweep_rad", 0.0) for f in profile.features] for profile in (read, written)]
    return (
        read.names == written.names
        and np.allclose([f.end_mm for f in read.features], [f.end_mm for f in written.features], rtol=0, atol=1e-9)
        and np.allclose(sweeps[0], sweeps[1], rtol=0, atol=1e-9)
        and [j.kind for j in read.junctions] == [j.kind for j in written.junctions]
    )


@pytest.mark.parametrize("profile", [modbas2(), piecs11()], ids=["MODBAS2", "PIECS11"])
def test_a_printed_part_table_reads_back_as_the_same_profile(profile: Profile) -> None:
    assert _same(profile_of_table(_table(part_table_toml('a "quoted" \\ name', profile))), profile)


@given(profiles())
def test_any_printed_part_table_reads_back(profile: Profile) -> None:
    assert _same(profile_of_table(_table(part_table_toml("part", profile))), profile)


@pytest.mark.parametrize("beyond_rad", [-1e-10, 1e-10])
def test_a_joint_at_the_edge_of_tangent_reads_back_as_what_it_was(beyond_rad: float) -> None:
    before = turned_on(None, "before", 0.1, 3.0, 0.0)
    after = turned_on(before, "after", 0.1 - TANGENT_WITHIN_RAD - beyond_rad, 3.0, 0.0)
    profile = checked_profile([before, after])
    assert _same(profile_of_table(_table(part_table_toml("part", profile))), profile)


def test_a_printed_part_table_is_a_file_that_parses(tmp_path: Path) -> None:
    path = tmp_path / "part.toml"
    path.write_text(part_table_toml("line\nend", modbas2()))
    assert tomllib.loads(path.read_text())["part"]["name"] == "line\nend"
