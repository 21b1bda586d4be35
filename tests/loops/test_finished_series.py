"""Finished parts one after the other: each goes on with the series of the correction it names, or notes why not."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Final, get_args

import numpy as np
import pytest

from tests.loops import test_cut_with
from tests.loops.test_cut_with import FIRST, PLACES, SECOND, correct
from tests.support.cli import run
from tests.support.profiles import polyline
from trueloop.arrays import Array
from trueloop.domain.inspection import Touch
from trueloop.domain.life import Ran
from trueloop.domain.option import MemoryUse
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.store.opened import Choice, Keeping
from trueloop.jobs.turned.compensate import Done, compensate_and_keep
from trueloop.loops.turned.finished_parts import _used, recorded_series
from trueloop.loops.turned.made_parts import moved_mm, taken_off_sizes_mm
from trueloop.loops.turned.next_measurement import OfSeries
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.touches.touches import Gauging, error_vectors

STEPS = checked_profile(polyline([(20.0, -60.0), (20.0, 0.0), (0.0, 0.0)], ["thin", "end"]))


def series(folder: Path, parts: int, programs: str = "") -> Done:
    """A series corrected by contours: 25, 27, 33 µm on the radius, had nothing been corrected."""
    taken_um, done = 0.0, None
    for part, radius_um in list(enumerate((25.0, 27.0, 33.0), 1))[:parts]:
        done = correct(folder, part, (2e-3 * (radius_um + taken_um),) * 4, "contour", f"{force(part)}\n{programs}")
        taken_um = -radius_um
    assert done is not None
    return done


def force(part: int) -> str:
    return f'cut_with = "o{part - 1}/record.json"' if part > 1 else ""


def changed(folder: Path, part: int, before: str, after: str) -> Done:
    """The correction of a part by its job with another text in one place."""
    text = (folder / f"j{part}.toml").read_text()
    assert text.count(before) == 1
    job = folder / "changed.toml"
    job.write_text(text.replace(before, after))
    return compensate_and_keep(job, folder / "changed", Keeping(db=False))


def kept_parts(done: Done) -> int:
    kept = done.correction.record.model["finished_parts"]
    assert isinstance(kept, list)
    return len(kept)


def test_each_use_of_a_series_has_its_own_record_and_none_loses_parts(tmp_path: Path) -> None:
    """The series corrects otherwise than its last part alone, and the id in the program names the correction."""
    series(tmp_path, 3)
    job, uses = tmp_path / "j3.toml", get_args(MemoryUse)
    done = {use: compensate_and_keep(job, tmp_path / use, Keeping(db=False), memory=use) for use in uses}
    assert len({one.correction.record.id for one in done.values()}) == 4
    assert {use: kept_parts(one) for use, one in done.items()} == dict.fromkeys(done, 3)
    for use in ("off", "frozen"):
        note = f"The 2 finished parts before this one are kept, and not used: `memory.use` is {use}"
        assert sum(note in words for words in done[use].correction.notes) == 1


@pytest.mark.parametrize(
    ("before", "after", "named"),
    [
        ('name = "s"', 'name = "another"', "are of s, it is of another"),
        ('name = "s"', 'name = "s"\nrevision = "B"', "are of s, it is of s B"),
        ('corner = "1"', 'corner = "2"', "are of T3 DNMG 1, it is of T3 DNMG 2"),
        ('machine = "A"', 'machine = "B"', "are of A, it is of B"),
        ('machine = "A"', "", ""),
    ],
)
def test_a_part_made_otherwise_begins_a_new_series(tmp_path: Path, before: str, after: str, named: str) -> None:
    """A note names the difference; a machine that is not stated is none."""
    assert kept_parts(series(tmp_path, 3, 'machine = "A"')) == 3
    third = changed(tmp_path, 3, before, after)
    assert kept_parts(third) == (1 if named else 3)
    assert sum("begins a new series" in note for note in third.correction.notes) == bool(named)
    assert any(named in note for note in third.correction.notes)


@pytest.mark.parametrize("damage", [[{"points": []}], [1], 5, "along_mm", "error_mm"])
def test_a_damaged_series_is_refused(tmp_path: Path, damage: object) -> None:
    series(tmp_path, 2)
    record = tmp_path / "o2" / "record.json"
    content = json.loads(record.read_text())
    del content["content_sha256"]
    if isinstance(damage, str):
        content["model"]["finished_parts"][0]["readings"][0]["value_mm"] = None
        content["model"]["finished_parts"][0]["points"][0][damage] = None
    else:
        content["model"]["finished_parts"] = damage
    record.write_text(json.dumps(content, indent=2))
    with pytest.raises(TrueloopError) as refused:
        correct(tmp_path, 3, SECOND, "contour", force(3))
    assert refused.value.code is Code.REC_KEY and "model.finished_parts" in refused.value.message
    assert refused.value.place is not None and not (tmp_path / "o3").exists()


@pytest.mark.parametrize(("left_mm", "share"), [(0.050, 0), (0.0, None), (0.006, None), (-0.050, 200), (0.100, -100)])
def test_an_offset_that_does_not_show_on_the_part_is_asked_about(
    tmp_path: Path, left_mm: float, share: int | None
) -> None:
    """25 µm on the radius are stated to be entered. By hand: what is left of Ø +0.050 shows that nothing, twice as much
    or the opposite was; a wear of 3 µm is none of these.
    """
    correct(tmp_path, 1, FIRST, "offset")
    second = correct(tmp_path, 2, (left_mm,) * 4, "offset", 'cut_with = "o1/record.json"\ncut_by = "wear"')
    asked = [
        re.search(r"X (\S+) µm .* before this one, (-?\d+) % ± \d+ % shows", note) for note in second.correction.notes
    ]
    found = [(one[1], int(one[2])) for one in asked if one]
    assert found == ([] if share is None else [("−25.0", share)])


def arrived(done: Done) -> list[tuple[str, ...]]:
    """Offset X and Z that were added since the part before, share and U of what shows, as the notes state them."""
    asked = r"X (\S+) µm \(radius\), Z (\S+) µm .* before this one, (-?\d+) % ± (\d+) % shows"
    return [found.groups() for note in done.correction.notes if (found := re.search(asked, note))]


def test_of_offsets_entered_one_after_the_other_the_last_step_is_asked_about(tmp_path: Path) -> None:
    """By hand: −25 µm of which 20 µm too much on Ø show 20 %, then −20 µm more that do not show at all. Two cuts differ
    by √2·2 µm together and √2·1.5 µm on each of both cylinders: u = 3.20 µm, U = 26 % of 25 µm and 32 % of 20 µm.
    """
    correct(tmp_path, 1, FIRST, "offset")
    second = correct(tmp_path, 2, (0.040,) * 4, "offset", f'{force(2)}\ncut_by = "wear"')
    assert arrived(second) == [("−25.0", "0.0", "20", "26")]
    third = correct(tmp_path, 3, (0.040,) * 4, "offset", f'{force(3)}\ncut_by = "wear"')
    assert arrived(third) == [("−20.0", "0.0", "0", "32")]


@pytest.mark.parametrize(
    ("cylinders_um", "face_um", "share"), [(0, -30, 41), (25, 0, 59), (0, 0, None), (25, -30, 0), (50, -60, -100)]
)
def test_an_offset_in_z_that_does_not_show_on_a_face_is_asked_about(
    tmp_path: Path, cylinders_um: float, face_um: float, share: int | None
) -> None:
    """X −25 µm and Z +30 µm are stated to be entered. By hand: X alone shows 25²/(25² + 30²) of it, Z alone the rest; U
    is 2·3.20 µm of 39.05 µm.
    """

    def part(number: int, radius_um: float, face_um: float, programs: str) -> Done:
        rows = "".join(f"{x},face-1,{x},-30,{face_um}\n" for x in (16.5, 15.5))
        (tmp_path / "t.csv").write_text(f"point,feature,nominal_x_mm,nominal_z_mm,error_um\n{rows}")
        return correct(tmp_path, number, (2e-3 * radius_um,) * 4, "offset", programs, 'touches = "t.csv"')

    part(1, 25.0, -30.0, "")
    second = part(2, cylinders_um, face_um, f'{force(2)}\ncut_by = "wear"')
    assert arrived(second) == ([] if share is None else [("−25.0", "30.0", f"{share}", "16")])


def test_an_offset_along_an_axis_that_the_read_surfaces_do_not_show_does_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """X and Z are entered; the next part is read on a cylinder and on a line that rises by 0.2 mm over 29 mm: ±2 µm of
    scatter between them would be 0.6 mm along Z.
    """
    slope = (("cylinder-2", -5, 30.0 + 0.4 * 4 / 29), ("cylinder-2", -25, 30.0 + 0.4 * 24 / 29))
    monkeypatch.setattr(test_cut_with, "PROGRAM", test_cut_with.PROGRAM.replace("\nZ-30.\nX36.", "\nX30.4 Z-30.\nX36."))
    monkeypatch.setattr(test_cut_with, "PLACES", (*slope, *PLACES[2:]))
    head = "point,feature,nominal_x_mm,nominal_z_mm,error_um\n"
    (tmp_path / "t.csv").write_text(f"{head}a,face-1,16.5,-30,-30\nb,face-1,15.5,-30,-30\n")
    first = correct(tmp_path, 1, FIRST, "offset", more='touches = "t.csv"').correction.record.tool_offset
    assert first is not None and first.z_mm == pytest.approx(0.030, abs=1e-3)
    second = correct(tmp_path, 2, (-0.004, -0.004, 0.004, 0.004), "offset", f'{force(2)}\ncut_by = "wear"')
    assert arrived(second) == []


def test_a_part_of_a_series_is_judged_by_its_own_readings(tmp_path: Path) -> None:
    """Ø30 ± 0.012 read at 30.010 and 30.014, standard 1 µm: out by 2 µm, more than 1.645 µm, whatever parts before it
    were; the probability of a normal distribution two standard deviations inside.
    """
    asked = '[[part.characteristic]]\nname = "D30"\nquantity = "diameter"\nfeature = "cylinder-2"\ntolerance = "±0.012"'
    part = "readings_u_um = 1\n" + asked
    readings = ((0.036,) * 4, (0.008,) * 4, (0.010, 0.014, 0.012, 0.012))
    done = [correct(tmp_path, k, each, "contour", force(k), part) for k, each in enumerate(readings, 1)][-1]
    assert any("By 3 finished parts of this series" in note for note in done.correction.notes)
    before = done.correction.characteristics[0].before
    assert before is not None and before.verdict == "out"
    assert (before.value, before.standard_u) == pytest.approx((30.014, 0.001), abs=1e-9)
    assert before.probability_in is not None and before.probability_in <= 0.5 * math.erfc(2.0 / math.sqrt(2.0)) + 1e-9


@pytest.mark.parametrize("parts", [1, 3])
def test_a_plan_of_measurements_states_the_probability_of_the_correction(tmp_path: Path, parts: int) -> None:
    """By job and by serial number: what finished parts show of the next one is one state, of one part and of three."""
    asked = '[[part.characteristic]]\nname = "D30"\nquantity = "diameter"\nfeature = "cylinder-2"\ntolerance = "±0.012"'
    db = str(tmp_path / "m.db")
    run("db", "init", db)
    readings = ((0.036,) * 4, (0.003,) * 4, (0.002, 0.004, 0.003, 0.003))[:parts]
    done = [correct(tmp_path, k, each, "contour", force(k), asked, db) for k, each in enumerate(readings, 1)][-1]
    after = done.correction.characteristics[0].after
    assert after is not None and after.probability_in is not None
    for of in (tmp_path / f"j{parts}.toml", parts):
        before = json.loads(run("measure", "next", of, "--db", db, "--json"))["before"]
        assert before == pytest.approx(1.0 - after.probability_in, rel=0.35, abs=1e-4)


def test_readings_without_a_nominal_value_are_diagnosed_on_the_profile_that_they_corrected(tmp_path: Path) -> None:
    """Ø30 and Ø36 read 50 µm too large by a gauge: 25 µm on the radius, and nothing of a probe."""
    db = str(tmp_path / "m.db")
    run("db", "init", db)
    correct(tmp_path, 1, FIRST, "contour", 'cut_with = "given"', db=db)
    said = run("diagnose", "part", "1", "--db", db)
    assert "CMM or gauge" in said and "probe" not in said
    assert "cylinder-2, radius: +25.0" in said and "cylinder-1, radius: +25.0" in said
    # A later inspection of one diameter: the other keeps its reading.
    (tmp_path / "again.csv").write_text("feature,z_mm,diameter_mm\ncylinder-2,-5,30.060\n")
    run("measure", "read", tmp_path / "again.csv", "--job", tmp_path / "j1.toml", "--after", "released", "--db", db)
    said = run("diagnose", "part", "1", "--db", db)
    assert "cylinder-2, radius: +30.0" in said and "cylinder-1, radius: +25.0" in said


@pytest.mark.parametrize("stored", [False, True])
def test_a_part_measured_again_was_not_cut_with_the_correction_made_from_it(tmp_path: Path, stored: bool) -> None:
    """What the hint names leads on: what cut the part, or another serial number for it."""
    db: Choice = str(tmp_path / "m.db") if stored else False
    if stored:
        run("db", "init", str(db))
    first = correct(tmp_path, 1, FIRST, "contour", db=db)
    own = f'cut_with = "{first.correction.record.id if stored else "o1/record.json"}"'
    with pytest.raises(TrueloopError) as refused:
        correct(tmp_path, 1, SECOND, "contour", own, db=db)
    assert refused.value.code is Code.CMP_CUT_WITH and refused.value.values["corrections"]
    assert refused.value.place is not None and "given program" in refused.value.hint
    correct(tmp_path, 2, SECOND, "contour", own, db=db)
    correct(tmp_path, 1, FIRST, "contour", 'cut_with = "given"', db=db)


def test_an_average_keeps_the_uncertainty_of_the_z_reference() -> None:
    """400 touches of a face, each 3 µm uncertain by itself and 4 µm by the reference: an average of ten is by 3/√10 µm
    and by 4 µm.
    """
    rng = np.random.default_rng(1)
    touches = [Touch("zero", (19.0, 0.0), "end", error_mm=0.0)]
    touches += [
        Touch(f"t{k}", (18.0 - 0.04 * k, 0.0), "end", error_mm=float(1e-3 * rng.standard_normal())) for k in range(400)
    ]
    vectors = error_vectors(STEPS, touches, Gauging(z_reference="zero"))
    vectors = replace(vectors, standard_u_mm=np.where(vectors.at_reference, 0.004, 0.005))
    kept = _used(fit_profile(STEPS, vectors))
    many = ~kept.at_reference
    assert np.count_nonzero(many) == 40
    assert kept.own_u_mm[many] == pytest.approx(0.003 / np.sqrt(10.0))
    assert kept.standard_u_mm[many] == pytest.approx(np.hypot(0.004, 0.003 / np.sqrt(10.0)))


SIZES: Final = (
    *((f"{name} {-z}", name, "", "diameter", z, size) for name, z, size in PLACES),
    ("step", "face-1", "face-2", "length", "", 30.0),
)
"""Characteristic, feature, from, quantity, z and nominal of what the shop measures."""
LONG_MM: Final = 0.005
"""The step is too long on every part: face-1 lies that much nearer to the chuck than it should."""


def shop(folder: Path, way: Ran) -> tuple[Array, Array]:
    """Four parts of a tool that stands 15 µm too far out and wears by 1.5 µm a part, each cut by what the part before
    it led to, as is stated. Returns the errors of sizes of uncorrected parts (parts, sizes), mm, and by how much each
    was made smaller, by the number entered or the text run.
    """
    free = [[LONG_MM if size[3] == "length" else 2e-3 * (15.0 + 1.5 * part) for size in SIZES] for part in range(1, 5)]
    less, entered_mm = [np.zeros(len(SIZES))], 0.0
    for part, own in enumerate(free, 1):
        by = "contour" if way is Ran.CORRECTED else "offset"
        correct(folder, part, FIRST, by, f'{force(part)}\ncut_by = "{way}"' if part > 1 else 'cut_with = "given"')
        keep_readings(folder / f"m{part}.csv", part, np.array(own) - less[-1])
        job = folder / f"j{part}.toml"
        job.write_text(job.read_text().replace(f"r{part}.csv", f"m{part}.csv"))
        done = compensate_and_keep(job, folder / f"o{part}", Keeping(db=str(folder / "m.db")))
        if way is Ran.CORRECTED:
            less.append(smaller_by_text((folder / f"o{part}" / "corrected.nc").read_text()))
        else:
            offset = done.correction.record.tool_offset
            assert offset is not None and offset.z_mm == 0.0
            entered_mm = offset.x_radius_mm + (entered_mm if way is Ran.WEAR else 0.0)
            less.append(np.array([-2.0 * entered_mm] * len(PLACES) + [0.0]))
        taken = taken_off_sizes_mm(done.correction, way, done.correction.record.inspections[-1])
        assert [taken[size[0]] for size in SIZES] == pytest.approx(less[-1], abs=0.0015)
    return np.array(free), np.array(less[:-1])


def keep_readings(file: Path, part: int, error_mm: Array) -> None:
    rows = [",".join(map(str, (*one, round(one[-1] + e, 4)))) for one, e in zip(SIZES, error_mm.tolist(), strict=True)]
    head = f"# serial: {part}\n# expanded_uncertainty_um: 2\ncharacteristic,feature,from,quantity,z_mm,nominal,value_mm"
    file.write_text("\n".join([head, *rows]) + "\n")


def smaller_by_text(text: str) -> Array:
    """How much smaller each size is by the words of a program, mm: cylinders from corner to corner, then the step."""
    x, z, corners = 0.0, 0.0, list[tuple[float, float]]()
    for line in text[text.index("G42") :].splitlines()[:7]:
        for axis, word in re.findall(r"([XZ])(-?\d+\.?\d*)", line):
            x, z = (float(word), z) if axis == "X" else (x, float(word))
        corners.append((x, z))
    ends = {"cylinder-2": np.array(corners[2:4]), "cylinder-1": np.array(corners[5:7])}
    cut = [float(np.interp(-z, -ends[name][:, 1], ends[name][:, 0])) for name, z, _ in PLACES]
    return np.array([size - one for (*_, size), one in zip(PLACES, cut, strict=True)] + [30.0 + corners[3][1]])


def test_an_offset_in_force_under_a_corrected_contour_is_taken_off_with_it(tmp_path: Path) -> None:
    """By hand: Ø +50 µm, wear −25 µm entered; Ø +8 µm on it, the contour then moved by −4 µm: 29 µm off the radius."""
    correct(tmp_path, 1, FIRST, "offset")
    second = correct(tmp_path, 2, (0.008,) * 4, "contour", f'{force(2)}\ncut_by = "wear"').correction
    assert not second.decision.by_offset and second.cut_with.offset_mm[0] == pytest.approx(-0.025, abs=1e-9)
    index, along = np.array([second.profile.names.index("cylinder-2")]), np.array([5.0])
    assert moved_mm(second, Ran.CORRECTED, index, along) == pytest.approx([-0.029], abs=1e-3)


def test_the_measured_part_of_a_series_is_its_latest_and_the_cut_planned_for_the_next(tmp_path: Path) -> None:
    """The latest part is known where it was read, the next one is as uncertain as the correction states."""
    known = recorded_series(series(tmp_path, 3).correction)
    assert known is not None
    at = known.vectors.feature_index[:1], known.vectors.arc_length_mm[:1]
    errors = OfSeries(known).errors(*at)
    measured, following = ((rows @ errors.covariance @ rows.T).item() for rows in (errors.measured, errors.following))
    assert measured < 0.3 * following
    predicted = known.next_part(*at).covariance_mm2.item()
    assert following + errors.following_mm2[0] == pytest.approx(predicted, rel=1e-9)


@pytest.mark.parametrize("way", [Ran.WEAR, Ran.OFFSETS, Ran.CORRECTED])
def test_a_diagnosis_takes_out_what_the_shop_entered_or_ran(tmp_path: Path, way: Ran) -> None:
    """A diagnosis of parts cut with corrections is that of parts that would have been cut without, with a job and
    without: an offset moves cylinders by as much and no length, a program what its text moved. All of it arrived. What
    a device is stated to have measured is what it measured.
    """
    db, free = str(tmp_path / "m.db"), str(tmp_path / "free.db")
    for one in (db, free):
        run("db", "init", one)
    own, less = shop(tmp_path, way)
    assert np.all(less[1:, : len(PLACES)] > 0.02)
    for part, error_mm in enumerate(own, 1):
        keep_readings(tmp_path / f"free{part}.csv", part, error_mm)
        run("series", "add", tmp_path / f"free{part}.csv", "--type", "s", "--db", free)
    job = ("-j", tmp_path / "j4.toml")
    ways = ((db, ()), (db, job), (free, job))
    found = [json.loads(run("diagnose", "series", "--db", of, "--json", *more)) for of, more in ways]
    assert found[0] == found[1] and not found[0]["findings"]
    assert found[0]["causes"]["gain"] == 1.0
    likely, uncorrected = (
        {one["key"]: one["probability"] for one in each["causes"]["candidates"]} for each in found[1:]
    )
    keys = {*likely, *uncorrected}
    assert [likely.get(key, 0.0) for key in keys] == pytest.approx([uncorrected.get(key, 0.0) for key in keys], abs=0.1)
    assert likely.get("tool-loose", 0.0) < 0.05
    said = found[1]["causes"]["candidates"][0]["supports"][0]
    stated = re.search(r"(cylinder-\d): .* finds (\S+) µm \((\S+) µm of the process without corrections\) on", said)
    assert stated is not None
    rows = [k for k, one in enumerate(SIZES) if one[1] == stated[1]]
    radial_um = [500.0 * float(np.mean(of[:, rows])) for of in (own - less, own)]
    assert [float(one.replace("−", "-")) for one in stated.groups()[1:]] == pytest.approx(radial_um, abs=0.5)
