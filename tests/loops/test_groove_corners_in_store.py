"""Both corners of a groove insert in a store, part after part: two edges, though holder and insert are one."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.grooved import FEATURES, LEFT, NOSE_MM, OD, PLACES, RIGHT, job, program
from trueloop.domain.life import Cut
from trueloop.domain.tool import Edge, Tool
from trueloop.jobs.store.history import history_of
from trueloop.jobs.store.opened import store_of
from trueloop.storage.store import Store, find

MOUNTED = {OD: ("turning", "1"), LEFT: ("grooving", "1"), RIGHT: ("grooving", "2")}


def errors_um(part: int) -> list[float]:
    """Each edge errs in its own way, and a part as it does."""
    level = {OD: 12.0, LEFT: 6.0, RIGHT: -8.0}
    noise = np.random.default_rng(part).normal(0.0, 0.4, len(PLACES))
    return [level[p.edge] * p.normal[0] + 3.0 * p.normal[1] + e for p, e in zip(PLACES, noise, strict=True)]


def part_made(folder: Path, part: int) -> None:
    """A part touched after the semi-finish cut, corrected, cut, and inspected after the finish cut."""
    path = job(folder, errors_um(part), "linuxcnc", '[compensation]\nby = "contour"\n')
    (folder / "semi.ngc").write_text(program("linuxcnc"))
    text = path.read_text().replace('finish = "finish.ngc"\n', 'finish = "finish.ngc"\nsemifinish = "semi.ngc"\n')
    path.write_text(text)
    run("compensate", path, "-o", folder / "out", "--serial", f"P{part}")
    rows = (folder / "touches.csv").read_text().splitlines()
    after = [row.rsplit(",", 1)[0] + f",{0.1 * e:.4f}" for row, e in zip(rows[1:], errors_um(part), strict=True)]
    (folder / "after.csv").write_text("\n".join([rows[0], *after, ""]))
    run("measure", "read", folder / "after.csv", "--job", path, "--after", "finish", "--serial", f"P{part}",
        "--program", folder / "out" / "corrected.ngc")  # fmt: skip


def store(folder: Path) -> Store:
    found = store_of(folder, None, None)
    assert found is not None
    return found


def edges_of_shares(folder: Path) -> dict[str, set[tuple[str, ...]]]:
    """By part type which edges are said to have cut it."""
    found: dict[str, set[tuple[str, ...]]] = {}
    for kept in find(store(folder), Cut):
        setting = kept.value.setting
        assert setting is not None
        found.setdefault(kept.value.part.part_type.name, set()).add(setting.edge.identity)
    return found


def test_corners_that_a_job_names_alike_are_two_edges(tmp_path: Path) -> None:
    """Both tables say `name = "grooving"`: what one corner cut must not teach the other."""
    assert FEATURES.count("wall") == 2
    run("db", "init", tmp_path / "trueloop.db")
    for part in (1, 2):
        part_made(tmp_path, part)
    assert edges_of_shares(tmp_path) == {
        "grooved, T3": {("turning", "", "")},
        "grooved, T5 (left corner)": {("grooving", "", "left")},
        "grooved, T15 (right corner)": {("grooving", "", "right")},
    }
    db = ("--db", tmp_path / "trueloop.db")
    said = " ".join(run("tool", "show", "T15", *db, status=3).split())
    assert "EDG-UNKNOWN" in said and "cuts by T15 grooving corner right are kept, never mounted" in said
    run("tool", "mount", "T15", "--holder", "grooving", "--corner", "right", "--nose-radius-mm", "0.2", *db,
        "--at", "2026-03-01T08:00")  # fmt: skip
    assert "4 cuts kept" in run("tool", "show", "T15", *db)


def test_a_finish_cut_without_a_correction_is_of_its_corner_too(tmp_path: Path) -> None:
    """Inspected after the semi-finish cut, before anything is corrected."""
    run("db", "init", tmp_path / "trueloop.db")
    path = job(tmp_path, errors_um(1), "linuxcnc")
    run("measure", "read", tmp_path / "touches.csv", "--job", path, "--after", "semifinish", "--serial", "P1")
    assert set().union(*edges_of_shares(tmp_path).values()) == {
        ("turning", "", ""), ("grooving", "", "left"), ("grooving", "", "right")
    }  # fmt: skip


def test_mounted_corners_keep_the_names_that_they_were_mounted_by(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Each corner learns its own errors, of its own sign, and no library complains of matrices without rows."""
    monkeypatch.chdir(tmp_path)
    run("db", "init", "trueloop.db")
    for tool, (holder, corner) in MOUNTED.items():
        run("tool", "mount", f"T{tool}", "--holder", holder, "--corner", corner, "--nose-radius-mm", NOSE_MM[tool],
            "--at", "2026-03-01T08:00")  # fmt: skip
    for part in (1, 2, 3):
        part_made(tmp_path, part)
    assert edges_of_shares(tmp_path)["grooved, T15 (right corner)"] == {("grooving", "", "2")}
    assert "DPOTRI" not in "".join(capfd.readouterr())
    said = run("tool", "show", "T15")
    assert "T15 grooving corner 2" in said and "6 cuts kept" in said
    for tool, corner, side, level_um in ((LEFT, "1", "left", 6.0), (RIGHT, "2", "right", -8.0)):
        history = history_of(store(tmp_path), Edge(Tool(tool, "grooving"), corner=corner))
        assert [(made.serial, made.part_type) for made in history] == [
            (f"P{number}", f"grooved, T{tool} ({side} corner)") for number in (1, 2, 3)
        ]
        for made in history:
            floor = [name == f"floor-{side}" for name in made.semifinish.feature]
            assert sum(floor) == 3
            assert 1e3 * made.semifinish.error_mm[floor].mean() == pytest.approx(level_um, abs=1.0)
    alike = " ".join(run("tool", "show", "grooving", status=3).split())
    assert "EDG-POCKET: 2 mounted edges go by 'grooving': T5 grooving corner 1; T15 grooving corner 2" in alike
    assert "name one by its number: T5 or T15" in alike
