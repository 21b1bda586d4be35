"""A shaft that an OD tool and both corners of a groove insert cut: cut by a model, touched, corrected, cut again.

LinuxCNC's interpreter says where every program sends each edge; the model moves the nose's circle there, by the edge's
own offset error and wear, and the part is what the circles leave.
"""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke, run
from tests.support.grooved import (
    LEFT,
    NOSE_MM,
    OD,
    PLACES,
    RIGHT,
    WIDTH_MM,
    Control,
    Cutting,
    dense,
    job,
    measured_um,
    program,
)
from tests.support.linuxcnc import Tool, interpret
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.turned.job import read_cuts
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.part import SetupCorrection, SetupCuts, correct_setup, require_sum
from trueloop.nc.program.program import read_program

TABLE = [Tool(OD, NOSE_MM[OD]), Tool(LEFT, NOSE_MM[LEFT]), Tool(RIGHT, NOSE_MM[RIGHT], z_offset_mm=WIDTH_MM)]
"""The right corner lies the insert's width behind the left one: calling its offset makes the programmed point jump."""
CALLED = re.compile(r"G43 H(\d+)")

SET_OFF = {OD: Cutting((0.012, -0.004)), LEFT: Cutting((0.006, 0.009)), RIGHT: Cutting((-0.008, 0.005))}
"""Edges that are set wrong, and nothing else."""


def worn(n: tuple[float, float]) -> float:
    """A nose that has lost 6 µm where it cuts diameters, 2 µm where it cuts faces, and 10 µm between them."""
    return 0.006 * n[0] ** 2 + 0.002 * n[1] ** 2 + 0.012 * n[0] * n[1]


WORN = {OD: Cutting((0.012, -0.004), worn), LEFT: Cutting((0.006, 0.009)), RIGHT: Cutting((-0.008, 0.005), worn)}


def commanded(file: Path) -> Mapping[int, Array]:
    """Where LinuxCNC sends the nose centre of each edge, at feed, densely."""
    lines = file.read_text().splitlines()
    edge, edge_of = 0, {}
    for number, line in enumerate(lines, 1):
        edge = int(found[1]) if (found := CALLED.search(line)) else edge
        edge_of[number] = edge
    paths: dict[int, list[Array]] = {OD: [], LEFT: [], RIGHT: []}
    for move in interpret(file, tools=TABLE):
        if move.kind == "line":
            (x0, _, z0), (x1, _, z1) = move.start_mm, move.end_mm
            paths[edge_of[move.line]].append(dense([(x0, z0), (x1, z1)]))
    return {edge: np.concatenate(pieces) for edge, pieces in paths.items()}


def touched(folder: Path, cuttings: Mapping[int, Cutting], file: Path | None = None) -> Array:
    """Errors at all places of the part that a program cuts, µm."""
    if file is None:
        file = folder / "given.ngc"
        file.write_text(program("linuxcnc"))
    return np.array(measured_um(commanded(file), cuttings))


def corrected(
    folder: Path, errors_um: Sequence[float], more: str = "", control: Control = "linuxcnc"
) -> SetupCorrection:
    """As the command does it, and its files in `out`."""
    path = job(folder, errors_um, control, more)
    run("compensate", path, "-o", folder / "out")
    return correct_setup(read_cuts(JobFiles.of(path)).setups[0])


def by_edge(errors_um: Array, edge: int) -> Array:
    return errors_um[[place.edge == edge for place in PLACES]]


def test_the_model_cuts_a_good_part_and_errs_as_it_is_told(tmp_path: Path) -> None:
    """By hand: an edge that stands off by o errs by n·o; a nose worn by w leaves w more."""
    good = touched(tmp_path, dict.fromkeys(NOSE_MM, Cutting((0.0, 0.0))))
    assert np.max(np.abs(good)) < 0.06  # the program's rounding to 0.1 µm
    off = touched(tmp_path, SET_OFF)
    expected = [1e3 * float(np.dot(p.normal, SET_OFF[p.edge].off_mm)) for p in PLACES]
    np.testing.assert_allclose(off - good, expected, atol=0.02)


def test_wear_is_taken_out_by_the_contours_of_all_edges_in_one_program(tmp_path: Path) -> None:
    """After the cut with the corrected program only rounding is left; with the sign turned all is there twice."""
    errors_um = touched(tmp_path, WORN)
    assert np.max(np.abs(errors_um)) > 15.0
    joint = corrected(tmp_path, errors_um.tolist(), '[compensation]\nby = "contour"\n')
    left = touched(tmp_path, WORN, tmp_path / "out" / "corrected.ngc")
    assert np.max(np.abs(left)) < 0.15
    assert joint.program == (tmp_path / "out" / "corrected.ngc").read_bytes()
    turned = tmp_path / "apart" / "turned"  # not near the corrections of the same program
    turned.mkdir(parents=True)
    corrected(turned, (-errors_um).tolist(), '[compensation]\nby = "contour"\n')
    twice = touched(turned, WORN, turned / "out" / "corrected.ngc")
    np.testing.assert_allclose(twice, 2 * errors_um, atol=0.3)


def test_each_edge_gets_the_offset_that_it_is_off_by(tmp_path: Path) -> None:
    """By hand: −o, X as a diameter. Entered at the control, the given program cuts true."""
    errors_um = touched(tmp_path, SET_OFF) + np.tile([0.2, -0.2, 0.2], len(PLACES) // 3)
    joint = corrected(tmp_path, errors_um.tolist())
    assert joint.program is None and not (tmp_path / "out" / "corrected.ngc").exists()
    entered = {}
    for one in joint.edges:
        assert one.correction is not None and one.correction.decision.by_offset
        wear = one.correction.wear
        off_x, off_z = SET_OFF[wear.tool].off_mm
        assert (wear.x, wear.z) == pytest.approx((-2 * off_x, -off_z), abs=5e-4)
        entered[wear.tool] = Cutting((off_x + wear.x / 2, off_z + wear.z))
    assert np.max(np.abs(touched(tmp_path, entered))) < 0.25
    said = run("compensate", tmp_path / "job.toml", "-o", tmp_path / "out")
    answer = said.splitlines()[0]
    assert re.fullmatch(
        r"T3 wear X −0\.02\d+ mm \(diameter\), Z \+0\.00\d+ \(.*\); "
        r"T5 \(left corner\) wear X −0\.01\d+ mm \(diameter\), "
        r"Z −0\.00\d+ \(.*\); T15 \(right corner\) wear X \+0\.01\d+ mm \(diameter\), Z −0\.00\d+ \(.*\)",
        answer,
    )
    assert "Enter at the control, once: T3 wear" in said and "Then run finish.ngc." in said


def test_an_edge_by_offset_leaves_its_contour_and_the_others_are_in_the_program(tmp_path: Path) -> None:
    """The left corner is set wrong alone; the two others are worn as well."""
    noise = np.tile([0.2, -0.2, 0.2], len(PLACES) // 3)
    bent = {OD: Cutting((0.012, -0.004)), LEFT: SET_OFF[LEFT], RIGHT: SET_OFF[RIGHT]}
    errors_um = touched(tmp_path, bent) + noise
    errors_um += np.array([8.0 * (p.feature == "seat") for p in PLACES])  # which no offset of the OD tool takes out
    joint = corrected(tmp_path, errors_um.tolist())
    by = {one.tool: one.correction.decision.by_offset for one in joint.edges if one.correction is not None}
    assert by == {"T3": False, "T5 (left corner)": True, "T15 (right corner)": True}
    assert joint.program is not None
    cut, given = commanded(tmp_path / "out" / "corrected.ngc"), commanded(tmp_path / "given.ngc")
    for edge in (LEFT, RIGHT):
        np.testing.assert_array_equal(cut[edge], given[edge])
    seat = [p.feature == "seat" for p in PLACES]
    left = np.array(measured_um(cut, bent))
    np.testing.assert_allclose(left[seat], -8.0, atol=0.3)  # of the model, which has no such error
    words = json.loads((tmp_path / "out" / "part.json").read_text())["to_do"]
    assert words.startswith("Enter at the control, once: T5 (left corner) wear") and "Then run corrected.ngc" in words


@pytest.mark.parametrize("control", ["fanuc-lathe", "siemens"])
def test_other_controls_get_the_same_coordinates(tmp_path: Path, control: Control) -> None:
    errors_um = touched(tmp_path, WORN).tolist()
    words = []
    for name in ("linuxcnc", control):
        folder = tmp_path / name
        folder.mkdir()
        corrected(folder, errors_um, '[compensation]\nby = "contour"\n[programs_]\n'.replace("[programs_]\n", ""), name)
        (file,) = (folder / "out").glob("corrected.*")
        moves = [re.findall(r"[XZ](-?[\d.]+)", line) for line in file.read_text().splitlines() if line[:3] == "G01"]
        words.append(np.array(moves, dtype=np.float64))
    np.testing.assert_allclose(words[0], words[1], atol=1.1e-3)


def test_a_fit_knows_nothing_of_another_edges_touches(tmp_path: Path) -> None:
    """The groove's touches are thrown 40 µm off: the OD tool's correction is the same to the last digit."""
    errors_um = touched(tmp_path, WORN)
    thrown = errors_um + np.array([40.0 * (p.edge != OD) for p in PLACES])
    of_od = []
    for errors in (errors_um, thrown):
        job(tmp_path, errors.tolist(), "linuxcnc", '[compensation]\nby = "contour"\n')
        joint = correct_setup(read_cuts(JobFiles.of(tmp_path / "job.toml")).setups[0])
        (one,) = [of.correction for of in joint.edges if of.tool == "T3"]
        assert one is not None
        of_od.append((one.decision.offset_mm, one.model.scatter_mm, [word.after for word in one.record.changes]))
    assert of_od[0] == of_od[1]


def test_bands_have_each_edges_own_prior(tmp_path: Path) -> None:
    """The left corner is said to repeat: its U is what was gauged and scatters alone, well under half the others'."""
    path = job(tmp_path, touched(tmp_path, SET_OFF).tolist(), "linuxcnc")
    text = path.read_text().replace("groove_corner = 'left'", "groove_corner = 'left'\ncut_to_cut_um = 0.0")
    path.write_text(text)
    joint = correct_setup(read_cuts(JobFiles.of(path)).setups[0])
    u = {one.tool: one.correction.prediction.expanded_u_mm.max() for one in joint.edges if one.correction is not None}
    others = min(u["T15 (right corner)"], u["T3"])
    assert others > 0.005 and u["T5 (left corner)"] < others / 2


def test_a_tool_that_cuts_nothing_measured_is_said_and_left(tmp_path: Path) -> None:
    errors_um = touched(tmp_path, WORN).tolist()
    path = job(tmp_path, errors_um, "linuxcnc", '[compensation]\nby = "contour"\n')
    rows = (tmp_path / "touches.csv").read_text().splitlines()
    (tmp_path / "touches.csv").write_text("\n".join(r for r in rows if "right" not in r) + "\n")
    said = run("compensate", path, "-o", tmp_path / "out")
    assert "T15 (right corner): not measured, left as programmed" in said.splitlines()[0]
    assert "T15 (right corner) cuts nothing that was measured: floor-right and right-wall stay as programmed." in said
    cut, given = commanded(tmp_path / "out" / "corrected.ngc"), commanded(tmp_path / "given.ngc")
    np.testing.assert_array_equal(cut[RIGHT], given[RIGHT])
    assert not (tmp_path / "out" / "record-T15.json").exists()


def test_what_is_left_alone_stays_and_its_touches_serve_nothing(tmp_path: Path) -> None:
    """The right wall's touches are thrown 60 µm off: what the right corner does to the floor is the same."""
    errors_um = touched(tmp_path, WORN)
    alone = '[compensation]\nby = "contour"\n[feature.right-wall]\ntool = 0\n'
    words = []
    for thrown in (0.0, 60.0):
        errors = errors_um + np.array([thrown * (p.feature == "right-wall") for p in PLACES])
        folder = tmp_path / f"apart {thrown:g}" / "job"  # not near the other's correction of the same program
        folder.mkdir(parents=True)
        joint = corrected(folder, errors.tolist(), alone)
        (one,) = [of.correction for of in joint.edges if of.tool == "T15 (right corner)"]
        assert one is not None and one.profile.names == ("floor-right",)
        words.append([word.after for word in one.record.changes])
        assert joint.notes == ("right-wall: left alone, and what was measured of it is used for nothing.",)
    assert words[0] == words[1]


UP_THE_WALL = (
    "G00 X54.0000 Z-37.0000\nG01 X40.4000 Z-37.0000 F0.05\nG01 X40.4000 Z-39.8000\nG01 X54.0000 Z-39.8000\nG00 X60.\n"
)
"""The left corner's cut the other way round, left by X alone."""


@pytest.mark.parametrize(("off_z_mm", "named_mm"), [(0.009, -39.8), (-0.009, None)], ids=["nearer", "further off"])
def test_a_rapid_by_one_axis_ends_where_it_did_or_further_off(
    off_z_mm: float, named_mm: float | None, tmp_path: Path
) -> None:
    """Inherited, z follows the wall's correction: the left wall looks to z+, material on it takes the tool to z−."""
    text = program("linuxcnc")
    first = text.index("G00 X54.0000 Z-39.8000")
    last = text.index("G00 X60. Z-37.", first)
    text = text[:first] + UP_THE_WALL + text[last:].removeprefix("G00 X60. Z-37.\n")
    (tmp_path / "given.ngc").write_text(text)
    cut = {**SET_OFF, LEFT: Cutting((0.004, off_z_mm))}
    errors = touched(tmp_path, cut, tmp_path / "given.ngc")
    path = job(tmp_path, errors.tolist(), "linuxcnc", '[compensation]\nby = "contour"\n')
    (tmp_path / "finish.ngc").write_text(text)
    run("compensate", path, "-o", tmp_path / "out")
    lines = (tmp_path / "out" / "corrected.ngc").read_text().splitlines()
    named = re.search(r"Z(\S+)", next(line for line in lines if line.startswith("G00 X60.")))
    assert (None if named is None else float(named[1])) == named_mm
    assert np.max(np.abs(touched(tmp_path, cut, tmp_path / "out" / "corrected.ngc"))) < 0.15


def test_an_edge_that_comes_again_leaves_the_moves_between_alone(tmp_path: Path) -> None:
    """The OD tool cuts up to the groove, the corners cut it, and the OD tool comes back for the rest."""
    text = program("linuxcnc")
    over = "G01 X51.6000 Z-60.0000\n"
    rest = "T3 M6 G43 H3\nG00 X56. Z-39.\nG01 X51.6000 Z-39.0000 F0.1\nG01 X51.6000 Z-60.0000\nG00 X80. Z20.\nM2"
    text = text.replace(over, "G01 X51.6000 Z-35.0000\n").replace("M2", rest)
    (tmp_path / "given.ngc").write_text(text)
    errors_um = touched(tmp_path, WORN, tmp_path / "given.ngc")
    path = job(tmp_path, errors_um.tolist(), "linuxcnc", '[compensation]\nby = "contour"\n')
    (tmp_path / "finish.ngc").write_text(text)
    run("compensate", path, "-o", tmp_path / "out")
    assert np.max(np.abs(touched(tmp_path, WORN, tmp_path / "out" / "corrected.ngc"))) < 0.15


LENGTH = (
    '[[part.characteristic]]\nname = "L1"\nquantity = "length"\nfeature = "step"\nother = "left-wall"\n'
    'tolerance = "±0.02"\n[[part.characteristic]]\nname = "D1"\nquantity = "diameter"\nfeature = "seat"\n'
    'tolerance = "±0.05"\n'
)
"""From the OD tool's face to the wall of the left corner, 20 mm; the seat's diameter is the OD tool's own."""


def test_a_length_between_two_edges_is_judged_by_both(tmp_path: Path) -> None:
    """By hand, half of the error taken out: the face at −20 − 0.002, the wall at −40 + 0.0045. Variances add."""
    half = "[compensation]\nweight = 0.5\ncut_to_cut_um = 3.0\n"
    errors_um = touched(tmp_path, SET_OFF) + np.tile([0.2, -0.2, 0.2], len(PLACES) // 3)
    path = job(tmp_path, errors_um.tolist(), "linuxcnc", LENGTH + half)
    joint = correct_setup(read_cuts(JobFiles.of(path)).setups[0])
    assert joint.notes == ()
    (length,) = joint.characteristics
    assert length.characteristic.name == "L1" and length.before is not None
    assert length.before.value == pytest.approx(20.0 - 0.004 - 0.009, abs=3e-4), "as touched"
    assert length.after.value == pytest.approx(20.0 - 0.002 - 0.0045, abs=3e-4)
    assert 0.003 * 2**0.5 * 2**0.5 < length.after.standard_u < 0.012, "two cuts differ by √2 · 3 µm, of either edge"
    assert length.after.verdict == "in" or (length.after.probability_in or 0.0) > 0.8
    judged = {
        one.tool: [j.characteristic.name for j in one.correction.characteristics]
        for one in joint.edges
        if one.correction
    }
    assert judged == {"T3": ["D1"], "T5 (left corner)": [], "T15 (right corner)": []}
    said = run("compensate", path, "-o", tmp_path / "out")
    assert "L1" in said and "L1" in (tmp_path / "out" / "report.html").read_text()
    (one,) = json.loads((tmp_path / "out" / "part.json").read_text())["characteristics"]
    assert one["name"] == "L1"


def test_what_a_program_itself_is_off_by_stays_in_a_length_where_an_offset_corrects(tmp_path: Path) -> None:
    """By hand: the left corner is sent 10 µm past −40 towards the free end, and an offset does not change that."""
    off_um = np.array([10.0 * (p.feature == "left-wall") for p in PLACES])
    errors_um = touched(tmp_path, SET_OFF) + np.tile([0.2, -0.2, 0.2], len(PLACES) // 3) + off_um
    path = job(tmp_path, errors_um.tolist(), "linuxcnc", LENGTH)
    program = (tmp_path / "finish.ngc").read_text()
    assert program.count("Z-39.8000") == 2
    (tmp_path / "finish.ngc").write_text(program.replace("Z-39.8000", "Z-39.7900"))
    joint = correct_setup(read_cuts(JobFiles.of(path)).setups[0])
    (left,) = [one.correction for one in joint.edges if one.tool == "T5 (left corner)"]
    assert left is not None and left.decision.by_offset
    (length,) = joint.characteristics
    assert length.after.value == pytest.approx(20.0 - 0.010, abs=6e-4)


def test_a_length_of_an_edge_that_was_not_measured_is_said_to_be_unjudged(tmp_path: Path) -> None:
    path = job(tmp_path, touched(tmp_path, SET_OFF).tolist(), "linuxcnc", LENGTH)
    rows = (tmp_path / "touches.csv").read_text().splitlines()
    (tmp_path / "touches.csv").write_text("\n".join(r for r in rows if ",left-" not in r and "-left" not in r) + "\n")
    joint = correct_setup(read_cuts(JobFiles.of(path)).setups[0])
    assert joint.notes == ("L1: sizes between features of several edges, which are not judged.",)
    assert joint.characteristics == ()


def test_one_table_of_tools_gives_what_one_tool_gives(tmp_path: Path) -> None:
    """A shaft of one tool: the words of the corrected program are the same, table [tool] or [[tools]]."""
    from tests.loops.test_tool_table_of_a_job import job as pin

    found = []
    for table, heading in (("[tool]", "tool"), ("[[tools]]", "tools")):
        folder = tmp_path / heading
        folder.mkdir()
        path = pin(folder, "number = 3\nnose_radius_mm = 0.4")
        run("part", "from-program", folder / "finish.nc", "--dialect", "fanuc-lathe", "--nose-radius-mm", "0.4",
            "-o", folder / "part.toml")  # fmt: skip
        text = path.read_text().split("[tool]")[1]
        path.write_text(f'{(folder / "part.toml").read_text()}\n{table}{text}[compensation]\nby = "contour"\n')
        run("compensate", path, "-o", folder / "out")
        lines = (folder / "out" / "corrected.nc").read_text().splitlines()
        found.append([line for line in lines if not line.startswith("(")])
    assert found[0] == found[1]


def test_a_joint_program_is_the_sum_of_its_corrections(tmp_path: Path) -> None:
    """A move of one correction is lost in the joint program, or two corrections move the same cut: refused."""
    joint = corrected(tmp_path, touched(tmp_path, WORN).tolist(), '[compensation]\nby = "contour"\n')
    assert joint.program is not None
    given, drive = read_program((tmp_path / "finish.ngc").read_bytes(), "linuxcnc"), Run({})
    cuts = read_cuts(JobFiles.of(tmp_path / "job.toml")).setups[0].cuts
    singles = [correct_setup(SetupCuts((one,))).program for one in cuts]
    paths = [drive.of(given.rewritten(one)) for one in singles if one is not None]
    whole = drive.of(given.rewritten(joint.program))
    require_sum(drive.of(given), paths, whole)
    lost = (
        joint.program.replace(b"Z-60.", b"Z-60.01")
        if b"Z-60." in joint.program
        else joint.program.replace(b"Z-59.", b"Z-58.")
    )
    for broken in (lost, singles[0] or b""):
        with pytest.raises(TrueloopError) as refused:
            require_sum(drive.of(given), paths, drive.of(given.rewritten(broken)))
        assert refused.value.code is Code.CMP_READ_BACK
    with pytest.raises(TrueloopError, match="both move"):
        require_sum(drive.of(given), [paths[0], paths[0]], whole)


def test_the_joint_program_is_refused_when_it_is_corrected_again(tmp_path: Path) -> None:
    corrected(tmp_path, touched(tmp_path, WORN).tolist(), '[compensation]\nby = "contour"\n')
    (tmp_path / "finish.ngc").write_bytes((tmp_path / "out" / "corrected.ngc").read_bytes())
    assert "CMP-TWICE" in run("compensate", tmp_path / "job.toml", "-o", tmp_path / "again", status=3)


def test_nothing_is_written_where_one_edge_cannot_be_corrected(tmp_path: Path) -> None:
    errors_um = touched(tmp_path, SET_OFF)
    errors_um = errors_um + np.array([400.0 * (p.edge == RIGHT) for p in PLACES])
    path = job(tmp_path, errors_um.tolist(), "linuxcnc", '[compensation]\nby = "contour"\n')
    assert invoke("compensate", path, "-o", tmp_path / "out").exit_code == 3
    assert not (tmp_path / "out").exists()


def test_the_page_says_what_its_example_prints(tmp_path: Path) -> None:
    root = Path(__file__).parents[2]
    printed = run("compensate", root / "examples" / "grooved" / "grooved.toml", "-o", tmp_path / "out")
    page = (root / "docs" / "several-tools.md").read_text()
    assert f"\n{printed.splitlines()[0]}\n" in page
    features = run("nc", "features", root / "examples" / "grooved" / "grooved.toml").splitlines()
    shown = [line.strip() for line in page.splitlines() if "nose centre" in line]
    assert shown and all(any(row == line.strip() for line in features) for row in shown)
    assert {file.name for file in (tmp_path / "out").iterdir()} == {
        "corrected.nc", "report.html", "part.json",
        *(f"{kind}-{tool}.{end}" for tool in ("T3", "T5", "T15")
          for kind, end in (("report", "html"), ("report", "json"), ("record", "json"), ("table", "csv"))),
    }  # fmt: skip
    assert "T15 (right corner)" in (tmp_path / "out" / "report.html").read_text()
