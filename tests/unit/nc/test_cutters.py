"""Which edge cuts which feature: an OD tool and both corners of a groove insert, in the words of three controls."""

import json
import re
from pathlib import Path

import pytest

from tests.support.cli import invoke, run
from tests.support.grooved import CALLS, LEFT, NOSE_MM, OD, PLACES, RIGHT, Control, job, program
from trueloop.geometry.profile import JunctionKind
from trueloop.jobs.turned.inputs import read_setups
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.nc.match.own_contour import OwnContour, own_contour
from trueloop.nc.program.called import CalledOffset, called
from trueloop.nc.program.program import read_program

BY_EDGE = {OD: ["big + mid", "step", "seat", "chamfer"], LEFT: ["left-wall", "floor-left"],
           RIGHT: ["floor-right", "right-wall"]}  # fmt: skip


def tools_of(path: Path, status: int = 0) -> dict[str, str]:
    found = json.loads(invoke("nc", "features", path, "--json", status=status).stdout)
    return {one["name"]: one["tool"] for one in found["features"]}


def own(path: Path, called: CalledOffset) -> OwnContour:
    (of,) = read_setups(JobFiles.of(path)).found.setups
    assert of.found is not None
    return own_contour(of.profile, of.found, next(edge for edge in of.setup.edges if edge.called == called))


def written(folder: Path, old: str, new: str, more: str = "") -> Path:
    """The job, with other words in its program."""
    path = job(folder, [0.0] * len(PLACES), more=more)
    changed = program().replace(old, new)
    assert changed != program()
    (folder / "finish.nc").write_text(changed)
    return path


@pytest.mark.parametrize("control", CALLS)
def test_every_feature_knows_its_tool_and_edge(tmp_path: Path, control: Control) -> None:
    right = "T5 D2" if control == "siemens" else "T15"
    words = {OD: "T3", LEFT: "T5 (left corner)", RIGHT: f"{right} (right corner)"}
    expected = {feature: words[edge] for edge, features in BY_EDGE.items() for feature in features}
    assert tools_of(job(tmp_path, [0.0] * len(PLACES), control)) == expected


def test_an_edge_has_a_contour_of_its_own(tmp_path: Path) -> None:
    """By hand: the OD tool passes from z −60 to −20 over the groove; the left corner's
    floor ends where the right corner's begins.
    """
    path = job(tmp_path, [0.0] * len(PLACES))
    turned = own(path, CalledOffset(OD))
    assert turned.profile.names == tuple(BY_EDGE[OD]) and turned.parts == ((0, 5), (6,), (7,), (8,))
    assert (turned.profile.features[0].start_mm, turned.profile.features[0].end_mm) == ((25.0, -60.0), (25.0, -20.0))
    assert [junction.kind for junction in turned.profile.junctions] == [JunctionKind.CORNER] * 3
    left = own(path, CalledOffset(LEFT))
    assert left.profile.features[-1].end_mm == (20.0, -37.0)


def test_an_edge_ends_where_its_nose_stops_at_the_corner_of_another(tmp_path: Path) -> None:
    """The right corner cuts the wall alone: at the floor its nose of 0.2 mm leaves 0.2 · tan 45° of it."""
    floor = f"G01 X40.4000 Z{-34 - NOSE_MM[RIGHT]:.4f} F0.05\nG01 X40.4000 Z-37.0000\nG00 X60. Z-37."
    path = written(tmp_path, floor, floor.replace("\nG01 X40.4000 Z-37.0000", ""))
    text = (tmp_path / "finish.nc").read_text().replace("G01 X40.4000 Z-37.0000", "G01 X40.4000 Z-34.2000")
    (tmp_path / "finish.nc").write_text(text)
    (wall,) = own(path, CalledOffset(RIGHT)).profile.features
    assert wall.start_mm == pytest.approx((20.2, -34.0)) and wall.end_mm == (25.0, -34.0)


def test_features_apart_are_cut_by_one_edge(tmp_path: Path) -> None:
    """The OD tool leaves out the groove and comes down again behind it: nothing joins the two cylinders."""
    over = "G01 X51.6000 Z-60.0000"
    path = written(tmp_path, over, "G01 X51.6000 Z-33.0000\nG00 X56.\nG00 Z-41.\nG01 X51.6000\nG01 Z-60.0000")
    turned = own(path, CalledOffset(OD))
    assert turned.profile.names == ("big", "mid", "step", "seat", "chamfer")
    assert turned.profile.junctions[0].kind is JunctionKind.APART
    assert tools_of(path)["big"] == tools_of(path)["mid"] == "T3"


def test_cuts_that_follow_each_other_over_anothers_feature_meet_where_their_lines_cross(tmp_path: Path) -> None:
    """The groove is moved to the corner of the step: the OD tool's cylinder goes on to where the face would be."""
    path = written(tmp_path, "G01 X40.4000 Z-34.2000 F0.05", "G01 X40.4000 Z-20.2000 F0.05")
    text = (tmp_path / "job.toml").read_text()
    for gone in ('{ name = "right-wall", to = [25, -34] }, { name = "mid", to = [25, -20] },',
                 '{ name = "step", to = [18, -20] },'):  # fmt: skip
        assert gone in text
        text = text.replace(gone, '{ name = "step", to = [18, -34] },' if "step" in gone else "")
    (tmp_path / "job.toml").write_text(text)
    lines = (tmp_path / "finish.nc").read_text().replace("G01 X37.6000 Z-19.2000", "G01 X37.6000 Z-33.2000")
    (tmp_path / "finish.nc").write_text(lines.replace("G01 X51.6000 Z-19.2000", "G01 X51.6000 Z-33.2000"))
    turned = own(path, CalledOffset(OD))
    big, step = turned.profile.features[:2]
    assert (big.name, step.name) == ("big", "step") and big.end_mm == step.start_mm == (25.0, -34.0)


def test_the_wrong_corner_is_refused(tmp_path: Path) -> None:
    """The two offsets exchanged in the program: each corner would cut the wall behind it."""
    path = job(tmp_path, [0.0] * len(PLACES))
    text = program().replace("T0505", "T05xx").replace("T0515", "T0505").replace("T05xx", "T0515")
    (tmp_path / "finish.nc").write_text(text)
    said = run("nc", "features", path, status=1)
    assert said.count("NC-EDGE") == 2
    assert "T15 (right corner) cuts 'left-wall', which leans 90.0° under that corner" in said
    assert "finish.nc:14: NC-EDGE" in said


BOTH = "G01 X40.4000 Z-37.0000\nG00 X60. Z-37.\nT0515"


def test_tools_that_both_cut_a_feature_are_named_and_the_job_decides(tmp_path: Path) -> None:
    """The left corner goes on over the whole floor: which corner leaves its right half nobody can say."""
    path = written(tmp_path, BOTH, BOTH.replace("Z-37.0000", "Z-34.2000"))
    said = run("nc", "features", path, status=1)
    assert "NC-TOOLS: 'floor-right' is cut by 2 tools" in said
    assert re.search(
        r"T15 \(right corner\) from line 20 on \(9\d %\), T5 \(left corner\) from line 15 on \(9\d %\)", said
    )
    for number in (LEFT, RIGHT):
        path.write_text(path.read_text().split("[feature")[0] + f"[feature.floor-right]\ntool = {number}\n")
        assert tools_of(path)["floor-right"].startswith(f"T{number} ")


def test_the_deeper_of_two_tools_leaves_the_surface(tmp_path: Path) -> None:
    """The left corner runs 0.05 mm above the right half of the floor: the right corner cuts away what it leaves."""
    above = BOTH.replace("G01 X40.4000 Z-37.0000", "G01 X40.4000 Z-37.0000\nG01 X40.5000\nG01 Z-34.2")
    path = written(tmp_path, BOTH, above)
    assert tools_of(path)["floor-right"] == "T15 (right corner)"


def test_what_is_left_alone_is_no_edges(tmp_path: Path) -> None:
    """The right wall is: its edge keeps the floor, and nothing says that the wall is not known."""
    path = job(tmp_path, [0.0] * len(PLACES), more="[feature.right-wall]\ntool = 0\n")
    found = tools_of(path)
    assert found["right-wall"] == "" and found["floor-right"] == "T15 (right corner)"
    assert own(path, CalledOffset(RIGHT)).profile.names == ("floor-right",)
    assert re.search(r"right-wall +– +– +left alone", run("nc", "features", path))


def test_a_tool_that_the_program_does_not_call_is_refused(tmp_path: Path) -> None:
    said = run("nc", "features", written(tmp_path, "T0515", "T0505"), status=3)
    assert (
        "NC-NO-TOOL: the job has a tool T15, which the program does not cut with: those of its cuts are T3, T5" in said
    )


def test_offsets_are_called_as_controls_call_them() -> None:
    """T0313 offset 13; H13; D2 of the tool in use; GE 2000T as Fanuc; TG and OG of an Okuma, or six digits."""
    for control, words, expected in (
        ("fanuc-lathe", "T0313", [CalledOffset(13)]),
        ("fanuc-lathe", "T3", [CalledOffset(3)]),
        ("linuxcnc", "T3 M6 G43 H13", [CalledOffset(13)]),
        ("linuxcnc", "T3 M6", [CalledOffset(3)]),
        ("siemens", "T3 D2", [CalledOffset(3, 2)]),
        ("siemens", "T3", [CalledOffset(3)]),
        ("ge2000t", "T0313", [CalledOffset(13)]),
        ("okuma-lathe", "T030313", [CalledOffset(13)]),
        ("okuma-lathe", "G01 X22. TG=06 OG=2\nOG=1", [CalledOffset(6, 2), CalledOffset(6)]),
        ("okuma-lathe", "G01 X22. TG=06 OG=2\nTG=03", [CalledOffset(6, 2), CalledOffset(3)]),
    ):
        source = read_program(f"{words}\nG1 X20. Z-20. F1\n".encode(), control)
        path = source.run({}, strict=False)
        assert [called(source.dialect, path, k) for k in range(len(path))] == expected, (control, words)
