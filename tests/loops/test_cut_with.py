"""What cut a measured part is a fact: the next correction is the whole one, however the last one was carried out."""

import json
import math
import re
import shutil
import time
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.support.cli import run
from tests.support.records import sealed
from trueloop.domain.life import Cut, Ran
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.opened import Choice, Keeping
from trueloop.jobs.turned.compensate import Done, compensate_and_keep
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.in_force import in_force
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.storage.store import find, open_store

PROGRAM = """O1
G21 G40 G99
T0303
G97 S1500 M3
G0 X40. Z2.
G0 X0
G42 G1 Z0. F0.1
X30. ,C1.
Z-30.
X36. ,C1.
Z-50.
G40 X42.
G0 X100. Z100.
M30
"""
PLACES = (("cylinder-2", -5, 30.0), ("cylinder-2", -25, 30.0), ("cylinder-1", -35, 36.0), ("cylinder-1", -45, 36.0))
FIRST = (0.050, 0.050, 0.050, 0.050)
SECOND = (0.004, 0.004, 0.004, 0.004)


def correct(
    folder: Path,
    part: int,
    readings: tuple[float, ...],
    by: str,
    programs: str = "",
    more: str = "",
    db: Choice = False,
) -> Done:
    """The correction from the finished part's diameters, as deviations in mm, into the folder oPART."""
    (folder / "f.nc").write_text(PROGRAM)
    rows = [f"{name},{z},{d + e:.4f}" for (name, z, d), e in zip(PLACES, readings, strict=True)]
    (folder / f"r{part}.csv").write_text("\n".join(["feature,z_mm,diameter_mm", *rows]) + "\n")
    if "measured_at" not in more:
        more = f"measured_at = {datetime.now(UTC).isoformat()}\n{more}"
    (folder / f"j{part}.toml").write_text(
        f'[part]\nname = "s"\nserial = "{part}"\nfrom_program = true\n'
        f'[tool]\nnose_radius_mm = 0.2\nnumber = 3\nname = "T3"\ninsert = "DNMG"\ncorner = "1"\n'
        f'[programs]\ndialect = "fanuc-lathe"\nfinish = "f.nc"\n{programs}\n'
        f'[gauging]\nreadings = "r{part}.csv"\n{more}\n'
        f'[compensation]\nby = "{by}"\n[output]\nfolder = "o{part}"\n'
    )
    return compensate_and_keep(folder / f"j{part}.toml", folder / f"o{part}", Keeping(db=db))


def diameters(done: Done) -> list[str]:
    """The words of both cylinders in the program to run, read from the file."""
    text = next(file for file in done.files if file.name == done.correction.name_to_run).read_text()
    assert text.count("X30.") + text.count("X36.") == 0 or done.correction.decision.by_offset
    return [line for line in text.splitlines() if line.startswith(("X29.9", "X35.9"))]


def whole_radius_mm(done: Done) -> float:
    return done.correction.decision.whole_offset_mm[0]


def entered_mm(done: Done) -> float:
    offset = done.correction.record.tool_offset
    assert offset is not None
    return offset.x_radius_mm


def test_a_contour_in_force_is_kept_and_the_rest_comes_on_top(tmp_path: Path) -> None:
    """Ø +0.050, then +0.004 with the corrected program: X29.946 is to be cut, and is said to hold 25 µm of before."""
    assert "X29.950" in " ".join(diameters(correct(tmp_path, 1, FIRST, "contour")))
    second = correct(tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"')
    assert all("29.946" in line or "35.946" in line for line in diameters(second))
    assert any("−27.0 µm, of which −25.0 µm were in force" in note for note in second.correction.notes)


INCH = """O31
G20 G40 G99
T0303
G97 S1200 M3
G0 X3.5 Z0.15
X0.9
G42 G1 X0.9 Z0. F0.004
X1.35
G3 X1.5 Z-0.075 R0.075
G1 Z-1.1
X1.8 Z-1.6
Z-2.4
G2 X2. Z-2.5 R0.1
G1 X2.2
Z-3.5
X2.5
G40 G0 X3.5
Z3.
M30
"""
SEATS = (("1,-3.3", 2.2), ("1,-2.7", 2.2), ("2,-2.24", 1.8), ("2,-1.76", 1.8), ("3,-0.9", 1.5), ("3,-0.3", 1.5))
TAPERED_UM = (29, 35, 39, 43, 50, 56)
LEFT_UM = ((-1, 1, 0, 2, -1, 2), (-1, 1, 0, 2, 1, 3), (1, 0, -1, 1, 2, 2), (1, 1, 2, 0, -1, 2))


def test_what_the_control_rounds_on_an_arc_is_not_carried_on_from_part_to_part(tmp_path: Path) -> None:
    """In inch the ends of a fillet's arcs are rounded to 2.5 µm: no later part needs more arcs than the first, and
    none is tighter than the nose (NC-GOUGE).
    """
    (tmp_path / "f.nc").write_text(INCH)
    arcs = []
    for part, left_um in enumerate((TAPERED_UM, *LEFT_UM), 1):
        rows = [f"cylinder-{at},{d + um / 25400:.6f}" for (at, d), um in zip(SEATS, left_um, strict=True)]
        (tmp_path / "r.csv").write_text("\n".join(["feature,z_in,diameter_in", *rows, ""]))
        ran = f'"o{part - 1}/record.json"' if part > 1 else '"given"'
        (tmp_path / "j.toml").write_text(
            '[part]\nname = "s"\nfrom_program = true\n[tool]\nnose_radius_mm = 0.8\n[programs]\n'
            f'dialect = "fanuc-lathe"\nfinish = "f.nc"\ncut_with = {ran}\n[gauging]\nreadings = "r.csv"\n'
            f'measured_at = {datetime.now(UTC).isoformat()}\n[compensation]\nby = "contour"\n'
        )
        run("compensate", tmp_path / "j.toml", "-o", tmp_path / f"o{part}", "--no-store")
        arcs.append(len(re.findall(r"^G[23] ", (tmp_path / f"o{part}" / "corrected.nc").read_text(), re.MULTILINE)))
    assert max(arcs[1:]) <= arcs[0]


@pytest.mark.parametrize("by", ["contour", "offset"])
def test_every_way_leads_to_the_same_third_part(tmp_path: Path, by: str) -> None:
    """A wear number that was entered stays in force: what is left to enter or to write is less by it.

    Where an offset is enough, the corrected program is the one with offsets.
    """
    correct(tmp_path, 1, FIRST, "offset")
    ways = {
        way: correct(tmp_path, part, SECOND, by, f'cut_with = "o1/record.json"\ncut_by = "{way}"')
        for part, way in enumerate(("wear", "offsets", "corrected"), 2)
    }
    assert (tmp_path / "o1" / "corrected.nc").read_bytes() == (tmp_path / "o1" / "offsets.nc").read_bytes()
    assert {round(1e3 * whole_radius_mm(done), 1) for done in ways.values()} == {-27.0}
    assert entered_mm(ways["wear"]) == pytest.approx(-0.002, abs=1e-9)
    assert entered_mm(ways["offsets"]) == entered_mm(ways["corrected"]) == pytest.approx(-0.027, abs=1e-9)
    if by == "contour":
        assert all("29.946" in line or "35.946" in line for line in diameters(ways["offsets"]))
        assert all("29.996" in line or "35.996" in line for line in diameters(ways["wear"]))


def test_wear_adds_up_over_parts(tmp_path: Path) -> None:
    correct(tmp_path, 1, FIRST, "offset")
    by_wear = '"\ncut_by = "wear"'
    second = correct(tmp_path, 2, SECOND, "offset", f'cut_with = "o1/record.json{by_wear}')
    assert second.correction.record.cut_with is not None
    third = correct(tmp_path, 3, (0.006,) * 4, "offset", f'cut_with = "o2/record.json{by_wear}')
    assert third.correction.record.cut_with is not None
    assert third.correction.record.cut_with.wear_mm[0] == pytest.approx(-0.027, abs=1e-9)
    assert entered_mm(third) == pytest.approx(whole_radius_mm(third) + 0.027, abs=0.0003)


@pytest.mark.parametrize(("by", "way"), [("offset", "wear"), ("offset", "offsets"), ("contour", "corrected")])
def test_from_the_third_part_on_all_finished_parts_correct_the_next(tmp_path: Path, by: str, way: str) -> None:
    """25, 27 and 33 µm on the radius, had nothing been corrected: the last part is not taken for all there is, and no
    mean lags behind; in the same way however the correction was carried out.
    """

    def correct_next(part: int, diameters_mm: float) -> Done:
        force = f'cut_with = "o{part - 1}/record.json"\ncut_by = "{way}"' if part > 1 else ""
        return correct(tmp_path, part, (diameters_mm,) * 4, by, force)

    taken = 0.0
    for part, radius_um in enumerate((25.0, 27.0, 33.0), 1):
        done = correct_next(part, 2e-3 * (radius_um + taken))
        taken = _taken_um(done, by)
        if part < 3:
            assert taken == pytest.approx(-radius_um, abs=0.3)
    assert taken == pytest.approx(-30.7, abs=0.5)
    assert any("finished parts of this series" in note for note in done.correction.notes)
    another = correct_next(4, 0.120)
    assert _taken_um(another, by) == pytest.approx(taken - 60.0, abs=0.6)
    assert any("contradicts the 3 before it" in note for note in another.correction.notes)


def _taken_um(done: Done, by: str) -> float:
    """What the surface is moved outwards by, µm: of the wear number or, of a contour, by its X words."""
    if by == "offset":
        return 1e3 * whole_radius_mm(done)
    (line,) = {line.split(" ")[0] for line in _lines(done) if line.startswith("X29.")}
    return 1e3 * (float(line.strip("X").split(",")[0]) - 30.0) / 2.0


def test_an_offset_in_place_of_a_contour_holds_its_mean(tmp_path: Path) -> None:
    """25 µm and 45 µm on the radius are in force by the contour; the best offset is 35 µm, and leaves 10 µm."""
    correct(tmp_path, 1, (0.050, 0.050, 0.090, 0.090), "contour")
    second = correct(tmp_path, 2, (0.0, 0.001, 0.0, 0.001), "offset", 'cut_with = "o1/record.json"')
    assert entered_mm(second) == pytest.approx(-0.035, abs=0.0006)
    left = second.correction.prediction.after_mm
    assert sorted(round(1e3 * abs(one)) for one in left) == [10, 10, 10, 10]


def test_a_weight_takes_its_share_of_what_is_left_and_keeps_the_rest(tmp_path: Path) -> None:
    """Half of 25 µm, then half of the 12.5 µm left on: 18.75 µm in all."""
    half = "[compensation]\nweight = 0.5\n"

    def halved(part: int, readings: tuple[float, ...], programs: str) -> Done:
        correct(tmp_path, part, readings, "contour", programs)
        job = tmp_path / f"j{part}.toml"
        job.write_text(job.read_text().replace("[compensation]\n", half))
        return compensate_and_keep(job, tmp_path / f"o{part}", Keeping(db=False))

    assert "X29.975" in " ".join(line for line in _lines(halved(1, FIRST, "")))
    second = halved(2, (0.025,) * 4, 'cut_with = "o1/record.json"')
    assert any(word in " ".join(_lines(second)) for word in ("X29.962", "X29.963"))


def _lines(done: Done) -> list[str]:
    return [line for file in done.files if file.name == "corrected.nc" for line in file.read_text().splitlines()]


def test_it_is_asked_for_where_a_correction_lies_beside_the_job(tmp_path: Path) -> None:
    correct(tmp_path, 1, FIRST, "contour")
    correct(tmp_path, 1, FIRST, "contour")  # made from this measurement: it cannot have cut the part
    for readings in (SECOND, FIRST):  # another part by its serial number, which may read as the first
        with pytest.raises(TrueloopError) as asked:
            correct(tmp_path, 2, readings, "contour")
        assert asked.value.code is Code.CMP_CUT_WITH and "o1/record.json" in asked.value.message
    given = correct(tmp_path, 2, SECOND, "contour", 'cut_with = "given"')
    assert all("29.996" in line or "35.996" in line for line in diameters(given))


@pytest.mark.parametrize(
    ("first", "second"), [(".", "q"), ("o/1", "o/2"), ("../apart/1", "../apart/2"), ("../apart", "../apart")]
)
@pytest.mark.parametrize("stated", [True, False])
def test_it_is_asked_for_wherever_the_outputs_are(tmp_path: Path, first: str, second: str, stated: bool) -> None:
    """In the job's own folder, in deeper ones, in folders elsewhere; named in the job or by the caller."""
    folder = tmp_path / "here"
    folder.mkdir()

    def corrected(part: int, errors_mm: tuple[float, ...], out: str, programs: str = "") -> Done:
        correct(folder, part, (0.0,) * 4, "contour", 'cut_with = "given"')  # writes the job, and o1 or o2
        shutil.rmtree(folder / f"o{part}")
        readings = folder / f"r{part}.csv"
        rows = [f"{name},{z},{d + e:.4f}" for (name, z, d), e in zip(PLACES, errors_mm, strict=True)]
        readings.write_text("\n".join(["feature,z_mm,diameter_mm", *rows]) + "\n")
        job = folder / f"j{part}.toml"
        text = job.read_text().replace(f'serial = "{part}"\n', "").replace('cut_with = "given"', programs)
        job.write_text(text.replace(f'folder = "o{part}"', f'folder = "{out}"') if stated else text)
        return compensate_and_keep(job, None if stated else folder / out, Keeping(db=False))

    corrected(1, FIRST, first)
    with pytest.raises(TrueloopError) as asked:
        corrected(2, SECOND, second)
    assert asked.value.code is Code.CMP_CUT_WITH
    named = asked.value.message.rpartition(": ")[2].partition(" (")[0]
    third = corrected(2, SECOND, second + "/new", f'cut_with = "{named}"')
    assert all("29.946" in line or "35.946" in line for line in diameters(third))
    with pytest.raises(TrueloopError) as itself:
        corrected(2, SECOND, "o3", f'cut_with = "{second}/new/record.json"')
    assert itself.value.code is Code.CMP_CUT_WITH and "this very measurement" in itself.value.message


@pytest.mark.parametrize(
    ("first", "second", "program"), [("part1", "part2", "f.nc"), ("jobs/11/part1", "jobs/12/part2", "../../../nc/f.nc")]
)
def test_it_is_asked_for_where_a_job_in_another_folder_corrected_the_program(
    tmp_path: Path, first: str, second: str, program: str
) -> None:
    """Each job has a folder and a store of its own; the program is a copy beside each, or one file of all."""

    def corrected(part: int, folder: Path, errors_mm: tuple[float, ...], programs: str = "") -> Done:
        folder.mkdir(parents=True, exist_ok=True)
        correct(folder, part, errors_mm, "contour", 'cut_with = "given"')  # writes the job
        shutil.rmtree(folder / f"o{part}")
        (folder / program).parent.mkdir(exist_ok=True)
        shutil.move(folder / "f.nc", folder / program)
        job = folder / f"j{part}.toml"
        text = job.read_text().replace('finish = "f.nc"', f'finish = "{program}"')
        job.write_text(text.replace('cut_with = "given"', programs))
        return compensate_and_keep(job, None, Keeping())

    corrected(1, tmp_path / first, FIRST)
    with pytest.raises(TrueloopError) as asked:
        corrected(2, tmp_path / second, SECOND)
    assert asked.value.code is Code.CMP_CUT_WITH and not (tmp_path / second / "o2").exists()
    named = asked.value.message.rpartition(": ")[2].partition(" (")[0]
    whole = corrected(2, tmp_path / second, SECOND, f'cut_with = "{named}"')
    assert all("29.946" in line or "35.946" in line for line in diameters(whole))
    assert (tmp_path / first / "trueloop.db").exists() and (tmp_path / second / "trueloop.db").exists()


@pytest.mark.parametrize(("most", "stated"), [(3, True), (2000, False)])
def test_a_note_states_that_not_all_folders_near_the_job_were_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, most: int, stated: bool
) -> None:
    monkeypatch.setattr("trueloop.jobs.turned.cut_with.MOST_FOLDERS", most)
    done = correct(tmp_path, 1, FIRST, "contour")
    assert any(f"looked for in {most} folders near the job" in note for note in done.correction.notes) == stated


@pytest.mark.parametrize("stored", [False, True])
def test_it_is_asked_for_where_the_time_of_the_measurement_is_not_stated(tmp_path: Path, stored: bool) -> None:
    """The answer that the hint names leads on; the files that were measured before stay possible."""
    db: Choice = str(tmp_path / "m.db") if stored else False
    if stored:
        run("db", "init", str(db))
    untimed = "# measured_at is not stated"
    first = correct(tmp_path, 1, FIRST, "contour", more=untimed, db=db)
    correct(tmp_path, 1, FIRST, "contour", more=untimed, db=db)  # made from these very readings
    with pytest.raises(TrueloopError) as asked:
        correct(tmp_path, 2, SECOND, "contour", more=untimed, db=db)
    assert asked.value.code is Code.CMP_CUT_WITH and first.correction.record.id in asked.value.message
    assert 'programs.cut_with = "given"' in asked.value.hint and not (tmp_path / "o2").exists()
    second = correct(tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"', untimed, db=db)
    assert all("29.946" in line or "35.946" in line for line in diameters(second))


def test_it_is_asked_for_where_only_one_of_the_two_jobs_states_the_tool_s_number(tmp_path: Path) -> None:
    correct(tmp_path, 1, FIRST, "contour")
    correct(tmp_path, 2, SECOND, "contour", 'cut_with = "given"')
    job = tmp_path / "j2.toml"
    job.write_text(job.read_text().replace("number = 3\nname", "name").replace('cut_with = "given"', ""))
    with pytest.raises(TrueloopError, match="CMP-CUT-WITH"):
        compensate_and_keep(job, tmp_path / "o2", Keeping(db=False))


def test_of_a_day_without_a_time_its_corrections_may_have_been_in_force(tmp_path: Path) -> None:
    """Files that state a date alone are read as midnight."""
    yesterday, before = ((datetime.now(UTC) - timedelta(days=days)).date() for days in (1, 2))
    correct(tmp_path, 1, FIRST, "contour")
    record = tmp_path / "o1/record.json"
    record.write_text(sealed(re.sub(r'("made_at": )"[^"]*"', rf'\1"{yesterday}T09:30:00+00:00"', record.read_text())))
    with pytest.raises(TrueloopError, match="CMP-CUT-WITH"):
        correct(tmp_path, 2, SECOND, "contour", "", f"measured_at = {yesterday}T00:00:00Z")
    second = correct(
        tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"', f"measured_at = {yesterday}T00:00:00Z"
    )
    assert all("29.946" in line or "35.946" in line for line in diameters(second))
    with pytest.raises(TrueloopError, match="MSR-OLD") as refused:  # the day before it was made
        correct(tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"', f"measured_at = {before}T00:00:00Z")
    assert "after_record" not in (refused.value.hint or "")


def test_a_correction_that_is_written_again_is_no_younger_than_the_part_that_it_cut(tmp_path: Path) -> None:
    correct(tmp_path, 1, FIRST, "contour")
    made_at = json.loads((tmp_path / "o1/record.json").read_text())["made_at"]
    time.sleep(1.1)  # records hold seconds
    measured_at = f"measured_at = {datetime.now(UTC).isoformat()}"
    time.sleep(1.1)
    compensate_and_keep(tmp_path / "j1.toml", tmp_path / "o1", Keeping(db=False))
    assert json.loads((tmp_path / "o1/record.json").read_text())["made_at"] == made_at
    with pytest.raises(TrueloopError, match="CMP-CUT-WITH"):
        correct(tmp_path, 2, SECOND, "contour", "", measured_at)


def test_it_is_asked_how_an_offset_was_in_force(tmp_path: Path) -> None:
    correct(tmp_path, 1, FIRST, "offset")
    with pytest.raises(TrueloopError) as asked:
        correct(tmp_path, 2, SECOND, "offset", 'cut_with = "o1/record.json"')
    assert asked.value.code is Code.CMP_CUT_WITH and "cut_by" in asked.value.hint


def test_contradictory_statements_of_what_cut_the_part_are_refused(tmp_path: Path) -> None:
    """Nothing was in force, and wear was; it was finished by the given program, and measured before its finish cut."""
    for programs, more in (('cut_by = "wear"', ""), ("", "measured_allowance_mm = 0.2")):
        with pytest.raises(TrueloopError) as refused:
            correct(tmp_path, 1, tuple(0.4 + e for e in FIRST), "offset", f'cut_with = "given"\n{programs}', more)
        assert refused.value.code is Code.CMP_CUT_WITH and refused.value.place is not None
    correct(tmp_path, 1, FIRST, "offset", 'cut_with = "given"')


@pytest.mark.parametrize(("by", "impossible"), [("offset", "offsets"), ("contour", "offsets"), ("offset", "corrected")])
def test_of_several_tools_no_program_with_offsets_was_in_force(tmp_path: Path, by: str, impossible: str) -> None:
    """None is written; the answer that the hint names leads on: what was entered is not to be entered again."""
    run("examples", "grooved", "-o", tmp_path)
    job = tmp_path / "grooved" / "grooved.toml"
    given = f'{job.read_text()}\n[compensation]\nby = "{by}"\n'
    job.write_text(given)
    run("compensate", job, "-o", tmp_path / "o1", "--no-store")
    assert not list((tmp_path / "o1").glob("offsets*"))

    def stated(key: str) -> Path:
        job.write_text(given.replace("[programs]\n", f'[programs]\ncut_with = "../o1/part.json"\n{key}'))
        touches = job.with_name("touches.csv")
        touches.write_text(touches.read_text() + "\n")  # measured anew
        return job

    refused = run("compensate", stated(f'cut_by = "{impossible}"\n'), "-o", tmp_path / "o2", "--no-store", status=3)
    assert "CMP-CUT-WITH" in refused and "without `cut_by`" in refused
    said = run("compensate", stated(""), "-o", tmp_path / "o2", "--no-store")
    assert ("stand in the control's wear table" in said) == (by == "offset")


def test_a_store_knows_the_corrections_of_the_program(tmp_path: Path) -> None:
    """Asked for once; stated by the id; then the store itself knows what cut the part."""
    db = str(tmp_path / "m.db")
    run("db", "init", db)
    first = correct(tmp_path, 1, FIRST, "contour", db=db)
    for file in first.files:
        if file.name == "record.json":
            file.unlink()
    with pytest.raises(TrueloopError) as asked:
        correct(tmp_path, 2, SECOND, "contour", db=db)
    record = first.correction.record.id
    assert asked.value.code is Code.CMP_CUT_WITH and record in asked.value.message
    job = tmp_path / "j2.toml"
    job.write_text(job.read_text().replace('name = "s"', 'name = "s, drawing B"'))
    with pytest.raises(TrueloopError) as renamed:
        compensate_and_keep(job, None, Keeping(db=db))
    assert renamed.value.code is Code.CMP_CUT_WITH and record in renamed.value.message
    second = correct(tmp_path, 2, SECOND, "contour", f'cut_with = "{record}"', db=db)
    assert all("29.946" in line or "35.946" in line for line in diameters(second))
    again = correct(tmp_path, 2, SECOND, "contour", db=db)
    assert all("29.946" in line or "35.946" in line for line in diameters(again))


def test_wear_does_not_last_at_a_control_whose_programs_set_the_offset() -> None:
    """GE 2000T: UPD sets the value, so that the next program would take back what had been entered."""
    inputs = read_job(Path(__file__).parents[2] / "examples/modbas2/job.toml").inputs
    record = compensate(replace(inputs, options=replace(inputs.options, by="offset"))).record
    assert in_force(record, Ran.OFFSETS, inputs.program, None).cut_with.ran is Ran.OFFSETS
    with pytest.raises(TrueloopError, match=r"CMP-CUT-WITH.*by \"offsets\", not by 'wear'"):
        in_force(record, Ran.WEAR, inputs.program, None)


def test_a_correction_of_another_tool_is_refused_in_a_job_of_one_tool(tmp_path: Path) -> None:
    correct(tmp_path, 1, FIRST, "offset")
    record = tmp_path / "o1/record.json"
    record.write_text(sealed(record.read_text().replace('"number": 3', '"number": 4')))
    with pytest.raises(TrueloopError, match=r"CMP-CUT-WITH.*of tool 4"):
        correct(tmp_path, 2, SECOND, "offset", 'cut_with = "o1/record.json"\ncut_by = "wear"')


def test_by_hand_lengths_from_a_face_that_the_tool_cuts_itself_ask_for_no_offset_along_z(tmp_path: Path) -> None:
    """Two shoulders 8 µm too far from the face: whatever Z of the tool is, face and shoulders move together."""
    job = shutil.copytree(Path(__file__).parents[2] / "examples/shaft", tmp_path / "shaft") / "job.toml"
    lengths = ["feature,from,length_mm", "shoulder-2,end-face,80.008", "shoulder-1,end-face,12.008", ""]
    (tmp_path / "shaft/lengths.csv").write_text("\n".join(lengths))
    job.write_text(job.read_text().replace('readings = "readings.csv"', 'readings = ["readings.csv", "lengths.csv"]'))
    inputs = read_job(job).inputs
    assert any("(datum)" in name for name in inputs.touches.gauged)
    decision = compensate(replace(inputs, options=replace(inputs.options, by="offset"))).decision
    assert decision.z.offset_mm == 0.0
    assert decision.z.expanded_u_mm is None


def test_another_program_s_correction_was_not_in_force(tmp_path: Path) -> None:
    correct(tmp_path, 1, FIRST, "contour")
    record = tmp_path / "o1" / "record.json"
    text = record.read_text()
    given = text.split('"program": {')[1].split('"sha256": "')[1][:64]
    record.write_text(sealed(text.replace(given, given[::-1])))
    with pytest.raises(TrueloopError) as refused:
        correct(tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"')
    assert refused.value.code is Code.CMP_OTHER_PROGRAM


def test_a_record_that_was_edited_is_refused_as_what_cut_the_part(tmp_path: Path) -> None:
    """A value, a word of the program and the hash itself; another layout of the same values is no edit."""
    correct(tmp_path, 1, FIRST, "contour")
    record = tmp_path / "o1" / "record.json"
    text = record.read_text()
    edits = [
        ('"x_radius_mm": -', '"x_radius_mm": '),
        ("X29.95", "X29.90"),
        ('"content_sha256": "', '"content_sha256": "0'),
    ]
    for before, after in edits:
        assert before in text
        record.write_text(text.replace(before, after))
        with pytest.raises(TrueloopError, match=r"REC-FILE.*was changed after trueloop wrote it"):
            correct(tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"')
    content = json.loads(text)
    record.write_text(json.dumps(content))
    correct(tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"')
    del content["content_sha256"]  # as earlier versions wrote it
    record.write_text(json.dumps(content))
    correct(tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"')
    content["changes"][-1]["before"] += "1"  # not what stands in the program that it names
    record.write_text(json.dumps(content))
    with pytest.raises(TrueloopError, match=r"REC-KEY.*'changes'"):
        correct(tmp_path, 2, SECOND, "contour", 'cut_with = "o1/record.json"')


@pytest.mark.parametrize("stored", [False, True])
def test_it_is_said_that_a_part_was_measured_before_the_corrections_beside_it(tmp_path: Path, stored: bool) -> None:
    """A measuring machine's clock that is behind would make it so: then the correction in force is forgotten."""
    db: Choice = str(tmp_path / "m.db") if stored else False
    if stored:
        run("db", "init", str(db))
    first = correct(tmp_path, 1, FIRST, "contour", db=db)
    assert not any("as cut by the given program" in note for note in first.correction.notes)
    hour_ago = datetime.now(UTC) - timedelta(hours=1)
    second = correct(tmp_path, 2, SECOND, "contour", more=f"measured_at = {hour_ago.isoformat()}", db=db)
    assert sum("it is taken as cut by the given program" in note for note in second.correction.notes) == 1


@pytest.mark.parametrize("key", ["touches", "readings"])
def test_what_was_measured_before_the_correction_is_not_of_it(tmp_path: Path, key: str) -> None:
    correct(tmp_path, 1, FIRST, "contour")
    more = 'measured_at = 2026-01-01T00:00:00Z\nafter_record = "o1/record.json"'
    if key == "touches":
        (tmp_path / "t.csv").write_text("point,feature,nominal_x_mm,nominal_z_mm,error_um\na,cylinder-2,15,-5,2\n")
        more = 'touches = "t.csv"\n' + more
    with pytest.raises(TrueloopError) as refused:
        correct(tmp_path, 2, SECOND, "contour", more=more)
    assert refused.value.code is Code.MSR_OLD


def test_a_z_reference_without_touches_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as refused:
        correct(tmp_path, 1, FIRST, "contour", more='z_reference = "7"')
    assert refused.value.code is Code.TCH_REFERENCE


def test_readings_that_are_all_exactly_nominal_get_a_remark(tmp_path: Path) -> None:
    def remarked(readings: tuple[float, ...]) -> bool:
        notes = correct(tmp_path, 1, readings, "contour", 'cut_with = "given"').correction.notes
        return any("All 4 readings are exactly nominal" in note for note in notes)

    assert remarked((0.0, 0.0, 0.0, 0.0))
    assert not remarked((0.0, 0.0, 0.0, 0.0001))


@pytest.mark.parametrize(("last_um", "remarked"), [(0.0, True), (0.1, False)])
def test_touches_that_are_all_exactly_zero_get_a_remark(tmp_path: Path, last_um: float, remarked: bool) -> None:
    """A column of zeros beside readings that were taken: the touches are remarked on, the readings are not."""
    head, places = "point,feature,nominal_x_mm,nominal_z_mm,error_um\n", (f"-8,{last_um}", "-5,0", "-3,0.000")
    rows = "".join(f"{k},cylinder-2,15,{place}\n" for k, place in enumerate(places))
    (tmp_path / "t.csv").write_text(head + rows)
    notes = correct(tmp_path, 1, FIRST, "contour", 'cut_with = "given"', more='touches = "t.csv"').correction.notes
    assert ["exactly" in note for note in notes if "exactly" in note] == [True] * remarked
    assert not remarked or "All 3 touches have an error of exactly 0" in " ".join(notes)


def test_another_feed_or_speed_of_the_semi_finish_cut_is_reported(tmp_path: Path) -> None:
    def words(semifinish: str) -> list[str]:
        (tmp_path / "semi.nc").write_text(semifinish)
        done = correct(tmp_path, 1, FIRST, "contour", 'semifinish = "semi.nc"')
        return [note for note in done.correction.notes if "The semi-finish cut has another" in note]

    assert words(PROGRAM) == []
    (feed,) = words(PROGRAM.replace("F0.1", "F0.25"))
    assert "another feed than the finish cut, 0.25 for 0.1" in feed
    (speed,) = words(PROGRAM.replace("S1500", "S3000"))
    assert "another spindle speed than the finish cut, 3000 for 1500" in speed
    (within,) = words(PROGRAM.replace("F0.1", "F0.1", 1).replace("X36.", "X36. F0.3"))
    assert "0.3 for 0.1 on cylinder-1" in within  # changed within the pass
    (mode,) = words(PROGRAM.replace("G97 S1500", "G96 S150"))
    assert "150 G96 for 1500 G97" in mode


@pytest.mark.parametrize("by", ["auto", "offset", "contour"])
def test_the_errors_of_another_tools_cut_are_not_taken_out_unasked(tmp_path: Path, by: str) -> None:
    """T0101 semi-finished: where its tip was set to is no error of T0303, which its contour would take over."""
    (tmp_path / "semi.nc").write_text(PROGRAM.replace("T0303", "T0101"))
    if by != "contour":
        with pytest.raises(TrueloopError) as refused:
            correct(tmp_path, 1, FIRST, by, 'semifinish = "semi.nc"')
        assert refused.value.code is Code.OFS_TOOL and "semi-finished with the offset T1" in refused.value.message
        assert (refused.value.override or "").startswith('compensation.by = "contour"') and not (
            tmp_path / "o1"
        ).exists()
        return
    done = correct(tmp_path, 1, FIRST, by, 'semifinish = "semi.nc"').correction
    assert not done.decision.by_offset and done.record.tool_offset is None and done.by_tool is None
    assert any("semi-finished with the offset T1 and is finished with T3" in note for note in done.notes)


def test_the_readings_of_a_finished_part_are_not_applied_twice_under_another_serial_number(tmp_path: Path) -> None:
    untimed = "# no measured_at"
    correct(tmp_path, 1, FIRST, "contour", 'cut_with = "given"', untimed)
    again = 'cut_with = "o1/record.json"'
    with pytest.raises(TrueloopError) as refused:
        correct(tmp_path, 2, FIRST, "contour", again, untimed)
    assert refused.value.code is Code.CMP_CUT_WITH and "this very measurement" in refused.value.message
    assert not (tmp_path / "o2").exists()
    correct(tmp_path, 2, SECOND, "contour", again, untimed)
    correct(tmp_path, 3, FIRST, "contour", again)  # measured later: parts of a series may read alike


@pytest.mark.parametrize(
    ("rough_mm", "said"),
    [
        (0.5, None),  # radii: as deep as the finish cut
        (0.55, None),
        (2.0, "The semi-finish cut is 2 mm deep on cylinder-2, the finish cut 0.5 mm"),
        (0.2, "The semi-finish cut is 0.2 mm deep on cylinder-2, the finish cut 0.5 mm"),
    ],
)
def test_another_depth_of_the_semi_finish_cut_is_reported(tmp_path: Path, rough_mm: float, said: str | None) -> None:
    """Along the cylinder of Ø 30: the pass before, the semi-finish pass 0.5 mm outside the finish pass, on the radius.

    On the other features the semi-finish pass takes 5 mm and more, of which the program shows nothing.
    """

    def body(more_mm: float) -> str:
        cut, corner, chamfer = 2 * more_mm, more_mm, f"C{1.0 + (2.0 - math.sqrt(2.0)) * more_mm:.3f}"
        return (
            f"G0 X0 Z2.\nG42 G1 Z{corner} F0.1\nX{30 + cut} ,{chamfer}\nZ{-30 + corner}\nX{36 + cut} ,{chamfer}\n"
            f"Z-50.\nG40 X{42 + cut}\nG0 X100. Z100.\n"
        )

    head = "O2\nG21 G40 G99\nT0303\nG97 S1500 M3\nG0 X40. Z2.\n"
    pass_before = f"G42 G1 X{30 + 2 * (0.5 + rough_mm)} Z2. F0.1\nZ-20.\nG40 X50.\n"
    (tmp_path / "semi.nc").write_text(f"{head}{pass_before}{body(0.5)}M30\n")
    programs = 'semifinish = "semi.nc"\nsemifinish_allowance_mm = 0.5\nfinish_lines = [5, 13]'
    notes = correct(tmp_path, 1, FIRST, "contour", programs).correction.notes
    found = [note for note in notes if "mm deep on" in note]
    assert [note.partition(": what was")[0] for note in found] == ([] if said is None else [said])


def test_a_part_too_large_by_one_amount_on_all_sides_may_have_its_allowance_on(tmp_path: Path) -> None:
    """30 µm along every normal: no offset of a tool does that, which leaves 21 µm on a cone of 45°. Stated as finished,
    it is corrected.
    """

    square = (("cylinder-1", 18, -40), ("face-1", 16, -30), ("cylinder-2", 15, -10), ("face-2", 5, 0))

    def measured(
        programs: str, errors_um: tuple[float, ...], places: tuple[tuple[str, float, float], ...] = square
    ) -> Done:
        rows = [f"{k},{n},{x},{z},{e}" for k, ((n, x, z), e) in enumerate(zip(places, errors_um, strict=True))]
        (tmp_path / "t.csv").write_text("\n".join(["point,feature,nominal_x_mm,nominal_z_mm,error_um", *rows]) + "\n")
        correct_job = 'touches = "t.csv"\nreadings = []\n'
        (tmp_path / "f.nc").write_text(PROGRAM)
        (tmp_path / "j.toml").write_text(
            '[part]\nname = "s"\nfrom_program = true\n[tool]\nnose_radius_mm = 0.2\nnumber = 3\n'
            f'[programs]\ndialect = "fanuc-lathe"\nfinish = "f.nc"\n{programs}\n[gauging]\n{correct_job}'
            '[output]\nfolder = "o"\n'
        )
        shutil.rmtree(tmp_path / "out", ignore_errors=True)
        return compensate_and_keep(tmp_path / "j.toml", tmp_path / "out" / "o", Keeping(db=False))

    alike = (30.0, 31.0, 29.0, 30.0)
    with pytest.raises(TrueloopError) as asked:
        measured("", alike)
    assert asked.value.code is Code.CMP_ALLOWANCE and "0.030" in asked.value.hint
    assert measured('cut_with = "given"', alike).correction.decision.offset_mm[0] == pytest.approx(-0.030, abs=0.002)
    with pytest.raises(TrueloopError) as asked:
        measured("", alike[:3], square[:3])
    assert asked.value.code is Code.CMP_ALLOWANCE
    measured("", (30.0, 30.0, 31.0), (square[0], square[2], ("cylinder-2", 15, -5)))  # one direction: as a tool set off
    measured("", (30.0, 4.0, 31.0, 5.0))
    measured("", (-30.0, -31.0, -29.0, -30.0))
    slanted = (("cylinder-1", 18, -40), ("cylinder-2", 15, -20), ("cylinder-2", 15, -10), ("cone-2", 14.5, -0.5))
    with pytest.raises(TrueloopError) as asked:
        measured("", alike, slanted)
    assert asked.value.code is Code.CMP_ALLOWANCE
    measured("", (30.0, 30.0, 30.0, 30.0 * 0.7071), slanted)


def test_a_further_inspection_of_a_finished_part_is_not_one_before_its_finish_cut(tmp_path: Path) -> None:
    """Another part of the number, or one that was cut again, may be meant: it is stated that one cut was measured."""
    db = str(tmp_path / "m.db")
    run("db", "init", db)
    kept = [correct(tmp_path, 1, read, "contour", 'cut_with = "given"', db=db).kept for read in (FIRST, (0.051,) * 4)]
    assert kept[0] is not None and kept[1] is not None
    (said,) = [one for one in kept[1].findings if one.code is Code.STO_STAGE]
    assert "measured again: both inspections are of one cut" in said.message and "cut again" in said.hint
    assert not [one for one in kept[0].findings if one.code is Code.STO_STAGE]


def test_a_finished_part_is_kept_by_both_devices(tmp_path: Path) -> None:
    """Corrected by what was read beside the machine, then measured again: one cut of one edge, nothing replaced."""
    db = str(tmp_path / "m.db")
    run("db", "init", db)
    correct(tmp_path, 1, FIRST, "contour", 'cut_with = "given"', db=db)
    rows = [f"{k},{name},{d / 2},{z},49.0" for k, (name, z, d) in enumerate(PLACES)]
    touched = tmp_path / "touched.csv"
    touched.write_text("\n".join(["point,feature,nominal_x_mm,nominal_z_mm,error_um", *rows]) + "\n")
    said = ("--after", "released", "--ran", "as-programmed", "--job", tmp_path / "j1.toml", "--db", db)
    run("measure", "read", touched, *said)
    (kept,) = find(open_store(db, codec=store_codec()), Cut)
    assert kept.value.setting is not None and kept.value.setting.edge.tool.corner_radius_mm == 0.2
