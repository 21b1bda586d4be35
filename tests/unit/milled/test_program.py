"""What cuts each feature, found from programs that a generator apart writes in the words of five controls."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.mill_programs import CONTROLS, Control, Writer, plate
from tests.support.mill_shop import BORES, BOSSES, PLANES
from tests.support.refusals import refused
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.milled_job import read_milled_job
from trueloop.jobs.milled_new import CutFeatures, cut_features
from trueloop.milled.entry import Entry
from trueloop.milled.feature import Kind
from trueloop.milled.observed import ObservedSize, places_of


def feature(name: str, kind: Kind, at: tuple[float, float, float], more: str = "") -> str:
    return f'[[feature]]\nname = "{name}"\nkind = "{kind}"\nat = {list(at)}\n{more}\n'


ROUND = {
    **{name: ("bore", (x, y, 0.0), f"size = {d}\ndepth = {t}") for name, (x, y, d, t) in BORES.items()},
    **{name: ("boss", (x, y, 0.0), f"size = {d}\ndepth = {t}") for name, (x, y, d, t) in BOSSES.items()},
    "H": ("bore", (80.0, 40.0, 0.0), "size = 6.0\ndepth = 20.0"),
}
FEATURES: dict[str, tuple[Kind, tuple[float, float, float], str]] = {
    **ROUND,  # type: ignore[dict-item]
    **{name: ("face", (0.0, 0.0, z), "") for name, z in PLANES.items()},
    "P.x": ("slot", (75.0, 0.0, 0.0), "size = 30.0\ndepth = 12.0\ndirection = [1.0, 0.0, 0.0]"),
    "P.y": ("slot", (75.0, 0.0, 0.0), "size = 20.0\ndepth = 12.0\ndirection = [0.0, 1.0, 0.0]"),
    "R": ("rib", (0.0, -50.0, 0.0), "size = 4.0\ndepth = 5.0\ndirection = [0.0, 1.0, 0.0]"),
}


def found(
    folder: Path,
    control: Control = "fanuc-mill",
    features: dict[str, tuple[Kind, tuple[float, float, float], str]] = FEATURES,
    tools: str = "",
    change: Callable[[str], str] = lambda text: text,
) -> CutFeatures:
    """Returns what is found of features in the plate's program, its text changed."""
    (folder / "finish.nc").write_text(change(plate(control)))
    job = folder / "job.toml"
    listed = "\n".join(feature(name, *one) for name, one in features.items())
    program = f'[program]\nfile = "finish.nc"\ndialect = "{control}"\n'
    job.write_text(f'name = "plate"\nunit = "mm"\n{listed}\n{program}\n{tools}\n[[measured]]\nfile = "part-1.dmo"\n')
    return cut_features(job, read_milled_job(job))


CIRCLE = (
    "900 L X{x:+d} Y{y:+d} Z+5 FMAX\n901 CYCL DEF 252 CIRCULAR POCKET Q215=2 Q223=12 Q368=0 Q207=500 Q351=1 Q201=-20 "
    "Q202=5 Q369=0 Q206=150 Q338=0 Q200=2 Q203=0 Q204=50 Q370=1 Q366=1 Q385=500\n902 L X{x:+d} Y{y:+d} FMAX M99\n"
)
CUT_BY = {
    "B": (2, True, "climb"),
    "S": (1, True, "climb"),
    "H": (6, False, ""),
    "P": (2, True, "conventional"),
    "R": (3, False, "climb"),
}
"""Tool, whether its radius stands at the control, direction: as the generator writes the features' last passes."""


@pytest.mark.parametrize("control", CONTROLS)
def test_tool_register_work_offset_and_direction_are_found_in_programs_of_five_controls(
    tmp_path: Path, control: Control
) -> None:
    cut = found(tmp_path, control)
    offset = "preset 1" if control == "heidenhain" else "G54"
    for name, one in cut.features.items():
        tool, control_radius, side = CUT_BY.get(name[0], (1, False, ""))
        assert (name, one.tool, one.radius_at_control, one.side) == (name, tool, control_radius, side)
        assert (one.work_offset, one.length_at_control) == (offset, True)
    words = {"fanuc-mill": "D22", "haas-mill": "D22", "linuxcnc": "D2", "siemens": "D1", "heidenhain": ""}
    assert cut.radius_words["2"] == words[control] and cut.corner_mm == {"2": 6.0}
    assert cut.diameters == (frozenset("1236") if control == "linuxcnc" else frozenset())
    assert cut.cutter_mm["6"] == pytest.approx(3.0)


def only(*names: str, **changed: tuple[Kind, tuple[float, float, float], str]):  # type: ignore[no-untyped-def]
    return {name: changed.get(name, FEATURES[name]) for name in names}


BORE = ("bore", (-50.0, -30.0, 0.0), "size = 12.0\ndepth = 20.0")
WIDE = (*BORE[:2], "size = 12.2\ndepth = 20.0")


@pytest.mark.parametrize(
    ("code", "features", "tools", "change"),
    [
        # a bore stated where a boss is cut, and the other way round
        (Code.MIL_SIDE, {"S0": ("bore", (-25.0, 0.0, 0.0), "size = 16.0\ndepth = 10.0")}, "", None),
        (Code.MIL_SIDE, {"B0": ("boss", *BORE[1:])}, "", None),
        (Code.MIL_SIDE, {"P.x": ("rib", *FEATURES["P.x"][1:])}, "", None),
        # another place, another size: whatever the job states, the wall is not there
        (Code.MIL_NOT_CUT, {"B0": ("bore", (-50.0, -29.8, 0.0), BORE[2])}, "", None),
        (Code.MIL_NOT_CUT, {"B0": WIDE}, "[[tool]]\nnumber = 2\ncutter_radius = 4.0", None),
        (Code.MIL_CUT, {"B0": WIDE}, "", None),
        # stated values that are not the program's
        (Code.MIL_STATED, {"B0": (*BORE[:2], BORE[2] + "\ntool = 1")}, "", None),
        (Code.MIL_STATED, {"B0": (*BORE[:2], BORE[2] + '\nwork_offset = "G55"')}, "", None),
        (Code.MIL_STATED, {"B0": (*BORE[:2], BORE[2] + '\nside = "conventional"')}, "", None),
        (Code.MIL_STATED, only("B0"), '[[tool]]\nnumber = 2\nradius = "program"', None),
        (Code.MIL_STATED, only("H"), '[[tool]]\nnumber = 6\nradius = "control"', None),
        (Code.MIL_STATED, only("H"), "[[tool]]\nnumber = 6\ncutter_radius = 6.0", None),  # its diameter
        # one register for two tools: D of the roughing tool, H of the drill
        (Code.MIL_REGISTER, only("B0"), "", lambda text: text.replace("D21", "D22")),
        (Code.MIL_REGISTER, only("H"), "", lambda text: text.replace("G43 H5", "G43 H6")),
        # the bores once more from another work offset
        (Code.MIL_CUT, only("B0"), "", lambda text: text.replace("M30", _bores_from(text, "G55") + "M30")),
        # tools by names: two of them would be one
        (Code.MIL_CUT, only("B0"), "siemens", lambda text: re.sub(r"^T(\d) M6", r'T="MILL\1" M6', text, flags=re.M)),
        # the floor a second time, 0.02 mm deeper
        (Code.MIL_LEVELS, only("floor"), "", lambda text: text.replace("T2 M6", _face(-15.02) + "T2 M6")),
    ],
)  # fmt: skip
def test_what_could_set_a_wrong_number_is_refused(
    tmp_path: Path, code: Code, features: dict[str, object], tools: str, change: Callable[[str], str] | None
) -> None:
    control = tools if tools in CONTROLS else "fanuc-mill"
    own = "" if tools in CONTROLS else tools
    refusal = refused(found, tmp_path, control, features, own, change or (lambda text: text))
    assert refusal.code is code, str(refusal)


def test_a_longer_tool_that_the_program_subtracts_cuts_deeper(tmp_path: Path) -> None:
    """G44: the control subtracts H, so that the face of a tool entered 10 µm longer lies 10 µm lower."""
    effects = {}
    changes: dict[str, Callable[[str], str]] = {"G43": str, "G44": lambda text: text.replace("G43", "G44")}
    for code, change in changes.items():
        part = found(tmp_path, features=only("floor"), change=change)
        (floor,) = part.features.values()
        places, _ = places_of((ObservedSize("floor, z", (floor,), (None,), np.ones(1), -15.0),), "plate", 0)
        (effects[code],) = 0.010 * Entry("length", str(floor.tool)).basis(places)
    assert effects == {"G43": pytest.approx(0.010), "G44": pytest.approx(-0.010)}


def _bores_from(text: str, offset: str) -> str:
    part = text[text.index("T2 M6") : text.index("G42")]
    return part.replace("G54", offset)


def _face(z: float) -> str:
    return f"G0 X-90. Y90.\nG1 Z{z} F200.\nX90.\nG0 Z50.\n"


@pytest.mark.parametrize("radius", ["", "cutter_radius = 4.0"])
def test_a_contour_of_the_centre_under_wear_compensation_is_found_by_the_cutters_radius(
    tmp_path: Path, radius: str
) -> None:
    """D holds wear alone: the circle that G41 keeps the tool from is smaller than the bore by the cutter's radius."""
    tools = f"[[tool]]\nnumber = 2\n{radius}"
    wear = lambda writer: writer.wear_of.update({2: 4.0})  # noqa: E731
    text = plate("fanuc-mill", wear)
    if not radius:
        assert refused(found, tmp_path, "fanuc-mill", only("B0"), tools, lambda _: text).code is Code.MIL_CUT
        return
    cut = found(tmp_path, "fanuc-mill", only("B0", "B5", "P.x", "P.y"), tools, lambda _: text)
    assert {(one.tool, one.radius_at_control) for one in cut.features.values()} == {(2, True)}
    assert [one.side for one in cut.features.values()] == ["climb", "climb", "conventional", "conventional"]


def test_a_pass_that_may_or_may_not_reach_is_asked_for(tmp_path: Path) -> None:
    """A second cutter goes around the boss at 11 mm from it, after it was finished: by its radius it touches or not."""
    again = Writer("fanuc-mill")
    again.change(7, 0)
    again.circle(-25.0, 0.0, 8.0 + 11.0, False, (-10.0,), inside=False)
    later = "\n".join(again.lines) + "\nM30"
    change = lambda text: text.replace("M30", later)  # noqa: E731
    refusal = refused(found, tmp_path, "fanuc-mill", only("S0"), "", change)
    assert refusal.code is Code.MIL_CUT and "cutter_radius" in refusal.hint
    for radius, tool in ((10.0, 1), (11.0, 7)):
        stated = f"[[tool]]\nnumber = 7\ncutter_radius = {radius}"
        assert found(tmp_path, "fanuc-mill", only("S0"), stated, change).features["S0"].tool == tool


def test_a_feature_of_another_program_is_as_stated(tmp_path: Path) -> None:
    elsewhere: tuple[Kind, tuple[float, float, float], str] = (
        "bore",
        (0.0, 80.0, 0.0),
        'size = 30.0\ndepth = 9.0\ntool = 9\nwork_offset = "G56"',
    )
    cut = found(tmp_path, "fanuc-mill", {**only("B0"), "E": elsewhere}, '[[tool]]\nnumber = 9\nradius = "control"')
    assert cut.stated == ("E",)
    one = cut.features["E"]
    assert (one.tool, one.work_offset, one.radius_at_control) == (9, "G56", True)
    # the tool that cuts B0 under G41 here, by paths of its centre there
    shared = (*elsewhere[:2], elsewhere[2].replace("tool = 9", "tool = 2"))
    cut = found(tmp_path, "fanuc-mill", {**only("B0"), "E": shared}, '[[tool]]\nnumber = 2\nradius = "program"')
    assert [cut.features[name].radius_at_control for name in ("B0", "E")] == [True, False]


@pytest.mark.parametrize(
    ("offset", "tool", "asked"),
    [
        ('work_offset = "G54"', "", "`radius` of tool 9 in its table [[tool]]"),
        ('work_offset = "G54"', "[[tool]]\nnumber = 9", "`radius` of tool 9 in its table [[tool]]"),
        ("", '[[tool]]\nnumber = 9\nradius = "control"', "`work_offset` in its table [[feature]]"),
    ],
)
def test_what_cuts_a_feature_of_another_program_is_not_assumed(
    tmp_path: Path, offset: str, tool: str, asked: str
) -> None:
    elsewhere: tuple[Kind, tuple[float, float, float], str] = (
        "bore",
        (0.0, 80.0, 0.0),
        f"size = 30.0\ndepth = 9.0\ntool = 9\n{offset}",
    )
    refusal = refused(found, tmp_path, "fanuc-mill", {**only("B0"), "E": elsewhere}, tool)
    assert refusal.code is Code.MIL_NOT_CUT and refusal.hint.startswith(f"state {asked}, or")


@pytest.mark.parametrize("control", CONTROLS)
def test_a_hole_drilled_through_a_finished_bore_is_not_taken_for_the_bores_last_pass(
    tmp_path: Path, control: Control
) -> None:
    """Tool 2 finishes B0 (Ø12) by G41, then tool 7 drills through on its axis: by its radius, with or without reach."""

    def drilled(*after: tuple[int, float, float]) -> Callable[[str], str]:
        late = Writer(control)
        for tool, x, y in after:
            late.change(tool, 0)
            late.drill(x, y, -25.0)
        lines = "\n".join(late.lines)
        return lambda text: re.sub(r"^(\d+ )?M(30|2)$", lambda end: f"{lines}\n{end[0]}", text, flags=re.M)

    through = drilled((7, -50.0, -30.0))
    refusal = refused(found, tmp_path, control, only("B0"), "", through)
    assert refusal.code is Code.MIL_CUT and "`cutter_radius` of tool 7" in refusal.hint
    for radius, tool, at_control in ((4.0, 2, True), (6.0, 7, False)):
        stated = f"[[tool]]\nnumber = 7\ncutter_radius = {radius}"
        one = found(tmp_path, control, only("B0"), stated, through).features["B0"]
        assert (one.tool, one.radius_at_control) == (tool, at_control)
    # another hole, which it drills from solid, shows its radius
    hole = ("bore", (0.0, 80.0, 0.0), "size = 8.0\ndepth = 20.0")
    both = {**only("B0"), "E": hole}
    cut = found(tmp_path, control, both, "", drilled((7, -50.0, -30.0), (7, 0.0, 80.0)))
    assert [cut.features[name].tool for name in ("B0", "E")] == [2, 7]


def test_the_way_into_a_lower_bore_on_the_axis_of_a_finished_one_asks_nothing(tmp_path: Path) -> None:
    """Tool 2 plunges in the middle of B0, which it has finished, to mill a bore of 9 mm below it."""
    lower = Writer("fanuc-mill", d_of={2: 22})
    lower.change(2, 0)
    lower.compensate(True)
    lower.circle(-50.0, -30.0, 4.5, True, (-40.0,), inside=True)
    change = lambda text: text.replace("M30", "\n".join(lower.lines) + "\nM30")  # noqa: E731
    features = {**only("B0"), "E": ("bore", (-50.0, -30.0, 0.0), "size = 9.0\ndepth = 40.0")}
    cut = found(tmp_path, "fanuc-mill", features, "", change)
    assert [(one.tool, one.radius_at_control) for one in cut.features.values()] == [(2, True), (2, True)]
    assert cut.lines["B0"] < cut.lines["E"]


def test_a_radius_is_not_made_larger_than_an_inside_corner_has_room_for(tmp_path: Path) -> None:
    def room(cutter: str) -> CutFeatures:
        return found(tmp_path, "fanuc-mill", only("P.x"), f"[[tool]]\nnumber = 2\n{cutter}")

    equal, smaller, unknown = (room(one) for one in ("cutter_radius = 6.0", "cutter_radius = 5.9", ""))
    for cut, total_mm, allowed in (
        (equal, 0.001, False), (equal, -0.02, True), (smaller, 0.09, True), (smaller, 0.11, False),
        (unknown, 0.001, False), (unknown, -0.001, True),
    ):  # fmt: skip
        try:
            cut.require_room("2", total_mm)
        except TrueloopError as refusal:
            assert refusal.code is Code.MIL_CORNER and not allowed
        else:
            assert allowed


@pytest.mark.parametrize(
    ("control", "run", "asked"),
    [
        ("fanuc-mill", "G65 P8100 X1.\n", True),
        ("fanuc-mill", "G65 P9814 D12.\n", False),  # Renishaw's measurement of a bore
        ("haas-mill", "G13 D2 I5. F100.\n", True),
        ("heidenhain", CIRCLE.format(x=-50, y=-30), True),
        ("heidenhain", CIRCLE.format(x=50, y=30), False),
    ],
)
def test_a_run_that_the_path_does_not_show_is_asked_for_where_it_could_cut_last(
    tmp_path: Path, control: Control, run: str, asked: bool
) -> None:
    """A macro or cycle after the bore's last pass; the place of a milling cycle is known, others are left alone."""
    change = lambda text: re.sub(r"(\d+ )?M30", lambda end: run + end[0], text)  # noqa: E731
    if asked:
        refusal = refused(found, tmp_path, control, only("B0"), "", change)
        assert refusal.code is Code.MIL_CUT and "the path does not show" in str(refusal)
    else:
        assert found(tmp_path, control, only("B0"), "", change).features["B0"].tool == 2
    bore = (*BORE[:2], BORE[2] + "\ntool = 2")
    stated = found(tmp_path, control, {"B0": bore}, '[[tool]]\nnumber = 2\nradius = "control"', change)  # type: ignore[dict-item]
    assert stated.features["B0"].tool == 2
