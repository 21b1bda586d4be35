"""A fit judges itself: of calibrations with a run that is wrong none gives a model that makes the machine worse in
silence. The machine is written apart (`forward_model`): 4×4 transforms, all errors polynomials.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.support.forward_model import ForwardMachine, random_machine
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.identify.form import Form, fit_form, with_segments
from trueloop.machine.identify.identify import Identification
from trueloop.machine.identify.judge_fit import HeldOut, hold_out, require_agreement, with_lack_of_fit
from trueloop.machine.identify.observations import Observations, joined
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import PRESETS, chain_of, five_axis_terms, frame_terms, mill_terms

TRAVEL = {"X": (0.0, 500.0), "Y": (-200.0, 200.0), "Z": (-300.0, 0.0), "A": (-1.2, 0.6), "B": (-1.0, 1.5), "C": (-2, 2)}
NOISE_MM = 0.3e-3


def _calibrated(structure: str, seed: int) -> tuple[Machine, Form, ForwardMachine, list[Observations]]:
    """Returns runs as a laser, a straight edge and a ball read them: a line along each axis in three places, each
    along X, Y and Z; of a rotary axis a turn with the ball in three places.
    """
    rng = np.random.default_rng(seed)
    chain = chain_of(structure)
    chain = chain.with_axes({a.name: replace(a, travel=TRAVEL[a.name]) for a in chain.axes if a.name in chain.order})
    terms = five_axis_terms(chain) if structure.startswith("five-axis") else mill_terms(chain)
    truth = random_machine(PRESETS[structure], TRAVEL, rng)
    runs = _lines(chain, truth, rng, 3)
    return Machine(structure, chain), Form(terms, frame=frame_terms(chain, terms)), truth, runs


def _lines(chain: Chain, truth: ForwardMachine, rng: np.random.Generator, places: int) -> list[Observations]:
    return [
        _line(chain, truth, axis, np.eye(3)[direction], rng, f"{axis} place {place} along {'XYZ'[direction]}")
        for axis in chain.order
        for place in range(places)
        for direction in range(3)
    ]


def _line(
    chain: Chain, truth: ForwardMachine, axis: str, along: Array, rng: np.random.Generator, name: str
) -> Observations:
    count = 21
    at = {other: np.full(count, rng.uniform(*TRAVEL[other])) for other in chain.order}
    at[axis] = np.linspace(*TRAVEL[axis], count)
    tool = np.tile(rng.uniform([-60, -60, -180], [60, 60, -60]), (count, 1))
    reading = truth.error_mm(at, tool) @ along + rng.normal(0, NOISE_MM, count)
    state, u = State(chain.positions(at), 0.0, {}, tool), np.full(count, NOISE_MM)
    return Observations(
        state, np.tile(along, (count, 1)), reading, np.zeros(count, bool), u, (name,) * count, own_zero=True
    )


def _everywhere(
    chain: Chain, truth: ForwardMachine, rng: np.random.Generator, count: int
) -> tuple[State, Array, Array, Array]:
    """Returns random places of the volume, and error and reading in three directions there."""
    at = {name: rng.uniform(*TRAVEL[name], count) for name in chain.order}
    tool = rng.uniform([-60, -60, -180], [60, 60, -60], (count, 3))
    error = truth.error_mm(at, tool)
    return State(chain.positions(at), 0.0, {}, tool), error, error + rng.normal(0, NOISE_MM, (count, 3)), np.eye(3)


def _scaled(factor: float) -> Callable[[Observations], Observations]:
    return lambda run: replace(run, reading=factor * run.reading)


def _turned(run: Observations) -> Observations:
    """Positions are written down from the other end of the line."""
    return replace(run, state=replace(run.state, positions=run.state.positions[::-1]))


def _swapped(run: Observations) -> Observations:
    """Another direction is written down than was read."""
    return replace(run, along=np.roll(run.along, 1, axis=1))


CORRUPTIONS = {
    "flipped": _scaled(-1.0),
    "mm under um": _scaled(1e-3),
    "um under mm": _scaled(1e3),
    "inch under mm": _scaled(1 / 25.4),
    "doubled": _scaled(2.0),
    "turned": _turned,
    "another direction": _swapped,
}


def _fit(machine: Machine, form: Form, runs: list[Observations]) -> tuple[MachineModel, tuple[str, ...]]:
    """Returns the model and the runs that a warning names. Raises as `fit_machine`."""
    data = joined(runs)

    def judged(some: Observations) -> tuple[Identification, tuple[HeldOut, ...]]:
        found, _ = fit_form(machine, form, some)
        return found, hold_out(some, found, lambda others: fit_form(machine, form, others)[0].model)

    whole = judged(data)
    warnings = require_agreement(whole, data, judged)
    return whole[0].model, tuple(str(one.values["runs"]) for one in warnings)


def _left_and_all(machine: Machine, truth: ForwardMachine, model: MachineModel) -> tuple[float, float]:
    """Returns RMS of the error that the model leaves and of the machine's, without what is equal everywhere, mm."""
    rng, chain = np.random.default_rng(0), machine.chain
    at = {name: rng.uniform(*TRAVEL[name], 500) for name in chain.order}
    tool = rng.uniform([-60, -60, -180], [60, 60, -60], (500, 3))
    actual = truth.error_mm(at, tool)
    rest = actual - model.error_mm(State(chain.positions(at), 0.0, {}, tool))
    return float(np.sqrt(np.mean((rest - rest.mean(axis=0)) ** 2))), float(np.std(actual - actual.mean(axis=0)))


@pytest.mark.parametrize(
    ("structure", "seed"), [("mill-gantry", 3), ("mill-gantry", 5), ("five-axis-head-table-bc", 1)]
)
def test_a_sound_calibration_is_not_refused_and_a_corrupted_run_is_named_or_does_no_harm(
    structure: str, seed: int
) -> None:
    """Where a run is neither refused nor named, the model still makes the machine truer than none."""
    machine, form, truth, runs = _calibrated(structure, seed)
    model, named = _fit(machine, form, runs)
    sound, whole = _left_and_all(machine, truth, model)
    assert not named and sound < 0.5 * whole
    which = int(np.random.default_rng(seed).integers(len(runs)))
    for corruption, corrupt in CORRUPTIONS.items():
        wrong = [corrupt(run) if k == which else run for k, run in enumerate(runs)]
        try:
            model, named = _fit(machine, form, wrong)
        except TrueloopError as error:
            assert error.code == Code.MCH_RUN
            continue
        left, _ = _left_and_all(machine, truth, model)
        assert named or left < whole, corruption


@pytest.mark.parametrize("structure", ["five-axis-table-table-ac", "five-axis-head-table-bc", "five-axis-head-head-cb"])
def test_errors_of_rotary_axes_in_waves_are_held_by_segments_chosen_for_them_and_by_u(structure: str) -> None:
    """Two waves a turn of 4 µm and 12 µrad, read along lines in four places and with a ball at 300 poses.

    With one polynomial over the travel, as stated, the model leaves several times as much: U covers that, too.
    """
    rng = np.random.default_rng(3)
    chain = chain_of(structure)
    chain = chain.with_axes({a.name: replace(a, travel=TRAVEL[a.name]) for a in chain.axes if a.name in chain.order})
    size = np.repeat([0.004, 12e-6], 3)[:, None]
    waves = {a: rng.normal(0, 1, (2, 6, 2)) * size * [[[1.0]], [[0.5]]] for a in "ABC" if a in chain.order}
    truth = replace(random_machine(PRESETS[structure], TRAVEL, rng), waves=waves)
    runs = _lines(chain, truth, rng, 4)
    state, _, reading, axes = _everywhere(chain, truth, rng, 300)
    for k, along in enumerate(axes):
        u, told = np.full(300, NOISE_MM), np.tile(along, (300, 1))
        name = (f"ball along {'XYZ'[k]}",) * 300
        runs.append(Observations(state, told, reading[:, k], np.zeros(300, bool), u, name, own_zero=True))
    machine, data, terms = Machine(structure, chain), joined(runs), five_axis_terms(chain)
    where, error, _, _ = _everywhere(chain, truth, rng, 600)
    found = dict[str, tuple[float, ...]]()

    def held(fit: Identification) -> tuple[HeldOut, ...]:
        return hold_out(data, fit, lambda _: fit.model)

    for how, free in (("chosen", frozenset(term.name for term in terms)), ("stated", frozenset())):
        form, _ = with_segments(machine, Form(terms, frame=frame_terms(chain, terms), free=free), data)
        fit, _ = fit_form(machine, form, data)
        rest, by = error - fit.model.error_mm(where), fit.model.sensitivities(where)
        rest, by = rest - rest.mean(axis=0), by - by.mean(axis=0)  # where the work stands is not read
        known = with_lack_of_fit(fit, data, held(fit))
        u_mm = np.sqrt(np.einsum("nij,jk,nik->ni", by, known.model.covariance, by))
        within = [float(np.mean(np.abs(rest) < 1.96 * u)) for u in (u_mm / known.lack_of_fit, u_mm)]
        found[how] = float(np.sqrt(np.mean(rest**2))), *within
    assert found["chosen"][0] < 0.2e-3 and 0.92 <= found["chosen"][2] <= 0.985
    assert found["stated"][0] > 3.0 * found["chosen"][0], found
    assert found["stated"][1] < 0.5 and found["stated"][2] > 0.7, found
