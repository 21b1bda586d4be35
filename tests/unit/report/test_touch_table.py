"""The numbers: one row a touch, what was measured, fitted and predicted."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from tests.support.correction import example_correction
from trueloop.geometry.profile import Profile
from trueloop.report.touch_table import TouchRow, touch_rows, touches_csv

MODBAS2 = example_correction("modbas2")


def test_the_csv_holds_every_touch_with_its_unit_in_the_name() -> None:
    rows = list(csv.DictReader(io.StringIO(touches_csv(MODBAS2))))
    assert len(rows) == 32
    assert tuple(rows[0]) == TouchRow._fields
    assert all(name in ("feature", "point") or name.endswith(("_mm", "_um")) for name in TouchRow._fields)


def test_a_row_says_what_table_1_says() -> None:
    """[6517] Table 1, point 20: x 30.67487 mm, z −16.24472 mm, 78.359 µm."""
    row = next(row for row in csv.DictReader(io.StringIO(touches_csv(MODBAS2))) if row["point"] == "20")
    assert (row["nominal_x_mm"], row["nominal_z_mm"], row["error_before_um"]) == ("30.6749", "-16.2447", "78.36")


def test_after_is_before_less_the_fit_for_a_whole_correction() -> None:
    rows = np.array([row[2:] for row in touch_rows(MODBAS2)], dtype=float)
    before, fitted, after = rows[:, 3], rows[:, 5], rows[:, 6]
    assert after == pytest.approx(before - fitted, abs=0.011)  # three numbers rounded to 0.01 µm


def test_names_with_commas_and_quotes_survive() -> None:
    feature = replace(MODBAS2.profile.features[2], name='cone, "steep"')
    features = (*MODBAS2.profile.features[:2], feature, *MODBAS2.profile.features[3:])
    renamed = replace(MODBAS2, profile=Profile(features, MODBAS2.profile.junctions))
    assert next(csv.DictReader(io.StringIO(touches_csv(renamed))))["feature"] == 'cone, "steep"'
