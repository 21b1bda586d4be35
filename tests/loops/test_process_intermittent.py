"""The loop on the published parts: the corrected program is measured on its own tool path."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.correction import example_inputs
from tests.support.standoff import feed_moves_of, standoff_mm
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion
from trueloop.turned.fit.between_cuts import PRIOR
from trueloop.turned.fit.chain_fit import TangentPolicy

EXAMPLES = Path(__file__).parents[2] / "examples"
WITHIN_MM = 0.0002


def inputs_of(part: str) -> Inputs:
    return read_job(EXAMPLES / part / "job.toml").inputs


def with_errors(inputs: Inputs, error_mm: Array) -> Inputs:
    return replace(inputs, touches=replace(inputs.touches, error_mm=error_mm))


def standoffs(correction: Correction, inputs: Inputs, source: bytes) -> Array:
    """Of the contour that a program cuts, at the touches."""
    program = read_program(source, correction.dialect)
    moves = feed_moves_of(program.run(inputs.parameters))
    pairs = zip(correction.touches.nominal_mm, correction.touches.outward_normal, strict=True)
    return np.array([standoff_mm(moves, point, normal, correction.nose_radius_mm) for point, normal in pairs])


def moved(correction: Correction, inputs: Inputs) -> Array:
    """How far correcting moved the contour at the touches."""
    return standoffs(correction, inputs, correction.corrected_program) - standoffs(
        correction, inputs, correction.source_program
    )


def of_slope_mm(correction: Correction) -> Array:
    """R e′² of the arcs at the touches; all of them are convex."""
    touches = correction.touches
    along = zip(touches.feature_index, touches.arc_length_mm, strict=True)
    slope = np.array([float(correction.model.curves[i].slope(s)[0]) for i, s in along])
    features = [correction.profile.features[i] for i in touches.feature_index]
    radius = np.array([feature.radius_mm if isinstance(feature, Arc) else 0.0 for feature in features])
    term: Array = np.minimum(radius * slope**2, 0.001)
    return term


@pytest.mark.parametrize("weight", [1.0, 0.6])
@pytest.mark.parametrize("part", ["modbas2", "piecs11", "facetst"])
def test_the_corrected_program_moves_the_contour_by_minus_w_times_the_fitted_error(part: str, weight: float) -> None:
    inputs = inputs_of(part)
    inputs = replace(inputs, options=replace(inputs.options, weight=weight))
    correction = compensate(inputs)
    fitted = correction.model.vectors.error_mm - correction.model.residual_mm
    assert np.abs(moved(correction, inputs) + weight * fitted).max() < WITHIN_MM


@pytest.mark.parametrize("part", ["modbas2", "piecs11"])
def test_where_errors_follow_the_nose_arcs_move_by_what_their_slope_asks_for_besides(part: str) -> None:
    inputs = inputs_of(part)
    inputs = replace(inputs, options=replace(inputs.options, errors_follow="nose"))
    correction = compensate(inputs)
    fitted = correction.model.vectors.error_mm - correction.model.residual_mm
    term_mm = of_slope_mm(correction)
    assert term_mm.max() > 2 * WITHIN_MM
    assert np.abs(moved(correction, inputs) + fitted + term_mm).max() < WITHIN_MM


@pytest.mark.parametrize("part", ["modbas2", "piecs11"])
def test_the_band_holds_what_is_left_where_nobody_says_that_errors_follow_the_nose(part: str) -> None:
    inputs = inputs_of(part)
    by_place = compensate(inputs)
    by_nose = compensate(replace(inputs, options=replace(inputs.options, errors_follow="nose")))
    told, untold = by_nose.prediction.standard_u_mm, by_place.prediction.standard_u_mm
    np.testing.assert_allclose(np.sqrt(untold**2 - told**2), of_slope_mm(by_place) / np.sqrt(3.0), atol=1e-9)
    for index in range(len(by_place.profile.features)):
        rows = by_place.touches.of_feature(index)
        drawn = by_place.next_cut(index, by_place.touches.arc_length_mm[rows]).standard_u_mm
        np.testing.assert_allclose(drawn, untold[rows], rtol=1e-12)


def test_prediction_on_the_dome_of_table_1() -> None:
    """NISTIR 6517 Table 1: the finish cut left 3.9 µm RMS on the dome; the slope-free fit predicts at most 1.3."""
    correction = compensate(inputs_of("modbas2"))
    dome = correction.touches.of_feature(correction.profile.names.index("dome"))
    assert np.sqrt(np.mean(correction.prediction.after_mm[dome] ** 2)) < 0.0013
    assert np.all(correction.prediction.standard_u_mm > 0)


def test_path_policy_closes_the_junction_in_value_and_slope() -> None:
    """Gap under 1 nm and slope mismatch under 1 µrad between small cylinder and dome."""
    inputs = inputs_of("modbas2")
    options = replace(inputs.options, junctions=TangentPolicy.PATH, knot_every=3)
    correction = compensate(replace(inputs, options=options))
    names = correction.profile.names
    contour = [piece.shifted for piece in correction.corrected]
    line, dome = contour[names.index("small-cylinder")], contour[names.index("dome")]
    length = line.feature.length_mm
    assert np.linalg.norm(line.contour_mm(length) - dome.contour_mm(0.0)) < 1e-6
    cross = line.tangent(length)[0] * dome.tangent(0.0)[1] - line.tangent(length)[1] * dome.tangent(0.0)[0]
    assert abs(cross) < 1e-6


def test_part_policy_closes_the_junction_and_lets_it_kink() -> None:
    correction = compensate(inputs_of("modbas2"))
    names = correction.profile.names
    contour = [piece.shifted for piece in correction.corrected]
    line, dome = contour[names.index("small-cylinder")], contour[names.index("dome")]
    assert np.linalg.norm(line.contour_mm(line.feature.length_mm) - dome.contour_mm(0.0)) < 1e-6
    kink = dome.tangent(0.0) - line.tangent(line.feature.length_mm)
    assert 1e-4 < np.linalg.norm(kink) < 2e-2


def test_corner_of_knob_and_cone_closes_exactly_with_its_slope_free() -> None:
    correction = compensate(inputs_of("piecs11"))
    names = correction.profile.names
    cone, knob = correction.corrected[names.index("cone")], correction.corrected[names.index("knob")]
    gap = cone.shifted.centre_mm(cone.end_mm) - knob.shifted.centre_mm(knob.start_mm)
    assert np.linalg.norm(gap) < 1e-9
    assert correction.model.curves[names.index("knob")].conditions.start_slope is None


def test_tapers_are_found_on_the_stepped_part() -> None:
    """FACETST part 1411.559 (NISTIR 6811 Table 4): +3…+13 µm along the large cylinder, −4…−17 µm along the small."""
    correction = compensate(inputs_of("facetst"))
    slopes = dict(zip(correction.profile.names, (float(c.slope(1.0)[0]) for c in correction.model.curves), strict=True))
    assert slopes["large-cylinder"] > 0 > slopes["small-cylinder"]
    assert not correction.decision.offset_is_enough


def test_pure_size_error_changes_offsets_and_leaves_the_path() -> None:
    """+20 µm on every cylinder: the X offset takes it out, coordinates stay as programmed [6811 §3.2]."""
    inputs = inputs_of("facetst")
    size_mm = inputs.touches.outward_normal @ [0.020, 0.0]
    jitter_mm = 0.0002 * np.array([1, -1] * 7 + [1])
    correction = compensate(with_errors(inputs, size_mm + jitter_mm))
    assert correction.decision.offset_is_enough
    before, after = (read_program(s, "ge2000t") for s in (correction.source_program, correction.corrected_program))
    assert np.array_equal(before.run(inputs.parameters).end_mm, after.run(inputs.parameters).end_mm)
    offset = {s.axis: s.value for s in after.offset_statements}
    assert offset["X"] == pytest.approx(-0.040 / 25.4, abs=1e-5)  # a diameter, in inches
    assert offset["Z"] == pytest.approx(0.0, abs=1e-5)
    assert correction.prediction.after_mm == pytest.approx(0.0, abs=3e-4)


def test_the_mark_names_parameters_with_every_digit() -> None:
    inputs = inputs_of("facetst")
    correction = compensate(replace(inputs, parameters={**inputs.parameters, "P47": 1.23456789e-05}))
    assert b"P47=1.23456789e-05" in correction.corrected_program


def test_the_table_corrects_by_what_the_offset_would() -> None:
    """+20 µm on every cylinder: a control that corrects by the table takes 20 µm off the radius everywhere."""
    inputs = inputs_of("facetst")
    correction = compensate(with_errors(inputs, inputs.touches.outward_normal @ [0.020, 0.0]))
    assert correction.decision.offset_is_enough
    assert correction.table.correction_mm[:, 0] == pytest.approx(-0.020, abs=1e-9)
    assert correction.table.correction_mm[:, 1] == pytest.approx(0.0, abs=1e-9)


def test_offsets_as_radius_when_the_control_reads_them_so() -> None:
    inputs = inputs_of("facetst")
    inputs = replace(inputs, options=replace(inputs.options, offset_is_diameter=False))
    correction = compensate(with_errors(inputs, inputs.touches.outward_normal @ [0.020, 0.0]))
    offset = {s.axis: s.value for s in read_program(correction.corrected_program, "ge2000t").offset_statements}
    assert offset["X"] == pytest.approx(-0.020 / 25.4, abs=1e-5)


def test_oversize_cuts_deeper_and_a_diameter_word_moves_twice_the_error() -> None:
    """The commonest blunder, both ways at once: sign and factor of two, on the word that a machinist reads."""
    inputs = inputs_of("facetst")
    large = inputs.touches.of_feature(inputs.profile.names.index("large-cylinder"))
    error_mm = np.zeros(len(inputs.touches.point))
    error_mm[large] = 0.0254
    correction = compensate(with_errors(inputs, error_mm))
    line = next(t for t in correction.corrected_program.decode().splitlines() if "Large cylinder" in t)
    assert "X(P46+0.0625+P47-0.00200)" in line or "X(P46+0.0625+P47-0.002)" in line  # 2 × 0.001 in on the diameter


def test_a_mock_error_of_the_program_is_kept_apart() -> None:
    """P47 = 0.002 in tapers both programs' large cylinder; touches that show just that find no error of the process."""
    inputs = inputs_of("facetst")
    inputs = replace(inputs, parameters={**inputs.parameters, "P47": 0.002})
    cylinder = inputs.profile.names.index("large-cylinder")
    s, length = inputs.touches.arc_length_mm, inputs.profile.features[cylinder].length_mm
    cut_mm = length + inputs.nose_radius_mm  # the cut goes on beyond the convex corner by the nose radius
    mock_mm = np.where(inputs.touches.feature_index == cylinder, 0.001 * 25.4 * s / cut_mm, 0.0)
    correction = compensate(with_errors(inputs, mock_mm))
    assert correction.model.vectors.error_mm == pytest.approx(0.0, abs=2e-4)
    assert any("large-cylinder" in note and "not blamed on the process" in note for note in correction.notes)


def test_reversed_program_gets_the_same_contour() -> None:
    """Cut from the free end towards the chuck, as most shops do, the contour must come out the same."""
    inputs = inputs_of("facetst")
    forward = compensate(inputs)
    source = b"\n".join(
        [
            b"N10 G70 G95",
            b"N20 G00 X6.2625 Z0.5",
            b"N30 G01 F.005 X-0.03125 Z0.03125",
            b"N40 X1.7825",
            b"N50 Z-1.96875",
            b"N60 X5.6825",
            b"N70 Z-3.96875",
            b"N80 G00 X6.5",
            b"N90 M30",
            b"",
        ]
    )
    backward_inputs = replace(inputs, program=read_program(source, "ge2000t"), semifinish=None)
    backward = compensate(backward_inputs)
    assert standoffs(backward, backward_inputs, backward.corrected_program) == pytest.approx(
        standoffs(forward, inputs, forward.corrected_program), abs=WITHIN_MM
    )


def test_fit_options_reach_the_fit() -> None:
    inputs = inputs_of("modbas2")
    correction = compensate(replace(inputs, options=replace(inputs.options, knot_every=3)))
    assert correction.model.options == correction.options
    assert (correction.options.knot_every, correction.options.between_cuts) == (3, PRIOR)


def test_same_job_same_record_and_same_bytes() -> None:
    first, second = compensate(inputs_of("modbas2")), compensate(inputs_of("modbas2"))
    assert first.record.id == second.record.id
    assert first.corrected_program == second.corrected_program


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_arcs_written_with_a_radius_stay_within_a_quadrant(sign: float) -> None:
    """The GE 2000T takes R arcs of one quadrant only [6811 §A.1.1]; a correction can tilt the dome's top past it.

    Rounding the ends of a short arc shifts its centre by some hundredths of a millimetre.
    """
    inputs = inputs_of("modbas2")
    correction = compensate(with_errors(inputs, sign * inputs.touches.error_mm))
    path = read_program(correction.corrected_program, "ge2000t").run(inputs.parameters)
    arcs = np.flatnonzero(path.motion == Motion.ARC)
    assert len(arcs) > 4
    for k in arcs:
        arms = np.array([path.start_mm[k] - path.centre_mm[k], path.end_mm[k] - path.centre_mm[k]])[:, [0, 2]]
        assert np.all((arms.min(axis=0) > -0.05) | (arms.max(axis=0) < 0.05))


def test_what_a_job_says_of_one_feature_s_curve_is_held_to(tmp_path: Path) -> None:
    """µm and µm/mm of the job are mm and mm/mm of the curve; a feature that is not there is named."""
    folder = tmp_path / "modbas2"
    shutil.copytree(EXAMPLES / "modbas2", folder)
    job = folder / "job.toml"
    held = "[compensation.features.dome]\nknot_every = 4\nend_um = -3.0\nend_slope_um_per_mm = 0.25\n"
    job.write_text(job.read_text() + "\n[compensation]\nrepeatability_um = 2.0\n" + held)
    curve = compensate(read_job(job).inputs).model.curves[-1]
    assert curve.value_mm(curve.length_mm)[0] == pytest.approx(-0.003, abs=1e-12)
    assert curve.slope(curve.length_mm)[0] == pytest.approx(0.00025, abs=1e-12)
    assert (curve.knot_every, curve.repeatability_mm) == (4, 0.002)
    job.write_text(job.read_text().replace("features.dome", "features.doom"))
    with pytest.raises(TrueloopError, match="'doom'") as refusal:
        compensate(read_job(job).inputs)
    assert refusal.value.code is Code.FIT_KNOTS


def test_ranges_of_repeated_touches_are_read_in_micrometres(tmp_path: Path) -> None:
    """A rectangular distribution: the standard uncertainty is the range by √12, along x on cylinders, z on faces."""
    shutil.copytree(EXAMPLES / "facetst", tmp_path / "facetst")
    job = tmp_path / "facetst" / "job.toml"
    text = job.read_text()
    assert "repeatability_" not in text
    job.write_text(text.replace("[gauging]", "[gauging]\nrepeatability_diameter_um = 2.4\nrepeatability_face_um = 0.6"))
    touches = read_job(job).inputs.touches
    along_x = np.abs(touches.outward_normal[:, 0]) > 0.99
    along_z = np.abs(touches.outward_normal[:, 1]) > 0.99
    assert along_x.any() and along_z.any()
    np.testing.assert_allclose(touches.standard_u_mm[along_x], 0.0024 / np.sqrt(12), rtol=1e-6)
    both = np.where(touches.at_reference, 1.0, np.sqrt(2))  # the touch and the one that z is counted from
    np.testing.assert_allclose(touches.standard_u_mm[along_z], (both * 0.0006 / np.sqrt(12))[along_z], rtol=1e-6)


@pytest.mark.parametrize(("vague", "refuses"), [("all", True), ("one", False)])
def test_touches_that_are_all_vague_are_refused_and_a_vague_one_is_not(vague: str, refuses: bool) -> None:
    """A standard uncertainty of 50 µm where at most 10 µm may scatter: as large as what is to be corrected."""
    inputs = example_inputs("modbas2")
    u_mm = inputs.touches.standard_u_mm.copy()
    u_mm[slice(None) if vague == "all" else slice(5, 6)] = 0.050
    given = replace(inputs, touches=replace(inputs.touches, standard_u_mm=u_mm))
    if refuses:
        with pytest.raises(TrueloopError) as refused:
            compensate(given)
        assert refused.value.code is Code.CMP_SCATTER
    else:
        assert compensate(given).record.id
