"""The real-time table as a control reads it."""

import csv
import io

import numpy as np

from trueloop.formats.tables.control_tables import table_to_csv
from trueloop.turned.compensation.targets import CorrectionTable

TABLE = CorrectionTable(
    feature=("neck", 'dome, "main"'),
    commanded_mm=np.array([[37.01875, -39.37], [12.3456789, 0.0]]),
    correction_mm=np.array([[-0.0234567891, 0.0], [1e-6, -0.05]]),
)


def test_rows_keep_order_units_and_digits() -> None:
    rows = list(csv.DictReader(io.StringIO(table_to_csv(TABLE).decode())))
    assert [row["feature"] for row in rows] == list(TABLE.feature)
    position = np.array([[float(row["commanded_x_radius_mm"]), float(row["commanded_z_mm"])] for row in rows])
    correction = np.array([[float(row["correction_x_radius_um"]), float(row["correction_z_um"])] for row in rows])
    assert np.abs(position - TABLE.commanded_mm).max() <= 0.5e-6
    assert np.abs(correction / 1000 - TABLE.correction_mm).max() <= 0.5e-9
