"""Every way in which probing is refused."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from tests.support.files import read_as_file
from tests.support.probing import APPROACH, STEP, plan_of
from trueloop.arrays import Array
from trueloop.controllers.probing import Settings, probing_program
from trueloop.errors import Code
from trueloop.formats.jobs.probe_toml import read_probe
from trueloop.formats.measurements.touches_csv import read_probe_log
from trueloop.geometry.feature import Line
from trueloop.geometry.validate import checked_profile
from trueloop.probing.calibration import BallCalibration, Stylus, calibrate
from trueloop.probing.probe_match import match_touches, match_trials
from trueloop.probing.probe_plan import SecondTouch

PLAN = plan_of(STEP, {"cylinder": 3, "face": 2})
CENTRES = np.array([touch.contact_mm for touch in PLAN.touches])
TWICE = replace(APPROACH, second=SecondTouch(0.5, 30.0))
CALIBRATED = BallCalibration(1.5)
CONE = checked_profile([Line("cone", (40.0, -30.0), (10.0, 0.0)), Line("face", (10.0, 0.0), (0.0, 0.0))])
GROOVE = checked_profile(
    [
        Line("shoulder", (40.0, -30.0), (40.0, -20.0)),
        Line("wall", (40.0, -20.0), (30.0, -20.0)),
        Line("floor", (30.0, -20.0), (30.0, -18.0)),
        Line("other-wall", (30.0, -18.0), (40.0, -18.0)),
        Line("rim", (40.0, -18.0), (40.0, 0.0)),
    ]
)


def _match(rows: Sequence[int], moved_mm: float = 0.0) -> object:
    normal = np.array([touch.normal for touch in PLAN.touches])
    positions = CENTRES[list(rows)] + moved_mm * normal[list(rows)]
    logged = [(float(x), float(z)) for x, z in positions]
    return match_touches(PLAN, logged, [k + 1 for k in range(len(rows))], CALIBRATED).findings


def _log(text: str) -> object:
    return read_as_file(text, lambda path: read_probe_log(path, "linuxcnc"))


def _probe_file(text: str) -> object:
    return read_as_file(text, read_probe)


def _circle(degrees: Array, radius_mm: float = 14.0) -> Array:
    angle = np.radians(degrees)
    return radius_mm * np.column_stack([np.sin(angle), np.cos(angle)])


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.PRB_FILE: lambda: _probe_file("[stylus]\nball_radius_mm = 1.5\nstem_radius = 0.75\n"),
    Code.PRB_CALIBRATION: lambda: calibrate(_circle(np.linspace(0, 40, 12)), 12.5),
    Code.PRB_REACH: lambda: plan_of(GROOVE, {"floor": 1}, APPROACH, Stylus(0.5, 0.4, 50.0, 0.0)),
    Code.PRB_BALL: lambda: plan_of(GROOVE, {"floor": 1}, APPROACH, Stylus(1.2, 0.4)),
    Code.PRB_SECOND: lambda: probing_program(plan_of(STEP, {"face": 2}, TWICE), "ge2000t", Settings()),
    Code.PRB_AXIS: lambda: probing_program(plan_of(CONE, {"cone": 2}), "renishaw", Settings()),
    Code.PRB_LOG: lambda: _log("16.5 0 -10\n"),
    Code.PRB_OTHER: lambda: _match(range(5), moved_mm=30.0),
    Code.PRB_MISSING: lambda: _match([0, 1, 3, 4]),
    Code.PRB_TWICE: lambda: _match([0, 1, 1, 2, 3, 4]),
    Code.PRB_TRIALS: lambda: match_trials(PLAN, [(float(x), float(z)) for x, z in CENTRES], range(1, 6), CALIBRATED),
    Code.PRB_ORDER: lambda: _match([1, 0, 2, 3, 4]),
    Code.PRB_RETRACT: lambda: _match(range(5), moved_mm=APPROACH.stand_off_mm),
    Code.PRB_MISSED: lambda: _match(range(5), moved_mm=-APPROACH.overtravel_mm),
}


def test_a_probe_that_was_never_calibrated_is_refused_by_name() -> None:
    import pytest

    from trueloop.errors import TrueloopError

    logged = [(float(x), float(z)) for x, z in CENTRES]
    with pytest.raises(TrueloopError, match=r"1\.500 mm ball radius is not calibrated") as refused:
        match_touches(PLAN, logged, range(1, 6), None)
    assert refused.value.code is Code.PRB_CALIBRATION
