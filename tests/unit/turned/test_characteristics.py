"""Characteristics of whole corrections: values and uncertainties against the budget at single places."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.correction import example_inputs
from trueloop.domain.characteristic import Characteristic, Judged, Quantity
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.turned.touches.error_vectors import Seen

D1 = Characteristic("D1", Quantity.DIAMETER, "small-cylinder", 43.688, 43.668, 43.708)
L1 = Characteristic("L1", Quantity.LENGTH, "step-face", 50.8, 50.78, 50.82, other="end-face")


def judged(inputs: Inputs, *asked: Characteristic) -> tuple[Correction, tuple[Judged, ...]]:
    correction = compensate(replace(inputs, characteristics=asked))
    return correction, correction.characteristics


def finished(inputs: Inputs) -> Inputs:
    """The same were the touches those of the finished part."""
    return replace(inputs, semifinish=None, allowance_mm=0.0)


def test_a_diameter_has_twice_the_uncertainty_of_its_place() -> None:
    correction, (one,) = judged(example_inputs("facetst"), replace(D1, at_z_mm=-20.0))
    at = np.array([correction.profile.features[2].locate((21.844, -20.0))[0]])
    budget = correction.next_cut(2, at)

    assert one.after.standard_u == pytest.approx(2.0 * budget.standard_u_mm[0], rel=1e-9)
    assert one.after.value == pytest.approx(43.688, abs=1e-6)
    assert one.before is None  # the semi-finish cut was touched


def test_without_a_correction_a_diameter_keeps_twice_its_error() -> None:
    """Half of it taken out leaves half: 43.688 + 2 · ½ · 5 µm."""
    inputs = example_inputs("facetst")
    five = replace(inputs.touches, error_mm=0.005 * np.abs(inputs.touches.outward_normal[:, 0]))
    options = replace(inputs.options, weight=0.5, by="contour")
    _, (one,) = judged(replace(inputs, touches=five, options=options), D1)

    assert one.after.value == pytest.approx(43.688 + 0.005, abs=2e-5)


def test_a_finished_part_is_judged_as_measured() -> None:
    inputs = finished(example_inputs("facetst"))
    large = replace(inputs.touches, error_mm=0.012 * np.abs(inputs.touches.outward_normal[:, 0]))
    _, (one,) = judged(replace(inputs, touches=large), D1)

    assert one.before is not None
    assert one.before.verdict == "out"
    assert one.before.value == pytest.approx(43.712, abs=2e-5)
    assert one.before.margin == pytest.approx(-0.004, abs=2e-5)
    assert (one.after.probability_in or 0.0) > 0.95


def test_what_moves_a_whole_cut_changes_no_length_between_faces() -> None:
    inputs = example_inputs("facetst")
    options = inputs.options
    whole = replace(options.between_cuts, common_mm=0.02, scatter_mm=0.0)
    alike = replace(options.between_cuts, common_mm=0.0, scatter_mm=0.0)
    u = [judged(replace(inputs, options=replace(options, between_cuts=one)), L1, D1)[1] for one in (whole, alike)]

    assert u[0][0].after.standard_u == pytest.approx(u[1][0].after.standard_u)
    difference = np.sqrt(u[0][1].after.standard_u ** 2 - u[1][1].after.standard_u ** 2)
    assert difference == pytest.approx(2.0 * np.sqrt(2.0) * 0.02, rel=1e-6)  # of a diameter all of it


def test_several_sizes_are_judged_by_the_worst() -> None:
    """The cylinder tapers by 20 µm on the diameter: its end is out, its middle in."""
    inputs = finished(example_inputs("facetst"))
    touches, index = inputs.touches, 2
    on_it = touches.feature_index == index
    along = touches.arc_length_mm / inputs.profile.features[index].length_mm - 0.5
    tapered = replace(touches, error_mm=np.where(on_it, 0.020 * along, 0.0))
    tight = replace(D1, lower_limit=43.688 - 0.008, upper_limit=43.688 + 0.030)
    _, (everywhere, in_the_middle) = judged(
        replace(inputs, touches=tapered), tight, replace(tight, name="D2", at_z_mm=-25.4)
    )

    assert everywhere.before is not None and in_the_middle.before is not None
    assert everywhere.before.verdict == "out"
    assert in_the_middle.before.verdict == "in"


def programmed_taper() -> Inputs:
    """A finished part without an error, whose program cuts the large cylinder's end larger by 0.002 inch."""
    inputs = finished(example_inputs("facetst"))
    none = replace(inputs.touches, error_mm=np.zeros(len(inputs.touches.error_mm)))
    return replace(inputs, touches=none, parameters={**inputs.parameters, "P47": 0.002})


D2 = Characteristic("D2", Quantity.DIAMETER, "large-cylinder", 142.748, 142.728, 142.768, at_z_mm=-60.0)


def test_what_was_commanded_is_part_of_what_was_measured() -> None:
    """The touches are on the nominal: so is the size, though the process took off what the program left on."""
    _, (one,) = judged(programmed_taper(), D2)

    assert one.before is not None
    assert one.before.value == pytest.approx(142.748, abs=1e-4)


def test_an_offset_leaves_what_the_program_commands_off_the_profile() -> None:
    """The next cut is the last one moved by the offset."""
    inputs = programmed_taper()
    correction, (one,) = judged(replace(inputs, options=replace(inputs.options, by="offset")), D2)

    assert one.after.value == pytest.approx(142.748 + 2.0 * correction.decision.offset_mm[0], abs=1e-4)
    assert abs(correction.decision.offset_mm[0]) > 1e-3


def test_at_a_touch_a_size_is_as_it_was_touched() -> None:
    inputs = finished(example_inputs("facetst"))
    k = inputs.touches.point.index("10")
    _, (one,) = judged(inputs, replace(D1, at_z_mm=float(inputs.touches.nominal_mm[k, 1])))

    assert one.before is not None
    assert one.before.value == pytest.approx(43.688 - 0.016, abs=1e-9)
    assert one.before.standard_u == pytest.approx(2.0 * inputs.touches.standard_u_mm[k])


def test_a_place_touched_twice_is_at_the_mean_of_both() -> None:
    inputs = finished(example_inputs("facetst"))
    touches = inputs.touches
    k = touches.point.index("10")
    twice = touches.chosen([*range(k + 1), k, *range(k + 1, len(touches.point))])
    arc_length, error = twice.arc_length_mm.copy(), twice.error_mm.copy()
    arc_length[k + 1], error[k + 1] = arc_length[k] + 0.02, error[k] + 0.002
    names = (*twice.point[: k + 1], "10 again", *twice.point[k + 2 :])
    again = replace(twice, point=names, arc_length_mm=arc_length, error_mm=error)
    at_z_mm = float(touches.nominal_mm[k, 1])
    _, (one,) = judged(replace(inputs, touches=again), replace(D1, at_z_mm=at_z_mm))

    assert one.before is not None
    assert one.before.value == pytest.approx(43.688 - 0.016 + 0.002, abs=1e-9)


def test_a_length_that_was_read_is_as_it_was_read() -> None:
    """13 µm too long to 2 µm, whatever its faces were touched at: 50.8 + 0.013, 7 µm inside its upper limit."""
    inputs = finished(example_inputs("facetst"))
    index = [inputs.profile.names.index(name) for name in (L1.feature, L1.other)]
    faces = [inputs.profile.features[k] for k in index]
    beyond = np.sign(faces[0].start_mm[1] - faces[1].start_mm[1])
    weights = beyond * np.array([1.0, -1.0]) * [float(face.outward_normal(0.0)[1]) for face in faces]
    places = tuple((k, 0.5 * face.length_mm, w) for k, face, w in zip(index, faces, weights.tolist(), strict=True))
    read = replace(inputs.touches, seen=(Seen.at("L1", places, 0.013, 0.002),))
    _, (one,) = judged(replace(inputs, touches=read), L1)

    assert one.before is not None and one.before.verdict == "in"
    assert (one.before.value, one.before.standard_u) == pytest.approx((50.813, 0.002), abs=1e-9)


def test_between_touches_the_part_scatters_about_its_curve() -> None:
    correction, (one,) = judged(finished(example_inputs("facetst")), replace(D1, at_z_mm=-25.0))
    curve, s = correction.model.curves[2], np.array([25.8])

    assert one.before is not None
    expected = np.hypot(curve.standard_deviation_mm(s)[0], curve.repeatability_mm)
    assert one.before.standard_u == pytest.approx(2.0 * expected, rel=1e-6)


def test_a_face_counts_from_the_reference_touch_of_its_own_cut() -> None:
    """What moves a whole cut moves the part's zero; how the cut scatters is in the face and in the reference."""
    inputs = example_inputs("facetst")
    from_zero = replace(L1, other="")

    def variance(**options: object) -> float:
        between = replace(inputs.options.between_cuts, scatter_mm=0.0, **options.pop("between", {}))  # type: ignore[arg-type]
        chosen = replace(inputs.options, between_cuts=between, **options)  # type: ignore[arg-type]
        return judged(replace(inputs, options=chosen), from_zero)[1][0].after.standard_u ** 2

    assert variance(between={"common_mm": 0.0}) == pytest.approx(variance(between={"common_mm": 0.02}))
    more = variance(repeatability_mm=0.004) - variance(repeatability_mm=0.002)
    assert more == pytest.approx((0.004**2 - 0.002**2) * (1.0 + 1.0 / 4.0))  # four touches on the face, one reference
