"""The virtual lathe that warms up: its transforms against other ones, its heat against formulas."""

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop_lab.simulator.lathe import (
    BEARING_K,
    BEARING_S,
    NUT_K,
    NUT_S,
    PARALLEL_RAD,
    SCREW_S,
    SQUARE_RAD,
    UNTIL_S,
    X_TRAVEL_MM,
    Z_TRAVEL_MM,
    WarmLathe,
    WarmUp,
    measured_day,
    warm_up,
)

TOOL_MM = np.array([-12.0, -30.0])


def still(count: int) -> WarmUp:
    nothing = np.zeros(count)
    return WarmUp(nothing, nothing, nothing, nothing, nothing, nothing)


def places() -> Array:
    rng = np.random.default_rng(3)
    return np.column_stack([rng.uniform(*X_TRAVEL_MM, 40), rng.uniform(*Z_TRAVEL_MM, 40)])


def test_without_errors_the_tool_is_where_the_drives_are() -> None:
    at = places()
    found = WarmLathe().without_errors().tool_mm(at, TOOL_MM, still(len(at)))
    assert np.abs(found - at - TOOL_MM).max() < 1e-12


def test_directions_of_the_axes_are_out_by_their_angles() -> None:
    """Of a cold machine the difference over a far travel, everything that is not straight left to the yaw."""
    lathe, far = WarmLathe(), np.array([[0.0, 0.0], [300.0, 0.0], [0.0, -300.0]])
    turned = lathe.turned_rad(far, still(3))
    error = lathe.error_mm(far, np.zeros(2), still(3))
    assert error[1, 1] - error[0, 1] == pytest.approx(-SQUARE_RAD * 300 + 0.001, abs=1e-6)  # straightness: 1 µm there
    assert error[2, 0] - error[0, 0] == pytest.approx(PARALLEL_RAD * -300, abs=1e-6)
    assert turned[1] == pytest.approx(9e-6) and turned[2] == pytest.approx(5e-6)


def test_yaw_acts_with_the_tools_arm() -> None:
    """A rotation by r about Y moves a point that lies further by (dx, dz) by r · (dz, −dx)."""
    lathe, at, arm = WarmLathe(), places(), np.array([-40.0, 70.0])
    difference = lathe.error_mm(at, arm, still(40)) - lathe.error_mm(at, np.zeros(2), still(40))
    turned = lathe.turned_rad(at, still(40))
    assert np.abs(difference - turned[:, None] * [arm[1], -arm[0]]).max() < 1e-7


def test_a_warm_headstock_moves_the_work_and_so_the_tool_the_other_way() -> None:
    at = places()
    hot = WarmUp(np.zeros(40), *(np.full(40, k) for k in (10.0, 0.0, 0.0, 0.0, 0.0)))
    moved = WarmLathe().error_mm(at, TOOL_MM, hot) - WarmLathe().error_mm(at, TOOL_MM, still(40))
    assert np.abs(moved - [-0.0015, -0.0096]).max() < 1e-7


def test_the_screw_grows_from_where_it_is_held() -> None:
    warm = WarmUp(np.zeros(2), *(np.array([k, k]) for k in (0.0, 0.0, 0.0, 10.0, 0.0)))
    at = np.array([[0.0, 110.0], [0.0, -90.0]])
    grown = (WarmLathe().error_mm(at, np.zeros(2), warm) - WarmLathe().error_mm(at, np.zeros(2), still(2)))[:, 1]
    assert grown[0] == pytest.approx(0.0, abs=1e-9)
    assert grown[1] == pytest.approx(11.5e-6 * 10 * (-200 - 60 / np.pi), rel=1e-6)  # warmer in its middle


def test_heat_follows_its_source_as_first_order_lags_do() -> None:
    warm = warm_up(100.0, ((10.0, 1e9),), ((10.0, 1e9),))
    after = np.maximum(warm.time_s - 10.0, 0.0)
    assert np.abs(warm.bearing - BEARING_K * (1 - np.exp(-after / BEARING_S))).max() < 0.03
    both = 1 - (NUT_S * np.exp(-after / NUT_S) - SCREW_S * np.exp(-after / SCREW_S)) / (NUT_S - SCREW_S)
    assert np.abs(warm.screw - NUT_K * both).max() < 0.03
    assert np.ptp(warm.casting[warm.time_s < 9]) == 0.0 and warm.casting[-1] > 10.0


def test_lost_motion_shows_between_there_and_back() -> None:
    lathe = WarmLathe()
    out = np.column_stack([np.full(50, 100.0), np.linspace(0.0, -50.0, 50)])
    there_and_back = np.concatenate([out, out[::-1]])
    found = lathe.tool_mm(there_and_back, TOOL_MM, still(100))[:, 1]
    apart = found[:50] - found[50:][::-1]
    assert apart[5:45] == pytest.approx(lathe.lost.z_mm, abs=2e-4)


def test_instruments_read_over_the_whole_day_and_travel() -> None:
    _, readings = measured_day(WarmLathe())
    times = np.array([reading.time_s for reading in readings])
    assert times.min() > 0.0 and times.max() < UNTIL_S
    assert {reading.way[1] for reading in readings if reading.run == "laser Z 0"} == {-1, 1}
    first = [reading.value for reading in measured_day(WarmLathe(), seed=1)[1]]
    assert first == [reading.value for reading in measured_day(WarmLathe(), seed=1)[1]]
    assert first != [reading.value for reading in readings]


def test_a_warm_casting_tilts_the_work() -> None:
    """What is turned about Y by less turns the tool's arm by less, too."""
    lathe, at, arm = WarmLathe(), places(), np.array([-40.0, 70.0])
    hot = WarmUp(np.zeros(40), *(np.full(40, k) for k in (0.0, 10.0, 0.0, 0.0, 0.0)))
    turned = lathe.turned_rad(at, hot)
    assert turned - lathe.turned_rad(at, still(40)) == pytest.approx(-8e-6)
    difference = lathe.error_mm(at, arm, hot) - lathe.error_mm(at, np.zeros(2), hot)
    assert np.abs(difference - turned[:, None] * [arm[1], -arm[0]]).max() < 1e-7


def test_sensors_say_what_they_are_on() -> None:
    warm = WarmUp(np.zeros(1), *(np.array([k]) for k in (10.0, 5.0, 3.0, 2.0, 1.0)))
    assert {name: float(value[0]) for name, value in warm.sensors().items()} == pytest.approx(
        {"T1": 31.0, "T2": 27.0, "T3": 24.0}
    )


def test_a_laser_sees_the_lost_motion_there_and_back() -> None:
    """A slide lags behind its drive: forward it stands short, on the way back long."""
    values: dict[int, list[float]] = {1: [], -1: []}
    for reading in measured_day(WarmLathe())[1]:
        if reading.run == "laser Z 0":
            values[reading.way[1]].append(reading.value)
    assert np.mean(values[1]) - np.mean(values[-1]) == pytest.approx(-8.0, abs=1.0)
