"""Known truth: what is found is what was put in, and the stated uncertainty is right."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t as student

from tests.support.machines import chain_with_travel, random_directions, random_model, random_state, readings
from trueloop.errors import Code, TrueloopError
from trueloop.formats.examples import example
from trueloop.jobs.machine.machine_model import fit_machine
from trueloop.machine.identify.identify import identify
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, State
from trueloop.machine.model.term import CONSTANT, Part, Term, mill_terms, segments, turning_terms

LATHE = Machine("lathe", chain_with_travel("turning"))
MILL = Machine("mill", chain_with_travel("mill-table-x"))
MAKE_TERMS = {"lathe": turning_terms, "mill": mill_terms}


@pytest.mark.parametrize("machine", [LATHE, MILL], ids=lambda machine: machine.name)
@pytest.mark.parametrize("both_ways", [False, True])
def test_without_noise_every_coefficient_is_found(machine: Machine, both_ways: bool) -> None:
    rng = np.random.default_rng(11)
    terms = MAKE_TERMS[machine.name](machine.chain, count=3, both_ways=both_ways)
    # errors a hundredth of the usual, so that second-order products stay below 1 nm
    truth = random_model(machine, terms, rng)
    truth = type(truth)(machine, terms, truth.coefficients * 0.01, truth.covariance)
    state = random_state(machine.chain, 4000, rng)
    data = readings(truth, state, random_directions(4000, rng, machine is LATHE), 0.0, rng)
    found = identify(machine, terms, data, robust=False)
    size = np.abs(truth.coefficients).max()
    np.testing.assert_allclose(found.model.coefficients, truth.coefficients, atol=2e-4 * size)


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize("machine", [LATHE, MILL], ids=lambda machine: machine.name)
def test_95_percent_bands_hold_the_truth_in_93_to_97_percent(machine: Machine, robust: bool) -> None:
    """0.5 µm noise, every term looked at in the middle of each third of its travel, a hundred random machines."""
    rng = np.random.default_rng(12)
    terms = MAKE_TERMS[machine.name](machine.chain)
    held = []
    for _ in range(100):
        truth = random_model(machine, terms, rng)
        state = random_state(machine.chain, 600, rng)
        data = readings(truth, state, random_directions(600, rng, machine is LATHE), 0.5e-3, rng)
        found = identify(machine, terms, data, robust=robust)
        quantile = student.ppf(0.975, found.degrees_of_freedom)
        for term, where in zip(terms, truth.slices(), strict=True):
            low, high = machine.chain.axis(term.name.axis).travel
            at = low + (high - low) * np.array([1, 3, 5]) / 6
            rows = term.design(at, np.ones(3), {})
            deviation = rows @ (found.model.coefficients - truth.coefficients)[where]
            u = np.sqrt(np.einsum("ni,ij,nj->n", rows, found.model.covariance[where, where], rows))
            held += list(np.abs(deviation) <= quantile * u)
    assert 0.93 <= np.mean(held) <= 0.97


@pytest.mark.parametrize("machine", [LATHE, MILL], ids=lambda machine: machine.name)
def test_the_sign_of_every_term(machine: Machine) -> None:
    """One error at a time is put in and is found in that term alone, with its sign."""
    rng = np.random.default_rng(13)
    terms = MAKE_TERMS[machine.name](machine.chain)
    state = random_state(machine.chain, 500, rng)
    along = random_directions(500, rng, machine is LATHE)
    zero = random_model(machine, terms, rng)
    for term, where in zip(terms, zero.slices(), strict=True):
        size = 1e-5 if term.name.is_rotation else 1e-3
        coefficients = np.zeros(len(zero.coefficients))
        coefficients[where] = term.admissible() @ np.full(term.admissible().shape[1], size)
        truth = type(zero)(machine, terms, coefficients, zero.covariance)
        found = identify(machine, terms, readings(truth, state, along, 0.0, rng), robust=False).model.coefficients
        np.testing.assert_allclose(found[where], coefficients[where], atol=1e-3 * size, err_msg=str(term.name))
        rest = np.delete(found, np.arange(where.start, where.stop))
        assert np.abs(rest).max() < 1e-5


def test_equation_3_with_backlash_and_three_segments() -> None:
    """[4773 Eq. 3] δz(z) = A + B·T12 + C·z + D·z², own parameters each way and in three segments joined smoothly."""
    rng = np.random.default_rng(14)
    form = Term(error_name("EZZ"), (Part(segments(-300.0, 0.0, 3, 2)), Part(CONSTANT, "T12", 20.0)), both_ways=True)
    assert form.size == 2 * (5 + 1)
    z = rng.uniform(-300, 0, 300)
    travel, warm = rng.choice([-1.0, 1.0], 300), rng.uniform(20, 35, 300)
    error = np.where(travel > 0, 1e-3, 4e-3) + 0.6e-3 * (warm - 20) + 2e-5 * z + 1e-8 * z**2
    state = State(LATHE.chain.positions({"Z": z}), LATHE.chain.positions({"Z": travel}), {"T12": warm})
    data = readings(random_model(LATHE, (form,), rng), state, np.tile([0.0, 0.0, 1.0], (300, 1)), 0.0, rng)
    found = identify(LATHE, [form], type(data)(state, data.along, error, data.is_angle, data.standard_u, data.run))
    at = np.array([-250.0, -250.0])
    values = form.values(found.model.coefficients, at, np.array([1.0, -1.0]), {"T12": 30.0})
    expected = np.array([1e-3, 4e-3]) + 0.6e-3 * 10 + 2e-5 * -250 + 1e-8 * 250**2
    np.testing.assert_allclose(values, expected, atol=1e-12)


def test_outliers_are_named_and_do_not_move_the_model() -> None:
    rng = np.random.default_rng(15)
    form = (Term(error_name("EXX"), (Part(segments(0.0, 500.0, 1, 3, (0.0,))),)),)
    truth = random_model(MILL, form, rng)
    state = State(MILL.chain.positions({"X": np.tile(np.linspace(0, 500, 21), 5)}))
    data = readings(truth, state, np.tile([1.0, 0.0, 0.0], (105, 1)), 0.5e-3, rng)
    slipped = data.reading.copy()
    slipped[[7, 60]] += [0.03, -0.05]
    spoilt = type(data)(state, data.along, slipped, data.is_angle, data.standard_u, data.run)
    found = identify(MILL, form, spoilt)
    assert list(np.flatnonzero(found.outlier)) == [7, 60]
    assert [finding.message.split()[1] for finding in found.findings] == ["8", "61"]
    clean = identify(MILL, form, data)
    plain = identify(MILL, form, spoilt, robust=False)
    moved, moved_plain = (np.abs(m.model.coefficients - clean.model.coefficients).max() for m in (found, plain))
    assert moved < 0.3e-3
    assert moved_plain > 5 * moved


def test_two_sensors_that_move_together_are_named() -> None:
    rng = np.random.default_rng(16)
    form = [Term(error_name("EZ0C"), (Part(), Part(CONSTANT, "T1", 20.0), Part(CONSTANT, "T2", 20.0)))]
    t1 = rng.uniform(20, 30, 60)
    signals = {"T1": t1, "T2": 1.5 * t1 + rng.normal(0, 0.05, 60)}
    state = State(LATHE.chain.positions({"Z": np.zeros(60)}), 0.0, signals)
    data = readings(random_model(LATHE, tuple(form), rng), state, np.tile([0.0, 0.0, 1.0], (60, 1)), 0.2e-3, rng)
    messages = [finding.message for finding in identify(LATHE, form, data).findings]
    assert len(messages) == 1
    assert "EZ0C·T1 and EZ0C·T2" in messages[0]


def test_a_run_that_is_off_as_a_whole_is_named_once_and_not_reading_by_reading(tmp_path: Path) -> None:
    """A run of the other sign, accepted: a warning for each of two runs that disagree, another for their outliers."""
    header, *rows = example("machine/readings.csv").read_text(encoding="utf-8").splitlines()
    where = header.split(",").index("reading_um")
    for k, row in enumerate(rows):
        cells = row.split(",")
        if "X at 20 °C" in cells:
            rows[k] = ",".join([*cells[:where], repr(-float(cells[where])), *cells[where + 1 :]])
    file = tmp_path / "readings.csv"
    file.write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    fitted = fit_machine(example("machine/machine.toml"), [file], accept=[Code.MCH_RUN])
    counted = Counter(finding.code for finding in fitted.found.findings)
    assert counted == {Code.MCH_RUN: 2, Code.MCH_OUTLIER: 2}
    assert all("of 11 readings" in one.message for one in fitted.found.findings if one.code == Code.MCH_OUTLIER)


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_readings_named_in_too_large_a_unit_are_refused(tmp_path: Path, unit: str) -> None:
    """Micrometres in a column of mm or inches make errors of centimetres, on which all runs agree."""
    text = example("machine/readings.csv").read_text(encoding="utf-8")
    file = tmp_path / "readings.csv"
    file.write_text(text.replace("reading_um", f"reading_{unit}"), encoding="utf-8")
    with pytest.raises(TrueloopError, match="times their stated standard uncertainty") as refused:
        fit_machine(example("machine/machine.toml"), [file])
    assert refused.value.code is Code.MCH_SCATTER and "reading_um" in refused.value.hint
