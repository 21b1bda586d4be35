"""The drawings of the manual are those that the code makes, and their signs are those of the code."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from scripts.manual.contents import ROOT
from scripts.manual.drawings.all import DRAWINGS
from trueloop.geometry.feature import Line, contact_angle_rad
from trueloop.geometry.validate import checked_profile


@pytest.mark.parametrize("name", DRAWINGS)
def test_the_file_is_what_the_code_draws(name: str) -> None:
    kept = (ROOT / "docs" / "images" / f"{name}.svg").read_text(encoding="utf-8")
    assert kept == DRAWINGS[name](), "run: python -m scripts.manual.drawings"
    root = ElementTree.fromstring(kept)
    assert root.find("{http://www.w3.org/2000/svg}title") is not None
    assert "prefers-color-scheme: dark" in kept and not re.search(r"href|url\(", kept)


def test_words_lie_inside_their_drawing() -> None:
    """By the width of an average letter, rounded up."""
    for name, draw in DRAWINGS.items():
        root = ElementTree.fromstring(draw())
        width, height = (float(root.attrib[side]) for side in ("width", "height"))
        for one in root.iter("{http://www.w3.org/2000/svg}text"):
            long = (6.7 if one.attrib.get("class") == "small" else 7.6) * len(one.text or "")
            start = float(one.attrib["x"]) - long * {"start": 0.0, "middle": 0.5, "end": 1.0}[one.attrib["text-anchor"]]
            assert start >= 0 and start + long <= width, (name, one.text)
            assert 10 <= float(one.attrib["y"]) <= height - 3, (name, one.text)


def test_normals_of_a_shaft_point_away_from_the_axis_and_from_the_chuck() -> None:
    """As sign-frame.svg has it: of a cylinder along +x, of the free end's face along +z."""
    profile = checked_profile([Line("cylinder", (20.0, -30.0), (20.0, 0.0)), Line("face", (20.0, 0.0), (0.0, 0.0))])
    normals = [feature.outward_normal(np.array([1.0]))[0] for feature in profile.features]
    np.testing.assert_allclose(normals, [(1.0, 0.0), (0.0, 1.0)], atol=1e-12)
    np.testing.assert_allclose(np.degrees(contact_angle_rad(normals)), [90.0, 0.0])  # as sign-angle.svg
