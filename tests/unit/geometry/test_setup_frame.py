"""The frame of a set-up against what it means: where a point of the part is for the program, its normal turned with it.

The places are mirrored by hand; the features in the frame have to agree about them by their own arithmetic.
"""

import numpy as np
import pytest

from trueloop.geometry.curve_kinds import ellipse
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile, junctions_of
from trueloop.geometry.setup_frame import SetupFrame

TURNED, MIRRORED = SetupFrame("second", -80.0, flipped=True), SetupFrame("sub", -80.0, mirrored_z=True)
TAKEN_OVER = SetupFrame("sub", -80.0)
FEATURES: tuple[Feature, ...] = (
    Line("back", (8.0, -80.0), (14.0, -80.0)),
    Arc("edge", (14.0, -80.0), (16.0, -78.0), (14.0, -78.0), np.pi / 2),
    Line("cone", (16.0, -78.0), (20.0, -50.0)),
    Arc("fillet", (20.0, -50.0), (24.0, -46.0), (24.0, -50.0), -np.pi / 2),
    ellipse("dome", ((24.0, -46.0), (0.0, -6.0)), (0.0, -46.0), (24.0, 40.0)),
)
PART = Profile(FEATURES, junctions_of(FEATURES))


def by_hand(frame: SetupFrame, x_mm: float, z_mm: float) -> tuple[float, float]:
    return (x_mm, -80.0 - z_mm) if frame.backwards else (x_mm, z_mm + 80.0)


@pytest.mark.parametrize("frame", [TURNED, MIRRORED, TAKEN_OVER], ids=["turned", "mirrored", "taken over"])
def test_every_place_of_the_part_is_where_the_program_has_it(frame: SetupFrame) -> None:
    """Its normal too, and a place off the surface is as far off it, on the same side."""
    seen = frame.profile(PART)
    turns = -1.0 if frame.backwards else 1.0
    assert seen.names == (PART.names[::-1] if frame.backwards else PART.names)
    for feature in FEATURES:
        placed = seen.features[seen.names.index(feature.name)]
        assert placed.length_mm == pytest.approx(feature.length_mm, abs=1e-9)
        for share in (0.0, 0.2, 0.5, 0.9, 1.0):
            s = share * feature.length_mm
            (x, z), (n_x, n_z) = feature.point_mm(s), feature.outward_normal(s)
            along, off = placed.locate(by_hand(frame, float(x + 0.3 * n_x), float(z + 0.3 * n_z)))
            assert float(off) == pytest.approx(0.3, abs=1e-9)
            assert float(along) == pytest.approx(feature.length_mm - s if frame.backwards else s, abs=1e-7)
            np.testing.assert_allclose(placed.outward_normal(along), (n_x, turns * n_z), atol=1e-9)
            bend = float(feature.curvature_per_mm(s))
            assert float(placed.curvature_per_mm(along)) == pytest.approx(bend, abs=1e-7)


def test_a_part_that_is_turned_round_runs_the_other_way_about_the_same_corners() -> None:
    seen = TURNED.profile(PART)
    assert seen.names == ("dome", "fillet", "cone", "edge", "back")
    assert seen.features[0].start_mm == pytest.approx((0.0, -74.0)) and seen.features[-1].end_mm == (8.0, 0.0)
    found = junctions_of(seen.features)
    assert [one.kind for one in seen.junctions] == [one.kind for one in found]
    np.testing.assert_allclose([one.turn_rad for one in seen.junctions], [one.turn_rad for one in found], atol=1e-12)
    assert seen.junctions[-1].kind is JunctionKind.TANGENT  # of the edge and the face


@pytest.mark.parametrize(
    ("frame", "words", "z_mm"),
    [
        (TURNED, "Z = −80.0000 − z", -30.0),
        (MIRRORED, "Z = −80.0000 − z", -30.0),
        (TAKEN_OVER, "Z = z + 80.0000", 30.0),
        (SetupFrame("front", 2.5), "Z = z − 2.5000", -52.5),
        (SetupFrame("front", 2.5, flipped=True), "Z = 2.5000 − z", 52.5),
        (SetupFrame("front"), "Z = z", -50.0),
    ],
)
def test_the_words_say_what_is_done(frame: SetupFrame, words: str, z_mm: float) -> None:
    """z −50 of the part, put into the words."""
    assert frame.words == words
    assert frame.z_mm(-50.0) == z_mm
    assert eval(words.removeprefix("Z = ").replace("−", "-"), {"z": -50.0}) == z_mm


@pytest.mark.parametrize(
    ("zero_mm", "flipped", "words", "z_mm"),
    [
        (-80.0, True, "Z = −80.0000 − z", -50.0),
        (0.5, True, "Z = 0.5000 − z", 30.5),
        (-80.0, False, "Z = z + 80.0000", 50.0),
        (0.5, False, "Z = z − 0.5000", -30.5),
        (0.0, False, "Z = z", -30.0),
        (0.0, True, "Z = 0.0000 − z", 30.0),
    ],
)
def test_places_and_directions_are_as_the_words_say(zero_mm: float, flipped: bool, words: str, z_mm: float) -> None:
    """Of z = −30 mm; x stays as it is, and so does the x of a direction."""
    frame = SetupFrame("frame", zero_mm, flipped=flipped)
    assert frame.words == words
    assert frame.points([[12.0, -30.0], [0.5, -30.0]]).tolist() == [[12.0, z_mm], [0.5, z_mm]]
    assert frame.point((12.0, -30.0)) == (12.0, z_mm)
    assert frame.directions([0.6, 0.8]).tolist() == [0.6, -0.8 if flipped else 0.8]
