"""The numbers: one row a touch, what was measured, fitted and predicted."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from tests.support.correction import example_correction
from trueloop.geometry.profile import Profile
from trueloop.report.turned.shapes import TouchShape
from trueloop.report.turned.touch_table import touch_rows, touches_csv, touches_table
from trueloop.turned.error_curve.bad_touches import SuspectTouch

MODBAS2 = example_correction("modbas2")


def test_the_csv_holds_every_touch_with_its_unit_in_the_name() -> None:
    rows = list(csv.DictReader(io.StringIO(touches_csv(MODBAS2))))
    assert len(rows) == 32
    assert tuple(rows[0]) == tuple(TouchShape.model_fields)
    without_unit = ("feature", "point", "weight", "probability_bad")
    assert all(name in without_unit or name.endswith(("_mm", "_um")) for name in TouchShape.model_fields)


def test_a_row_says_what_table_1_says() -> None:
    """[6517] Table 1, point 20: x 30.67487 mm, z −16.24472 mm, 78.359 µm."""
    row = next(row for row in csv.DictReader(io.StringIO(touches_csv(MODBAS2))) if row["point"] == "20")
    assert (row["nominal_x_mm"], row["nominal_z_mm"], row["error_before_um"]) == ("30.6749", "-16.2447", "78.36")


def test_after_is_before_less_the_fit_for_a_whole_correction() -> None:
    for row in touch_rows(MODBAS2):
        left = row.error_before_um - row.commanded_um - row.fitted_um
        assert row.predicted_after_um == pytest.approx(left, abs=0.021)  # four numbers rounded to 0.01 µm


def test_what_the_semifinish_program_meant_is_told_apart() -> None:
    """A commanded 5 µm on the cone is in the touches but not in the process error."""
    vectors = MODBAS2.model.vectors
    commanded = np.where(vectors.feature_index == 2, 0.005, 0.0)
    process = replace(vectors, error_mm=MODBAS2.touches.error_mm - commanded)
    rows = touch_rows(replace(MODBAS2, model=replace(MODBAS2.model, vectors=process)))
    assert [row.commanded_um for row in rows] == [5.0] * 5 + [0.0] * 27


def test_a_touch_that_the_others_say_nothing_of_has_an_empty_cell() -> None:
    rows = list(csv.DictReader(io.StringIO(touches_csv(MODBAS2))))
    assert [row["point"] for row in rows if row["leave_one_out_um"] == ""] == ["11", "12"]


def test_names_with_commas_and_quotes_survive() -> None:
    feature = replace(MODBAS2.profile.features[2], name='cone, "steep"')
    features = (*MODBAS2.profile.features[:2], feature, *MODBAS2.profile.features[3:])
    renamed = replace(MODBAS2, profile=Profile(features, MODBAS2.profile.junctions))
    assert next(csv.DictReader(io.StringIO(touches_csv(renamed))))["feature"] == 'cone, "steep"'


def test_a_touch_left_out_shows_its_weight_and_probability() -> None:
    suspect = SuspectTouch(3, MODBAS2.touches.point[3], "cone", 0.06, 0.03, 0.0015, 0.998, True, False)
    weight = np.where(np.arange(32) == 3, 0.0, 1.0)
    spoiled = replace(MODBAS2, model=replace(MODBAS2.model, suspects=(suspect,), weight=weight))
    assert [(row.weight, row.probability_bad) for row in touch_rows(spoiled)][3] == (0.0, 0.998)
    assert "<strong>0</strong> (bad: 99.8 %)" in touches_table(spoiled)
    assert "bad:" not in touches_table(MODBAS2)
