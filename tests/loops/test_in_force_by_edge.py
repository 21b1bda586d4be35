"""Corrections in force of several tools and set-ups: each edge has its own, measured or not."""

import csv
import json
import re
import shutil
from collections.abc import Collection, Mapping
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from trueloop.errors import TrueloopError
from trueloop.jobs.store.opened import Keeping
from trueloop.jobs.turned.compensate import Done, compensate_and_keep

EXAMPLES = Path(__file__).parents[2] / "examples"
GROOVE = {"left-wall": 9.0, "floor-left": 6.0, "floor-right": -8.0, "right-wall": -4.0}
"""Errors of what T5 and T15 cut, um."""
FIRST = {"big": 13.0, **GROOVE}
BY_CONTOUR = '\n[compensation]\nby = "contour"\nmax_scatter_um = 20.0\n'


def correct(
    folder: Path,
    errors_um: Mapping[str, float],
    cut_with: str,
    without: Collection[str] = (),
    output: str = "out",
    example: str = "grooved",
    more: str = BY_CONTOUR,
) -> Done:
    """Corrects a job of an example in a folder of its own, features measured with these errors, those `without` not."""
    if not folder.exists():
        shutil.copytree(EXAMPLES / example, folder)
        (folder / "touches.csv").rename(folder / "all.csv")
        (folder / f"{example}.toml").rename(folder / "given.toml")
    with (folder / "all.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["feature"] not in without]
    lines = ["point,feature,nominal_x_mm,nominal_z_mm,error_um"]
    for row in rows:
        place = f"{row['nominal_x_mm']},{row['nominal_z_mm']}"
        lines.append(f"{row['point']},{row['feature']},{place},{errors_um.get(row['feature'], 0.0):.3f}")
    (folder / "touches.csv").write_text("\n".join(lines) + "\n")
    job, stated = (folder / "given.toml").read_text() + more, f'\ncut_with = "{cut_with}"' if cut_with else ""
    (folder / "job.toml").write_text(re.sub(r"(?m)^finish = .*$", lambda line: line.group() + stated, job))
    return compensate_and_keep(folder / "job.toml", folder / output, Keeping(db=False))


def of_groove(program: Path) -> list[str]:
    """The lines of the groove's walls and floor, as they stand in a program."""
    return re.findall(r"X40\.\d+.*|Z-39\.8\d+", program.read_text())


def test_another_edge_s_record_is_refused_and_the_list_of_all_is_named(tmp_path: Path) -> None:
    correct(tmp_path / "1", FIRST, "given")
    with pytest.raises(TrueloopError, match="CMP-CUT-WITH") as refused:
        correct(tmp_path / "2", {}, "../1/out/record-T3.json")
    assert "part.json" in (refused.value.hint or "")
    with pytest.raises(TrueloopError, match="CMP-CUT-WITH") as refused:
        correct(tmp_path / "2", {}, "")
    assert "../1/out/part.json" in str(refused.value)


def test_the_contour_in_force_of_an_edge_that_is_not_measured_stays(tmp_path: Path) -> None:
    """T5 and T15 as the first correction has them in the second program and, by its own list, in the third."""
    correct(tmp_path / "1", FIRST, "given")
    given, first = of_groove(tmp_path / "1/finish.nc"), of_groove(tmp_path / "1/out/corrected.nc")
    assert given != first
    second = correct(tmp_path / "2", {"big": 2.0}, "../1/out/part.json", without=GROOVE)
    assert of_groove(tmp_path / "2/out/corrected.nc") == first
    listed = json.loads((tmp_path / "1/out/part.json").read_text())["edges"][1]["record_id"]
    assert f"correction {listed} stays in force" in " ".join(
        json.loads((tmp_path / "2/out/part.json").read_text())["words"].split()
    )
    assert [edge.kept is not None for edge in second.corrected.edges] == [False, True, True]
    third = correct(tmp_path / "3", GROOVE, "../2/out/part.json")
    groove = [edge.correction for edge in third.corrected.edges[1:]]
    # in force at each feature is what the first correction took off, found by way of the second list
    for edge in groove:
        assert edge is not None
        for name, index in zip(edge.profile.names, range(len(edge.profile.names)), strict=True):
            taken_um = 1e3 * float(edge.in_force_mm(index, np.array([0.5 * edge.profile.features[index].length_mm]))[0])
            assert taken_um == pytest.approx(-GROOVE[name], abs=1.5)


def test_a_set_up_that_is_not_measured_keeps_its_corrected_program(tmp_path: Path) -> None:
    errors = {"collar": 12.0, "seat": 6.0, "back-seat": -6.0, "edge": -2.0, "back": 3.0, "bore": -5.0}
    first = correct(tmp_path / "1", errors, "given", example="two-sides")
    assert first.corrected.setups[1].program is not None
    at_back = ("bore", "bore-chamfer", "back", "edge", "back-seat", "back-step")
    second = correct(tmp_path / "2", {"collar": 2.0}, "../1/out/part.json", at_back, example="two-sides")
    ran, stays = first.corrected.setups[1].program, second.corrected.setups[1].program
    assert stays is not None
    moves = [[line for line in text.splitlines() if line.startswith((b"G01", b"G02", b"G03"))] for text in (ran, stays)]
    assert moves[0] == moves[1]


def test_files_of_an_earlier_run_are_not_taken_for_an_edge_that_was_not_measured(tmp_path: Path) -> None:
    correct(tmp_path / "1", FIRST, "given")
    assert (tmp_path / "1/out/record-T5.json").exists()
    correct(tmp_path / "1", FIRST, "given", without=GROOVE)
    assert not list((tmp_path / "1/out").glob("*-T5.*"))
    second = correct(tmp_path / "2", GROOVE, "../1/out/part.json")
    t5 = second.corrected.edges[1].correction
    assert t5 is not None
    assert t5.in_force_mm(0, np.array([2.0]))[0] == 0.0
    shutil.copy(tmp_path / "2/out/record-T5.json", tmp_path / "1/out/record-T5.json")
    assert correct(tmp_path / "3", GROOVE, "../1/out/part.json").corrected.edges[1].correction is not None
    shutil.copy(tmp_path / "2/out/record-T3.json", tmp_path / "1/out/record-T3.json")
    with pytest.raises(TrueloopError, match="REC-FILE"):
        correct(tmp_path / "4", GROOVE, "../1/out/part.json")


def test_after_record_takes_the_list_of_a_part_of_which_an_edge_was_not_measured(tmp_path: Path) -> None:
    correct(tmp_path / "1", FIRST, "given", without=GROOVE)
    folder = tmp_path / "2"
    shutil.copytree(tmp_path / "1", folder)
    given, now = folder / "given.toml", datetime.now(UTC)
    keys = f'after_record = "../1/out/part.json"\nmeasured_at = {now.isoformat()}'
    given.write_text(given.read_text().replace("[gauging]", f"[gauging]\n{keys}"))
    assert correct(folder, GROOVE, "").corrected.edges[1].correction is not None


@pytest.mark.parametrize(("machines", "shared"), [(("L1", ""), True), (("L1", "L1"), True), (("L1", "L2"), False)])
def test_two_set_ups_have_two_machines_only_where_both_are_named(
    tmp_path: Path, machines: tuple[str, str], shared: bool
) -> None:
    shutil.copytree(EXAMPLES / "two-sides", tmp_path / "job")
    folder = tmp_path / "job"
    text = (folder / "two-sides.toml").read_text().replace("number = 2  # T0202", "number = 1")
    for finish, machine in zip(("first.nc", "second.nc"), machines, strict=True):
        named = f'finish = "{finish}"' + (f'\nmachine = "{machine}"' if machine else "")
        text = text.replace(f'finish = "{finish}"', named)
    (folder / "two-sides.toml").write_text(text)
    (folder / "second.nc").write_text((folder / "second.nc").read_text().replace("T0202", "T0101"))
    shown = run("compensate", folder / "two-sides.toml", "--no-store", "-o", folder / "out")
    assert ("second: T1: by the contour" in shown) == shared


def test_an_offset_that_another_tool_cuts_with_is_not_entered_for_an_edge(tmp_path: Path) -> None:
    """T0705 cuts with T0505's offset: the wear of offset 5 would move what it cuts too."""
    shutil.copytree(EXAMPLES / "grooved", tmp_path / "job")
    program = tmp_path / "job/finish.nc"
    text = program.read_text()
    program.write_text(text.replace("T0505", "T0705\nG00 X60. Z-55.\nG01 X51.8 F0.1\nG00 X60.\nT0505", 1))
    shown = run("compensate", tmp_path / "job/grooved.toml", "--no-store", "-o", tmp_path / "job/out")
    assert "T5 (left corner): by the contour" in shown
    assert "T0505" in shown and "T0705" in shown


def test_by_hand_an_offset_along_z_of_the_tool_that_cuts_the_zero_face_is_not_proposed(tmp_path: Path) -> None:
    """T3 cuts 'step', from which z counts: whatever its offset along Z, a next part measures the same. The offsets of
    the first part, entered, leave on the next what its prediction states: e + n · offset, z counted from 'step'.
    """
    errors = {"chamfer": 12.0, **GROOVE}
    more = '\n[compensation]\nby = "offset"\nmax_scatter_um = 20.0\n'
    correct(tmp_path / "1", {}, "given", output="first")
    given = tmp_path / "1/given.toml"
    given.write_text(given.read_text().replace("[gauging]", '[gauging]\nz_reference = "20"'))
    done = correct(tmp_path / "1", errors, "given", more=more)
    t3 = done.corrected.edges[0].correction
    assert t3 is not None
    assert (t3.decision.z.offset_mm, t3.decision.z.expanded_u_mm) == (0.0, None)
    assert "moves both" in t3.decision.z.words
    for edge in (one.correction for one in done.corrected.edges):
        assert edge is not None
        x_mm, z_mm = edge.decision.offset_mm
        rows = np.flatnonzero(edge.touches.standard_u_mm > 0.0)
        next_mm = edge.touches.error_mm + edge.touches.outward_normal @ np.array([x_mm, z_mm])
        assert edge.prediction.after_mm[rows] == pytest.approx(next_mm[rows], abs=0.001)


def test_a_list_that_does_not_have_the_edge_is_refused(tmp_path: Path) -> None:
    correct(tmp_path / "1", FIRST, "given")
    listed = tmp_path / "1/out/part.json"
    content = json.loads(listed.read_text())
    listed.write_text(json.dumps({**content, "edges": content["edges"][:2]}))
    with pytest.raises(TrueloopError, match=r"REC-FILE.*no edge 1 of tool 15"):
        correct(tmp_path / "2", {}, "../1/out/part.json")
    listed.write_text(json.dumps({**content, "source_sha256": "0" * 64}))
    with pytest.raises(TrueloopError, match="CMP-OTHER-PROGRAM"):
        correct(tmp_path / "2", {}, "../1/out/part.json")


def test_new_tables_of_two_tables_of_one_name_are_named_by_their_folders(tmp_path: Path) -> None:
    job = shutil.copytree(EXAMPLES / "two-sides", tmp_path / "job") / "two-sides.toml"
    text = job.read_text()
    for tool, folder in (("T0101", "a"), ("T0202", "b")):
        number = int(tool[-1])
        (tmp_path / "job" / folder).mkdir()
        row = f"%\nG21\nG10 P{number} X0. Z0. R0.8 Q3\n%\n"
        (tmp_path / "job" / folder / "tool.txt").write_text(row)
        text = text.replace(f"number = {number}  # {tool}", f'number = {number}\ntable = "{folder}/tool.txt"')
    job.write_text(text + '\n[compensation]\nby = "offset"\nmax_scatter_um = 20.0\n')
    run("compensate", job, "--no-store", "-o", tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").glob("new-*")} == {"new-a-tool.txt", "new-b-tool.txt"}
