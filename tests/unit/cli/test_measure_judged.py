"""Expected against obtained: a finish inspection of the second part of an edge, cut in the simulator, in three ways.

The simulator cuts by the corrected program, and by the given one; what a correction leaves that was run twice is, to
first order, as far from the first of these as the second is on the other side.
"""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from tests.support.cli import invoke
from tests.support.correction import EXAMPLES, example_inputs
from tests.support.edge_example import text_of
from tests.support.edge_in_simulator import measured_vectors, workshop_of
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Quarantine
from trueloop.domain.record import Correction
from trueloop.domain.tool import Edge, Tool
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.history import history_of
from trueloop.loops.turned import correction as turned
from trueloop.storage.store import Store, find, open_store
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop_lab.loops.turned import finish, finish_along, semifinish_and_probe, trial_of

EDGE = Edge(Tool(1, "SVJBL"), "VCMT 110304", "1")
WAYS = ("clean", "not-run", "twice")


@pytest.fixture(scope="module")
def corrected(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """S1 inspected, S2 corrected by it, and what would be found on S2 after each of three finish cuts."""
    folder = tmp_path_factory.mktemp("edge")
    for name in ("edge", "modbas2"):
        shutil.copytree(EXAMPLES / name, folder / "examples" / name)
    work = folder / "examples" / "edge"
    invoke("db", "init", work / "trueloop.db", status=0)
    shutil.copy(work / "touches-1.csv", work / "touches.csv")
    invoke("compensate", work / "edge.toml", "--serial", "S1", status=0)
    said = read(work, "finish-1.csv", "--order", 0, serial="S1")
    assert "MEM-ALARM" not in said.output and "S1: predicted" in said.stdout
    shutil.copy(work / "touches-2.csv", work / "touches.csv")
    invoke("compensate", work / "edge.toml", "--serial", "S2", status=0)
    last: Correction[turned.Correction] = find(store_in(work), Correction)[-1].value
    for name, found in zip(WAYS, finished(last.payload), strict=True):
        (work / f"{name}.csv").write_text(text_of(found), encoding="utf-8")
    return folder


def finished(correction: turned.Correction) -> tuple[ErrorVectors, ErrorVectors, ErrorVectors]:
    inputs, workshop = example_inputs("modbas2"), workshop_of(1)
    trial = trial_of(inputs, inputs.touches.point[int(np.flatnonzero(inputs.touches.at_reference)[0])])
    stock, _ = semifinish_and_probe(trial, workshop, 1)
    clean = measured_vectors(trial, finish(trial, workshop, correction, stock, 1), workshop, 1)
    given = finish_along(workshop, workshop.machine, trial.finish, stock, 1)
    not_run = measured_vectors(trial, given, workshop, 1)
    return clean, not_run, replace(clean, error_mm=2.0 * clean.error_mm - not_run.error_mm)


@pytest.fixture
def work(corrected: Path, tmp_path: Path) -> Path:
    shutil.copytree(corrected, tmp_path, dirs_exist_ok=True)
    return tmp_path / "examples" / "edge"


def store_in(work: Path) -> Store:
    return open_store(work / "trueloop.db", codec=store_codec())


def read(work: Path, file: str, *options: object, serial: str = "S2") -> Result:
    given = ("--job", work / "edge.toml", "--serial", serial, "--after", "finish")
    return invoke("measure", "read", work / file, *given, *options, status=0)


def taught(work: Path) -> list[str]:
    return [part.serial for part in history_of(store_in(work), EDGE)]


def test_a_part_as_predicted_raises_nothing_and_teaches(work: Path) -> None:
    said = read(work, "clean.csv", "--order", 1)
    assert "MEM-ALARM" not in said.output and not find(store_in(work), Quarantine)
    assert "STO-PATTERN" not in said.output  # of its dome three points were touched, and twenty inspected
    assert taught(work) == ["S1", "S2"]


def test_a_part_inspected_at_fewer_points_than_touched_is_flagged(work: Path) -> None:
    lines = (work / "clean.csv").read_text(encoding="utf-8").splitlines()
    (work / "fewer.csv").write_text("\n".join(lines[:-24]), encoding="utf-8")
    assert "STO-PATTERN" in read(work, "fewer.csv", "--order", 1).stderr


@pytest.mark.parametrize(("way", "cause"), [("not-run", "was not run"), ("twice", "was applied twice")])
def test_another_share_of_the_correction_is_alarmed_and_not_learned_from(work: Path, way: str, cause: str) -> None:
    said = read(work, f"{way}.csv", "--order", 1)
    assert "warning MEM-ALARM: part 'S2'" in said.stderr and cause in said.stderr
    assert "1 quarantine" in said.stdout and "nothing is learned from it" in said.stderr
    (word,) = (kept.value for kept in find(store_in(work), Quarantine))
    assert cause in word.why and word.by == "trueloop"
    assert taught(work) == ["S1"]
    assert "in quarantine" in invoke("db", "show", "S2", "--db", work / "trueloop.db", status=0).stdout


def test_the_same_again_changes_nothing_and_accepting_it_lifts_it_for_good(work: Path) -> None:
    read(work, "not-run.csv", "--order", 1)
    said = read(work, "not-run.csv", "--order", 1)
    assert "kept already" in said.stdout and "MEM-ALARM" in said.stderr
    said = read(work, "not-run.csv", "--order", 1, "--accept", "MEM-ALARM")
    assert "1 quarantine lifted" in said.stdout and "later parts learn from it" in said.stderr
    assert taught(work) == ["S1", "S2"]
    assert "kept already" in read(work, "not-run.csv", "--order", 1).stdout
    assert taught(work) == ["S1", "S2"] and len(find(store_in(work), Quarantine)) == 2


def test_accepted_at_once_it_is_learned_from_and_stays_so(work: Path) -> None:
    read(work, "twice.csv", "--order", 1, "--accept", "MEM-ALARM")
    read(work, "twice.csv", "--order", 1)
    assert taught(work) == ["S1", "S2"]


def test_saying_what_ran_lifts_it(work: Path) -> None:
    read(work, "not-run.csv", "--order", 1)
    said = read(work, "not-run.csv", "--ran", "as-programmed", "--supersede")
    assert "MEM-ALARM" not in said.output and "1 quarantine lifted" in said.stdout
    assert taught(work) == ["S1", "S2"]
    assert "predicted" not in said.stdout


def test_a_better_inspection_lifts_it_and_the_first_handed_in_again_does_not_undo_that(work: Path) -> None:
    read(work, "not-run.csv", "--order", 1)
    assert "1 quarantine lifted" in read(work, "clean.csv", "--order", 1).stdout
    said = read(work, "not-run.csv", "--order", 1)
    assert "MEM-ALARM" not in said.output and "kept already" in said.stdout
    assert taught(work) == ["S1", "S2"]


def test_what_a_person_lifted_is_judged_again_by_another_inspection(work: Path) -> None:
    read(work, "not-run.csv", "--order", 1, "--accept", "MEM-ALARM")
    assert "1 quarantine" in read(work, "twice.csv", "--order", 1).stdout
    assert taught(work) == ["S1"]


def test_the_next_correction_is_without_the_part_in_quarantine(work: Path) -> None:
    read(work, "not-run.csv", "--order", 1)
    (work / "touches.csv").write_text("# S3\n" + (work / "touches-2.csv").read_text(encoding="utf-8"), encoding="utf-8")
    next_part = ("compensate", work / "edge.toml", "--serial", "S3")
    assert "inspected parts: 1." in " ".join(invoke(*next_part, status=0).stdout.split())
    read(work, "not-run.csv", "--order", 1, "--accept", "MEM-ALARM")
    assert "inspected parts: 2." in " ".join(invoke(*next_part, status=0).stdout.split())


def test_expected_against_obtained_by_hand(work: Path) -> None:
    """Obtained: by the file alone. Predicted: weight 1 by memory expects 0 with memory's own standard uncertainty."""
    found = json.loads(read(work, "clean.csv", "--order", 1, "--json").stdout)["obtained"]
    rows = [line.split(",") for line in (work / "clean.csv").read_text(encoding="utf-8").splitlines()[2:]]
    by_point = {row[0]: float(row[4]) for row in rows}
    store = store_in(work)
    correction = find(store, Correction)[-1].value.payload
    known, profile, touches = correction.memory.expected, correction.profile, []
    (inspection,) = [one.value for one in find(store, Inspection, serial="S2") if one.value.count == 32]
    for t in inspection.touches:
        if t.feature != "main-face":  # z is counted from its touch
            index = profile.names.index(t.feature)
            s = float(profile.features[index].locate(t.nominal_mm)[0])
            u = known.along(np.sqrt(np.diag(known.covariance_mm2)), index, s)[0]
            left = known.along(known.mean_mm, index, s)[0] - correction.model.curves[index].value_mm(s)[0]
            touches.append((by_point[t.point], 1e3 * u, 1e3 * left))
    errors, u, left = (np.array(column) for column in zip(*touches, strict=True))
    (one,) = found
    assert one["serial"] == "S2" and one["places"] == len(errors) == 31
    assert one["obtained_rms_um"] == pytest.approx(np.sqrt(np.mean(errors**2)))
    assert one["predicted_rms_um"] == pytest.approx(np.sqrt(np.mean(u**2 + left**2)), rel=0.02)
    assert one["inside"] == np.count_nonzero(np.abs(errors - left) <= 1.96 * u) > 27
