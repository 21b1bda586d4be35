"""COMP_MTG and COMP_PROC in one correction: judged by a formula of the machine's error and LinuxCNC's interpreter.

The machine goes to command + E, the process leaves material on by a known amount. Neither is asked of trueloop.
"""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from tests.support import erring_lathe
from tests.support.cli import output_of, run
from tests.support.linuxcnc import Tool, interpret
from tests.support.machined_path import interpreted_points
from tests.support.probing import example
from tests.support.remembered import remembering_inputs
from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import CmmPoint, Inspection
from trueloop.domain.option import Limits
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import MARK
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.dmis.results import dmis_results
from trueloop.formats.tables.model_file import model_to_json
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.diagnose.seen_series import DiagnosisOptions, parts_of, sources_of
from trueloop.jobs.store.opened import open_store
from trueloop.loops.turned.part_on_machine import PartOnMachine, check_composed
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.machine.model.model import MachineModel, State
from trueloop.turned.compensation.displaced import centre_pieces, shifted_contour
from trueloop.turned.compensation.shift import ZERO as STAYS
from trueloop.turned.compensation.shift import sampled
from trueloop_lab.loops.turned import simulate, trial_of
from trueloop_lab.simulator.machine import ErrorTerm, MachineError, Repeatability
from trueloop_lab.simulator.presets import Workshop, nist

NOSE_MM = 0.8
BALL_MM = 1.5
UM = 1e-3
ZERO, TOOL, PROBE = (70.0, 0.0, -100.0), (-30.0, 0.0, 45.0), (-10.0, 0.0, 70.0)
SEMIFINISH_C, PROBING_C, CUTTING_C = 22.0, 25.0, 28.0
PROFILE = checked_profile(
    [
        Line("cylinder", (20.0, -60.0), (20.0, -15.0)),
        Arc("dome", (20.0, -15.0), (5.0, 0.0), (5.0, -15.0), np.pi / 2),
        Line("face", (5.0, 0.0), (0.0, 0.0)),
    ]
)


def process_mm(normal: Array) -> Array:
    """Material that the process leaves on, by the place of the nose that cuts."""
    return np.asarray(0.010 + 0.008 * normal[:, 0] - 0.006 * normal[:, 1] ** 2)


def machine_mm(at: Array, normal: Array, t1_degc: float, tool: tuple[float, float, float]) -> Array:
    """E along the normals with the tool's point at part positions (n, 2)."""
    axes = at + np.array([ZERO[0] - tool[0], ZERO[2] - tool[2]])
    return np.asarray(np.sum(erring_lathe.error_mm(axes[:, 0], axes[:, 1], t1_degc) * normal, axis=1))


@dataclass(frozen=True)
class Places:
    """Points of the part with their normals, (n, 2)."""

    feature: list[str]
    at: Array
    normal: Array


def places(profile: Profile, counts: Mapping[str, int]) -> Places:
    found = [
        (f.name, f.point_mm(s), f.outward_normal(s))
        for f in profile.features
        for s in np.linspace(0.06, 0.94, counts[f.name]) * f.length_mm
    ]
    return Places([p[0] for p in found], np.array([p[1] for p in found]), np.array([p[2] for p in found]))


TOUCHES = places(PROFILE, {"cylinder": 6, "dome": 13, "face": 4})
EVERYWHERE = places(PROFILE, {"cylinder": 61, "dome": 91, "face": 21})


def reported_mm(touched_on: str, semifinish_cut: str) -> Array:
    """Part errors as the control, or a CMM, reports them of the semi-finished part."""
    at, normal = TOUCHES.at, TOUCHES.normal
    error = process_mm(normal)
    if semifinish_cut == "uncompensated":
        error = error + machine_mm(at + NOSE_MM * normal, normal, SEMIFINISH_C, TOOL)
    if touched_on == "machine":  # the ball is where the surface is, the control says where it was sent
        error = error - machine_mm(at + BALL_MM * normal, normal, PROBING_C, PROBE)
    return np.asarray(error)


def finish_program(mode: str) -> str:
    """The nose centre's path in mm, X as a diameter under G7, as a radius under G8."""
    scale = 2.0 if mode == "G7" else 1.0
    lines = [f"G21 G18 {mode} G40 G90 G94 G91.1 F100", "T1 M6", f"G0 X{scale * 30} Z-65"]
    for k, f in enumerate(nose_centre_path(PROFILE, NOSE_MM).features):
        (x0, z0), (x, z) = (f.point_mm(s) for s in (0.0, f.length_mm))
        if k == 0:
            lines.append(f"G1 X{scale * x0:.5f} Z{z0:.5f}")
        end = f"X{scale * x:.5f} Z{z:.5f}"
        centre = f"I{f.centre_mm[0] - x0:.5f} K{f.centre_mm[1] - z0:.5f}" if isinstance(f, Arc) else ""
        lines.append(f"G2 {end} {centre}" if centre else f"G1 {end}")
    return "\n".join([*lines, "G0 Z5", f"G0 X{scale * 30} Z5", "M2", ""])


def write_job(folder: Path, mode: str, touched_on: str, semifinish_cut: str, more: str = "") -> Path:
    rows = [
        f"{k},{name},{x},{z},{error / UM}"
        for k, (name, (x, z), error) in enumerate(
            zip(TOUCHES.feature, TOUCHES.at, reported_mm(touched_on, semifinish_cut), strict=True)
        )
    ]
    (folder / "touches.csv").write_text("\n".join(["point,feature,nominal_x_mm,nominal_z_mm,error_um", *rows, ""]))
    (folder / "finish.ngc").write_text(finish_program(mode))
    (folder / "model.json").write_text(model_to_json(erring_lathe.model(), {}))
    probing = f"probing = {{ T1 = {PROBING_C} }}\nprobe_mm = {list(PROBE)}\nprobe_ball_radius_mm = {BALL_MM}\n"
    (folder / "job.toml").write_text(
        '[part]\nname = "pin"\nstart = [20.0, -60.0]\nfeature = [{ name = "cylinder", to = [20.0, -15.0] }, '
        '{ name = "dome", to = [5.0, 0.0], centre = [5.0, -15.0] }, { name = "face", to = [0.0, 0.0] }]\n'
        f'[tool]\nnose_radius_mm = {NOSE_MM}\n[programs]\ndialect = "linuxcnc"\nfinish = "finish.ngc"\n'
        '[gauging]\ntouches = "touches.csv"\n[compensation]\nchord_tolerance_um = 0.2\n'
        f'[machine]\nmodel = "model.json"\nwork_zero_mm = {list(ZERO)}\ntool_mm = {list(TOOL)}\n'
        f"cutting = {{ T1 = {CUTTING_C} }}\nsemifinish = {{ T1 = {SEMIFINISH_C} }}\n"
        f'semifinish_cut = "{semifinish_cut}"\ntouched_on = "{touched_on}"\n'
        f"{probing if touched_on == 'machine' else ''}{more}"
    )
    return folder / "job.toml"


def compensated(job: Path) -> str:
    run("compensate", job, "-o", job.parent / "out")
    return (job.parent / "out" / "corrected.ngc").read_text()


def left_on_mm(program: str, folder: Path, at: Places) -> Array:
    """What is left on at places of the part: by where LinuxCNC sends the nose, E and the process, (n,).

    The surface is the lowest that a nose of this radius leaves along each normal, from everywhere it was.
    """
    sent, _ = interpreted_points(program, folder, "judged", 0.002, [Tool(1, NOSE_MM, 9)])
    sent = sent[:, [0, 2]]
    axes = sent + np.array([ZERO[0] - TOOL[0], ZERO[2] - TOOL[2]])
    went = sent + erring_lathe.error_mm(axes[:, 0], axes[:, 1], CUTTING_C)
    left = []
    for point, normal in zip(at.at, at.normal, strict=True):
        near = went[np.abs(went - (point + NOSE_MM * normal)).max(axis=1) < 0.3] - point
        height, aside = near @ normal, near @ np.array([-normal[1], normal[0]])
        left.append(np.min(height - np.sqrt(NOSE_MM**2 - aside**2)))
    return np.array(left) + process_mm(at.normal)


def test_model_and_formula_are_one_machine() -> None:
    """What the judge knows of E is not what the correction asks: both are compared here alone."""
    rng = np.random.default_rng(3)
    x, z = rng.uniform(*erring_lathe.X_TRAVEL, 50), rng.uniform(*erring_lathe.Z_TRAVEL, 50)
    positions = erring_lathe.CHAIN.positions({"X": x, "Z": z})
    found = erring_lathe.model().error_mm(State(positions, 0.0, {"T1": 27.0}, (3.0, 0.0, -8.0)))
    assert found[:, [0, 2]] == pytest.approx(erring_lathe.error_mm(x, z, 27.0), abs=1e-12)


def test_uncorrected_the_part_would_be_wrong_by_both(tmp_path: Path) -> None:
    left = left_on_mm(finish_program("G7"), tmp_path, EVERYWHERE)
    assert np.ptp(left) > 20 * UM and np.max(np.abs(left)) > 25 * UM


@pytest.mark.parametrize("mode", ["G7", "G8"])
@pytest.mark.parametrize("touched_on", ["machine", "cmm"])
@pytest.mark.parametrize("semifinish_cut", ["uncompensated", "compensated"])
def test_path_and_machine_and_process_make_the_nominal(
    tmp_path: Path, mode: str, touched_on: str, semifinish_cut: str
) -> None:
    """Within 0.5 µm everywhere on the part, X programmed as a diameter and as a radius."""
    program = compensated(write_job(tmp_path, mode, touched_on, semifinish_cut))
    assert np.max(np.abs(left_on_mm(program, tmp_path, EVERYWHERE))) < 0.5 * UM


def test_what_the_job_says_of_the_touches_decides(tmp_path: Path) -> None:
    """Touches of a CMM taken for the machine's own: the part is wrong by E(T_probing), with its sign."""
    job = write_job(tmp_path, "G7", "machine", "uncompensated")
    wrong = reported_mm("cmm", "uncompensated")
    lines = (tmp_path / "touches.csv").read_text().splitlines()
    rows = [f"{line.rpartition(',')[0]},{error / UM}" for line, error in zip(lines[1:], wrong, strict=True)]
    (tmp_path / "touches.csv").write_text("\n".join([lines[0], *rows, ""]))
    job.write_text(job.read_text().replace("chord_tolerance_um = 0.2", "chord_tolerance_um = 0.5"))
    left = left_on_mm(compensated(job), tmp_path, TOUCHES)
    expected = -machine_mm(TOUCHES.at + BALL_MM * TOUCHES.normal, TOUCHES.normal, PROBING_C, PROBE)
    assert left == pytest.approx(expected, abs=2.0 * UM)  # a line is fitted to what is curved
    assert np.max(np.abs(expected)) > 8 * UM


def test_one_record_and_one_mark_name_both(tmp_path: Path) -> None:
    program = compensated(write_job(tmp_path, "G7", "machine", "uncompensated"))
    record = json.loads((tmp_path / "out" / "record.json").read_text())
    assert program.count(MARK) == 1
    assert f"{MARK}: record {record['id']}" in program
    assert f"composed of COMP_MTG by model {record['inputs_sha256']['model.json'][:16]} and COMP_PROC" in program
    told = record["components"]
    normal = TOUCHES.normal
    mtg = -machine_mm(TOUCHES.at + NOSE_MM * normal, normal, CUTTING_C, TOOL) / UM
    assert [row["comp_mtg_um"] for row in told] == pytest.approx(mtg, abs=0.02)
    assert [row["comp_proc_um"] for row in told] == pytest.approx(-process_mm(normal) / UM, abs=0.3)
    assert [row["composed_um"] for row in told] == pytest.approx(
        [row["comp_mtg_um"] + row["comp_proc_um"] for row in told], abs=1e-3
    )
    assert record["options"]["machine"]["cutting"] == {"T1": CUTTING_C}
    report = (tmp_path / "out" / "report.html").read_text()
    assert "COMP_MTG" in report and "COMP_PROC" in report
    assert "CMP-TWICE" in run(
        "machine", "compensate", tmp_path / "out" / "corrected.ngc", "-m", tmp_path / "model.json",
        "--work-zero", "1=70,0,-100", "-t", "T1=24", "-o", tmp_path / "again", status=3,
    )  # fmt: skip


def test_components_of_a_second_part_are_what_its_program_moves(tmp_path: Path) -> None:
    """The first part's correction is in force and 3 µm are left: by hand COMP_PROC is the first one's less 3 µm.

    On the cylinder the program's X words are by both components off those given, within the chords' 0.2 µm. No offset
    can carry the machine's error: none is to be entered, and a second part that is stated to be cut by one is refused.
    """
    job = write_job(tmp_path, "G7", "cmm", "compensated")
    (tmp_path / "finish.ngc").write_text((tmp_path / "finish.ngc").read_text().replace("T1 M6", "T1 M6\nG43"))
    run("compensate", job, "-o", tmp_path / "o1", "--no-store")
    left = [f"{k},{name},{x},{z},3.0" for k, (name, (x, z)) in enumerate(zip(TOUCHES.feature, TOUCHES.at, strict=True))]
    (tmp_path / "touches.csv").write_text("\n".join(["point,feature,nominal_x_mm,nominal_z_mm,error_um", *left, ""]))
    text = job.read_text().replace('finish = "finish.ngc"', 'finish = "finish.ngc"\ncut_with = "o1/record.json"')
    # The cut that was measured ran at the temperatures that its program was written for
    job.write_text(text.replace(f"semifinish = {{ T1 = {SEMIFINISH_C} }}", f"semifinish = {{ T1 = {CUTTING_C} }}"))
    text = job.read_text().replace('"compensated"', '"uncompensated"')
    job.write_text(text)
    said = run("compensate", job, "-o", tmp_path / "o2", "--no-store")
    assert (
        "COMP_MTG of the machine comes on top of these" in said and "the measured surface was cut compensated" in said
    )
    assert "(not to be entered: " in said and "G10" not in said
    offset = json.loads((tmp_path / "o2" / "report.json").read_text())["tool_offset"]
    assert offset["tool"] == 1 and not offset["blocks"]
    asked = text.replace('"o1/record.json"', '"o2/record.json"\ncut_by = "wear"')
    job.write_text(asked)
    said = run("offsets", "program", tmp_path / "o2" / "record.json", status=3)
    assert "OFS-NONE" in said and "no offset can carry it" in said
    assert "CMP-CUT-WITH" in run("compensate", job, "-o", tmp_path / "o3", "--no-store", status=3)
    first, second = (json.loads((tmp_path / name / "report.json").read_text())["components"] for name in ("o1", "o2"))
    for before, now in zip(first, second, strict=True):
        assert now["comp_proc_um"] == pytest.approx(before["comp_proc_um"] - 3.0, abs=0.2)
        assert now["composed_um"] == pytest.approx(now["comp_mtg_um"] + now["comp_proc_um"], abs=0.002)
    words = re.findall(r"^G1 X(4[\d.]+) Z(-[\d.]+)", (tmp_path / "o2" / "corrected.ngc").read_text(), re.MULTILINE)
    x_mm, z_mm = np.array(words, dtype=float).T
    on_cylinder = z_mm < -16.0
    at = TOUCHES.at[:6, 1]
    moved_um = (np.interp(at, z_mm[on_cylinder], x_mm[on_cylinder]) - 2 * (20.0 + NOSE_MM)) / 2 / UM
    assert moved_um == pytest.approx([one["composed_um"] for one in second[:6]], abs=0.5)


@pytest.mark.parametrize("touched_on", ["machine", "cmm"])
def test_a_diagnosis_is_of_the_process_whatever_the_machine_did(tmp_path: Path, touched_on: str) -> None:
    """A is cut by the given program with the whole E in it, B by the corrected one, which leaves nothing. A diagnosis
    shows the surfaces as they are; without the machine and without the correction both are the process alone.
    """
    job = write_job(tmp_path, "G7", touched_on, "uncompensated")
    text = job.read_text().replace('finish = "finish.ngc"', 'finish = "finish.ngc"\ncut_with = "given"')
    job.write_text(text)
    run("compensate", job, "--serial", "A", "-o", tmp_path / "o1")
    probed_mm = machine_mm(TOUCHES.at + BALL_MM * TOUCHES.normal, TOUCHES.normal, PROBING_C, PROBE)
    said_mm = -probed_mm if touched_on == "machine" else 0.0 * probed_mm
    rows = zip(TOUCHES.feature, TOUCHES.at, said_mm / UM, strict=True)
    left = [f"{k},{name},{x},{z},{um}" for k, (name, (x, z), um) in enumerate(rows)]
    (tmp_path / "touches.csv").write_text("\n".join(["point,feature,nominal_x_mm,nominal_z_mm,error_um", *left, ""]))
    text = text.replace('"given"', '"o1/record.json"').replace(f"= {SEMIFINISH_C} ", f"= {CUTTING_C} ")
    job.write_text(text.replace("[gauging]", f"[gauging]\nmeasured_at = {datetime.now(UTC).isoformat()}"))
    run("compensate", job, "--serial", "B", "-o", tmp_path / "o2")
    sources = sources_of(open_store(str(tmp_path / "trueloop.db")), DiagnosisOptions(), None)
    parts = [part.with_errors(sources.places) for part in parts_of(sources)[0]]
    nose_mm = TOUCHES.at + NOSE_MM * TOUCHES.normal
    carried_mm = machine_mm(nose_mm, TOUCHES.normal, SEMIFINISH_C, TOOL)
    truth_mm = {"A": process_mm(TOUCHES.normal) + carried_mm, "B": np.zeros(len(TOUCHES.at))}
    assert np.max(np.abs(carried_mm)) > 8 * UM and np.max(np.abs(probed_mm)) > 8 * UM
    for part in parts:
        (points,) = part.points.values()
        assert points.nominal_mm == pytest.approx(TOUCHES.at)
        assert points.error_mm == pytest.approx(truth_mm[part.serial], abs=0.5 * UM)
        (carried,), taken = part.carried_mm.values(), list(part.taken_off_mm.values())
        assert points.error_mm - carried + sum(taken) == pytest.approx(process_mm(TOUCHES.normal), abs=0.5 * UM)


def test_what_the_probe_reports_of_a_finished_part_is_no_error_of_it(tmp_path: Path) -> None:
    """The finished part is right, and the probe, at temperatures that nobody states, reports it 9 µm off. Nothing is
    learned of it and no alarm raised; a measuring machine's ±0.5 µm are what was expected.
    """
    job = write_job(tmp_path, "G7", "machine", "uncompensated")
    edge = 'name = "T1"\ninsert = "VNMG"\ncorner = "1"\n[programs]\nsemifinish_allowance_mm = 0.2'
    job.write_text(job.read_text().replace("[programs]", edge))
    run("compensate", job, "--serial", "A", "-o", tmp_path / "out")
    probed_mm = machine_mm(TOUCHES.at + BALL_MM * TOUCHES.normal, TOUCHES.normal, CUTTING_C, PROBE)
    for name, said_mm in (("probe", -probed_mm), ("cmm", 0.5 * UM * (-1.0) ** np.arange(len(probed_mm)))):
        rows = zip(TOUCHES.feature, TOUCHES.at, said_mm / UM, strict=True)
        text = [f"{k},{feature},{x},{z},{um}" for k, (feature, (x, z), um) in enumerate(rows)]
        head = "point,feature,nominal_x_mm,nominal_z_mm,error_um"
        (tmp_path / f"{name}.csv").write_text("\n".join([head, *text, ""]))
    keep = ("--job", job, "--serial", "A", "--after")
    said = output_of("measure", "read", tmp_path / "probe.csv", *keep, "finish")
    assert "the machine's own probe inspected part 'A'" in said
    assert "obtained" not in said and "MEM-ALARM" not in said
    db = ("--db", tmp_path / "trueloop.db")
    assert "has no inspection after its finish cut that tells its errors" in run("diagnose", "part", "A", *db, status=3)
    (tmp_path / "trueloop.db").unlink()
    run("compensate", job, "--serial", "A", "-o", tmp_path / "out")
    said = output_of("measure", "read", tmp_path / "cmm.csv", *keep, "released")
    assert "obtained 0.5 µm RMS; 23 of 23 inside ±U" in said and "own probe" not in said


def test_rapids_stay_where_they_were(tmp_path: Path) -> None:
    """Only the contour is displaced: no way to or from the part comes closer than it was programmed."""
    program = compensated(write_job(tmp_path, "G7", "machine", "uncompensated"))
    rapids = []
    for name, text in (("source", finish_program("G7")), ("corrected", program)):
        (tmp_path / name).write_text(text)
        moves = interpret(tmp_path / name, tools=[Tool(1, NOSE_MM, 9)])
        rapids.append(np.array([move.end_mm for move in moves if move.kind == "rapid"]))
    # the first way out inherits x from the contour's end, which is displaced along the axis of the part alone
    assert rapids[1] == pytest.approx(rapids[0], abs=0.03)
    assert rapids[1][0] == pytest.approx(rapids[0][0], abs=1e-9) and rapids[1][-1] == pytest.approx(
        rapids[0][-1], abs=1e-9
    )


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        ("max_correction_um = 17.0", "the correction of 'cylinder' reaches"),
        ("max_correction_um = 19.0", "COMP_MTG of 'cylinder' reaches"),
        ("max_correction_um = 30.0", "the composed correction of 'cylinder' reaches"),
    ],
)
def test_the_limit_of_size_holds_for_each_component_and_for_both(tmp_path: Path, limit: str, words: str) -> None:
    job = write_job(tmp_path, "G7", "machine", "uncompensated")
    job.write_text(job.read_text().replace("chord_tolerance_um = 0.2", limit))
    said = " ".join(run("compensate", job, "-o", tmp_path / "out", status=3).split())
    assert "CMP-SIZE" in said and words in said
    assert not (tmp_path / "out").exists()


@dataclass(frozen=True)
class AlongZ:
    per_mm: float

    def displacement_mm(self, at_mm: Array) -> Array:
        return np.column_stack([0 * at_mm[:, 0], self.per_mm * (at_mm[:, 0] - 20.0)])


@pytest.mark.parametrize(
    ("own", "steep", "words"),
    [(0.0, 0.050, "COMP_MTG of 'dome'"), (0.030, -0.030, "the composed correction of 'dome'")],
)
def test_the_limit_of_slope_holds_for_each_component_and_for_both(own: float, steep: float, words: str) -> None:
    """A displacement along z that changes along x, and a shift of the dome that changes along it."""
    displacement = AlongZ(steep)
    shifts = [STAYS, sampled(np.array([0.0, 1.0]), np.array([0.0, own])), STAYS]
    pieces = centre_pieces(PROFILE, shifted_contour(PROFILE, shifts, NOSE_MM))
    with pytest.raises(TrueloopError, match=words) as refused:
        check_composed(pieces, shifts, (displacement, displacement), Limits(correction_mm=10.0, slope=0.040))
    assert refused.value.code is Code.CMP_SLOPE


@pytest.mark.parametrize(
    ("before", "after", "code", "words"),
    [
        (
            f"cutting = {{ T1 = {CUTTING_C} }}",
            "cutting = { T1 = 40.0 }",
            Code.MCH_RANGE,
            "machine.extrapolate in the job",
        ),
        (f"cutting = {{ T1 = {CUTTING_C} }}", "cutting = { T2 = 20.0 }", Code.MCH_SIGNAL, "needs the signal 'T1'"),
        (f"work_zero_mm = {list(ZERO)}", "work_zero_mm = [70.0, 0.0, -400.0]", Code.MCH_TRAVEL, "Z would go"),
        ('model = "model.json"', 'model = "model.json"\nserial = "8"', Code.MCH_MACHINE, "not '8'"),
        (f"probe_mm = {list(PROBE)}", "", Code.JOB_KEY, "`probe_mm`"),
        ("chord_tolerance_um = 0.2", 'by = "offset"', Code.JOB_KEY, "no tool offset can carry"),
    ],
)
def test_what_is_refused(tmp_path: Path, before: str, after: str, code: Code, words: str) -> None:
    job = write_job(tmp_path, "G7", "machine", "uncompensated")
    text = job.read_text()
    assert before in text
    job.write_text(text.replace(before, after))
    said = " ".join(run("compensate", job, "-o", tmp_path / "out", status=3).split())
    assert code in said and words in said


def test_a_program_that_moves_its_own_zero_in_the_pass_is_refused(tmp_path: Path) -> None:
    job = write_job(tmp_path, "G7", "machine", "uncompensated")
    program = tmp_path / "finish.ngc"
    program.write_text(program.read_text().replace("\nG2 ", "\nG52 Z0.001\nG2 "))
    assert "MCH-FRAME" in run("compensate", job, "-o", tmp_path / "out", status=3)


E_MTG = MachineError(
    (
        ErrorTerm(0, 0.0114),
        ErrorTerm(0, 0.056, z_power=1),
        ErrorTerm(0, 0.060, z_power=2),
        ErrorTerm(0, 0.0015, temperature_power=1),
        ErrorTerm(1, -0.010, x_power=1),
        ErrorTerm(1, -0.0010, temperature_power=1),
    )
)
"""The formula of `erring_lathe` in the simulator's own words, for a part whose zero lies at X 100, Z −120."""
AT = (100.0, 0.0, -120.0)
TEMPERATURES_C = (SEMIFINISH_C, PROBING_C, CUTTING_C)


def workshop(error: MachineError) -> Workshop:
    base = nist(Repeatability())
    machine, probe = replace(base.machine, error=error), replace(base.probe, range_x_mm=0.0, range_z_mm=0.0)
    return Workshop(machine, probe, base.cmm, TEMPERATURES_C)


def on_machine(model: MachineModel, touched_on: str, semifinish_cut: str, ball_radius_mm: float) -> PartOnMachine:
    return PartOnMachine(
        model=model,
        sha256="0" * 64,
        work_zero_mm=AT,
        tool_mm=(0.0, 0.0, 0.0),
        probe_mm=(0.0, 0.0, 0.0),
        cutting={"T1": CUTTING_C},
        semifinish={"T1": SEMIFINISH_C},
        probing={"T1": PROBING_C},
        touched_on=touched_on,
        semifinish_cut=semifinish_cut,
        ball_radius_mm=ball_radius_mm,
    )


def test_the_simulated_loop_comes_out_as_on_a_machine_without_errors() -> None:
    """Worn nose, deflection, a probing machine that errs: what the finished part has more than without E is second
    order. Without the table [machine] it carries E in full."""
    inputs = example("modbas2")
    ball_mm = workshop(E_MTG).probe.ball_radius_mm
    part = on_machine(erring_lathe.model(), "machine", "uncompensated", ball_mm)
    without = simulate(trial_of(inputs), workshop(MachineError())).finish_truth_mm
    ignored = simulate(trial_of(inputs), workshop(E_MTG)).finish_truth_mm
    composed = simulate(trial_of(replace(inputs, machine=part)), workshop(E_MTG))
    assert np.max(np.abs(ignored - without)) > 10 * UM
    assert np.max(np.abs(composed.finish_truth_mm - without)) < 0.5 * UM
    assert composed.correction.touches.error_mm == pytest.approx(composed.semifinish_truth_mm, abs=0.4 * UM)


def test_earlier_parts_take_part_where_errors_of_the_machine_are_known() -> None:
    """Today's touches are as without memory, the machine's errors taken out; earlier parts are of the same kind."""
    remembering = remembering_inputs()
    part = on_machine(erring_lathe.model(), "machine", "uncompensated", BALL_MM)
    wide = replace(remembering.options, limits=replace(remembering.options.limits, correction_mm=0.3))
    inputs = replace(remembering, machine=part, options=wide)
    correction, alone = compensate(inputs), compensate(replace(inputs, history=()))
    assert correction.memory is not None and correction.memory.applied
    assert alone.memory is None
    assert correction.model.vectors.error_mm == pytest.approx(alone.model.vectors.error_mm, abs=0.0)


def two_ways(forward_z: bool = True, forward_x: bool = False) -> MachineModel:
    """The model with other parameters for the way that the finish pass does not go."""
    model = erring_lathe.model()
    on_z, on_x = model.coefficients[:4], model.coefficients[4:]
    both = [
        np.r_[own[:-1] + (0.0 if way == forward else 0.02), own[-1]]
        for own, forward in ((on_z, forward_z), (on_x, forward_x))
        for way in (True, False)
    ]
    terms = tuple(replace(term, both_ways=True) for term in model.terms)
    return replace(model, terms=terms, coefficients=np.concatenate(both), covariance=1e-12 * np.eye(14))


def test_the_play_of_the_way_that_the_pass_goes_is_taken(tmp_path: Path) -> None:
    """It goes towards +z and −x; E of the other ways is 20 µm off."""
    job = write_job(tmp_path, "G7", "cmm", "compensated")
    (tmp_path / "model.json").write_text(model_to_json(two_ways(), {}))
    assert np.max(np.abs(left_on_mm(compensated(job), tmp_path, EVERYWHERE))) < 0.5 * UM
    for wrong in (two_ways(forward_z=False), two_ways(forward_x=True)):
        (tmp_path / "model.json").write_text(model_to_json(wrong, {}))
        assert np.max(np.abs(left_on_mm(compensated(job), tmp_path, EVERYWHERE))) > 15 * UM


def test_an_axis_that_turns_round_is_refused_where_both_ways_differ() -> None:
    """The knob goes out in x behind the cone that goes in: nobody knows which play is taken up where."""
    part = on_machine(two_ways(), "cmm", "compensated", 0.0)
    with pytest.raises(TrueloopError) as refused:
        simulate(trial_of(replace(example("piecs11"), machine=part)), workshop(MachineError()))
    assert refused.value.code is Code.MCH_PROGRAM


def test_a_finished_part_is_judged_by_its_touches_whatever_the_machine_put_in() -> None:
    """The touches say 10 µm on the radius; between them the process' curve and the machine's error add up to that."""
    inputs = example("modbas2")
    touches = replace(inputs.touches, error_mm=10 * UM * inputs.touches.outward_normal[:, 0])
    asked = Characteristic("D1", Quantity.DIAMETER, "main-cylinder", 89.408, 89.39, 89.42, at_z_mm=-80.0)
    part = on_machine(erring_lathe.model(), "cmm", "uncompensated", 0.0)
    finished = replace(inputs, touches=touches, semifinish=None, allowance_mm=0.0, machine=part)
    correction = compensate(replace(finished, characteristics=(asked,)))
    assert correction.composed is not None
    assert np.max(np.abs(correction.composed.cut_in_mm)) > 20 * UM
    (one,) = correction.characteristics
    assert one.before is not None
    assert one.before.value == pytest.approx(89.428, abs=6 * UM)


def test_points_of_a_measuring_machine_beside_touches_of_the_machine(tmp_path: Path) -> None:
    """Every second point comes from a measuring machine's file: it carries no error of the probe, the touches do."""
    job = write_job(tmp_path, "G7", "machine", "uncompensated")
    lines = (tmp_path / "touches.csv").read_text().splitlines()
    (tmp_path / "touches.csv").write_text("\n".join([lines[0], *lines[1::2], ""]))
    far = reported_mm("cmm", "uncompensated")
    points = [
        CmmPoint((x + e * nx, 0.0, z + e * nz), (x, 0.0, z), (nx, 0.0, nz), f"P{k}")
        for k, ((x, z), (nx, nz), e) in enumerate(zip(TOUCHES.at, TOUCHES.normal, far, strict=True))
        if k % 2
    ]
    inspection = Inspection(Part(PartType("pin")), "CMM points", "", len(points), tuple(points))
    (tmp_path / "points.dmo").write_text(dmis_results([inspection], "pin"))
    both = job.read_text().replace('touches = "touches.csv"', 'touches = "touches.csv"\nreadings = "points.dmo"')
    job.write_text(both)
    assert np.max(np.abs(left_on_mm(compensated(job), tmp_path, EVERYWHERE))) < 0.5 * UM
    job.write_text(both.replace('touches = "touches.csv"\n', ""))
    said = run("compensate", job, "-o", tmp_path / "no", status=3)
    assert "JOB-KEY" in said and 'machine.touched_on = "machine"` is of `gauging.touches`' in said
