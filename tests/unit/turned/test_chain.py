"""Which features one spline runs over, and who prescribes to whom."""

import math

from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import Profile, junctions_of
from trueloop.turned.fit.chain_fit import End, chains_of, tangent_neighbours

R = 10.0


def profile(*features: Feature) -> Profile:
    return Profile(features, junctions_of(features))


CYLINDER = Line("cylinder", (30.0, -50.0), (30.0, -40.0))
CONTINUED = Line("continued", (30.0, -40.0), (30.0, -30.0))
QUARTER = Arc("quarter", (30.0, -30.0), (20.0, -20.0), (20.0, -30.0), math.pi / 2)
FILLET = Arc("fillet", (20.0, -20.0), (10.0, -10.0), (20.0, -10.0), -math.pi / 2)
NECK = Line("neck", (10.0, -10.0), (10.0, 0.0))
FACE = Line("face", (10.0, 0.0), (0.0, 0.0))


def test_lines_in_line_and_arcs_in_tangent_contact_are_chains() -> None:
    chains = chains_of(profile(CYLINDER, CONTINUED, QUARTER, FILLET, NECK, FACE))
    assert [chain.features for chain in chains] == [(0, 1), (2, 3), (4,), (5,)]
    assert [chain.curved for chain in chains] == [False, True, False, False]
    assert chains[1].starts_mm == (0.0, QUARTER.length_mm)
    assert chains[1].joints_mm == (QUARTER.length_mm,)
    assert chains[1].length_mm == QUARTER.length_mm + FILLET.length_mm


def test_neighbours_are_tangent_ones_only() -> None:
    part = profile(CYLINDER, CONTINUED, QUARTER, FILLET, NECK, FACE)
    chains = chains_of(part)
    found = [tangent_neighbours(part, chains, i) for i in range(len(chains))]
    assert found == [(None, End(1, False)), (End(0, True), End(2, False)), (End(1, True), None), (None, None)]
