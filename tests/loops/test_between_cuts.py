"""What two cuts of one part differ by, which its touches cannot show: in every band, and in no correction."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import stdtrit

from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.outcome import outcomes
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.report.turned.page import page
from trueloop.turned.error_curve.curve import Budget, joined
from trueloop.turned.fit.between_cuts import NONE, PRIOR, BetweenCuts
from trueloop.units import UM_PER_MM

EXAMPLES = Path(__file__).parents[2] / "examples"
MODBAS2 = read_job(EXAMPLES / "modbas2" / "job.toml").inputs
PROBE_MM = 0.0015 / np.sqrt(12.0)


def with_touches(inputs: Inputs, rows: "np.ndarray[tuple[int], np.dtype[np.intp]]") -> Inputs:
    return replace(inputs, touches=inputs.touches.chosen(rows))


def corrected(inputs: Inputs, between: BetweenCuts) -> Correction:
    return compensate(replace(inputs, options=replace(inputs.options, between_cuts=between)))


def test_one_touch_on_a_cylinder_is_not_known_to_the_probes_repeatability() -> None:
    """By hand: the touch and the next cut scatter by 1.5 µm/√12 each; √2 times 2 and 1.5 µm set the cuts apart."""
    neck = MODBAS2.touches.of_feature(MODBAS2.profile.names.index("small-cylinder"))
    one = with_touches(MODBAS2, neck)
    assert len(one.touches.point) == 1
    alone = 1.959964 * np.sqrt(2.0) * PROBE_MM
    assert corrected(one, NONE).prediction.expanded_u_mm == pytest.approx([alone], rel=1e-6)
    together = 1.959964 * np.sqrt(2.0 * (PROBE_MM**2 + 0.0020**2 + 0.0015**2))
    assert corrected(one, PRIOR).prediction.expanded_u_mm == pytest.approx([together], rel=1e-6)
    assert together > 0.0070 > 5 * alone


def test_by_default_every_band_and_the_headline_hold_it() -> None:
    assert MODBAS2.options.between_cuts == PRIOR
    alike, default = corrected(MODBAS2, NONE), compensate(MODBAS2)
    assert np.all(default.prediction.expanded_u_mm > 1.95 * PRIOR.difference_mm)
    assert np.all(alike.prediction.expanded_u_mm < default.prediction.expanded_u_mm)
    worst = int(np.argmax(np.abs(default.prediction.after_mm)))
    assert f"± {1000 * default.prediction.expanded_u_mm[worst]:.1f} µm" in page(default)


def test_it_changes_no_correction() -> None:
    """Of the program only the record's id differs."""
    programs = [corrected(MODBAS2, between).corrected_program.splitlines() for between in (NONE, PRIOR)]
    differing = [(a, b) for a, b in zip(*programs, strict=True) if a != b]
    assert len(differing) == 1
    assert b"trueloop corrected" in differing[0][0]
    np.testing.assert_array_equal(
        corrected(MODBAS2, NONE).prediction.after_mm, corrected(MODBAS2, PRIOR).prediction.after_mm
    )


def test_the_budget_adds_up_to_the_band() -> None:
    """Squares of the causes, each group times its own k squared."""
    correction = compensate(MODBAS2)
    budget, k = correction.prediction.budget, stdtrit(correction.model.degrees_of_freedom, 0.975)
    found = budget.probe_mm**2 + budget.curve_mm**2 + budget.process_mm**2
    stated = budget.common_mm**2 + budget.along_mm**2 + budget.estimate_mm**2
    np.testing.assert_allclose(budget.standard_u_mm**2, found + stated)
    np.testing.assert_allclose(correction.prediction.expanded_u_mm**2, k**2 * found + 1.959964**2 * stated, rtol=1e-4)
    elsewhere = ~correction.touches.at_reference
    across, along = np.abs(correction.touches.outward_normal[elsewhere]).T
    # z is taken from a face: what moves a whole cut along z moves that too, and that face varies by itself
    np.testing.assert_allclose(budget.common_mm[elsewhere], np.sqrt(2.0) * 0.0020 * across, atol=2e-4)
    np.testing.assert_allclose(budget.along_mm[elsewhere], np.sqrt(2.0) * 0.0015 * np.hypot(1.0, along), rtol=1e-2)


def test_without_a_z_reference_both_hold_everywhere() -> None:
    touches = replace(MODBAS2.touches, at_reference=np.zeros(len(MODBAS2.touches.point), dtype=np.bool_))
    budget = compensate(replace(MODBAS2, touches=touches)).prediction.budget
    np.testing.assert_allclose(budget.common_mm, np.sqrt(2.0) * 0.0020)
    np.testing.assert_allclose(budget.along_mm, np.sqrt(2.0) * 0.0015)


@pytest.mark.parametrize("spare", [1, 3, 10])
@pytest.mark.parametrize("stated", [0.3, 1.0, 3.0])
def test_a_student_and_a_normal_part_together_are_held(spare: int, stated: float) -> None:
    """Drawn: a normal error of a scatter that is known from few touches, and a normal one of stated size."""
    rng, draws = np.random.default_rng(spare), 100_000
    scatter = np.sqrt(rng.chisquare(spare, draws) / spare)
    error = rng.standard_normal(draws) + stated * rng.standard_normal(draws)
    zero = np.zeros(draws)
    band = Budget(zero, zero, scatter, np.full(draws, stated), zero, zero, spare)
    assert 0.944 < np.mean(np.abs(error) <= band.expanded_u_mm) < 0.99


def test_a_budget_of_several_features_keeps_their_order() -> None:
    parts = [compensate(MODBAS2).model.curves[i].budget([1.0, 2.0]) for i in (2, 6)]
    both = joined(parts)
    np.testing.assert_array_equal(both.curve_mm, np.concatenate([parts[0].curve_mm, parts[1].curve_mm]))
    np.testing.assert_allclose(both.at(np.array([3])).expanded_u_mm, parts[1].expanded_u_mm[1:])


@pytest.mark.parametrize(
    ("keys", "between"),
    [
        ("", PRIOR),
        ("cut_to_cut_um = 0", NONE),
        ("cut_to_cut_um = 1.2", BetweenCuts(0.0012, 0.0, "stated in the job")),
        ("cut_to_cut_along_um = 3", BetweenCuts(0.0, 0.003, "stated in the job")),
    ],
)
def test_the_job_sets_it_or_switches_it_off(tmp_path: Path, keys: str, between: BetweenCuts) -> None:
    for file in (EXAMPLES / "modbas2").iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    job = tmp_path / "job.toml"
    job.write_text(job.read_text().replace("\n[output]", f"\n[compensation]\n{keys}\n\n[output]"))
    assert read_job(job).inputs.options.between_cuts == between


def test_terminal_json_and_report_name_the_causes_and_the_prior(tmp_path: Path) -> None:
    job = str(EXAMPLES / "modbas2" / "job.toml")
    said = invoke("compensate", job, "-o", str(tmp_path), status=ExitStatus.DONE).stdout
    assert "- Between cuts: prior for turning in general, one standard deviation of 2 µm that moves a whole cut" in said
    (budget,) = (line for line in said.splitlines() if line.startswith("- Uncertainty budget"))
    assert "between cuts (whole cut) 2.8, between cuts (along it) 3.0" in budget
    told = json.loads(invoke("compensate", job, "-o", str(tmp_path), "--json", status=ExitStatus.DONE).stdout)
    assert "compensation.cut_to_cut_um" in told["between_cuts"]
    cone = told["features"][2]
    faces_x = MODBAS2.profile.features[2].outward_normal(0.0)[0]
    assert cone["standard_u_um"]["between cuts (whole cut)"] == pytest.approx(np.sqrt(8.0) * faces_x, rel=1e-3)
    (outcome,) = (one for one in outcomes(compensate(MODBAS2)) if one.index == 2)
    assert cone["predicted_expanded_u_um"] == pytest.approx(outcome.expanded_u_mm * UM_PER_MM)
    report = (tmp_path / "report.html").read_text()
    assert "between cuts,<br>whole cut" in report
    assert "prior for turning in general" in report
