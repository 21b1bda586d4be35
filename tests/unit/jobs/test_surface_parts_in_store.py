"""Parts of a surface in the store: added one by one they give what all at once give; others are refused."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.surface_parts import NOMINAL, U, V, job, part
from tests.support.surfaces import random_surface, wavy_surface
from trueloop.domain.inspection import Inspection
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.surface.job import ReadSurface, pattern_of_parts
from trueloop.jobs.surface.kept_parts import AddedPart, Together, add_parts, keep_parts, measured_of, with_kept_parts
from trueloop.loops.surface.over_parts import BEYOND_DOUBT, NoticedPart, as_findings, notice_in_order
from trueloop.loops.surface.surface import SurfaceModel, model_of
from trueloop.memory.noticing import What
from trueloop.storage.store import Store, find, open_store
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.surface.options import SurfaceOptions


@pytest.fixture
def store() -> Store:
    return open_store("sqlite://", create=True, codec=store_codec())


def model(read: ReadSurface) -> SurfaceModel:
    given = read.inputs
    return pattern_of_parts(read, model_of(given.surface, given.parts, given.options, trim=given.trim))


def add(store: Store, *parts: MeasuredPoints) -> AddedPart:
    together, notes = with_kept_parts(store, job(parts))
    return add_parts(Together(together, store, notes))


def test_parts_one_by_one_give_the_pattern_of_all_at_once(store: Store) -> None:
    parts = [part(k) for k in range(4)]
    for one in parts[:-1]:
        keep_parts(store, job([one]))
    together, notes = with_kept_parts(store, job(parts[-1:]))
    found, batch = model(together), model(job(parts))
    assert notes == () and together.inputs.earlier == 3
    assert found.pattern.names == batch.pattern.names == tuple(one.name for one in parts)
    np.testing.assert_array_equal(found.pattern.mean.coefficients_mm, batch.pattern.mean.coefficients_mm)
    assert found.figures == batch.figures


def test_a_part_of_the_job_that_is_kept_already_counts_once(store: Store) -> None:
    parts = [part(k) for k in range(4)]
    first = add(store, *parts)
    assert first.parts == 4 and len(find(store, Inspection)) == 4
    again = add(store, *parts)
    assert again.parts == 4 and again.kept.new == () and len(find(store, Inspection)) == 4


@pytest.mark.parametrize("ball_radius_mm", [0.0, 2.0])
def test_points_come_back_to_the_last_bit_with_their_holes(store: Store, ball_radius_mm: float) -> None:
    grid = part(1, ball_radius_mm=ball_radius_mm)
    holed = grid.points_mm.copy()
    holed[[0, 17, 100]] = np.nan
    scattered = MeasuredPoints(grid.points_mm[5:90], ball_radius_mm, None, "S02")
    keep_parts(store, job([replace(grid, points_mm=holed), scattered]))
    one, two = (measured_of(kept.value) for kept in find(store, Inspection))
    np.testing.assert_array_equal(one.points_mm, holed)
    np.testing.assert_array_equal(two.points_mm, scattered.points_mm)
    assert one.shape == grid.shape and two.shape is None
    assert one.ball_radius_mm == two.ball_radius_mm == ball_radius_mm


def test_parts_of_another_program_do_not_count(store: Store) -> None:
    keep_parts(store, job([part(k) for k in range(4)]))
    keep_parts(store, job([part(9)], program_sha256="b" * 64))
    together, (note,) = with_kept_parts(store, job([part(5)]))
    assert [one.name for one in together.inputs.parts] == ["S00", "S01", "S02", "S03", "S05"]
    assert "S09" in note and "another program" in note
    unstated, (note,) = with_kept_parts(store, job([part(5)], program_sha256=""))
    assert len(unstated.inputs.parts) == 1 and "not stated" in note


def test_parts_of_another_name_are_not_looked_at(store: Store) -> None:
    keep_parts(store, job([part(1)], name="Bowl", surface=wavy_surface(height_mm=2.0)))
    assert with_kept_parts(store, job([part(2)]))[0].inputs.earlier == 0


@pytest.mark.parametrize(
    "other",
    [
        job([part(2)], surface=wavy_surface(height_mm=4.01)),
        job([part(2)], surface=NOMINAL.turned_over()),
        job([part(2)], options=SurfaceOptions(best_fit=True)),
    ],
    ids=["0.01 mm higher", "normals turned over", "aligned otherwise"],
)
def test_parts_of_another_surface_under_one_name_are_refused(store: Store, other: ReadSurface) -> None:
    keep_parts(store, job([part(1)]))
    with pytest.raises(TrueloopError) as refused:
        with_kept_parts(store, other)
    assert refused.value.code is Code.SRF_STORED and "'S01'" in refused.value.message


def test_the_same_bytes_under_another_name_are_refused(store: Store) -> None:
    keep_parts(store, job([part(1)]))
    with pytest.raises(TrueloopError) as refused:
        with_kept_parts(store, job([replace(part(1), name="copy")]))
    assert refused.value.code is Code.SRF_TWICE


def test_old_parts_in_the_store_do_not_make_todays_old(store: Store) -> None:
    from datetime import UTC, datetime

    def measured(read: ReadSurface, year: int) -> ReadSurface:
        at = datetime(year, 1, 1, tzinfo=UTC)
        dated = tuple(replace(one, measured_at=at) for one in read.inputs.inspections)
        return replace(read, inputs=replace(read.inputs, inspections=dated))

    keep_parts(store, measured(job([part(1)]), 2020))
    together, _ = with_kept_parts(store, measured(job([part(2)]), 2026))
    assert together.inputs.measured_at == datetime(2026, 1, 1, tzinfo=UTC)


def test_a_pattern_that_changes_from_part_to_part_is_noticed(store: Store) -> None:
    """By 4 µm a part; without that nothing is."""
    names = [f"S{k:02d}" for k in range(6)]
    for growth_um, alarms in ((0.0, []), (4.0, [What.DRIFT])):
        given = job([part(k, more_um=growth_um * k * np.sin(4 * U)) for k in range(6)]).inputs
        apart = model_of(given.surface, given.parts, given.options)
        (last,) = notice_in_order(apart, names[-1:])
        assert [alarm.what for alarm in last.alarms] == alarms
    (finding,) = as_findings(last)
    assert finding.code is Code.SRF_DRIFT and "changes by" in finding.message and "cutter wears" in finding.message


def test_an_outlying_part_is_named_and_does_not_count(store: Store) -> None:
    """Another form of 80 µm: the pattern is that of the other parts, to the last digit."""
    parts = [part(k) for k in range(6)]
    odd = part(6, more_um=80 * np.sin(6 * U) * np.sin(6 * V))
    (finding,) = add(store, *parts, odd).findings
    assert finding.code is Code.SRF_OUTLIER and "'S06'" in finding.message and "does not count" in finding.message
    together, _ = with_kept_parts(store, job([part(7)]))
    given = together.inputs
    apart = model_of(given.surface, given.parts, given.options)
    found = pattern_of_parts(together, apart).pattern
    good = [one for one in apart if one.deviations.name != "S06"]
    batch = pattern_of_parts(job([*parts, part(7)]), good).pattern
    np.testing.assert_array_equal(found.mean.coefficients_mm, batch.mean.coefficients_mm)
    kept = replace(together, inputs=replace(given, leave_out=False))
    assert pattern_of_parts(kept, apart).pattern.parts == 8
    noticed = list(notice_in_order(apart, ["S07"]))
    assert noticed == [NoticedPart("S07", ())]  # the next good part is not compared with the outlying one


def test_an_outlying_part_of_the_job_itself_does_not_count() -> None:
    """Without a store as with one, from the fifth part on; of fewer it is named. Either names the key of the job."""
    own = [random_surface(np.random.default_rng(k), 7, 6.0).value_mm(U, V) for k in range(5)]
    own[3] = own[3] + 900 * np.sin(6 * U) * np.sin(6 * V)
    parts = [part(k, more_um=more_um) for k, more_um in enumerate(own)]
    for used, left in ((parts, ("S03",)), (parts[:4], ())):
        found = model(job(used, options=SurfaceOptions(target_mm=0.1)))
        assert found.pattern.names == tuple(one.name for one in used if one.name not in left)
        finding = next(one for one in found.findings if one.code is Code.SRF_OUTLIER and "part 'S03'" in one.message)
        assert "model.exclude = ['S03']" in finding.hint and ("is left out" in finding.message) == bool(left)
    given = job(parts[:4]).inputs
    apart = model_of(given.surface, given.parts, given.options)
    (noticed,) = notice_in_order(apart, ["S03"])
    assert noticed.alarms[0].probability < BEYOND_DOUBT and not noticed.left_out


def test_a_part_in_doubt_is_named_and_counts(store: Store) -> None:
    parts = [*(part(k) for k in range(6)), part(6, more_um=10 * np.sin(6 * U) * np.sin(6 * V))]
    (finding,) = add(store, *parts).findings
    assert finding.code is Code.SRF_OUTLIER and "does not count" not in finding.message
