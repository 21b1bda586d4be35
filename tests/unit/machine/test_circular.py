"""The circular test of ISO 230-4: hand arithmetic, and causes named in runs that a machine simulated in time makes."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.circular import Cause, Circle, circular_test

RADIUS_MM = 150.0


def _circle(way: int, deviation_um: Callable[[Array], Array], *, step_deg: float = 0.5) -> Circle:
    angle = np.radians(np.arange(0.5 * step_deg, 360, step_deg)[::way])
    value = 1e-3 * deviation_um(angle)
    return Circle("ccw" if way > 0 else "cw", "XY", RADIUS_MM, angle, value, np.arange(len(angle)))


def _cause(circles: list[Circle], name: str) -> Cause:
    return next(cause for cause in circular_test(circles).causes if cause.name == name)


def _alike(deviation: Callable[[Array], Array]) -> list[Circle]:
    return [_circle(way, deviation) for way in (1, -1)]


def test_figures_by_hand() -> None:
    """24 µrad of squareness at R 150: 3.6 µm wide, ±1.8 at 45° and 135°; a bar 4 µm too long, a centre 7 µm off."""
    found = circular_test(_alike(lambda t: 1.8 * np.sin(2 * t) + 4 + 7 * np.cos(t)))
    for width in (*found.zone_mm.values(), *found.about_centre_mm.values(), found.both_zone_mm):
        assert abs(1e3 * width - 3.6) < 1e-3
    np.testing.assert_allclose(1e3 * np.array(found.extremes_mm["ccw"]), [5.8, 2.2], atol=1e-3)
    assert abs(1e3 * found.mean_radial_mm - 4) < 1e-9


def test_both_ways_apart_are_wider_than_each() -> None:
    """Round circles of ±3 µm: each has no width, together they are 6 µm wide; D is the mean of both radii."""
    found = circular_test([_circle(1, lambda t: 0 * t + 3), _circle(-1, lambda t: 0 * t - 3)])
    np.testing.assert_allclose([*found.zone_mm.values()], 0, atol=1e-9)
    np.testing.assert_allclose([1e3 * found.both_zone_mm, 1e3 * found.both_about_centre_mm], 6, atol=1e-6)
    assert abs(found.mean_radial_mm) < 1e-12


def test_the_smallest_ring_is_narrower_than_that_about_the_least_squares_centre() -> None:
    """A step at X>0 of 4 µm: the ring's centre may move towards it, to half."""
    found = circular_test(_alike(lambda t: np.where(np.cos(t) > 0, 4.0, 0.0)))
    assert found.zone_mm["ccw"] < found.about_centre_mm["ccw"]


@pytest.mark.parametrize(
    ("name", "deviation_um", "amplitude"),
    [
        ("squareness", lambda t, way: 1.8 * np.sin(2 * t), 24.0),  # +Y leans towards +X: longer at 45°
        ("scale mismatch", lambda t, way: 3 * np.cos(t) ** 2, 20.0),  # X too far by 20 µm/m of 150 mm
        ("servo mismatch", lambda t, way: way * 1.5 * np.sin(2 * t), 3.0),  # X lags more: outside at 45° ccw
        ("backlash X", lambda t, way: way * 1.6 * np.sign(np.sin(t)) * np.cos(t), 3.2),
        ("backlash Y", lambda t, way: -way * 0.7 * np.sign(np.cos(t)) * np.sin(t), 1.4),
    ],
)
def test_the_sign_of_a_cause_by_hand(name: str, deviation_um: Callable[[Array, int], Array], amplitude: float) -> None:
    """Backlash: X goes to −X above the centre, counter-clockwise, and stays half its backlash too far towards +X."""
    circles = [_circle(way, lambda t, way=way: deviation_um(t, way)) for way in (1, -1)]  # type: ignore[misc]
    found = circular_test(circles)
    assert found.largest is not None and found.largest.name == name
    assert abs(found.largest.amplitude - amplitude) < 1e-6


def test_one_way_round_does_not_separate_squareness_from_the_servos() -> None:
    found = circular_test([_circle(1, lambda t: np.sin(2 * t))])
    assert found.largest is not None and found.largest.name == "squareness or servo mismatch"
    assert np.isnan([found.both_zone_mm, found.mean_radial_mm]).all()


@pytest.mark.parametrize(
    "change",
    [
        lambda ccw, cw: [ccw, ccw],
        lambda ccw, cw: [ccw, cw, ccw],
        lambda ccw, cw: [ccw, replace(cw, radius_mm=100.0)],
        lambda ccw, cw: [ccw, replace(cw, plane="YZ")],
        lambda ccw, cw: [replace(ccw, angle_rad=ccw.angle_rad[:500], deviation_mm=ccw.deviation_mm[:500])],
        lambda ccw, cw: [_circle(1, np.cos, step_deg=10)],
    ],
)
def test_what_is_no_test_is_refused(change: Callable[[Circle, Circle], list[Circle]]) -> None:
    with pytest.raises(TrueloopError) as refused:
        circular_test(change(*_alike(np.cos)))
    assert refused.value.code is Code.MCH_DATA


@dataclass
class _Drive:
    """An axis in time: servo of the first order, friction that holds at a reversal, play, then scale and screw."""

    tau_s: float = 0.02
    stick_mm: float = 0.0
    play_mm: float = 0.0
    scale: float = 0.0
    cyclic_mm: float = 0.0
    pitch_mm: float = 10.0
    phase: float = 0.4

    def path(self, commanded: Array, dt_s: float) -> Array:
        """Positions of the slide at each moment."""
        servo = motor = slide = float(commanded[0])
        held, last, gap, out = False, 0.0, 0.0, []
        for wanted in commanded.tolist():
            before = servo
            servo += (wanted - servo) * (1 - math.exp(-dt_s / self.tau_s))
            speed = servo - before
            if self.stick_mm and speed * last < 0:
                held = True
            last = speed or last
            if held and abs(servo - motor) > self.stick_mm:
                held = False
            gap = motor - servo if held else gap * math.exp(-dt_s / 0.08)
            motor = servo + gap
            slide = min(max(slide, motor - self.play_mm / 2), motor + self.play_mm / 2)
            out.append(slide)
        position = np.array(out)
        return position * (1 + self.scale) + self.cyclic_mm * np.sin(2 * np.pi * position / self.pitch_mm + self.phase)


def _simulated(x: _Drive, y: _Drive, lean: float, rng: np.random.Generator) -> list[Circle]:
    """Both ways round at 3000 mm/min with a lead of a quarter turn; the bar takes the angle from the constant feed. Its
    length and centre are a few µm off, its noise 0.2 µm.
    """
    radius, speed, dt = 100.0, 50.0, 0.002
    centre, length = rng.normal(0, 5e-3, 2), rng.normal(0, 4e-3)
    circles = []
    for way in (1, -1):
        turn = np.arange(-np.pi / 2, 2 * np.pi + 0.02, speed / radius * dt)
        angle = turn if way > 0 else 2 * np.pi - turn
        at = [drive.path(radius * f(angle), dt) for drive, f in ((x, np.cos), (y, np.sin))]
        bar = np.hypot(at[0] + lean * at[1] - centre[0], at[1] - centre[1]) - radius + length
        read = np.arange(0.0025, 2 * np.pi, np.radians(0.5))
        deviation = np.interp(read, turn, bar) + rng.normal(0, 2e-4, len(read))
        told = read if way > 0 else 2 * np.pi - read
        circles.append(Circle("a", "XY", radius, told, deviation, np.arange(len(read))))
    return circles


def test_the_one_cause_of_simulated_runs_is_named() -> None:
    """In 19 of 20 at least, each with a cause of 4 to 12 µm, and with its size; other servos are alike."""
    rng, named, sizes = np.random.default_rng(4), [], []
    for k in range(20):
        x, y, lean, size = _Drive(), _Drive(), 0.0, rng.uniform(4e-3, 12e-3) * rng.choice([-1, 1])
        match k % 7:
            case 0:
                name, lean, expected = "squareness", size / 100, 1e6 * size / 100
            case 1:
                name, x, expected = "scale mismatch", _Drive(scale=size / 100), 1e6 * size / 100
            case 2:
                name, x, expected = "backlash X", _Drive(play_mm=abs(size)), 1e3 * abs(size)
            case 3:
                name, y, expected = "backlash Y", _Drive(play_mm=abs(size)), 1e3 * abs(size)
            case 4:
                name, expected = "servo mismatch", 1e3 * abs(size)
                x = _Drive(tau_s=0.02 + abs(size) / 50)
            case 5:
                pitch, phase = rng.choice([5.0, 10.0, 16.0]), rng.uniform(0, 6)
                name, expected = "cyclic error Y", 1e3 * abs(size) / 2
                y = _Drive(cyclic_mm=abs(size) / 2, pitch_mm=pitch, phase=phase)
            case _:
                name, x, expected = "reversal spikes X", _Drive(stick_mm=abs(size)), math.nan
        largest = circular_test(_simulated(x, y, lean, rng)).largest
        assert largest is not None
        named.append(largest.name == name)
        if named[-1] and not math.isnan(expected):
            sizes.append((largest.amplitude - expected) / expected)
    assert sum(named) >= 19
    assert np.abs(sizes).max() < 0.2  # a short period, its phase shifted by the lag the other way in the other sense
    assert np.sort(np.abs(sizes))[-2] < 0.1
