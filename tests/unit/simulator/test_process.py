"""What the process does to the nose, beside closed forms."""

import math

import numpy as np

from trueloop.geometry.feature import Line
from trueloop_lab.simulator.machine import (
    Backlash,
    Deflection,
    ErrorTerm,
    MachineError,
    Repeatability,
    Stock,
    VirtualMachine,
    sweep,
)
from trueloop_lab.simulator.nose import CentrePath, Nose, path_along, path_of_positions

NOSE = Nose(0.8)
LENGTH_MM = 100.0


def cylinder_path(x_mm: float = 20.8) -> tuple[CentrePath, ...]:
    return (path_along([Line("", (x_mm, -LENGTH_MM), (x_mm, 0.0))]),)


def heights(stock: Stock, z_mm: np.ndarray, x_mm: float = 20.0) -> np.ndarray:
    points = np.column_stack([np.full(len(z_mm), x_mm), z_mm])
    return stock.height_mm(points, np.tile([1.0, 0.0], (len(z_mm), 1)))


def test_a_slender_part_is_left_thicker_at_its_free_end_by_the_cantilever_s_deflection() -> None:
    """F L³/(3 E I) with F = k f a of what is really cut, iterated: nothing of the simulator is used."""
    k, feed, depth, per_mm3, chuck = 400.0, 0.1, 0.25, 2e-10, -LENGTH_MM
    machine = VirtualMachine(
        NOSE, deflection=Deflection(k, part_mm_per_n_mm3=per_mm3, chuck_z_mm=chuck, feed_mm_per_rev=feed)
    )
    stock = Stock((sweep(cylinder_path(20.8 + depth)[0].centre_mm, NOSE),))
    z = np.linspace(-90.0, -5.0, 18)
    left = heights(machine.cut(stock, cylinder_path(), np.random.default_rng(0)), z)
    compliance, expected = per_mm3 * (z - chuck) ** 3, np.zeros(len(z))
    for _ in range(200):
        expected = compliance * k * feed * (depth - expected)
    assert np.max(np.abs(left - expected)) < 1e-6
    assert expected[-1] > 1e-3


def test_a_worn_tool_cuts_less_and_the_next_cut_takes_more() -> None:
    """The depth of the second cut is what the first one left: its deflection is larger by the same share."""
    machine = VirtualMachine(NOSE, deflection=Deflection(400.0, tool_mm_per_n=1e-4, feed_mm_per_rev=0.1))
    stock = Stock((sweep(cylinder_path(21.3)[0].centre_mm, NOSE),))
    rng = np.random.default_rng(0)
    z = np.array([-50.0])
    first = machine.cut(stock, cylinder_path(21.05), rng)
    second = machine.cut(first, cylinder_path(20.8), rng)
    stiffness = 400.0 * 0.1 * 1e-4
    left_by_first = stiffness * 0.25 / (1 + stiffness)
    assert math.isclose(heights(first, z, 20.25)[0], left_by_first, rel_tol=1e-6)
    assert math.isclose(heights(second, z)[0], stiffness * (0.25 + left_by_first) / (1 + stiffness), rel_tol=1e-6)


def test_backlash_is_left_behind_after_a_reversal() -> None:
    driven = np.column_stack([np.concatenate([np.linspace(0, 1, 101), np.linspace(1, 0, 101)]), np.zeros(202)])
    followed = Backlash(x_mm=0.02).follow(driven)[:, 0]
    assert math.isclose(followed[100], 0.99) and math.isclose(followed[-1], 0.01)
    still = followed[101:104]
    assert np.ptp(still) < 0.011 and np.all(np.abs(followed - driven[:, 0]) <= 0.01 + 1e-12)


def test_the_random_errors_have_the_size_and_reach_that_were_asked_for() -> None:
    repeatability = Repeatability(along_mm=0.002, correlation_mm=2.0)
    (path,) = cylinder_path()
    drawn = [repeatability.displacement_mm(path, np.zeros(2), np.random.default_rng(seed))[:, 0] for seed in range(200)]
    values = np.array(drawn)
    assert abs(values.std() / 0.002 - 1.0) < 0.03
    steps = np.diff(path.along_mm)[0]
    lag = round(2.0 / steps)
    correlation = np.mean(values[:, :-lag] * values[:, lag:]) / values.var()
    assert abs(correlation - math.exp(-0.5)) < 0.05


def test_a_whole_cut_moves_by_what_does_not_repeat_from_cut_to_cut() -> None:
    machine = VirtualMachine(NOSE, repeatability=Repeatability(cut_to_cut_mm=0.003))
    z = np.linspace(-90.0, -10.0, 5)
    left = np.array([heights(machine.cut(Stock(), cylinder_path(), np.random.default_rng(s)), z) for s in range(300)])
    assert np.max(np.ptp(left, axis=1)) < 1e-9
    assert abs(left[:, 0].std() / 0.003 - 1.0) < 0.15


def test_the_same_seed_gives_the_same_part() -> None:
    machine = VirtualMachine(NOSE, repeatability=Repeatability(0.002, 1.0, 0.001))
    z = np.linspace(-90.0, -10.0, 50)
    one, same, other = (heights(machine.cut(Stock(), cylinder_path(), np.random.default_rng(s)), z) for s in (3, 3, 4))
    assert np.array_equal(one, same) and not np.allclose(one, other)


def test_a_machine_error_is_cut_into_the_part() -> None:
    """x is 1 µm too large a 100 mm of z, and grows by 2 µm a kelvin: positive E on x leaves material on."""
    error = MachineError((ErrorTerm(0, 0.001, z_power=1), ErrorTerm(0, 0.002, temperature_power=1)))
    machine = VirtualMachine(NOSE, error=error)
    left = heights(
        machine.cut(Stock(), cylinder_path(), np.random.default_rng(0), temperature_c=23.0), np.array([-50.0])
    )
    assert math.isclose(left[0], -0.0005 + 0.006, abs_tol=1e-8)


def test_recorded_positions_cut_as_the_path_they_were_recorded_on() -> None:
    (path,) = cylinder_path()
    recorded = np.repeat(path.centre_mm, 3, axis=0)
    z = np.linspace(-90.0, -10.0, 7)
    cut = [
        VirtualMachine(NOSE).cut(Stock(), [p], np.random.default_rng(0)) for p in (path, path_of_positions(recorded))
    ]
    assert np.array_equal(heights(cut[0], z), heights(cut[1], z))
