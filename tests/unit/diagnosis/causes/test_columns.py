"""Signs of what causes leave: tools of two faces, bores, standard parts."""

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.diagnosis.causes.catalogue import CAUSES
from trueloop.diagnosis.causes.cause import Over
from trueloop.diagnosis.causes.columns import columns, variants
from trueloop.diagnosis.causes.rows import rows_of
from trueloop.diagnosis.causes.seen_part import SeenBy, SeenPart, SeenSeries
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError
from trueloop.diagnosis.features.feature_place import FeaturePlace

PLACES = {
    "near": FeaturePlace("near", "face", (5.0, 20.0), (10.0, 10.0), "T1"),
    "far": FeaturePlace("far", "face", (5.0, 20.0), (40.0, 40.0), "T2"),
    "end": FeaturePlace("end", "face", (5.0, 20.0), (60.0, 60.0), "T2"),
    "shaft": FeaturePlace("shaft", "shaft", (20.0, 20.0), (0.0, 40.0), "T1"),
    "bore": FeaturePlace("bore", "shaft", (5.0, 5.0), (0.0, 40.0), "T1"),
}
ERRORS = (
    FeatureError("far", ErrorKind.LENGTH, 0.0, 0.001, 6, other="near"),
    FeatureError("end", ErrorKind.LENGTH, 0.0, 0.001, 6, other="far"),
    FeatureError("shaft", ErrorKind.RADIUS, 0.0, 0.001, 6, more={"normal_x": 1.0}),
    FeatureError("bore", ErrorKind.RADIUS, 0.0, 0.001, 6, more={"normal_x": -1.0}),
)
FAR, END, SHAFT, BORE = range(4)


def one_column(key: str, tool: str, seen_by: SeenBy, standard: bool = False) -> Array:
    """Of a cause that is the same on all parts and features, on one part's four errors."""
    series = SeenSeries(PLACES, (SeenPart("A", 0, {seen_by: ERRORS}, setting={"T1": 1, "T2": 1}, standard=standard),))
    cause = next(one for one in CAUSES if one.key == key)
    variant = next(one for one in variants(cause, series) if one.over is Over.CONSTANT and one.tool == tool)
    found = columns(variant, rows_of(series), series)
    return found[:, 0] if found.shape[1] else np.zeros(len(ERRORS))


def test_a_tool_too_far_out_lengthens_to_its_face_and_shortens_from_it() -> None:
    assert one_column("two-tools", "T2", SeenBy.CMM)[FAR] == 1.0
    assert one_column("two-tools", "T1", SeenBy.CMM)[FAR] == -1.0
    assert one_column("two-tools", "T2", SeenBy.CMM)[END] == 0.0


@pytest.mark.parametrize("key", ["tool-setting", "part-probe-offset", "machine"])
def test_a_shift_along_x_shows_the_other_way_round_in_a_bore(key: str) -> None:
    tool = "T1" if key == "tool-setting" else ""
    found = one_column(key, tool, SeenBy.CMM if key == "machine" else SeenBy.MACHINE)
    assert (found[SHAFT], found[BORE]) == (1.0, -1.0)


def test_a_standard_part_shows_the_probe_as_it_is_the_machine_turned_round_and_no_tool() -> None:
    assert one_column("part-probe-offset", "", SeenBy.MACHINE, standard=True)[SHAFT] == 1.0
    assert one_column("machine", "", SeenBy.MACHINE, standard=True)[SHAFT] == -1.0
    assert one_column("tool-setting", "T1", SeenBy.MACHINE, standard=True)[SHAFT] == 0.0
