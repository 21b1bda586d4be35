"""Every way in which touches are refused."""

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from trueloop.domain.inspection import Touch
from trueloop.errors import Code
from trueloop.formats.measurements.touches_csv import read_touches
from trueloop.geometry.feature import Line, Point
from trueloop.geometry.validate import checked_profile
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, check_loop_sign, error_vectors

STEP = checked_profile([Line("cylinder", (40.0, 0.0), (40.0, 30.0)), Line("face", (40.0, 30.0), (10.0, 30.0))])
ON_CYLINDER: tuple[Point, ...] = ((40.0, 5.0), (40.0, 15.0), (40.0, 25.0))
PLAIN = Gauging()
HEADER = "point,feature,nominal_x_mm,nominal_z_mm,error_um"


def _read(text: str) -> object:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "touches.csv"
        path.write_text(text)
        return read_touches(path)


def _vectors(points: Sequence[Point], gauging: Gauging = PLAIN, feature: str | None = None) -> ErrorVectors:
    touches = [Touch(str(k + 1), point, feature, error_mm=0.01, line=k + 2) for k, point in enumerate(points)]
    return error_vectors(STEP, touches, gauging)


def _scaled(x: float, z: float) -> ErrorVectors:
    return _vectors([(px * x, pz * z) for px, pz in ON_CYLINDER])


def _twice_over() -> None:
    before = _vectors(ON_CYLINDER)
    errors = before.error_mm + np.array([0.001, 0.0, 0.002])
    before = ErrorVectors(**{**vars(before), "error_mm": errors})
    check_loop_sign(before, ErrorVectors(**{**vars(before), "error_mm": 2 * errors}))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.TCH_FILE: lambda: read_touches(Path("/nowhere/touches.csv")),
    Code.TCH_COLUMN: lambda: _read("point,x,z,error\n1,40,5,10\n"),
    Code.TCH_NUMBER: lambda: _read(f"{HEADER}\n1,cylinder,40,5,ten\n"),
    Code.TCH_FEATURE: lambda: _vectors(ON_CYLINDER, feature="cilinder"),
    Code.TCH_OFF_PROFILE: lambda: _vectors([(40.0, 5.0), (45.0, 15.0), (40.0, 25.0)]),
    Code.TCH_UNIT: lambda: _scaled(1 / 25.4, 1 / 25.4),
    Code.TCH_DIAMETER: lambda: _scaled(2, 1),
    Code.TCH_SIGN: _twice_over,
    Code.TCH_DUPLICATE: lambda: _vectors([ON_CYLINDER[0], ON_CYLINDER[0]]),
    Code.TCH_ORDER: lambda: _vectors([ON_CYLINDER[1], ON_CYLINDER[0]]),
    Code.TCH_REFERENCE: lambda: _vectors(ON_CYLINDER, Gauging(z_reference="1")),
}
