"""What causes leave on the surface: signs on bores, faces and standard parts, parts without the name of a tool."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.diagnosis.causes.catalogue import CAUSES
from trueloop.diagnosis.causes.cause import Over, SeenBy, SeenPart, SeenSeries, SurfaceErrors, surface_errors
from trueloop.diagnosis.causes.judge import asked
from trueloop.diagnosis.causes.ways import Way, block_of, ways
from trueloop.diagnosis.features.feature_error import FeaturePlace, SeenPoints

PLACES = {
    "near": FeaturePlace("near", "face", (5.0, 20.0), (10.0, 10.0), "T1"),
    "far": FeaturePlace("far", "face", (5.0, 20.0), (40.0, 40.0), "T2"),
    "end": FeaturePlace("end", "face", (5.0, 20.0), (60.0, 60.0), "T2"),
    "shaft": FeaturePlace("shaft", "shaft", (20.0, 20.0), (0.0, 40.0), "T1"),
    "bore": FeaturePlace("bore", "shaft", (5.0, 5.0), (0.0, 40.0), "T1"),
}
NEAR, FAR, END, SHAFT, BORE = range(5)
NORMAL = np.array([[0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [1.0, 0.0], [-1.0, 0.0]])


def points(error_mm: Array) -> SeenPoints:
    """One in the middle of each feature."""
    at = np.array([[0.5 * sum(place.radius_mm), 0.5 * sum(place.z_mm)] for place in PLACES.values()])
    n = len(PLACES)
    return SeenPoints(tuple(PLACES), at, NORMAL, error_mm, np.full(n, 1e-3), np.full(n, np.nan), np.ones(n, np.intp))


def series(seen_by: SeenBy, standard: bool = False, places: Mapping[str, FeaturePlace] = PLACES) -> SeenSeries:
    seen = {seen_by: points(np.zeros(len(PLACES)))}
    parts = tuple(
        SeenPart(str(k), k, {}, seen, setting={"T1": 1, "T2": 1}, standard=standard and k == 0) for k in range(3)
    )
    return SeenSeries(places, parts)


def errors_of(whole: SeenSeries) -> SurfaceErrors:
    found = surface_errors(whole)
    assert found is not None
    return found


def one_column(key: str, tool: str, seen_by: SeenBy, standard: bool = False, form: int = 0) -> Array:
    """Of a cause that is the same on all parts, on the first part's five points."""
    whole = series(seen_by, standard)
    errors = errors_of(whole)
    cause = next(one for one in CAUSES if one.key == key)
    way = next(
        one
        for one in ways(cause, errors, whole)
        if one.over is Over.CONSTANT and one.tool == tool and one.form == form and seen_by in one.seen_by
    )
    found = block_of(way, errors)[: len(PLACES)]
    return found[:, 0] if found.shape[1] else np.zeros(len(PLACES))


def test_a_tool_too_far_out_leaves_material_on_its_own_faces_alone() -> None:
    assert one_column("two-tools", "T2", SeenBy.CMM).tolist() == [0.0, 1.0, 1.0, 0.0, 0.0]
    assert one_column("two-tools", "T1", SeenBy.CMM).tolist() == [1.0, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(("key", "tool"), [("tool-setting", "T1"), ("part-probe-offset", ""), ("machine", "")])
def test_a_shift_along_x_shows_the_other_way_round_in_a_bore(key: str, tool: str) -> None:
    found = one_column(key, tool, SeenBy.CMM if key == "machine" else SeenBy.MACHINE)
    assert (found[SHAFT], found[BORE]) == (1.0, -1.0)
    assert not np.any(found[[NEAR, FAR, END]])


def test_a_standard_part_shows_the_probe_as_it_is_the_machine_turned_round_and_no_tool() -> None:
    whole = series(SeenBy.MACHINE, standard=True)
    errors = errors_of(whole)
    by_key = {cause.key: cause for cause in CAUSES}

    def first(key: str) -> Array:
        found = [one for one in ways(by_key[key], errors, whole) if one.over is Over.CONSTANT and one.form == 0]
        return block_of(found[0], errors)[:, 0]

    assert first("part-probe-offset")[SHAFT] == 1.0
    assert first("machine")[SHAFT] == -1.0
    assert first("tool-setting")[SHAFT] == 0.0 and first("tool-setting")[len(PLACES) + SHAFT] == 1.0


def of_cause(key: str, whole: SeenSeries) -> list[Way]:
    cause = next(one for one in CAUSES if one.key == key)
    return list(ways(cause, errors_of(whole), whole))


def test_a_tool_that_no_feature_names_is_that_of_all_features() -> None:
    unnamed = {name: replace(place, tool="") for name, place in PLACES.items()}
    whole = series(SeenBy.CMM, places=unnamed)
    errors = errors_of(whole)
    (constant,) = (one for one in of_cause("tool-setting", whole) if one.over is Over.CONSTANT)
    assert block_of(constant, errors)[: len(PLACES), 0].tolist() == [0.0, 0.0, 0.0, 1.0, -1.0]


def test_where_no_tool_is_named_a_second_one_may_have_cut_one_face_or_all_from_one_on() -> None:
    unnamed = {name: replace(place, tool="") for name, place in PLACES.items()}
    whole = series(SeenBy.CMM, places=unnamed)
    errors = errors_of(whole)
    found = {
        tuple(np.flatnonzero(block_of(one, errors)[: len(PLACES), 0]))
        for one in of_cause("two-tools", whole)
        if one.over is Over.CONSTANT
    }
    assert found >= {(NEAR,), (FAR,), (END,)}


def test_what_no_instrument_sees_is_not_weighed() -> None:
    """Without angles nobody sees waves around the turn; an inspection by the probe alone no error of the machine."""
    whole = series(SeenBy.MACHINE)
    keys = {way.cause.key for way in asked(errors_of(whole), whole).ways}
    assert not keys & {"chuck", "jaws", "machine", "servo-lag"}
    assert {"tool-setting", "part-probe-offset", "other"} <= keys


def test_one_angle_around_the_turn_shows_no_waves() -> None:
    whole = series(SeenBy.CMM)
    seen = replace(points(np.zeros(len(PLACES))), spindle_rad=np.zeros(len(PLACES)))
    parts = tuple(replace(part, points={SeenBy.CMM: seen}) for part in whole.parts)
    at_one_angle = replace(whole, parts=parts)
    keys = {way.cause.key for way in asked(errors_of(at_one_angle), at_one_angle).ways}
    assert not keys & {"chuck", "jaws"}


def test_corrections_of_lengths_are_added_up_from_the_chuck() -> None:
    whole = series(SeenBy.CMM)
    taken = {("far", "length"): 0.004, ("end", "length"): 0.001, ("shaft", "radius"): 0.003, ("bore", "radius"): 0.002}
    part = replace(whole.parts[1], correction_mm=taken)
    found = errors_of(replace(whole, parts=(whole.parts[0], part)))
    assert found.corrected_mm[len(PLACES) :].tolist() == pytest.approx([0.0, 0.004, 0.005, 0.003, 0.002])
