"""Known truth: a lathe with known errors cuts, probes and is measured on a CMM; every component comes back."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from tests.support.exact_kinematics import exact_error_of
from tests.support.machines import chain_with_travel, random_directions, random_model, random_state, readings
from trueloop.arrays import Array
from trueloop.diagnosis.components import (
    FrameDiscrepancy,
    Inspections,
    error_components,
    fit_frame_discrepancy,
    without_discrepancy,
)
from trueloop.machine.identify.identify import identify
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import CONSTANT, Part, Term, turning_terms

LATHE = Machine("lathe", chain_with_travel("turning"))
TOOL_MM = np.array([60.0, 0.0, 35.0])
COLD, WARM = {"T1": 21.0}, {"T1": 29.0}


def _terms() -> tuple[Term, ...]:
    """The geometric terms, positioning errors growing with a temperature."""
    warm = Part(CONSTANT, "T1", 20.0)
    return tuple(
        replace(term, parts=(*term.parts, warm)) if str(term.name) in ("EXX", "EZZ", "EB0Z") else term
        for term in turning_terms(LATHE.chain)
    )


def _truth(rng: np.random.Generator) -> MachineModel:
    """Geometric errors of 15 µm and 30 µrad; thermal ones of 1 µm/K and 1 µrad/K."""
    terms = _terms()
    model = random_model(LATHE, terms, rng)
    coefficients = model.coefficients.copy()
    for term, where in zip(terms, model.slices(), strict=True):
        if term.needs():
            coefficients[where.stop - 1] = rng.normal(0, 1e-6 if term.name.is_rotation else 1e-3)
    return replace(model, coefficients=coefficients)


def _identified(truth: MachineModel, rng: np.random.Generator) -> MachineModel:
    state = random_state(LATHE.chain, 500, rng)
    state = replace(state, signals={"T1": rng.uniform(20, 30, 500)})
    data = readings(truth, state, random_directions(500, rng, plane=True), 0.5e-3, rng)
    return identify(LATHE, truth.terms, data, robust=False).model


def _gauging_points(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    nominal = np.stack([rng.uniform(50, 400, count), np.zeros(count), rng.uniform(-250, -50, count)], axis=1)
    return nominal, random_directions(count, rng, plane=True)


def _state(point_mm: Array, signals: dict[str, float]) -> State:
    """Axis positions that put the tool point there on the nominal machine."""
    return State((point_mm - TOOL_MM)[:, [0, 2]], 0.0, signals, TOOL_MM)


def _made_and_inspected(
    truth: MachineModel, model: MachineModel, rng: np.random.Generator, *, compensated: bool, noise_mm: float = 0.0
) -> tuple[Inspections, State, State, Array, Array]:
    """Cuts cold, probes warm, all along the normals: (inspections, cutting, probing, ERROR_MTG, ERROR_PROC)."""
    nominal, normal = _gauging_points(rng, 25)
    process = rng.normal(0, 0.02, 25)
    comp_proc = -0.75 * process
    cutting, probing = _state(nominal, COLD), _state(nominal, WARM)

    def along(vectors: Array) -> Array:
        scalar: Array = np.einsum("ni,ni->n", normal, vectors)
        return scalar

    command = model.comp_mtg_mm(cutting) if compensated else np.zeros_like(nominal)
    # the machine cuts where it is, not where it was sent: exact transforms at the commanded position
    e_cut = along(exact_error_of(truth, _state(nominal + command, COLD)))
    surface = e_cut + along(command) + comp_proc + process
    at = nominal + surface[:, None] * normal
    # the controller's position at contact: where the machine has to be told to be, so that it is on the surface
    told = at.copy()
    for _ in range(5):
        told = at - exact_error_of(truth, _state(told, WARM))
    seen = Inspections(
        nominal,
        normal,
        told + rng.normal(0, noise_mm, 25)[:, None] * normal,
        at + rng.normal(0, noise_mm, 25)[:, None] * normal,
        noise_mm,
        noise_mm,
        comp_proc,
    )
    return seen, cutting, probing, e_cut, process


@pytest.mark.parametrize("compensated", [False, True])
def test_with_a_right_model_every_component_comes_back(compensated: bool) -> None:
    rng = np.random.default_rng(21)
    truth = _truth(rng)
    seen, cutting, probing, error_mtg, error_proc = _made_and_inspected(truth, truth, rng, compensated=compensated)
    found = error_components(truth, seen, cutting, probing, compensated=compensated)
    # second-order terms and the slope of E over the corrections: 20 nm
    np.testing.assert_allclose(found.error_mtg, error_mtg, atol=2e-5)
    np.testing.assert_allclose(found.error_proc, error_proc, atol=2e-5)
    assert np.abs(error_mtg).max() > 5e-3
    if compensated:
        assert np.abs(found.error_mtg_resid).max() < 2e-5


def test_the_equation_subtracts_and_the_glossary_is_wrong() -> None:
    """[6876 §3.3] against its glossary: only subtracting COMP_MTG brings the touch back to the true surface."""
    rng = np.random.default_rng(22)
    truth = _truth(rng)
    seen, _, probing, _, _ = _made_and_inspected(truth, truth, rng, compensated=True)
    actual = seen.controller_mm - truth.comp_mtg_mm(probing)
    wrong = seen.controller_mm + truth.comp_mtg_mm(probing)
    off = np.abs(np.einsum("ni,ni->n", seen.normal, actual - seen.cmm_mm)).max()
    off_wrong = np.abs(np.einsum("ni,ni->n", seen.normal, wrong - seen.cmm_mm)).max()
    assert off < 2e-5
    assert off_wrong > 1e-2


def test_identities_of_the_report() -> None:
    """[6876 §3.5]: COMP = −ERROR + RESID, ERROR_PP the sum of residuals; surfaces as in Figs. 13 and 14."""
    rng = np.random.default_rng(23)
    truth = _truth(rng)
    seen, cutting, probing, *_ = _made_and_inspected(truth, _identified(truth, rng), rng, compensated=True)
    c = error_components(truth, seen, cutting, probing, compensated=True)
    np.testing.assert_allclose(c.comp_mtg_cutting, -c.error_mtg + c.error_mtg_resid, atol=1e-15)
    np.testing.assert_allclose(c.comp_proc, -c.error_proc + c.error_proc_resid, atol=1e-15)
    np.testing.assert_allclose(c.error_pp, c.error_mtg_resid + c.error_proc_resid, atol=1e-15)
    np.testing.assert_allclose(
        c.detected_surface - c.uncompensated_surface, c.comp_proc + c.comp_mtg_applied, atol=1e-15
    )
    np.testing.assert_allclose(
        c.nominal_surface_mt - c.uncompensated_nominal_surface_mt, c.comp_mtg_applied, atol=1e-15
    )
    np.testing.assert_allclose(c.uncompensated_surface, c.uncompensated_error, atol=1e-15)
    np.testing.assert_allclose(c.gt_compensated_surface, c.detected_surface - c.comp_proc, atol=1e-15)


@pytest.mark.parametrize("compensated", [False, True])
def test_95_percent_bands_hold_the_truth_in_93_to_97_percent(compensated: bool) -> None:
    """A model identified with 0.5 µm noise, touches and CMM with 0.5 µm noise, eighty lathes with 25 points each."""
    rng = np.random.default_rng(24)
    held_mtg, held_proc = [], []
    for _ in range(80):
        truth = _truth(rng)
        model = _identified(truth, rng)
        seen, cutting, probing, error_mtg, error_proc = _made_and_inspected(
            truth, model, rng, compensated=compensated, noise_mm=0.5e-3
        )
        found = error_components(model, seen, cutting, probing, compensated=compensated)
        quantile = student.ppf(0.975, 450)
        held_mtg += list(np.abs(found.error_mtg - error_mtg) <= quantile * found.u_error_mtg)
        held_proc += list(np.abs(found.error_proc - error_proc) <= quantile * found.u_error_proc)
    assert 0.93 <= np.mean(held_mtg) <= 0.97
    assert 0.93 <= np.mean(held_proc) <= 0.97


def test_a_part_clamped_differently_on_the_cmm_is_separated() -> None:
    rng = np.random.default_rng(25)
    truth = _truth(rng)
    seen, cutting, probing, error_mtg, _ = _made_and_inspected(truth, truth, rng, compensated=True)
    moved = FrameDiscrepancy(np.array([0.03, 0.0, -0.05]), np.array([0.0, 2e-4, 0.0]), np.zeros(6), 0.0, 0.0)
    displaced = replace(seen, cmm_mm=moved.apply(seen.cmm_mm))
    spoilt = error_components(truth, displaced, cutting, probing, compensated=True)
    assert np.abs(spoilt.error_mtg - error_mtg).max() > 0.03
    found = fit_frame_discrepancy(displaced, spoilt.error_proc_resid)
    np.testing.assert_allclose(found.shift_mm, moved.shift_mm, atol=5e-5)
    np.testing.assert_allclose(found.turn_rad, moved.turn_rad, atol=2e-7)
    # in the plane of turning nothing tells a shift along Y, nor turns about X and Z
    assert list(np.isnan(found.standard_u)) == [False, True, False, True, False, True]
    assert found.rms_after_mm < 1e-4 < found.rms_before_mm
    mended = error_components(truth, without_discrepancy(displaced, found), cutting, probing, compensated=True)
    np.testing.assert_allclose(mended.error_mtg, error_mtg, atol=1e-4)
