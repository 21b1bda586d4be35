"""The measurements planned next, judged by conditioning a normal distribution as a whole and by drawn parts."""

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_several_tools_in_machine import MACHINE, ZERO, placed
from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.jobs.measure.next_measurement import _edges, _nose_mm, _places, _size, _touch, plan_measurements
from trueloop.jobs.turned.job import read_cuts
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.next_measurement import OUT, Candidate, Edge, OfPart, next_measurements
from trueloop.turned.fit.prior.part_state import PartState, in_frame, places_on
from trueloop.turned.touches.touches import Gauging

EXAMPLES = Path(__file__).parents[2] / "examples"
SHAFT = EXAMPLES / "shaft" / "job.toml"


def edge_of(path: Path, asked: tuple[Characteristic, ...] = ()) -> Edge:
    """The only edge of a job with a touch of a probe at every place, one minute each."""
    cuts = read_cuts(JobFiles.of(path))
    profile = cuts.read.profile
    places = _places(profile, _nose_mm(cuts))
    seen = [(one.feature, "probe", _touch(profile, one, "probe", Gauging())) for one in places]
    (edge,) = _edges(cuts, seen, {"probe": 1.0, "micrometer": 1.0, "cmm": 1.0})  # type: ignore[arg-type]
    return replace(edge, characteristics=asked)


def part_of(edge: Edge) -> PartState:
    assert isinstance(edge.known, OfPart)
    return edge.known.state


def conditioned(edge: Edge, taken: list[Candidate], contour: tuple[Array, Array, Array]) -> float:
    """Mean square, µm², along the contour when these are measured too: C − C_m (C_mm + N)⁻¹ C_mᵀ, all at once."""
    index, along, share = contour
    state, profile = part_of(edge).updated.state, edge.profile
    at = np.concatenate([index, *(one.seen.feature_index for one in taken)]).astype(np.intp)
    s = np.concatenate([along, *(one.seen.arc_length_mm for one in taken)])
    covariance = state.predict(places_on(profile, at, s), repeatability=False).covariance_mm2
    scatter = state.sizes["repeatability"] ** 2
    n = len(index)
    noise = np.diag([one.seen.standard_u_mm**2 + scatter for one in taken])
    cross = covariance[:n, n:]
    left = covariance[:n, :n] - cross @ np.linalg.solve(covariance[n:, n:] + noise, cross.T)
    between = edge.known.between
    return 1e6 * (float(share @ np.diag(left)) + between.difference_mm**2 + scatter)


def contour_of(edge: Edge) -> tuple[Array, Array, Array]:
    """Nine places in the middle of equal stretches of each feature."""
    features = edge.profile.features
    index = np.repeat(np.arange(len(features)), 9)
    along = np.concatenate([one.length_mm * (np.arange(9) + 0.5) / 9 for one in features])
    share = np.repeat([one.length_mm for one in features], 9)
    return np.asarray(index, dtype=np.float64), along, share / share.sum()


def test_a_plan_expects_what_conditioning_on_all_of_it_at_once_gives() -> None:
    edge = edge_of(SHAFT)
    plan, contour = next_measurements([edge], 4), contour_of(edge)
    by_name = {one.seen.name: one for one in edge.candidates}
    assert plan.criterion == "rms_um" and len(plan.chosen) >= 2
    for count in range(len(plan.chosen) + 1):
        taken = [by_name[one.name] for one in plan.chosen[:count]]
        expected_um = math.sqrt(conditioned(edge, taken, contour))
        found = plan.before if count == 0 else plan.chosen[count - 1].after
        assert found == pytest.approx(expected_um, rel=1e-6)


def test_the_first_measurement_is_the_best_of_all_and_two_are_near_the_best_pair() -> None:
    edge = edge_of(SHAFT)
    contour, each = contour_of(edge), edge.candidates
    alone = {one.seen.name: conditioned(edge, [one], contour) for one in each}
    plan = next_measurements([edge], 2)
    assert plan.chosen[0].name == min(alone, key=alone.__getitem__)
    few = sorted(each, key=lambda one: alone[one.seen.name])[::4]
    best = min(conditioned(edge, list(pair), contour) for pair in itertools.combinations(few, 2))
    assert plan.chosen[1].after ** 2 <= 1.02 * best


def test_minutes_decide_between_instruments() -> None:
    """A touch that takes a hundred times as long is not taken, where another one is at hand that shows as much."""
    edge = edge_of(SHAFT)
    first = next_measurements([edge], 1).chosen[0].name
    slow = tuple(replace(one, minutes=100.0) if one.seen.name == first else one for one in edge.candidates)
    assert next_measurements([replace(edge, candidates=slow)], 1).chosen[0].name != first


def length(limit_mm: float) -> Characteristic:
    """The length of the shaft's untouched shoulder from the part's zero."""
    return Characteristic("12", Quantity.LENGTH, "shoulder-1", 12.0, 12.0 - limit_mm, 12.0 + limit_mm)


def test_limits_decide_what_is_measured_and_whether() -> None:
    narrow, wide = (next_measurements([edge_of(SHAFT, (length(limit),))], 5) for limit in (0.012, 0.4))
    assert narrow.criterion == wide.criterion == "probability_out"
    assert narrow.chosen[0].feature in ("shoulder-1", "shoulder-2", "end-face")
    assert narrow.after < narrow.before and narrow.worst == "12"
    assert wide.chosen == () and wide.enough and wide.before < OUT


def test_parts_drawn_from_what_is_known_come_out_as_often_as_the_plan_expects() -> None:
    """50,000 faces drawn where a correction by the expected error leaves them: the probability is a share of parts."""
    asked = length(0.012)
    edge = edge_of(SHAFT, (asked,))
    index = edge.profile.names.index("shoulder-1")
    middle_mm = edge.profile.features[index].length_mm / 2
    place = places_on(edge.profile, np.array([index]), np.array([middle_mm]))
    state, between = part_of(edge).updated.state, edge.known.between
    drawn = np.random.default_rng(5).standard_normal((4, 50_000))
    u_mm = [float(state.predict(place, repeatability=False).standard_u_mm[0]), state.sizes["repeatability"]]
    u_mm += [between.common_difference_mm, between.scatter_difference_mm]
    out = np.mean(np.abs(np.array(u_mm) @ drawn) > 0.012)
    assert next_measurements([edge], 1).before == pytest.approx(float(out), abs=0.01)


def test_a_diameter_that_has_to_be_in_everywhere_is_out_where_any_place_is() -> None:
    """Seven radii of a cylinder drawn together: what a cut does along it is alike over the cylinder's length."""
    edge = edge_of(SHAFT, (Characteristic("30", Quantity.DIAMETER, "seat-30", 30.0, 29.985, 30.015),))
    index = edge.profile.names.index("seat-30")
    length_mm = edge.profile.features[index].length_mm
    s = length_mm * np.linspace(0.02, 0.98, 7)
    state, between = part_of(edge).updated.state, edge.known.between
    covariance = state.predict(places_on(edge.profile, np.full(7, index), s), repeatability=False).covariance_mm2
    covariance = covariance + state.sizes["repeatability"] ** 2 * np.eye(7) + between.common_difference_mm**2
    apart = np.abs(np.subtract.outer(s, s)) / length_mm
    covariance = covariance + between.scatter_difference_mm**2 * np.exp(-apart)
    drawn = np.random.default_rng(5).multivariate_normal(np.zeros(7), covariance, 50_000)
    out = np.mean(np.max(np.abs(drawn), axis=1) > 0.0075)
    assert next_measurements([edge], 1).before == pytest.approx(float(out), abs=0.015)
    assert float(out) > 1.2 * np.max(np.mean(np.abs(drawn) > 0.0075, axis=0))


@pytest.mark.parametrize("name", ["two-sides/two-sides.toml", "grooved/grooved.toml", "piecs11/job.toml"])
def test_every_place_of_a_part_is_a_candidate_of_the_edge_that_cuts_it(name: str) -> None:
    """Several tools, two set-ups, one of which looks the other way, inches: the same place, whatever the frame."""
    cuts = read_cuts(JobFiles.of(EXAMPLES / name))
    profile, setups = cuts.read.profile, [(setup, cut) for setup in cuts.setups for cut in setup.cuts]
    places = {one.name: one for one in _places(profile, _nose_mm(cuts))}
    seen = [(one.feature, "probe", _touch(profile, one, "probe", Gauging())) for one in places.values()]
    edges = _edges(cuts, seen, {"probe": 1.0})  # type: ignore[arg-type]
    found = []
    for (setup, _), edge in zip(setups, edges, strict=True):
        for one in edge.candidates:
            point = edge.profile.features[int(one.seen.feature_index[0])].point_mm(float(one.seen.arc_length_mm[0]))
            expected = setup.frame.point(places[one.seen.name.removesuffix(" (probe)")].place_mm)
            assert point == pytest.approx(expected, abs=1e-6)
            found.append(one.seen.name)
    assert len(found) == len(set(found)) >= 0.9 * len(places)


def test_a_diameter_is_twice_the_error_and_a_length_the_difference_of_two_faces() -> None:
    profile = read_cuts(JobFiles.of(SHAFT)).read.profile
    seat = _size(profile, Characteristic("d", Quantity.DIAMETER, "seat-30", 30.0, at_z_mm=-20.0), Gauging())
    assert seat.weight == pytest.approx([2.0])
    apart = _size(profile, Characteristic("l", Quantity.LENGTH, "shoulder-1", 12.0, other="end-face"), Gauging())
    both = dict(zip((profile.names[i] for i in apart.feature_index), apart.weight, strict=True))
    assert both == pytest.approx({"shoulder-1": -1.0, "end-face": 1.0})


def test_a_part_that_was_not_measured_yet_is_planned_from_the_priors(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for file in ("job.toml", "finish.nc"):
        (tmp_path / file).write_bytes((SHAFT.parent / file).read_bytes())
    before, after = plan_measurements(tmp_path / "job.toml", 3), plan_measurements(SHAFT, 3)
    assert (before.measured, after.measured) == (False, True)
    assert before.plan.before > 2.0 * after.plan.before
    assert before.plan.chosen[-1].after < before.plan.before
    assert capfd.readouterr() == ("", "")


def test_tools_that_stand_in_a_machine_with_a_model_are_planned_as_without_it(tmp_path: Path) -> None:
    """The model takes its errors out of the touches; what is not known of the process stays within their scatter."""
    path = placed(tmp_path, MACHINE + f"work_zero_mm = {list(ZERO)}\n")
    inside = plan_measurements(path, 4).plan
    text = path.read_text()
    path.write_text(text.replace(MACHINE + f"work_zero_mm = {list(ZERO)}\n", ""))
    outside = plan_measurements(path, 4).plan
    assert inside.criterion == outside.criterion == "rms_um"
    assert 0.5 < inside.before / outside.before < 2.0
    assert inside.after <= inside.before


def test_limits_of_a_tool_of_whose_features_nothing_was_measured_are_weighed(tmp_path: Path) -> None:
    """The grooved part with its touches of the groove left out: the groove's own limits ask for one there."""
    given = EXAMPLES / "grooved"
    for file in ("finish.nc", "grooved.toml", "touches.csv"):
        (tmp_path / file).write_bytes((given / file).read_bytes())
    edges = _edges(read_cuts(JobFiles.of(tmp_path / "grooved.toml")), [], {})
    own = {name for edge in edges[1:] for name in edge.profile.names}
    rows = (tmp_path / "touches.csv").read_text().splitlines()
    kept = [row for row in rows if not any(f",{name}," in row for name in own)]
    assert len(kept) < len(rows)
    (tmp_path / "touches.csv").write_text("\n".join(kept) + "\n")
    name = edges[1].profile.names[0]
    text = (tmp_path / "grooved.toml").read_text()
    limits = (
        f'[[part.characteristic]]\nname = "groove"\nquantity = "length"\nfeature = "{name}"\ntolerance = "±0.01"\n\n'
    )
    at = text.index("\n[", text.index("[part]") + 5) + 1
    (tmp_path / "grooved.toml").write_text(text[:at] + limits + text[at:])
    plan = plan_measurements(tmp_path / "grooved.toml", 1).plan
    assert (plan.criterion, plan.worst) == ("probability_out", "groove")
    assert plan.chosen[0].feature in own


def test_the_face_that_z_was_taken_from_has_no_error_left_to_measure() -> None:
    """Its error is 0 by definition: with the other sign of its share it would be twice its own uncertainty."""
    edges = _edges(read_cuts(JobFiles.of(EXAMPLES / "dxf" / "job.toml")), [], {})
    states = [part_of(edge) for edge in edges if edge.vectors.at_reference.any()]
    assert states
    for state in states:
        k = np.flatnonzero(state.vectors.at_reference)
        there = state.vectors.feature_index[k], state.vectors.arc_length_mm[k]
        assert state.at(*there).standard_u_mm == pytest.approx([0.0], abs=1e-9)
        places, functional = in_frame(state.profile, state.vectors, *there)
        assert functional @ np.ones(len(places)) == pytest.approx([0.0])
