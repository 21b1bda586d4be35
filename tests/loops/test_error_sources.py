"""The sources of the errors, judged by parts that were drawn by formulas of their own and by the rules of sums."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_composed_correction import TOUCHES, finish_program, left_on_mm, write_job
from tests.loops.test_remembering import by_memory
from tests.support.cli import run
from tests.support.correction import example_correction, example_inputs
from trueloop.arrays import Array
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.error_sources import FeatureSources, Share, Source, error_sources
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.between_cuts import PRIOR
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.touches.error_vectors import ErrorVectors

UM = 1e-3
DOME = checked_profile(
    [
        Line("seat", (25.0, -60.0), (25.0, -20.0)),
        Arc("dome", (25.0, -20.0), (5.0, 0.0), (5.0, -20.0), math.pi / 2),
        Line("face", (5.0, 0.0), (0.0, 0.0)),
    ]
)


def touched(profile: Profile, error: Array, counts: tuple[int, ...], u_mm: float = 0.0007) -> ErrorVectors:
    """Touches of each feature, evenly spread, with errors (n,)."""
    places = [(i, (k + 0.5) / n * profile.features[i].length_mm) for i, n in enumerate(counts) for k in range(n)]
    return ErrorVectors(
        point=tuple(str(k) for k in range(len(places))),
        feature_index=np.array([i for i, _ in places], dtype=np.intp),
        arc_length_mm=np.array([s for _, s in places]),
        error_mm=error,
        standard_u_mm=np.full(len(places), u_mm),
        at_reference=np.zeros(len(places), dtype=np.bool_),
        nominal_mm=np.array([profile.features[i].point_mm(s) for i, s in places]),
        outward_normal=np.array([profile.features[i].outward_normal(s) for i, s in places]),
    )


def sources_of(profile: Profile, vectors: ErrorVectors) -> tuple[FeatureSources, ...]:
    return error_sources(fit_profile(profile, vectors, FitOptions()), PRIOR, None, None)


def share(of: FeatureSources, source: Source) -> Share:
    return next(one for one in of.shares if one.source is source)


def drawn(seed: int, counts: tuple[int, ...]) -> tuple[ErrorVectors, dict[Source, Array]]:
    """Errors of a tool set off, a nose worn by a cosine, and features off by themselves, with the truth by feature."""
    random = np.random.default_rng(seed)
    dx, dz = random.normal(0.0, 0.018, 2)
    worn, turn = random.normal(0.0, 0.007), random.uniform(0.0, math.pi)
    own = random.normal(0.0, 0.003, len(counts))
    at = touched(DOME, np.zeros(sum(counts)), counts)
    angle = DOME.contact_angle_rad(at.feature_index, at.arc_length_mm)
    by_source = {
        Source.SETTING: dx * np.sin(angle) + dz * np.cos(angle),
        Source.NOSE: math.sqrt(2.0) * worn * np.cos(2.2 * angle - turn),
        Source.PART: own[at.feature_index],
    }
    error = sum(by_source.values()) + random.normal(0.0, 0.0012, len(angle))
    return touched(DOME, np.asarray(error), counts), by_source


def test_the_truth_lies_within_the_uncertainty_of_each_share() -> None:
    """Of 60 drawn parts; the sum is known far better than a tool's setting and the form of its nose are."""
    counts, inside, wide = (5, 9, 4), list[bool](), list[float]()
    for seed in range(60):
        vectors, truth = drawn(seed, counts)
        for of in sources_of(DOME, vectors):
            rows = vectors.of_feature(of.index)
            for source, values in truth.items():
                one = share(of, source)
                inside.append(abs(one.mean_mm - float(np.mean(values[rows]))) <= 1.96 * one.standard_u_mm)
            total = float(np.mean(np.sum([values[rows] for values in truth.values()], axis=0)))
            inside.append(abs(of.together_mm - total) <= 1.96 * of.together_u_mm)
            wide.append(share(of, Source.SETTING).standard_u_mm / of.together_u_mm)
    assert 0.90 <= float(np.mean(inside)) <= 0.995
    assert float(np.median(wide)) > 1.5


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cylinder_that_differs_from_its_like_is_the_parts_error_by_its_sign(sign: float) -> None:
    """Two cylinders at one contact angle: neither tool nor nose makes them differ."""
    profile = checked_profile(
        [
            Line("wide", (30.0, -100.0), (30.0, -60.0)),
            Line("step", (30.0, -60.0), (20.0, -60.0)),
            Line("thin", (20.0, -60.0), (20.0, 0.0)),
        ]
    )
    error = sign * UM * np.array([30.0] * 5 + [0.0] * 3 + [18.0] * 5)
    wide, _, thin = sources_of(profile, touched(profile, error, (5, 3, 5)))
    assert share(wide, Source.SETTING).mean_mm == pytest.approx(share(thin, Source.SETTING).mean_mm)
    assert share(wide, Source.NOSE).mean_mm == pytest.approx(share(thin, Source.NOSE).mean_mm)
    differs = share(wide, Source.PART).mean_mm - share(thin, Source.PART).mean_mm
    assert differs == pytest.approx(sign * 12.0 * UM, abs=1.5 * UM)
    assert sign * (wide.together_mm - share(wide, Source.PART).mean_mm) > 8.0 * UM


def corrections() -> list[Correction]:
    return [example_correction("modbas2"), example_correction("bush"), by_memory()]


def test_shares_add_up_to_the_error_and_measuring_to_what_was_measured() -> None:
    for correction in corrections():
        assert [one.index for one in correction.sources] == list(range(len(correction.profile.features)))
        for of in correction.sources:
            causes = [one for one in of.shares if one.source is not Source.MEASURING]
            assert math.fsum(one.mean_mm for one in causes) == pytest.approx(of.together_mm, abs=1e-9)
            assert all(one.low_mm - 1e-9 <= one.mean_mm <= one.high_mm + 1e-9 for one in causes if one.high_mm > 0.0)
            rows = correction.model.vectors.of_feature(of.index)
            rows = rows[(correction.model.weight[rows] > 0.0) & ~correction.model.vectors.at_reference[rows]]
            assert bool(len(rows)) == any(one.source is Source.MEASURING for one in of.shares)
            if len(rows) and correction.memory is None:
                measured = float(np.mean(correction.model.vectors.error_mm[rows]))
                assert of.together_mm + share(of, Source.MEASURING).mean_mm == pytest.approx(measured, abs=1e-6)


def test_earlier_parts_narrow_the_shares_and_know_what_the_next_cut_does_otherwise() -> None:
    remembered = by_memory()
    dome = remembered.profile.names.index("dome")
    alone = error_sources(remembered.model, remembered.options.between_cuts, None, None)[dome]
    with_them = remembered.sources[dome]
    assert share(alone, Source.NEXT_CUT).mean_mm == 0.0
    assert abs(share(with_them, Source.NEXT_CUT).mean_mm) > 0.1 * UM
    assert with_them.together_u_mm < 0.7 * alone.together_u_mm


def test_the_machine_has_the_share_that_its_component_takes_out(tmp_path: Path) -> None:
    run("compensate", write_job(tmp_path, "G8", "machine", "uncompensated"), "-o", tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    for feature in report["features"]:
        mine = [-one["comp_mtg_um"] for one in report["components"] if one["feature"] == feature["feature"]]
        (found,) = [one for one in feature["sources"] if one["source"] == "machine"]
        assert found["mean_um"] == pytest.approx(float(np.mean(mine)), abs=1e-3)
        assert (found["low_um"], found["high_um"]) == pytest.approx((min(mine), max(mine)), abs=1e-3)
        assert abs(found["mean_um"]) > 1.0


def test_with_a_machine_the_shares_add_up_to_what_the_given_program_would_leave_on(tmp_path: Path) -> None:
    """Judged by the formulas of machine and process and LinuxCNC's interpreter: what the uncorrected program cuts."""
    run("compensate", write_job(tmp_path, "G8", "machine", "uncompensated"), "-o", tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    left_um = 1000.0 * left_on_mm(finish_program("G8"), tmp_path, TOUCHES)
    assert len(report["features"]) == 3
    for feature in report["features"]:
        mine = [left for left, name in zip(left_um, TOUCHES.feature, strict=True) if name == feature["feature"]]
        shares = [one["mean_um"] for one in feature["sources"] if one["source"] != "measuring"]
        assert math.fsum(shares) == pytest.approx(float(np.mean(mine)), abs=0.7)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_touch_that_the_fit_leaves_out_has_no_share(sign: float) -> None:
    """A chip under the ball at one touch of the dome: shares are those of the other touches."""
    vectors, _ = drawn(3, (5, 9, 4))
    wrong = vectors.error_mm.copy()
    wrong[9] += sign * 0.060
    with_it = fit_profile(DOME, touched(DOME, wrong, (5, 9, 4)), FitOptions())
    assert np.flatnonzero(with_it.weight == 0.0).tolist() == [9]
    without = fit_profile(DOME, vectors.chosen([k for k in range(18) if k != 9]), FitOptions())
    for found, expected in zip(*(error_sources(one, PRIOR, None, None) for one in (with_it, without)), strict=True):
        assert [one.mean_mm for one in found.shares] == pytest.approx([one.mean_mm for one in expected.shares])
        assert found.together_mm == pytest.approx(expected.together_mm)


def test_a_correction_without_them_is_otherwise_the_same() -> None:
    """Many simulated parts, and a tool's offset, need no shares of sources."""
    inputs, whole = example_inputs("modbas2"), example_correction("modbas2")
    assert whole.sources and compensate(inputs, sources=False) == replace(whole, sources=())
