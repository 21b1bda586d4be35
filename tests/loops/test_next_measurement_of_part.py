"""Measurements planned next for a part by its serial number: profile and history come out of the store."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.loops.test_several_tools_in_store import PROFILE, make_parts, place, store
from tests.support.cli import run
from trueloop.domain.record import Correction
from trueloop.jobs.measure.next_measurement import next_of_part
from trueloop.jobs.turned.job import read_part
from trueloop.storage.store import find

EXAMPLES = Path(__file__).parents[2] / "examples"


def plan(job: Path, serial: str, *more: object) -> Any:
    return json.loads(run("measure", "next", serial, "--db", job.parent / "trueloop.db", "--json", *more))


@pytest.fixture(scope="module")
def plugs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three finished parts of two edges, and one that was touched and corrected."""
    job = place(tmp_path_factory.mktemp("plugs") / "plug", PROFILE)
    make_parts(job, PROFILE, (1, 2, 3))
    make_parts(job, PROFILE, (4,), finish=False)
    return job


def test_before_its_finish_cut_a_part_is_as_unknown_as_its_correction_predicts(plugs: Path) -> None:
    """The judge is the band that memory stated with the correction, in the store."""
    found = plan(plugs, "P4")
    of_edges = [one.value.record for one in find(store(plugs), Correction, serial="P4")]
    stated = [np.array(one.model["memory"]["standard_u_mm"]) for one in of_edges]  # type: ignore[index]
    assert len(stated) == 2
    assert found["before"] == pytest.approx(1e3 * float(np.sqrt(np.mean(np.concatenate(stated) ** 2))), rel=0.15)


def test_earlier_parts_of_the_edges_are_weighed(plugs: Path, tmp_path: Path) -> None:
    """P4 also without the three parts before it: what the finish cut does otherwise was never inspected then."""
    alone = place(tmp_path / "alone", PROFILE)
    make_parts(alone, PROFILE, (4,), finish=False)
    with_history, without = plan(plugs, "P4", "-n", "1"), plan(alone, "P4", "-n", "1")
    assert with_history["before"] < 0.8 * without["before"]


def test_of_a_finished_part_the_next_one_is_asked_for(plugs: Path) -> None:
    """Clamping and setting of another part are not known yet: more is open than before P4's own finish cut."""
    assert plan(plugs, "P3", "-n", "1")["before"] > 1.05 * plan(plugs, "P4", "-n", "1")["before"]


def test_what_was_not_touched_comes_first_and_a_list_is_written(tmp_path: Path) -> None:
    """As by the job: MODBAS2's collar and step face were not touched. A DMIS program needs the job."""
    run("db", "init", tmp_path / "trueloop.db")
    given = "--db", tmp_path / "trueloop.db", "--serial", "7", "-o", tmp_path / "out"
    run("compensate", EXAMPLES / "modbas2" / "job.toml", *given)
    found = plan(tmp_path / "job.toml", "7", "--with", "cmm", "-n", "2", "-o", tmp_path / "next")
    assert {one["feature"] for one in found["measurements"]} == {"collar", "step-face"}
    assert [path.name for path in (tmp_path / "next").iterdir()] == ["cmm.csv"]


def test_places_of_a_part_with_two_set_ups_are_those_of_the_part(tmp_path: Path) -> None:
    """In one of the set-ups Z looks the other way: with the frame turned round no place would be on its feature."""
    shutil.copytree(EXAMPLES / "two-sides", tmp_path / "job")
    job = tmp_path / "job" / "two-sides.toml"
    run("db", "init", job.parent / "trueloop.db")
    run("compensate", job, "--serial", "7", "-o", tmp_path / "out")
    found, profile = next_of_part(store(job), "7", 1), read_part(job).profile
    assert {one.feature for one in found.touches.values()} == set(profile.names)
    for one in found.touches.values():
        feature = profile.features[profile.names.index(one.feature)]
        along = float(feature.locate(one.place_mm)[0])
        assert feature.point_mm(along) == pytest.approx(one.place_mm, abs=1e-9)
        assert one.normal == pytest.approx(tuple(feature.outward_normal(along)), abs=1e-9)


def test_a_part_that_is_not_in_the_store_is_named(plugs: Path) -> None:
    told = run("measure", "next", "P44", "--db", plugs.parent / "trueloop.db", status=3)
    assert "DIA-NONE" in told and "did you mean 'P4'?" in told


def test_a_job_is_planned_by_the_earlier_parts_of_its_edges_as_its_part_in_the_store_is(plugs: Path) -> None:
    """The job names the touches of P4 still, and its folder has the store; `--db` may name another, or none."""
    of_job = json.loads(run("measure", "next", plugs, "--json", "-n", "2"))
    of_part = plan(plugs, "P4", "-n", "2")
    assert of_job["before"] == pytest.approx(of_part["before"], rel=0.02)
    assert of_job["after"] == pytest.approx(of_part["after"], rel=0.02)
    empty = plugs.parent / "empty.db"
    run("db", "init", empty)
    alone = json.loads(run("measure", "next", plugs, "--db", empty, "--json", "-n", "1"))
    assert of_job["before"] < 0.8 * alone["before"]


def test_a_job_without_touches_yet_is_planned_by_earlier_parts_alone(plugs: Path, tmp_path: Path) -> None:
    shutil.copytree(plugs.parent, tmp_path / "next")
    (tmp_path / "next" / "touches.csv").unlink()
    found = json.loads(run("measure", "next", tmp_path / "next" / "job.toml", "--json", "-n", "3"))
    assert not found["measured"]
    assert found["before"] > 1.05 * plan(plugs, "P4", "-n", "1")["before"]
    (tmp_path / "next" / "trueloop.db").unlink()
    alone = json.loads(run("measure", "next", tmp_path / "next" / "job.toml", "--json", "-n", "3"))
    assert found["before"] < 0.5 * alone["before"]
