"""A shaft turned at both its sides: cut by a model, touched once in the part's frame, corrected, and cut again.

LinuxCNC's interpreter says where each program sends the nose's centre in its own set-up; the model turns the part
round, moves the nose's circle there by the tool's own offset error and wear, and the part is what the circles leave.
"""

import json
import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke, run
from tests.support.grooved import Cutting
from tests.support.linuxcnc import Tool, interpret
from tests.support.two_sides import BORE, FIRST, FRAMES, NOSE_MM, PLACES, SECOND, first, job, measured_um, second
from trueloop.arrays import Array
from trueloop.jobs.turned.compensate import corrected_part
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.part import PartCorrection

SET_OFF = {FIRST: Cutting((0.012, -0.004)), SECOND: Cutting((-0.007, 0.009)), BORE: Cutting((0.005, 0.006))}
"""Tools that are set wrong, by (x, Z) on the machine, and nothing else."""
CONTOUR = '[compensation]\nby = "contour"\n'


def worn(n: tuple[float, float]) -> float:
    """A nose that has lost 6 µm where it cuts diameters, 2 µm where it cuts faces, and more between them."""
    return 0.006 * n[0] ** 2 + 0.002 * n[1] ** 2 + 0.012 * n[0] * n[1]


WORN = {tool: Cutting(cutting.off_mm, worn) for tool, cutting in SET_OFF.items()}
MIRRORED = {"first": FRAMES["first"], "second": "zero_at_z_mm = -80.0\nmirrored_z = true"}
NOT_TURNED = {"first": FRAMES["first"], "second": "zero_at_z_mm = -80.0"}


def programs(folder: Path, out: str = "") -> Mapping[str, Path]:
    """The given ones, or those in a folder of results, of which a set-up has none that is run as given."""
    given = {name: folder / f"{name}.ngc" for name in ("first", "second")}
    made = {name: folder / out / f"corrected-{name}.ngc" for name in given}
    return {name: made[name] if out and made[name].exists() else given[name] for name in given}


def touched(folder: Path, cuttings: Mapping[int, Cutting], out: str = "", *, turned_round: bool = True) -> Array:
    """Errors at all places of the part that the programs cut, µm."""
    for name, text in (("first", first("linuxcnc")), ("second", second("linuxcnc"))):
        if not (folder / f"{name}.ngc").exists():
            (folder / f"{name}.ngc").write_text(text)
    return measured_um(programs(folder, out), cuttings, turned_round=turned_round)


def corrected(
    folder: Path, errors_um: Sequence[float] | Array, more: str = "", frames: Mapping[str, str] = FRAMES, part: str = ""
) -> PartCorrection:
    """As the command does it, and its files in `out`."""
    path = job(folder, list(errors_um), more, frames=frames, part=part)
    run("compensate", path, "-o", folder / "out")
    return corrected_part(JobFiles.of(path))


def by_tool(done: PartCorrection) -> dict[str, Correction]:
    """Corrections by what calls the edge."""
    return {e.tool: e.correction for one in done.setups for e in one.edges if e.correction is not None}


def on(*features: str) -> Array:
    """1 at the places on these features, else 0."""
    return np.array([float(place.feature in features) for place in PLACES])


def test_the_model_cuts_a_good_part_and_errs_as_it_is_told(tmp_path: Path) -> None:
    """By hand: a tool that stands off by o on its machine errs by n·o; turned round, n_Z is −n_z of the part.

    Of the edge of R 2, which is a circle that has moved, by (t·o)²/2R less, 0.03 µm.
    """
    good = touched(tmp_path, dict.fromkeys(NOSE_MM, Cutting((0.0, 0.0))))
    assert np.max(np.abs(good)) < 0.06  # the programs' rounding to 0.1 µm
    off = touched(tmp_path, SET_OFF) - good
    turns = {FIRST: 1.0, SECOND: -1.0, BORE: -1.0}
    expected = [
        1e3 * (p.normal[0] * SET_OFF[p.tool].off_mm[0] + turns[p.tool] * p.normal[1] * SET_OFF[p.tool].off_mm[1])
        for p in PLACES
    ]
    o_x, o_z = SET_OFF[SECOND].off_mm
    across = np.array([(o_x * -turns[p.tool] * p.normal[1] + o_z * p.normal[0]) ** 2 for p in PLACES])
    np.testing.assert_allclose(off, expected - on("edge") * 1e3 * across / (2 * 2.0), atol=0.005)


def test_each_tool_gets_the_offset_that_it_is_off_by_in_its_own_set_up(tmp_path: Path) -> None:
    """By hand: −o, X as a diameter, Z as the program of the set-up has it. Entered, the given programs cut true."""
    done = corrected(tmp_path, touched(tmp_path, SET_OFF))
    assert not list((tmp_path / "out").glob("corrected-*"))
    entered = {}
    for tool, correction in by_tool(done).items():
        assert correction.decision.by_offset
        wear, (off_x, off_z) = correction.wear, SET_OFF[int(tool[1:])].off_mm
        assert (wear.x, wear.z) == pytest.approx((-2 * off_x, -off_z), abs=2e-4)
        entered[wear.tool] = Cutting((off_x + wear.x / 2, off_z + wear.z))
    assert set(entered) == {FIRST, SECOND, BORE}
    assert np.max(np.abs(touched(tmp_path, entered))) < 0.15


def test_wear_is_taken_out_by_the_contours_of_both_programs(tmp_path: Path) -> None:
    """After the cut with the corrected programs only rounding is left; with the signs turned all is there twice."""
    errors_um = touched(tmp_path, WORN)
    assert np.max(np.abs(errors_um)) > 15.0
    corrected(tmp_path, errors_um, CONTOUR)
    assert np.max(np.abs(touched(tmp_path, WORN, "out"))) < 0.2
    turned = tmp_path / "apart" / "turned"  # not near the corrections of the same programs
    turned.mkdir(parents=True)
    corrected(turned, -errors_um, CONTOUR)
    np.testing.assert_allclose(touched(turned, WORN, "out"), 2 * errors_um, atol=0.5)


def test_a_part_that_is_too_long_is_faced_deeper_in_each_set_up(tmp_path: Path) -> None:
    """By hand: 6 µm too long in front, 10 µm at the back: the nose's centre goes to Z 0.8 − 0.006 and 0.8 − 0.010."""
    corrected(tmp_path, 6.0 * on("front", "step") + 10.0 * on("back", "back-step"), CONTOUR)
    faced = {}
    for name, file in programs(tmp_path, "out").items():
        moves = interpret(file, tools=[Tool(tool, NOSE_MM[tool]) for tool in NOSE_MM])
        faced[name] = next(move.end_mm[2] for move in moves if move.kind == "line" and abs(move.end_mm[2] - 0.8) < 0.05)
    assert faced == pytest.approx({"first": 0.794, "second": 0.790}, abs=1.1e-4)


def test_a_taper_leans_the_right_way_in_a_program_that_is_turned_round(tmp_path: Path) -> None:
    """By hand: the back seat grows by 0.5 µm a mm towards the back, 0 at the collar: X 2 (19.8 − 0.014) at Z −2."""
    along = np.array([0.5 * (-50.0 - p.z_mm) if p.feature == "back-seat" else 0.0 for p in PLACES])
    slope = np.array([14.0 * p.normal[0] if p.feature == "edge" else 0.0 for p in PLACES])
    corrected(tmp_path, along + slope, CONTOUR)
    large, small = ends_of_back_seat(tmp_path)
    assert (large, small) == pytest.approx((2 * (19.8 - 0.014), 2 * (19.8 - 0.5e-3 * 0.8)), abs=1e-3)


def ends_of_back_seat(folder: Path) -> tuple[float, float]:
    """X of the second side's corrected cut over the back seat, a diameter, at Z −2 and at Z −29.2."""
    moves = interpret(programs(folder, "out")["second"], tools=[Tool(tool, NOSE_MM[tool]) for tool in NOSE_MM])
    cuts = [m for m in moves if m.kind == "line" and max(abs(m.start_mm[0] - 19.8), abs(m.end_mm[0] - 19.8)) < 0.05]
    assert cuts[0].start_mm[2] == pytest.approx(-2.0, abs=0.05) and cuts[-1].end_mm[2] == pytest.approx(-29.2, abs=0.05)
    return 2 * cuts[0].start_mm[0], 2 * cuts[-1].end_mm[0]


def test_measured_points_are_of_the_parts_frame(tmp_path: Path) -> None:
    """The back face is touched at z −80.010: by hand T2's Z goes in by 10 µm; the collar is not its to move."""
    path = job(tmp_path, [0.0] * len(PLACES))
    rows = ["point,feature,nominal_x_mm,nominal_z_mm,measured_x_mm,measured_z_mm"]
    for k, p in enumerate(PLACES, 1):
        long_mm = 0.010 if p.feature in ("back", "back-step") else 0.0
        rows.append(f"{k},{p.feature},{p.x_mm:.6f},{p.z_mm:.6f},{p.x_mm:.6f},{p.z_mm - long_mm:.6f}")
    rows = [row for row in rows if ",edge," not in row]
    (tmp_path / "touches.csv").write_text("\n".join([*rows, ""]))
    wear = by_tool(corrected_part(JobFiles.of(path)))["T2"].wear
    assert (wear.x, wear.z) == pytest.approx((0.0, -0.010), abs=1e-4)


def test_z_may_count_from_a_face_of_the_other_set_up(tmp_path: Path) -> None:
    """The front is 6 µm too long and the back 10: counted from the front, by hand, the back and T2's Z are 16 µm."""
    errors_um = 6.0 * on("front") + 10.0 * on("back", "back-step")
    reference = str(1 + next(k for k, p in enumerate(PLACES) if p.feature == "front" and p.x_mm == 10.0))
    path = job(tmp_path, errors_um.tolist(), f'z_reference = "{reference}"\n')
    rows = [row for row in (tmp_path / "touches.csv").read_text().splitlines() if ",edge," not in row]
    (tmp_path / "touches.csv").write_text("\n".join([*rows, ""]))
    done = corrected_part(JobFiles.of(path))
    assert by_tool(done)["T2"].wear.z == pytest.approx(-0.016, abs=1e-4)
    assert not any("z counts from no face" in note for note in done.notes)
    path.write_text(path.read_text().replace("z_reference", "device"))
    done = corrected_part(JobFiles.of(path))
    assert by_tool(done)["T2"].wear.z == pytest.approx(-0.010, abs=1e-4)
    assert any("z counts from no face" in note for note in done.notes)


def test_a_part_that_is_taken_over_and_not_turned_round(tmp_path: Path) -> None:
    """A sub-spindle whose Z is the machine's: the tool comes from −Z. Offsets by hand, then cut by the contour."""
    text = second("linuxcnc", sign=-1.0)
    (tmp_path / "second.ngc").write_text(text)
    off = touched(tmp_path, SET_OFF, turned_round=False)
    for tool, correction in by_tool(corrected(tmp_path, off, frames=NOT_TURNED)).items():
        off_x, off_z = SET_OFF[int(tool[1:])].off_mm
        assert (correction.wear.x, correction.wear.z) == pytest.approx((-2 * off_x, -off_z), abs=2e-4)
    shutil.rmtree(tmp_path / "out")  # another part, that none of its corrections cut
    corrected(tmp_path, touched(tmp_path, WORN, turned_round=False), CONTOUR, frames=NOT_TURNED)
    assert np.max(np.abs(touched(tmp_path, WORN, "out", turned_round=False))) < 0.2


@pytest.mark.parametrize(
    ("sign", "frame", "key"),
    [
        (1.0, "zero_at_z_mm = -80.0", "state in its table [[setups]] `flipped = true`"),
        (-1.0, FRAMES["second"], "leave out `flipped`"),
        (-1.0, MIRRORED["second"], "leave out `mirrored_z`"),
    ],
)
def test_a_z_that_points_the_other_way_is_refused_by_its_key(tmp_path: Path, sign: float, frame: str, key: str) -> None:
    (tmp_path / "second.ngc").write_text(second("linuxcnc", sign=sign))
    path = job(tmp_path, [0.0] * len(PLACES), frames={**FRAMES, "second": frame})
    said = run("compensate", path, "-o", tmp_path / "out", status=3)
    assert "SET-MIRROR" in said and key in " ".join(said.split())
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("zero", ["80.0", "0.0", "-160.0"])
def test_a_zero_that_is_elsewhere_is_refused(tmp_path: Path, zero: str) -> None:
    """Among them the right one with its sign turned."""
    frames = {**FRAMES, "second": f"zero_at_z_mm = {zero}\nflipped = true"}
    path = job(tmp_path, [0.0] * len(PLACES), frames=frames)
    said = run("compensate", path, "-o", tmp_path / "out", status=3)
    assert "SET-CUTS" in said or "SET-MIRROR" in said or "NC-NO-MATCH" in said
    assert not (tmp_path / "out").exists()


def test_a_set_up_without_its_datum_is_refused(tmp_path: Path) -> None:
    path = job(tmp_path, [0.0] * len(PLACES), frames={**FRAMES, "second": "flipped = true"})
    for command in (("compensate",), ("nc", "features"), ("part", "show")):
        said = run(*command, path, status=3)
        assert "SET-DATUM" in said and "'second'" in said and "zero_at_z_mm" in said
    assert not (tmp_path / "out").exists()


def test_a_mirrored_z_is_corrected_by_the_contour_alone(tmp_path: Path) -> None:
    """The same moves as of a part that is turned round, and no offset to enter; asked for one, it is refused."""
    errors_um = touched(tmp_path, SET_OFF)
    corrected(tmp_path, errors_um, CONTOUR)
    moves = [line for line in programs(tmp_path, "out")["second"].read_text().splitlines() if line[:1] == "G"]
    done = corrected(tmp_path, errors_um, frames=MIRRORED)
    found = [line for line in programs(tmp_path, "out")["second"].read_text().splitlines() if line[:1] == "G"]
    assert found == moves
    of = by_tool(done)
    assert of["T1"].decision.by_offset
    for tool in ("T2", "T4"):
        assert not of[tool].decision.by_offset and of[tool].by_tool is None
        assert of[tool].record.tool_offset is None
        assert f"{tool}: the control mirrors Z, so that the sign of an offset is not known." in of[tool].notes
    second_side = json.loads((tmp_path / "out" / "part.json").read_text())["setups"][1]
    assert [edge["tool_offset"] for edge in second_side["edges"]] == [None, None]
    path = job(tmp_path, errors_um.tolist(), '[compensation]\nby = "offset"\n', frames=MIRRORED)
    assert "SET-OFFSET" in run("compensate", path, "-o", tmp_path / "again", status=3)


def shared(folder: Path, errors_um: Sequence[float], machines: Sequence[str], more: str = "") -> Path:
    """T1 cuts both sides; `machines` by set-up, "" not stated."""
    (folder / "second.ngc").write_text(second("linuxcnc", tool=FIRST))
    path = job(folder, errors_um, more)
    text = path.read_text().replace(f"number = {SECOND}\n", f"number = {FIRST}\n")
    for name, machine in zip(("first", "second"), machines, strict=True):
        text = text.replace(f'finish = "{name}.ngc"\n', f'finish = "{name}.ngc"\nmachine = "{machine}"\n')
    path.write_text(text)
    return path


def test_one_offset_of_two_set_ups_is_not_corrected_twice(tmp_path: Path) -> None:
    """T1 of one machine cuts both sides: entered for one, it would move the other. On two machines they are two."""
    errors_um = touched(tmp_path, SET_OFF).tolist()
    for machines, by_offset in ((("", ""), False), (("Lathe 1", "Lathe 1"), False), (("Lathe 1", "Lathe 2"), True)):
        done = corrected_part(JobFiles.of(shared(tmp_path, errors_um, machines)))
        found = [e.correction for one in done.setups for e in one.edges if e.tool == "T1"]
        assert [one.decision.by_offset for one in found if one] == [by_offset, by_offset]
        (bore,) = (e.correction for one in done.setups for e in one.edges if e.tool == "T4")
        assert bore is not None and bore.decision.by_offset
        for one, other in zip(found, ("second", "first"), strict=True):
            assert one is not None
            assert any(note.startswith(f"T1 cuts in set-up {other} too") for note in one.notes) != by_offset
    said = run("compensate", shared(tmp_path, errors_um, ("", ""), '[compensation]\nby = "offset"\n'), status=3)
    assert "SET-OFFSET" in said


def test_one_refused_set_up_leaves_everything_unwritten(tmp_path: Path) -> None:
    errors_um = touched(tmp_path, SET_OFF)
    path = job(tmp_path, (errors_um + 400.0 * on("bore")).tolist(), CONTOUR)
    assert invoke("compensate", path, "-o", tmp_path / "out").exit_code == 3
    assert not (tmp_path / "out").exists()
    corrected(tmp_path, errors_um, CONTOUR)
    before = {file.name: file.read_bytes() for file in (tmp_path / "out").iterdir()}
    path = job(tmp_path, (errors_um + 400.0 * on("bore")).tolist(), CONTOUR)
    assert invoke("compensate", path, "-o", tmp_path / "out").exit_code == 3
    assert {file.name: file.read_bytes() for file in (tmp_path / "out").iterdir()} == before


@pytest.mark.parametrize("name", ["first", "second"])
def test_a_corrected_program_is_refused_when_it_is_corrected_again(tmp_path: Path, name: str) -> None:
    errors_um = touched(tmp_path, WORN)
    corrected(tmp_path, errors_um, CONTOUR)
    (tmp_path / f"{name}.ngc").write_bytes((tmp_path / "out" / f"corrected-{name}.ngc").read_bytes())
    path = job(tmp_path, errors_um.tolist(), CONTOUR)
    said = run("compensate", path, "-o", tmp_path / "again", status=3)
    assert "CMP-TWICE" in said and f"{name}.ngc" in said and not (tmp_path / "again").exists()


def test_each_program_is_the_one_that_was_run(tmp_path: Path) -> None:
    frames = {**FRAMES, "second": FRAMES["second"] + f'\nprogram_sha256 = "{64 * "0"}"'}
    path = job(tmp_path, touched(tmp_path, SET_OFF).tolist(), frames=frames)
    assert "CMP-OTHER-PROGRAM" in run("compensate", path, "-o", tmp_path / "out", status=3)
    assert not (tmp_path / "out").exists()


def test_a_feature_of_two_set_ups_is_asked_for(tmp_path: Path) -> None:
    """The second program goes on over the collar: which of them left it, nobody can say; the job does."""
    over = second("linuxcnc").replace("G01 X54.0000 Z-29.2000\n", "G01 X53.6000 Z-29.2000\nG01 X53.6000 Z-50.5\n")
    (tmp_path / "second.ngc").write_text(over)
    errors_um = touched(tmp_path, SET_OFF).tolist()
    path = job(tmp_path, errors_um)
    said = " ".join(run("compensate", path, "-o", tmp_path / "out", status=3).split())
    assert "SET-FEATURE" in said and '[feature.collar] setup = "second"' in said
    features = run("nc", "features", path, status=1)
    assert "SET-FEATURE" in features
    for name in ("first", "second"):
        path.write_text(path.read_text() + f'[feature.collar]\nsetup = "{name}"\n')
        done = corrected_part(JobFiles.of(path))
        assert [one.frame.name for one in done.setups if "collar" in one.features] == [name]
        path = job(tmp_path, errors_um)
    path.write_text(path.read_text() + "[feature.collar]\ntool = 0\n")
    done = corrected_part(JobFiles.of(path))
    assert done.uncut == ("collar",) and not [one for one in done.setups if "collar" in one.features]
    path = job(tmp_path, errors_um)
    path.write_text(path.read_text() + '[feature.collar]\nsetup = "third"\n')
    assert "JOB-KEY" in run("compensate", path, "-o", tmp_path / "out", status=3)


def test_what_no_set_up_cuts_is_named_and_left(tmp_path: Path) -> None:
    text = second("linuxcnc")
    (tmp_path / "second.ngc").write_text(text[: text.index("T4 M6")] + "M2\n")
    path = job(tmp_path, [4.0 if k % 2 else -4.0 for k in range(len(PLACES))])
    table = f"[[setups.tools]]\nnumber = {BORE}\nnose_radius_mm = {NOSE_MM[BORE]}\n"
    path.write_text(path.read_text().replace(table, ""))
    said = " ".join(run("compensate", path, "-o", tmp_path / "out").split())
    assert "bore and bore-chamfer: cut in no set-up, left as they are." in said
    assert "bore and bore-chamfer: touched, which corrects nothing." in said
    assert json.loads((tmp_path / "out" / "part.json").read_text())["uncut"] == ["bore", "bore-chamfer"]
    assert "Cut in no set-up: bore, bore-chamfer." in run("nc", "features", path)


def test_a_set_up_that_was_not_measured_is_run_as_given(tmp_path: Path) -> None:
    path = job(tmp_path, touched(tmp_path, WORN).tolist(), CONTOUR)
    rows = (tmp_path / "touches.csv").read_text().splitlines()
    (tmp_path / "touches.csv").write_text("\n".join(r for r in rows if "bore" not in r and "back" not in r) + "\n")
    (tmp_path / "touches.csv").write_text(
        "\n".join(r for r in (tmp_path / "touches.csv").read_text().splitlines() if ",edge," not in r) + "\n"
    )
    said = run("compensate", path, "-o", tmp_path / "out")
    assert "second: T2: not measured, left as programmed; T4: not measured, left as programmed" in said
    assert "second: Run second.ngc." in said
    assert {file.name for file in (tmp_path / "out").glob("corrected-*")} == {"corrected-first.ngc"}


def test_sizes_are_judged_in_the_parts_frame(tmp_path: Path) -> None:
    """By hand: the back step is 50 − 0.009 from the part's zero and the seat 36 + 0.024; one across is not judged."""
    asked = "".join(
        f'\n[[part.characteristic]]\nname = "{name}"\nquantity = "{quantity}"\nfeature = "{feature}"\n{more}'
        f'tolerance = "±0.05"\n'
        for name, quantity, feature, more in (
            ("L1", "length", "back-step", ""), ("L2", "length", "back", 'other = "back-step"\n'),
            ("D1", "diameter", "back-seat", "at_z_mm = -60.0\n"), ("D2", "diameter", "bore", ""),
            ("L3", "length", "back", 'other = "front"\n'), ("L4", "length", "step", ""),
        )
    )  # fmt: skip
    done = corrected(tmp_path, touched(tmp_path, SET_OFF), part=asked)
    judged = {one.characteristic.name: one for c in by_tool(done).values() for one in c.characteristics}
    measured = {name: one.before.value for name, one in judged.items() if one.before is not None}
    by_hand = {"L1": 50.0 + 0.009, "L2": 30.0, "D1": 38.0 - 0.014, "D2": 20.0 + 0.010, "L4": 30.0 + 0.004}
    assert measured == pytest.approx(by_hand, abs=2e-4)
    assert judged["D1"].characteristic.at_z_mm == -60.0
    after = {name: one.after.value for name, one in judged.items()}
    assert after == pytest.approx({"L1": 50.0, "L2": 30.0, "D1": 38.0, "D2": 20.0, "L4": 30.0}, abs=2e-4)
    assert any(note.startswith("L3: sizes of no single set-up, which are not judged: ") for note in done.notes)


def test_ends_are_prescribed_as_the_part_has_them(tmp_path: Path) -> None:
    """The edge begins at the back face, where the program that is turned round ends it."""
    more = CONTOUR + "[compensation.features.back-seat]\nstart_um = 7.0\nstart_slope_um_per_mm = 0.25\n"
    more += "[compensation.features.edge]\nend_um = 7.0\n"
    errors = [7.0 + 0.25 * (p.z_mm + 78.0) if p.feature == "back-seat" else 7.0 * (p.feature == "edge") for p in PLACES]
    done = corrected_part(JobFiles.of(job(tmp_path, errors, more)))
    correction = by_tool(done)["T2"]
    index = correction.profile.names.index("back-seat")
    curve, length_mm = correction.model.curves[index], correction.profile.features[index].length_mm
    at = np.asarray(curve.value_mm(np.array([0.0, length_mm])))
    np.testing.assert_allclose(1e3 * at, [7.0 + 0.25 * 28.0, 7.0], atol=0.05)


def test_readings_of_gauges_find_their_places_in_a_set_up(tmp_path: Path) -> None:
    """A micrometer reads the back seat 20 µm too large in its middle, and larger by 2 µm a mm towards the back.

    By hand the cut loses 20 µm of X in the middle of it, and more at Z −2, which is z −78, than at Z −29.2. How much
    more is the fit's, which trusts seven readings less than a drawing does.
    """
    rows = ["feature,z_mm,diameter_mm"]
    for z in (-76.0, -72.0, -68.0, -64.0, -60.0, -56.0, -52.0):
        rows.append(f"back-seat,{z},{38.020 - 2e-3 * (z + 64.0):.4f}")
    (tmp_path / "readings.csv").write_text("\n".join([*rows, ""]))
    path = job(tmp_path, [24.0 * p.normal[0] * (p.feature == "edge") for p in PLACES])
    rows = (tmp_path / "touches.csv").read_text().splitlines()
    kept = [row for row in rows if ",back-seat," not in row]
    (tmp_path / "touches.csv").write_text("\n".join([*kept, ""]))
    path.write_text(path.read_text() + 'readings = "readings.csv"\nreadings_u_um = 0.5\n' + CONTOUR)
    run("compensate", path, "-o", tmp_path / "out")
    large, small = ends_of_back_seat(tmp_path)
    assert (large + small) / 2 == pytest.approx(2 * 19.8 - 0.020, abs=0.010)
    assert small - large > 0.030


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("flipped = true", "flipped = true\nmirrored_z = true", "each point the program's"),
        ('name = "second"', 'name = "First"', "same `name`"),
        ('name = "second"', 'name = "../second"', "setups.1.name"),
        ("number = 4", "number = 2", "same `number`"),
        ("[gauging]\n", '[gauging]\nprogram_sha256 = "0"\n', "program_sha256` of a table [[setups]]"),
        ("[gauging]\n", "[tool]\nnose_radius_mm = 0.8\n[gauging]\n", "those of each set-up"),
        ("[gauging]\n", "[feature.bore]\nedge = 1\n[gauging]\n", "`tool` or `setup` is missing"),
        ("[gauging]\n", "[feature.bore]\ntool = 9\n[gauging]\n", "not one of [[setups.tools]]"),
    ],
)
def test_keys_that_do_not_go_together(tmp_path: Path, before: str, after: str, words: str) -> None:
    path = job(tmp_path, [0.0] * len(PLACES))
    path.write_text(path.read_text().replace(before, after, 1))
    said = " ".join(run("compensate", path, "-o", tmp_path / "out", status=3).split())
    assert "JOB-KEY" in said and words in said


def test_a_set_up_of_a_feature_without_set_ups_is_refused(tmp_path: Path) -> None:
    from tests.support import grooved

    path = grooved.job(tmp_path, [0.0] * len(grooved.PLACES), more='[feature.seat]\nsetup = "first"\n')
    assert "JOB-KEY" in run("compensate", path, "-o", tmp_path / "out", status=3)


def test_what_is_printed_and_what_is_said_to_machines(tmp_path: Path) -> None:
    path = job(tmp_path, touched(tmp_path, SET_OFF).tolist())
    said = run("compensate", path, "-o", tmp_path / "out").splitlines()
    known = r" \(X ± 0\.01\d+, Z ± 0\.00\d+\)"
    assert re.fullmatch(r"first: T1 wear X −0\.02\d+ mm \(diameter\), Z \+0\.00\d+" + known, said[0])
    assert re.fullmatch(
        rf"second: T2 wear X \+0\.01\d+ mm \(diameter\), Z −0\.00\d+{known}; "
        rf"T4 wear X −0\.0\d+ mm \(diameter\), Z −0\.00\d+{known}",
        said[1],
    )
    assert "second: Enter at the control, once: T2 wear" in "\n".join(said)
    told = json.loads(run("compensate", path, "-o", tmp_path / "out", "--json"))
    assert [(one["name"], one["z_of_program"]) for one in told["setups"]] == [
        ("first", "Z = z"),
        ("second", "Z = −80.0000 − z"),
    ]
    assert told["setups"][1]["features"] == ["bore", "bore-chamfer", "back", "edge", "back-seat", "back-step"]
    assert told["setups"][1]["program_to_run"] == "second.ngc"
    features = run("nc", "features", path)
    assert "set-up second (Z = −80.0000 − z of the part), cut by" in features
    shown = json.loads(run("nc", "features", path, "--json"))
    assert [one["name"] for one in shown["setups"]] == ["first", "second"]
    assert "Set-up second, turned round: Z = −80.0000 − z of the part." in run("part", "show", path)
    frames = json.loads(run("part", "show", path, "--json"))["setups"]
    assert [frame["zero_at_z_mm"] for frame in frames] == [0.0, -80.0]
    own = (tmp_path / "out" / "report-second-T2.html").read_text()
    assert "Set-up second: positions are those of its program, Z = −80.0000 − z of the part." in own
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<svg" in page and "report-second-T4.html" in page and "second: +Z ←" in page
    run("compensate", path, "-o", tmp_path / "deutsch", "--language", "de")
    assert "Aufspannung" in (tmp_path / "deutsch" / "report.html").read_text()
