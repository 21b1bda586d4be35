"""The shop that diagnoses are judged by: its axis errors against plain transforms, its process against arithmetic."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.diagnosed.axis_errors import CHUCK_MM, REFERENCE_C, SIGNALS, SPAN_K, TOOLS_MM, left_mm
from studies.diagnosed.day import day
from studies.diagnosed.fixtures import Unsteady, repeats
from studies.diagnosed.part_types import DISC, SLIM, TYPES, gauged, places
from studies.diagnosed.seen import machine_seen, seen_points, seen_series, together
from studies.diagnosed.shop import Series, Shop, cut_series
from studies.diagnosed.truth import Fault, Truth, Wrong
from trueloop.arrays import Array
from trueloop.diagnosis.causes.cause import SeenBy
from trueloop.diagnosis.features.feature_error import ErrorKind

QUIET = Shop(cut_mm=0.0, probe_mm=0.0, cmm_mm=0.0, cooled_k=0.0, stock=0.0)
TERMS = ("EXX", "EZX", "EBX", "EXZ", "EZZ", "EBZ", "EX0C", "EZ0C", "EB0C")


def moved(dx: float, dz: float, turn: float) -> Array:
    """A homogeneous transform of the x-z plane: turned about y, then moved."""
    cos, sin = np.cos(turn), np.sin(turn)
    return np.array([[cos, sin, dx], [-sin, cos, dz], [0.0, 0.0, 1.0]])


def tool_in_work(x: float, z: float, tool: tuple[float, float], errors: dict[str, float]) -> Array:
    """Bed → carriage → cross slide → tool point, seen from a spindle that has drifted, grown and tilted."""
    carriage = moved(0, z, 0) @ moved(errors["EXZ"], errors["EZZ"], errors["EBZ"])
    slide = moved(x, 0, 0) @ moved(errors["EXX"], errors["EZX"], errors["EBX"])
    spindle = moved(errors["EX0C"], errors["EZ0C"], errors["EB0C"])
    point: Array = np.linalg.inv(spindle) @ carriage @ slide @ np.array([*tool, 1.0])
    return point[:2]


@pytest.mark.parametrize("term", TERMS)
@pytest.mark.parametrize("tool", sorted(TOOLS_MM))
def test_formulas_are_those_of_plain_transforms(term: str, tool: str) -> None:
    """At 8 K above the reference a term of the spindle has its size; those of slides go over their travel."""
    size = 1e-5 if term[1] == "B" else 0.004
    truth = Truth((Wrong(Fault.AXIS_ERROR, size, error=term, signal="T spindle", bend=0.3),))
    warm = dict.fromkeys(SIGNALS, REFERENCE_C + SPAN_K)
    arm = TOOLS_MM[tool]
    for radius, z in ((10.0, 0.0), (35.0, 60.0), (70.0, 130.0)):
        slides = (radius - arm[0], z + CHUCK_MM - arm[1])
        errors = dict.fromkeys(TERMS, 0.0)
        share = (slides[0] + 65.0) / 115.0 if term.endswith("X") else (slides[1] + 10.0) / 265.0
        errors[term] = size if term.endswith("C") else size * (0.2 + share + 1.2 * share * (1 - share))
        there = tool_in_work(*slides, arm, errors) - tool_in_work(*slides, arm, dict.fromkeys(TERMS, 0.0))
        left = left_mm(truth, np.array([[radius, z]]), np.array([arm]), warm)[0]
        assert left == pytest.approx(there, abs=1e-7)
        assert np.abs(there).max() > 5e-5
    cold = left_mm(truth, np.array([[35.0, 60.0]]), np.array([arm]), dict.fromkeys(SIGNALS, REFERENCE_C))
    assert np.abs(cold).max() == 0.0


def read(series: Series, by: SeenBy, feature: str, part: int = 0) -> Array:
    found: Array = series.made[part].read_mm[by][series.points.is_of([feature]).astype(bool)]
    return found


def cut(fault: Fault, size_mm: float, shop: Shop = QUIET, tool: str = "") -> Series:
    return cut_series(Truth((Wrong(fault, size_mm, tool),)), shop)


def test_a_quiet_shop_makes_parts_without_error() -> None:
    for part in TYPES:
        series = cut_series(Truth(), Shop(part, cut_mm=0, probe_mm=0, cmm_mm=0, stock=0, parts=2))
        assert max(np.abs(one.read_mm[SeenBy.MACHINE]).max() for one in series.made) < 2.6e-5  # depths differ by 5 %
        assert len(series.points.feature) == len(series.made[0].read_mm[SeenBy.CMM])


def test_a_tool_too_far_out_leaves_material_on_shafts_until_it_is_set_anew() -> None:
    series = cut(Fault.TOOL_OFFSET, 0.010)
    for by in SeenBy:
        assert read(series, by, "shaft 1", 5).mean() == pytest.approx(0.010, abs=4e-4)
        assert read(series, by, "shaft 1", 6).mean() == pytest.approx(-0.006, abs=4e-4)
    assert abs(read(series, SeenBy.MACHINE, "end face", 5).mean()) < 1e-4


def test_wear_is_left_on_along_normals_and_a_new_edge_ends_it() -> None:
    series = cut(Fault.WEAR, 0.012, Shop(set_anew=(6,), parts=12, cut_mm=0, probe_mm=0, cmm_mm=0))
    worn = [float(read(series, SeenBy.MACHINE, "end face", k).mean()) for k in range(12)]
    assert worn[5] > worn[3] > worn[0] > 0 and worn[6] < worn[1]
    minutes = series.made[5].cut.minutes["T1"]
    assert worn[5] == pytest.approx(0.012 * (0.15 * (1 - np.exp(-minutes / 6)) + 0.85 * minutes / 60), abs=2e-4)


def test_a_probes_offset_is_seen_on_the_machine_alone_and_on_a_standard_part() -> None:
    series = cut(Fault.PROBE_OFFSET, 0.008, Shop(standard_at=(0,), cut_mm=0, probe_mm=0, cmm_mm=0, stock=0))
    assert series.made[0].standard and series.made[0].read_mm.keys() == {SeenBy.MACHINE}
    assert read(series, SeenBy.MACHINE, "shaft 2", 0).mean() == pytest.approx(0.008, abs=1e-9)
    assert read(series, SeenBy.MACHINE, "shaft 2", 3).mean() == pytest.approx(0.008, abs=1e-4)
    assert abs(read(series, SeenBy.CMM, "shaft 2", 3).mean()) < 1e-3
    assert abs(read(series, SeenBy.MACHINE, "end face", 0).mean()) < 1e-9


def test_forces_bend_the_part_at_its_free_end_and_faces_at_the_axis() -> None:
    bent = cut(Fault.PART_DEFLECTION, 0.020)
    shaft = read(bent, SeenBy.MACHINE, "shaft 3")
    assert shaft[-1] == pytest.approx(0.020 * (139 / 146) ** 3, rel=0.06) and shaft[0] < shaft[-1]
    face = read(cut(Fault.CONSTANT_SPEED, 0.010, Shop(DISC, cut_mm=0, probe_mm=0, stock=0)), SeenBy.MACHINE, "end face")
    assert face[0] < face[-1] < 0.010


def test_unequal_depth_and_a_second_tool_lengthen() -> None:
    deep = cut(Fault.UNEQUAL_DEPTH, 0.010)
    length = read(deep, SeenBy.CMM, "end face").mean() - read(deep, SeenBy.CMM, "shoulder 1").mean()
    assert length == pytest.approx(0.010, rel=0.12)
    two = cut(Fault.TWO_TOOLS, -0.007, Shop(tools=("T1", "T2"), cut_mm=0, probe_mm=0, cmm_mm=0, stock=0), "T2")
    (error,) = [
        one
        for one in seen_series(two).parts[0].errors[SeenBy.MACHINE]
        if one.kind is ErrorKind.LENGTH and one.feature == "end face"
    ]
    assert error.value_mm == pytest.approx(-0.007, abs=5e-5) and error.other == "shoulder 1"


def test_jaws_show_once_they_have_let_go_and_an_eccentric_chuck_to_both() -> None:
    lobed = seen_series(cut(Fault.JAWS, 0.006)).parts[0].errors
    wave = {by: {one.kind: one.value_mm for one in found if one.feature == "shaft 1"} for by, found in lobed.items()}
    assert wave[SeenBy.CMM][ErrorKind.LOBING] == pytest.approx(0.006, rel=0.05)
    assert wave[SeenBy.MACHINE][ErrorKind.LOBING] < 1e-6
    round_about = seen_series(cut(Fault.RUN_OUT, 0.005)).parts[0].errors
    for found in round_about.values():
        (one,) = [e for e in found if e.kind is ErrorKind.ECCENTRICITY and e.feature == "shaft 2"]
        assert one.value_mm == pytest.approx(0.005, abs=1.2e-3)


@given(st.sampled_from([0.0, 1.0, 2.0]), st.integers(0, 9))
def test_of_a_correction_the_gain_arrives(gain: float, seed: int) -> None:
    shop = Shop(corrected_from=4, set_anew=(), cut_mm=0, probe_mm=0, cmm_mm=0, parts=6)
    series = cut_series(Truth((Wrong(Fault.TOOL_OFFSET, 0.010),), gain), shop, seed)
    seen = seen_series(series).parts
    assert seen[3].correction_mm == {} and seen[5].correction_mm[("shaft 1", "radius")] == pytest.approx(
        0.010, abs=5e-4
    )
    left = read(series, SeenBy.MACHINE, "shaft 1", 5).mean()
    assert left == pytest.approx(0.010 * (1 - gain), abs=5e-4)


def test_an_axis_error_escapes_the_machines_probe_and_is_what_the_cmm_has_more() -> None:
    truth = Truth((Wrong(Fault.AXIS_ERROR, 0.005, error="EX0C", signal="T spindle"),))
    series = cut_series(truth, Shop(cut_mm=0, probe_mm=0, cmm_mm=0, cooled_k=0, parts=8))
    assert max(abs(read(series, SeenBy.MACHINE, "shaft 1", k).mean()) for k in range(8)) < 1e-4
    seen = machine_seen(series)
    shaft = np.abs(seen.normal[:, 0] - 1) < 1e-9
    expected = -0.005 * (seen.signals["T spindle"] - REFERENCE_C) / SPAN_K
    assert np.abs(seen.residual_mm - expected)[shaft].max() < 0.0025  # set up anew on the CMM
    assert np.ptp(expected) > 0.002
    both = together([seen, seen])
    assert both.part.max() == 15 and both.normal.shape == (2 * len(seen.part), 3)


def test_elements_warm_apart_and_cool_in_pauses() -> None:
    found = day(24, np.random.default_rng(2))
    table = np.array([[one.true_c[name] for name in SIGNALS] for one in found])
    assert (np.corrcoef(table.T) < 0.98).sum() == 6 and np.ptp(table, axis=0).min() > 2.0
    assert np.diff(table, axis=0).min() < -0.5
    assert max(np.ptp([one.true_c[name] for one in day(5, np.random.default_rng(2), True)]) for name in SIGNALS) == 0


def test_repeats_are_what_is_said_of_them() -> None:
    drift = repeats(Unsteady.DRIFT, 0.01, 10, 0.0)
    assert drift[-1] - drift[0] == pytest.approx(0.01) and np.ptp(np.diff(drift)) < 1e-9
    step = np.diff(repeats(Unsteady.STEP, 0.01, 10, 0.0))
    assert (step != 0).sum() == 1 and step.max() == pytest.approx(0.01)
    assert np.ptp(repeats(Unsteady.NOTHING, 0.01, 10, 0.0)) == 0
    assert repeats(Unsteady.SPREAD, 0.01, 400, 0.0).std() == pytest.approx(0.01, rel=0.1)


def test_points_lie_on_the_part_and_seen_points_carry_them() -> None:
    series = cut_series(Truth(), Shop(parts=1))
    seen = seen_points(series, series.made[0], SeenBy.CMM)
    assert np.hypot(*seen.normal.T) == pytest.approx(np.ones(series.points.count))
    assert seen.of("shaft 1").nominal_mm[:, 0] == pytest.approx(20.0)
    cone = gauged(places(SLIM, ("T1",)))
    assert set(cone.feature) == {"shaft 1", "shaft 2", "shaft 3", "shoulder 1", "shoulder 2", "cone", "end face"}
