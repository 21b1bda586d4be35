"""Runs that were zeroed one by one, as every laser is: judged by a machine written apart, over the whole volume."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.support.forward_model import ForwardMachine, random_machine
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.identify.form import Form, fit_form
from trueloop.machine.identify.identify import Identification, identify
from trueloop.machine.identify.judge_fit import HeldOut, compare, contradictions, hold_out, require_agreement
from trueloop.machine.identify.observations import Observations, joined
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import CONSTANT, PRESETS, Part, Term, chain_of, frame_terms, mill_terms, segments

TRAVEL = {"X": (0.0, 500.0), "Y": (-200.0, 200.0), "Z": (-300.0, 0.0)}
NOISE_MM, NOISE_RAD = 0.3e-3, 0.5e-6
TOOL = np.array([0.0, 0.0, -100.0])
POINTS = 26
STRUCTURE = "mill-table-xy"


@dataclass(frozen=True)
class Campaign:
    """A machine and a whole characterization of it, what is read exactly, without zeros."""

    machine: Machine
    truth: ForwardMachine
    data: Observations

    def fitted(self, data: Observations) -> Identification:
        terms = mill_terms(self.machine.chain)
        return fit_form(self.machine, Form(terms, frame=frame_terms(self.machine.chain, terms)), data)[0]


def _campaign(seed: int) -> Campaign:
    chain = chain_of(STRUCTURE)
    chain = chain.with_axes({n: replace(chain.axis(n), travel=TRAVEL[n]) for n in "XYZ"})
    rng = np.random.default_rng(seed)
    truth = random_machine(PRESETS[STRUCTURE], TRAVEL, rng)
    machine = Machine("mill", chain)
    runs = []
    for axis in "XYZ":
        for k, share in enumerate((0.1, 0.9)):
            at = {n: np.full(POINTS, np.dot(TRAVEL[n], (1 - share, share))) for n in "XYZ"}
            at[axis] = np.linspace(*TRAVEL[axis], POINTS)
            for number in range(3):
                tool = TOOL + k * np.array([0.0, 80.0, 60.0])
                runs.append(_run(machine, truth, rng, at, tool, np.eye(3)[number], False, f"{axis}{'XYZ'[number]}{k}"))
                runs.append(_run(machine, truth, rng, at, TOOL, np.eye(3)[number], True, f"{axis}{'ABC'[number]}{k}"))
    for k, corner in enumerate([(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)]):
        way = np.linspace(0, 1, POINTS)
        at = {n: np.interp(way if s > 0 else 1 - way, (0, 1), TRAVEL[n]) for n, s in zip("XYZ", corner, strict=True)}
        along = np.array(corner) * [500.0, 400.0, 300.0]
        runs.append(_run(machine, truth, rng, at, TOOL, along / np.linalg.norm(along), False, f"diagonal {k}"))
    return Campaign(machine, truth, joined(runs))


def _run(
    machine: Machine,
    truth: ForwardMachine,
    rng: np.random.Generator,
    at: dict[str, Array],
    tool: Array,
    along: Array,
    angle: bool,
    run: str,
) -> Observations:
    tools = np.tile(tool, (POINTS, 1))
    error = truth.rotation_rad(at) if angle else truth.error_mm(at, tools)
    noise = NOISE_RAD if angle else NOISE_MM
    state = State(machine.chain.positions(at), 0.0, {}, tools)
    reading = error @ along + rng.normal(0, noise, POINTS)
    directions, u = np.tile(along, (POINTS, 1)), np.full(POINTS, noise)
    return Observations(state, directions, reading, np.full(POINTS, angle), u, (run,) * POINTS, own_zero=True)


def _zeroed(data: Observations, slopes: bool = True) -> Observations:
    """Every run zero at its first reading, straightness at its last too; said to be so."""
    reading, runs = data.reading.copy(), np.array(data.run)
    for run in dict.fromkeys(data.run):
        own = runs == run
        reading[own] -= reading[own][0]
        if slopes and run[:1] in "XYZ" and run[1] in "XYZ" and run[0] != run[1]:
            reading[own] -= np.linspace(0, reading[own][-1], POINTS)
    return replace(data, reading=reading, own_zero=np.ones(len(data), bool), own_slope=np.ones(len(data), bool))


def _off_um(campaign: Campaign, found: Identification) -> Array:
    """Model − truth over the volume, but for how work is clamped: displaced and turned as a whole."""
    rng = np.random.default_rng(9)
    at = {name: rng.uniform(*TRAVEL[name], 1500) for name in "XYZ"}
    tools = np.tile(TOOL, (1500, 1))
    point = np.stack([at[n] for n in "XYZ"], axis=1) + tools
    state = State(campaign.machine.chain.positions(at), 0.0, {}, tools)
    rest = (found.model.error_mm(state) - campaign.truth.error_mm(at, tools)).ravel()
    turned = np.stack([np.cross(axis, point).ravel() for axis in np.eye(3)], axis=1) / 300
    rigid = np.hstack([np.tile(np.eye(3), (1500, 1)), turned])
    rest = 1e3 * (rest - rigid @ np.linalg.lstsq(rigid, rest, rcond=None)[0])
    return rest.reshape(-1, 3)


@pytest.mark.parametrize("seed", [1, 2])
def test_runs_zeroed_one_by_one_give_the_machine(seed: int) -> None:
    campaign = _campaign(seed)
    found = campaign.fitted(_zeroed(campaign.data))
    rest = _off_um(campaign, found)
    taken = _off_um(campaign, campaign.fitted(replace(_zeroed(campaign.data), own_zero=False, own_slope=False)))
    assert np.sqrt(np.mean(rest**2)) < 0.3 and np.abs(rest).max() < 1.5
    assert np.sqrt(np.mean(taken**2)) > 2.0
    assert found.scatter == pytest.approx(1.0, abs=0.06) and found.outlier.sum() <= 3
    assert np.sqrt(np.mean(found.residual[~campaign.data.is_angle] ** 2)) < 1.1 * NOISE_MM


def test_a_run_left_out_is_judged_without_its_zero_and_slope() -> None:
    campaign = _campaign(3)
    data = _zeroed(campaign.data)
    found = campaign.fitted(data)
    held = hold_out(data, found, lambda others: campaign.fitted(others).model)
    lengths = [run.length_mm.rms for run in held if run.length_mm]
    assert len(held) == 40 and max(lengths) < 3 * NOISE_MM
    moved = replace(data, reading=data.reading + np.unique(data.run, return_inverse=True)[1] * 0.01)
    model = found.model
    assert _rms_mm(model, moved) == pytest.approx(_rms_mm(model, data), rel=1e-6)


@pytest.mark.parametrize(
    ("run", "factor", "words"),
    [
        ("XX0", 1.0, None),
        ("ZZ1", -1.0, "predicted from them it is"),  # half as large as the scatter allows: worse than without a model
        ("XY1", 1e-3, "its readings' stated uncertainty is 0.3 µm"),  # mm in a column of µm: noise alone would be more
        ("ZZ1", 1e-3, "its readings' stated uncertainty is 0.3 µm"),
    ],
)
def test_a_small_run_of_another_sign_or_unit_is_refused_by_name(run: str, factor: float, words: str | None) -> None:
    """A contradiction is judged by chance, not against a multiple of the scatter: the wrong run makes that larger."""
    campaign = _campaign(3)
    own = np.array(campaign.data.run) == run
    data = replace(campaign.data, reading=np.where(own, factor, 1.0) * campaign.data.reading)
    found = campaign.fitted(data)
    held = hold_out(data, found, lambda others: campaign.fitted(others).model)
    wrong = contradictions((found, held), data)
    assert [one.run for one in wrong if one.refused] == ([] if words is None else [run])
    assert words is None or words in wrong[0].message


def test_a_constant_of_the_model_says_what_all_zeros_say_together() -> None:
    """One run or several: the growth with temperature is found, and the constant is the mean of the runs' zeros."""
    machine = Machine("mill", chain_of(STRUCTURE))
    warm = np.linspace(20, 30, 12)
    state = State(machine.chain.positions({"X": np.zeros(12)}), 0.0, {"T1": warm})
    along, exact = np.tile([0.0, 0.0, 1.0], (12, 1)), 2e-3 * (warm - 20) + 5e-3
    term = Term(error_name("EZ0S"), (Part(), Part(CONSTANT, "T1", 20.0)))
    for runs in (("one",) * 12, ("one", "two") * 6):
        off = np.where(np.array(runs) == "two", 0.4, 0.0)
        data = Observations(state, along, exact + off, np.zeros(12, bool), np.full(12, np.nan), runs, own_zero=True)
        found = identify(machine, [term], data, robust=False)
        np.testing.assert_allclose(found.model.coefficients, [5e-3 + off.mean(), 2e-3], atol=1e-9)
        assert np.abs(found.residual).max() < 1e-9


@pytest.mark.parametrize(("factor", "gains"), [(1.0, ()), (-1.0, (-1.0, -1.0)), (0.5, (0.5, 2.0)), (2.0, (2.0, 0.5))])
def test_a_run_that_alone_shows_a_term_is_compared_in_all_else(factor: float, gains: tuple[float, ...]) -> None:
    """The spindle's growth follows from the warm run alone: its scale along Z is compared all the same.

    A scale of −0.1 µm/mm over 300 mm, a growth of 9 µm, readings to 0.3 µm.
    """
    machine, rng = Machine("mill", chain_of(STRUCTURE)), np.random.default_rng(4)
    z = np.tile(np.linspace(*TRAVEL["Z"], 11), 2)
    warm = np.repeat([20.0, 26.0], 11)
    exact = -1e-4 * z + 1.5e-3 * (warm - 20.0)
    state = State(machine.chain.positions({"Z": z, "X": 0 * z, "Y": 0 * z}), 0.0, {"T1": warm})
    reading = (exact + NOISE_MM * rng.standard_normal(22)) * np.where(warm > 20.0, factor, 1.0)
    along, u, runs = np.tile([0.0, 0.0, 1.0], (22, 1)), np.full(22, NOISE_MM), ("cold",) * 11 + ("warm",) * 11
    data = Observations(state, along, reading, np.zeros(22, bool), u, runs)
    terms = (Term(error_name("EZZ"), (Part(segments(*TRAVEL["Z"], 1, 1, (0.0,))),)),
             Term(error_name("EZ0S"), (Part(CONSTANT, "T1", 20.0),)))  # fmt: skip

    def judged(others: Observations) -> tuple[Identification, tuple[HeldOut, ...]]:
        found = identify(machine, terms, others)
        return found, hold_out(others, found, lambda rest: identify(machine, terms, rest).model)

    if not gains:
        assert require_agreement(judged(data), data, judged) == ()
        return
    with pytest.raises(TrueloopError) as refusal:
        require_agreement(judged(data), data, judged)
    assert refusal.value.code is Code.MCH_RUN and refusal.value.values["runs"] in (["cold", "warm"], ["warm", "cold"])
    of_warm, of_cold = sorted(contradictions(judged(data), data), key=lambda one: one.run, reverse=True)
    assert (of_warm.gain, of_cold.gain) == pytest.approx(gains, rel=0.03)


def test_taking_a_run_out_of_the_normal_equations_is_fitting_the_others() -> None:
    """Exactly for plain least squares; of a run that the others predict nothing of, a warning names it."""
    campaign = _campaign(5)
    data = _zeroed(campaign.data)
    few = data.only(np.array([run[:2] in ("XX", "XY", "XC", "YB") or run.startswith("d") for run in data.run]))
    terms = tuple(Term(error_name(n), (Part(segments(*TRAVEL["X"], 1, 3, (0.0,))),)) for n in ("EXX", "ECX"))
    terms += (Term(error_name("EYX"), (Part(segments(*TRAVEL["X"], 1, 2, TRAVEL["X"])),)), Term(error_name("EC0Y")))

    def fitted(others: Observations) -> Identification:
        return identify(campaign.machine, terms, others, robust=False)

    found, seen = fitted(few), []

    def refit(others: Observations) -> MachineModel:
        seen.append(others)
        return fitted(others).model

    quick = hold_out(few, found, refit)
    assert not seen
    anew = {one.run: one for one in hold_out(few, found, refit, anew=True)}
    assert set(anew) - {one.run for one in quick} == {"YB0", "YB1"}  # which follow no term of the model
    for one in quick:
        other = anew[one.run]
        for unit, left in one.by_unit.items():
            assert left.rms == pytest.approx(other.by_unit[unit].rms, rel=1e-6)
            assert left.largest == pytest.approx(other.by_unit[unit].largest, rel=1e-6)
            assert left.raw == pytest.approx(other.by_unit[unit].raw, rel=1e-12)
    lone = data.only(np.array([run in ("XX0", "YY0") for run in data.run]))
    own = tuple(Term(error_name(f"E{a}{a}"), (Part(segments(*TRAVEL[a], 1, 2, TRAVEL[a])),)) for a in "XY")
    apart = identify(campaign.machine, own, lone, robust=False)
    (warning,) = require_agreement((apart, hold_out(lone, apart, refit)), lone, lambda _: (apart, ()))
    assert warning.code is Code.MCH_RUN and warning.values == {"runs": ["XX0", "YY0"]}


def _rms_mm(model: MachineModel, data: Observations) -> float:
    left = compare(model, data).length_mm
    assert left is not None
    return left.rms


def test_squareness_of_slopes_that_are_not_known_is_refused() -> None:
    """Without diagonals nothing says it; straightedges read against a square do."""
    campaign = _campaign(4)
    rows = np.array([not run.startswith("diagonal") for run in campaign.data.run])
    data = _zeroed(campaign.data, slopes=False).only(rows)
    with pytest.raises(TrueloopError, match=r"EC0Y.*zeros and slopes") as error:
        campaign.fitted(data)
    assert error.value.code is Code.MCH_COLLINEAR and "absolute" in str(error.value.hint)
    rest = _off_um(campaign, campaign.fitted(replace(data, own_slope=np.zeros(len(data), bool))))
    assert np.sqrt(np.mean(rest**2)) < 0.3
