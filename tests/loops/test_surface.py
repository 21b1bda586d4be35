"""From a job's files to a corrected surface and program, and back through a CAD file and the simulated cut."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import interpret
from tests.support.surfaces import ball_centres, left_on_mm
from trueloop.formats.cad.step import named_faces, read_faces, write_surface
from trueloop.geometry.surface import closest
from trueloop.jobs.surface.job import read_surface
from trueloop.loops.surface.correction import SurfaceInputs
from trueloop.loops.surface.surface import Part, SurfaceCorrection, SurfaceModel, correct, model_of, pattern_model
from trueloop.surface.compensation.shift import corrected_surface
from trueloop.surface.deviations.deviations import surface_deviations
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.surface.separation.neighbourhood import Neighbourhood
from trueloop.surface.separation.separate import averaged_over_cells, separate
from trueloop.surface.separation.spline_surface import Places
from trueloop_lab.simulator.machine import published_process

EXAMPLE = Path(__file__).parents[2] / "examples" / "surface" / "surface.toml"


@cache
def inputs() -> SurfaceInputs:
    return read_surface(EXAMPLE).inputs


@cache
def parts() -> list[Part]:
    return model_of(inputs().surface, inputs().parts, inputs().options)


@cache
def model() -> SurfaceModel:
    return pattern_model(inputs().surface, parts(), inputs().options)


@cache
def correction() -> SurfaceCorrection:
    return correct(model(), inputs().program, inputs().cutter, "0123456789abcdef")


def test_the_example_s_pattern_is_the_one_it_was_made_with() -> None:
    """Within its own uncertainty at 95 % of places, apart from what the best fit took for a shift or turn."""
    at = np.linspace(0.03, 0.97, 40)
    made = published_process(np.random.default_rng(2017), pattern_mm=0.010).pattern.grid_mm(at, at)
    found, unsure = model().pattern.mean.grid_mm(at, at), model().pattern.uncertainty_grid_mm(at, at)
    u, v = np.repeat(at, 40), np.tile(at, 40)
    normal = inputs().surface.normal(u, v)
    design = np.concatenate([normal, np.cross(inputs().surface.point_mm(u, v), normal)], axis=1)  # rigid motions
    off = (found - made).ravel()
    off = off - design @ np.linalg.lstsq(design, off, rcond=None)[0]
    assert np.mean(np.abs(off) <= unsure.ravel()) > 0.88
    assert np.max(np.abs(made)) > 12 * np.sqrt(np.mean(off**2))
    assert not model().pattern.outlying


def test_parts_measured_on_one_grid_share_their_neighbourhood() -> None:
    assert len({id(part.separation.near) for part in parts()}) == 1
    assert {part.deviations.alignment.kind for part in parts()} == {"best fit"}


def test_linuxcnc_runs_the_corrected_program_and_its_envelope_is_the_corrected_surface(tmp_path: Path) -> None:
    """Within the scallop height of the program (20 µm) and its chord tolerance (5 µm), as before correction."""
    done = correction().program
    assert done is not None
    path = tmp_path / "corrected.ngc"
    path.write_bytes(done.source)
    moves = [move for move in interpret(path, startup="G17 G21 G40 G90 G94") if move.kind == "line"]
    centres = np.array([moves[0].start_mm, *(move.end_mm for move in moves)]) + np.array([0.0, 0.0, 3.0])
    np.testing.assert_allclose(centres, ball_centres(done.source, 3.0), atol=1e-9)
    u, v = np.random.default_rng(5).uniform(0.05, 0.95, (2, 300))
    surface = correction().surface.surface
    left = left_on_mm(centres, 3.0, surface.point_mm(u, v), surface.normal(u, v))
    assert np.max(left) < 0.0255
    assert np.min(left) > -0.0055


def test_parts_that_are_excluded_stay_out_of_the_pattern_and_make_it_less_certain() -> None:
    fewer = pattern_model(inputs().surface, parts(), replace(inputs().options, exclude=("S02", "S09")))
    assert fewer.pattern.names == ("S01", "S03", "S04", "S05", "S06", "S07", "S08", "S10")
    at = np.linspace(0, 1, 9)
    assert np.mean(fewer.pattern.uncertainty_grid_mm(at, at)) > np.mean(model().pattern.uncertainty_grid_mm(at, at))


def test_a_scan_of_many_points_is_averaged_over_cells() -> None:
    rng = np.random.default_rng(3)
    u, v = rng.uniform(0, 1, (2, 60_000))
    surface = inputs().surface
    process = published_process(np.random.default_rng(1), pattern_mm=0.010)
    error = process.pattern.value_mm(u, v) + rng.normal(0, 0.004, len(u))
    points = surface.point_mm(u, v) + error[:, None] * surface.normal(u, v)
    scanned = surface_deviations(surface, MeasuredPoints(points, name="scan"))
    places, means = averaged_over_cells(surface, scanned, (40, 40))
    found = separate(places, means, near=Neighbourhood(places))
    at = np.linspace(0.05, 0.95, 30)
    off = found.deterministic.grid_mm(at, at) - process.pattern.grid_mm(at, at)
    assert np.sqrt(np.mean(off**2)) < 0.0006
    assert found.sigma_mm == pytest.approx(0.004 / np.sqrt(60_000 / 1600), rel=0.2)


def test_a_scan_of_some_thousand_scattered_points_needs_no_cells() -> None:
    rng = np.random.default_rng(3)
    u, v = rng.uniform(0, 1, (2, 6000))
    surface = inputs().surface
    pattern = published_process(np.random.default_rng(1), pattern_mm=0.010, controls=6).pattern
    error = pattern.value_mm(u, v) + rng.normal(0, 0.004, len(u))
    places = Places(surface.point_mm(u, v), u, v)
    found = separate(places, error, near=Neighbourhood(places))
    at = np.linspace(0.05, 0.95, 30)
    off = found.deterministic.grid_mm(at, at) - pattern.grid_mm(at, at)
    assert np.sqrt(np.mean(off**2)) < 0.0006
    assert found.sigma_mm == pytest.approx(0.004, rel=0.05)
    assert found.permutation_p > 0.005


@pytest.mark.corpus
def test_surfaces_of_others_go_through_deviation_model_and_corrected_step(corpus: Path, tmp_path: Path) -> None:
    """The outer cylinder of a STEP AP214 solid and a patch of a lens in IGES 128."""
    cad = corpus / "data/public/cad"
    rng = np.random.default_rng(8)
    for face in (read_faces(cad / "conical-surface.step")[0], read_faces(cad / "sunglasses-lens.igs")[4]):
        surface = face.surface
        (u0, u1), (v0, v1) = surface.domain
        at = np.linspace(0.02, 0.98, 25)
        u, v = np.repeat(at, 25), np.tile(at, 25)
        wide = (u0 + (u1 - u0) * u, v0 + (v1 - v0) * v)
        process = published_process(rng, controls=6)
        error = process.pattern.value_mm(u, v) + rng.normal(0, 0.002, 625)
        touched = surface.point_mm(*wide) + (0.5 + error)[:, None] * surface.normal(*wide)
        options = replace(inputs().options, best_fit=False)
        (part,) = model_of(surface, [MeasuredPoints(touched, 0.5, (25, 25), "other")], options)
        np.testing.assert_allclose(part.deviations.error_mm, error, atol=1e-9)
        corrected = corrected_surface(surface, part.separation.deterministic, tolerance_mm=1e-4)
        write_surface(corrected.surface, tmp_path / "corrected.step")
        again = named_faces(tmp_path / "corrected.step")[0].surface
        feet = closest(again, corrected.surface.point_mm(u, v))
        assert np.max(np.abs(feet.distance_mm)) < 1e-6
        shift = closest(again, surface.point_mm(*wide)).distance_mm
        np.testing.assert_allclose(shift, part.separation.deterministic.value_mm(u, v), atol=3e-4)
