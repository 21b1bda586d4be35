"""A face with air in it, places without points, and scatter: what is judged, refused and named."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.support.refusals import refused
from tests.support.surfaces import points_to_csv, square_places, wavy_surface
from trueloop.arrays import Array
from trueloop.domain.option import Limits
from trueloop.errors import Code
from trueloop.jobs.surface.job import correct_surface, read_surface
from trueloop.loops.surface.surface import SurfaceModel, correct, model_of, pattern_model
from trueloop.report.surface.maps import colour_range_um
from trueloop.report.surface.page import maps, surface_page
from trueloop.surface.compensation.shift import corrected_surface
from trueloop.surface.on_face import on_face
from trueloop.surface.separation.neighbourhood import Neighbourhood
from trueloop.surface.separation.separate import of_size, outlying_point
from trueloop.surface.separation.spline_surface import Size, SplineSurface

SIDE = 17
AT = np.linspace(0.01, 0.99, SIDE)
U, V = (a.ravel() for a in np.meshgrid(AT, AT, indexing="ij"))
SURFACE = wavy_surface()
NORMAL = SURFACE.normal(U, V)
JOB = 'name = "Wave"\n[surface]\nfile = "nominal.csv"\n[gauging]\npoints = ["parts/*.csv"]\n[compensation]\n{more}\n'


def steep(u: Array, v: Array) -> Array:
    """A pattern in mm that rises towards the notch: 0 far from it, 60 µm at it."""
    return np.asarray(0.06 * np.exp(-6 * np.hypot(u - 1, v - 0.5)) + 0.005 * np.sin(7 * u) * np.cos(6 * v))


def gentle(u: Array, v: Array) -> Array:
    return np.asarray(0.008 * np.sin(5 * u) * np.cos(4 * v))


def short(u: Array, v: Array) -> Array:
    return np.asarray(0.01 * np.sin(25 * u) * np.cos(25 * v))


def air(u: Array, v: Array) -> np.ndarray:
    """A notch of a fifth of the sides, in the edge u = 1."""
    return np.asarray((u > 0.78) & (np.abs(v - 0.5) < 0.12))


def job(
    folder: Path,
    missing: np.ndarray,
    errors: Callable[[int, Array], Array] = lambda _, form: form,
    form: Callable[[Array, Array], Array] = gentle,
    more: str = "",
) -> Path:
    """A job of four parts of one pattern, 1 µm of noise, with the points that are missing left out."""
    (folder / "parts").mkdir()
    x, y = np.meshgrid(np.linspace(0, 50, 21), np.linspace(0, 50, 21), indexing="ij")
    nominal = np.stack([x, y, 4.0 * np.sin(x / 14) * np.cos(y / 17)], axis=2)
    (folder / "nominal.csv").write_bytes(points_to_csv(nominal.reshape(-1, 3), (21, 21)))
    for k in range(4):
        made = errors(k, form(U, V) + np.random.default_rng(100 + k).normal(0, 0.001, len(U)))
        points = SURFACE.point_mm(U, V) + made[:, None] * NORMAL
        points[missing] = np.nan
        (folder / "parts" / f"S0{k + 1}.csv").write_bytes(points_to_csv(points, (SIDE, SIDE)))
    (folder / "job.toml").write_text(JOB.format(more=more))
    return folder / "job.toml"


def modelled(path: Path, trim: Callable[[Array, Array], np.ndarray] | None = None) -> SurfaceModel:
    inputs = read_surface(path).inputs
    return pattern_model(
        inputs.surface, model_of(inputs.surface, inputs.parts, inputs.options, trim=trim), inputs.options, trim=trim
    )


NONE = np.zeros(SIDE**2, bool)


def test_limits_are_judged_on_the_face_that_exists() -> None:
    """300 µm in the air are no reason to refuse; the same on the face are."""
    bump = np.zeros((12, 12))
    bump[10:, 5:7] = 0.3
    deviation = SplineSurface(Size(12, 12, 3), bump)
    upper, lower = on_face(SURFACE, lambda u, _: u <= 0.5), on_face(SURFACE, lambda u, _: u >= 0.5)
    assert refused(corrected_surface, SURFACE, deviation).code is Code.CMP_SIZE
    assert refused(partial(corrected_surface, SURFACE, deviation, there=upper)).code is Code.CMP_SIZE
    slopes = partial(corrected_surface, SURFACE, deviation, limits=Limits(1.0, 0.03), there=upper)
    assert refused(slopes).code is Code.CMP_SLOPE
    done = corrected_surface(SURFACE, deviation, there=lower)
    assert done.largest_shift_mm < 1e-9


def test_a_notch_is_air_to_limits_figures_maps_and_colours(tmp_path: Path) -> None:
    path = job(tmp_path, air(U, V), form=steep)
    trimmed, blind = modelled(path, air), modelled(path)
    assert trimmed.figures.unsupported < blind.figures.unsupported
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, 61), np.linspace(0, 1, 61), indexing="ij"))
    found = np.abs(trimmed.pattern.mean.value_mm(u, v))
    assert trimmed.figures.largest_mm == pytest.approx(np.max(found[~air(u, v)]))
    (shown,) = [one for one in maps(trimmed) if one.name == "pattern"]
    np.testing.assert_array_equal(np.isnan(shown.error_mm), air(*np.moveaxis(shown.uv, 2, 0)))
    largest = max(float(np.nanmax(np.abs(one.error_mm))) for one in maps(trimmed))
    assert colour_range_um(maps(trimmed)) < 1.4e3 * largest
    assert correct(trimmed).surface.largest_shift_mm < 0.06


def test_a_window_is_named_in_headline_finding_record_and_page(tmp_path: Path) -> None:
    def waves(u: Array, v: Array) -> Array:
        return np.asarray(0.012 * np.sin(19 * u + 4) * np.cos(17 * v) + 0.004 * u, float)

    window = (np.abs(U - 0.4) < 0.13) & (np.abs(V - 0.55) < 0.13)
    path = job(tmp_path, window, form=waves)
    found = modelled(path)
    (finding,) = [one for one in found.findings if one.code is Code.SRF_SUPPORT]
    share = f"{100 * found.figures.unsupported:.1f} % of the face is not supported by measurements: correction faded"
    assert finding.message.startswith(share)
    assert 0.03 < found.figures.unsupported < 0.15
    x, y, _ = found.figures.unsupported_at_mm
    assert abs(x - 20) < 9 and abs(y - 27.5) < 9
    page = surface_page("Wave", found)
    assert f"Support</span>{share}" in page
    assert page.count('<path class="bare"') == 2
    record = correct_surface(read_surface(path)).record
    support = record.model["support"]
    assert isinstance(support, dict)
    assert support["unsupported_percent"] == pytest.approx(100 * found.figures.unsupported)
    assert any(share in line for line in record.decision)
    at = np.linspace(0.28, 0.52, 20), np.linspace(0.43, 0.67, 20)
    u, v = np.meshgrid(*at, indexing="ij")
    assert np.max(np.abs(found.pattern.mean.grid_mm(*at) - waves(u, v))) < 0.018
    assert np.max(found.pattern.uncertainty_grid_mm(*at)) > 2 * found.figures.uncertainty_mm


def test_a_face_of_which_most_was_not_measured_is_refused_by_its_own_code(tmp_path: Path) -> None:
    path = job(tmp_path, U > 0.3, form=short)
    refusal = refused(correct_surface, read_surface(path))
    assert refusal.code is Code.SRF_SUPPORT
    assert refusal.override == "compensation.min_supported_percent in the job"
    path.write_text(JOB.format(more="min_supported_percent = 0.0"))
    assert correct_surface(read_surface(path)).record.model["support"]


def test_one_bad_touch_is_named_where_it_spoils_the_scatter(tmp_path: Path) -> None:
    bad = 5 * SIDE + 9

    def one_bad(part: int, form: Array) -> Array:
        return np.asarray(form + 0.4 * (np.arange(len(form)) == bad) * (part == 2))

    path = job(tmp_path, NONE, one_bad, more="max_scatter_um = 8")
    refusal = refused(correct_surface, read_surface(path))
    assert refusal.code is Code.CMP_SCATTER
    assert "'S03' scatters by" in refusal.message
    assert f"point {bad + 1} (row 6, column 10) of 'S03' lies +" in refusal.message
    (touch,) = [one for one in modelled(path).findings if one.code is Code.SRF_OUTLIER and "point" in one.message]
    assert str(touch).startswith(f"{tmp_path / 'parts' / 'S03.csv'}:{bad + 2}: warning")


def test_a_part_that_chattered_is_named_without_a_touch(tmp_path: Path) -> None:
    def chatter(part: int, form: Array) -> Array:
        return form + (part == 1) * np.random.default_rng(9).normal(0, 0.03, len(form))

    path = job(tmp_path, NONE, chatter)
    refusal = refused(correct_surface, read_surface(path))
    assert refusal.code is Code.CMP_SCATTER
    assert "'S02' scatters by" in refusal.message and "point" not in refusal.message


def test_waves_too_short_for_the_points_are_no_scatter(tmp_path: Path) -> None:
    """A wave of two steps of the grid, alike on all parts."""
    wave = np.where((np.arange(SIDE**2) % SIDE + np.arange(SIDE**2) // SIDE) % 2, -0.02, 0.02)
    path = job(tmp_path, NONE, lambda _, form: form + wave)
    refusal = refused(correct_surface, read_surface(path))
    assert refusal.code is Code.SRF_SUPPORT
    assert "alike on all 4 parts" in refusal.message


def test_clean_touches_are_called_odd_on_one_part_in_a_hundred() -> None:
    """Two hundred parts of nothing but noise; one touch ten standard deviations off is always found."""
    places, rng = square_places(12), np.random.default_rng(4)
    near = Neighbourhood(places)
    noise = rng.normal(0, 0.001, (200, 144))
    odd = [outlying_point(of_size(places, errors, Size(5, 5, 3), near)).p_value < 0.01 for errors in noise]
    assert np.count_nonzero(odd) <= 6
    noise[0, 77] -= 0.01
    found = outlying_point(of_size(places, noise[0], Size(5, 5, 3), near))
    assert (found.index, found.p_value < 1e-6) == (77, True)
    assert found.off_mm == pytest.approx(-0.01, abs=0.004)


def test_options_take_the_share_from_the_job(tmp_path: Path) -> None:
    inputs = read_surface(job(tmp_path, NONE, more="min_supported_percent = 80.0")).inputs
    assert inputs.options.least_supported == pytest.approx(0.8)
    assert replace(inputs.options, least_supported=0.5) == read_surface(_default(tmp_path)).inputs.options


def _default(folder: Path) -> Path:
    (folder / "job.toml").write_text(JOB.format(more=""))
    return folder / "job.toml"
