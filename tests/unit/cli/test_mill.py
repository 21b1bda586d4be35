"""`trueloop mill entries` over parts that a shop written apart cuts, measures and hands over as files."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.mill_programs import CONTROLS, Control, plate
from tests.support.mill_shop import Mill
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import Part, PartType
from trueloop.formats.inspections.dmis.results import dmis_results
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.formats.inspections.qif.writer import qif_of
from trueloop.jobs.milled import read_milled

TYPED = re.compile(r"^(tool (\d), (radius|diameter|length)|G54, (X|Y|Z|rotation)).*: add ([+-][\d.]+)( mm| in|°)", re.M)


def _typed(mill: Mill, printed: str, diameters: str = "") -> None:
    """Enters what is printed, as a person does who reads it, at a control with registers of its own."""
    for _, tool, register, axis, value, unit in TYPED.findall(printed):
        number, per_mm = float(value), 1.0 / 25.4 if unit == " in" else 1.0
        if unit == "°":
            key, number = "turn", np.radians(number)
        elif axis:
            key, number = axis.lower(), number / per_mm
        else:
            assert (register == "diameter") == (register != "length" and tool == diameters)
            key = f"{register.replace('diameter', 'radius')} {tool}"
            number = number / per_mm / (2.0 if register == "diameter" else 1.0)
        mill.entered[key] = mill.entered.get(key, 0.0) + number


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("Feature;Ø Soll [mm];Ø Ist [mm]\nB0;12;11,96\nB1;14;13,96\n", "tool 2, radius (D22): add -0.020 mm"),
        ("Feature;Ø Soll [mm];Ø Ist [mm]\nB0;11,96;12\nB1;13,96;14\n", "are nominal and actual values exchanged?"),
        ("Feature;Soll [mm];Ist [mm]\nB0;12;11,96\n", "'B0' names none of `Ø`, `Diameter`"),
        ("feature,diameter_mm\nB0,\n", "MSR-NONE: 'm.csv' holds 0 values"),
    ],
)
def test_a_table_of_bores_gives_the_radius_or_the_reason(table: str, said: str, tmp_path: Path) -> None:
    """Two bores 40 µm too small: the tool's radius 20 µm smaller brings its path that much nearer to the walls."""
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    job.write_text(job.read_text().replace("part-1.dmo", "m.csv"))
    (job.parent / "m.csv").write_text(table)
    told = run("mill", "entries", job, "-o", tmp_path / "out", status=0 if said.startswith("tool") else 3)
    assert said in told


@pytest.mark.parametrize(("form", "unit"), [("dmo", "mm"), ("qif", "inch")])
def test_three_parts_are_measured_and_the_control_is_set_between_them(tmp_path: Path, form: str, unit: str) -> None:
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    per_mm = 1.0 if unit == "mm" else 1.0 / 25.4
    text = job.read_text().replace('unit = "mm"', f'unit = "{unit}"').partition("[[measured]]")[0]
    text += '[[tool]]\nnumber = 2\nregister_is = "diameter"\n'
    number = r"-?\d+(?:\.\d+)?"
    in_unit = lambda found: f"{found[1]}{re.sub(number, lambda one: repr(float(one[0]) * per_mm), found[2])}"  # noqa: E731
    text = re.sub(r"^((?:at|size|depth) = )(.*)$", in_unit, text, flags=re.M)
    mill, rng = (
        Mill({1: 0.012, 2: -0.02}, {1: 0.03, 2: 0.0}, (0.03, -0.02, 0.0), 2e-4, scatter=5e-4),
        np.random.default_rng(4),
    )
    worst = list[float]()
    for k in (1, 2, 3):
        readings = [replace(one, actual=round(one.actual, 5)) for one in mill.measured(rng, 3e-4)]
        worst.append(max(abs(one.actual - (one.nominal or 0.0)) for one in readings))
        one = Inspection(Part(PartType("plate"), str(k)), "readings", "", len(readings), tuple(readings))
        content = dmis_results([one], "part").encode() if form == "dmo" else qif_of([one])
        (job.parent / f"part-{k}.{form}").write_bytes(content)
        entered = "" if k == 1 else f'entered = ["out{k - 1}/entries.json"]\n'
        text += f'\n[[measured]]\nfile = "part-{k}.{form}"\n{entered}'
        job.write_text(text)
        printed = run("mill", "entries", job, "-o", job.parent / f"out{k}")
        _typed(mill, printed, diameters="2")
    step_mm = 1e-3  # of a control that counts millimetres, as its program does
    assert worst[0] > 0.03 and max(worst[1:]) < 3e-3 + step_mm
    found = json.loads(run("mill", "entries", job, "--json"))
    record = json.loads((job.parent / "out1" / "entries.json").read_text())
    steps = [one["change"] / step_mm for one in record["entries"] if one["unit"] == "mm"]
    assert steps and all(step == pytest.approx(round(step), abs=1e-6) for step in steps)
    assert found["parts"] == ["1", "2", "3"] and found["unlike"] == [] and found["unused"] == []


def _three_small_bores(folder: Path, dialect: str, unit: str = "mm") -> Path:
    """A job of three bores of 12.7 mm that read 40 µm small, its program in inches."""
    bore = "G0 X{x}. Y0.\nG1 Z-.5 F10.\nG41 D4 X{x}.25\nG3 I-.25\nG40 G1 X{x}.\nG0 Z1.\n"
    bores = "".join(bore.format(x=x) for x in range(1, 4))
    head = "G20 G17 G90 G40 G49\nT4 M6\nG54 G0 X1. Y0. S3000 M3\nG43 H4 Z1.\n"
    (folder / "own.nc").write_text(f"{head}{bores}M30\n")
    table = ["Characteristic,Feature,Type,Nominal [mm],Actual [mm]"]
    table += [f"B{k}.d,B{k},diameter,12.7,12.66" for k in range(1, 4)]
    (folder / "p.csv").write_text("\n".join(table))
    inch, job = 25.4 if unit == "mm" else 1.0, folder / "job.toml"
    feature = '[[feature]]\nname = "B{k}"\nkind = "bore"\nat = [{x}, 0.0, 0.0]\nsize = {size}\ndepth = {size}\n'
    job.write_text(
        f'name = "p"\nunit = "{unit}"\n'
        + "".join(feature.format(k=k, x=inch * k, size=0.5 * inch) for k in range(1, 4))
        + f'[program]\nfile = "own.nc"\ndialect = "{dialect}"\n[[measured]]\nfile = "p.csv"\n'
    )
    return job


@pytest.mark.parametrize(("dialect", "register", "times"), [("fanuc-mill", "D4", 1), ("linuxcnc", "D4", 2)])
def test_a_number_is_in_the_unit_and_of_the_register_of_its_control(
    tmp_path: Path, dialect: str, register: str, times: int
) -> None:
    """An inch program, a job in mm: bores 40 µm small need the radius 20 µm smaller, 0.0008 in = 0.02032 mm, or twice
    that in LinuxCNC's table of diameters.
    """
    job = _three_small_bores(tmp_path, dialect)
    [line, *_] = run("mill", "entries", job).splitlines()
    holds = "radius" if times == 1 else "diameter"
    millimetres = f"{-0.02032 * times:+.4f} mm"
    assert line.startswith(f"tool 4, {holds} ({register}): add {-0.0008 * times:+.4f} in = {millimetres} (± ")
    [entry] = json.loads(run("mill", "entries", job, "--json"))["entries"]
    assert entry["change_um"] == pytest.approx(-20.32)
    change = pytest.approx(-0.0008 * times)
    assert entry["at_control"] == {"name": register, "holds": holds, "change": change, "total": change, "unit": "in"}


@pytest.mark.parametrize("unit", ["mm", "inch"])
@pytest.mark.parametrize(("ring_off_mm", "radius_um"), [(-0.04, None), (0.0, -20.32), (0.04, -40.64)])
def test_half_of_what_a_ring_is_read_off_is_taken_out_of_every_wall(
    tmp_path: Path, unit: str, ring_off_mm: float, radius_um: float | None
) -> None:
    """Bores that read 40 µm small: by a device that reads a ring 40 µm small as well, they are right; by one that reads
    it 40 µm large, they are 80 µm small, and the radius is 40 µm too large, 0.0016 in.
    """
    job, per_mm = _three_small_bores(tmp_path, "fanuc-mill", unit), 1.0 if unit == "mm" else 1.0 / 25.4
    ring, measured = 25.0 * per_mm, (25.0 + ring_off_mm) * per_mm
    device = f'device = "probe"\n[[device]]\nname = "probe"\nring = {ring}\nring_measured = {measured}\n'
    job.write_text(job.read_text() + device)
    entries = json.loads(run("mill", "entries", job, "--json"))["entries"]
    radii = [one["change_um"] for one in entries if one["at_control"]["name"] == "D4"]
    assert radii == ([] if radius_um is None else [pytest.approx(radius_um)])


def test_a_part_that_was_not_cut_with_the_stated_numbers_is_refused(tmp_path: Path) -> None:
    """The second part is like the first: nothing had been entered before it was cut, whatever the job states."""
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    run("mill", "entries", job)
    second = job.read_text() + '\n[[measured]]\nfile = "part-1.dmo"\n'
    job.write_text(second + 'entered = ["out/entries.json"]\n')
    assert "MIL-CONTRADICTED: part '1' is off by" in run("mill", "entries", job, "-o", tmp_path / "no", status=3)
    assert not (tmp_path / "no").exists()
    job.write_text(second + "entered = []\n")
    assert "tool 2, radius (D22): add -0.020 mm" in run("mill", "entries", job, "-o", tmp_path / "yes")


def test_the_changes_of_several_records_add_up(tmp_path: Path) -> None:
    """Twice −0.010 had been entered and the bores still read 40 µm small: −0.020 more, −0.040 since the first part."""
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    names = []
    for total in (-0.010, -0.020):
        entry = {"register": "radius", "of": "2", "change": -0.010, "total": total, "unit": "mm"}
        record = {"kind": "trueloop entries of a milled part", "part_type": "plate", "before": {}, "entries": [entry]}
        names.append(f"entered{total}.json")
        (job.parent / names[-1]).write_text(json.dumps(record))
    job.write_text(job.read_text().replace('dmo"', f'dmo"\nentered = {json.dumps(names)}'))
    own = next(one for one in json.loads(run("mill", "entries", job, "--json"))["entries"] if one["of"] == "2")
    assert (own["register"], own["change_um"], own["total_um"]) == (
        "radius",
        pytest.approx(-20.0),
        pytest.approx(-40.0),
    )


def test_the_latest_record_holds_what_was_in_force_before_it(tmp_path: Path) -> None:
    """Numbers are entered after the first part, the second is good and nothing is proposed: that record alone states
    the numbers of the first, with those of the first named beside it as well, and neither counts twice.
    """
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    run("mill", "entries", job)
    first = json.loads((job.parent / "out" / "entries.json").read_text())["entries"]
    assert {one["register"] for one in first} == {"radius", "length", "x", "y", "turn"}
    text, measured = job.read_text(), []
    good = read_measured_file(job.parent / "part-1.dmo", StatedFacts()).inspections[0]
    for serial in ("2", "3"):
        readings = tuple(replace(one, actual=one.nominal or 0.0) for one in good.readings)
        part = Inspection(Part(PartType("plate"), serial), "readings", "", len(readings), readings)
        (job.parent / f"part-{serial}.dmo").write_text(dmis_results([part], "part"))
        measured.append(f'\n[[measured]]\nfile = "part-{serial}.dmo"\nentered = ')
    job.write_text(text + measured[0] + '["out/entries.json"]\n')
    run("mill", "entries", job, "-o", job.parent / "second")
    assert json.loads((job.parent / "second" / "entries.json").read_text())["entries"] == []
    for named in (["second/entries.json"], ["out/entries.json", "second/entries.json"]):
        job.write_text(text + "".join(measured[:1]) + '["out/entries.json"]\n' + measured[1] + json.dumps(named) + "\n")
        third = read_milled(job).parts[2].in_force
        assert {one.register: value for one, value in third.items() if one.of != "1"} == pytest.approx(
            {one["register"]: one["change"] for one in first if one["of"] != "1"}
        )
        assert json.loads(run("mill", "entries", job, "--json", "-o", tmp_path / "third"))["entries"] == []


def _with_record(job: Path, **entry: object) -> str:
    record = {"kind": "trueloop entries of a milled part", "part_type": "plate", "before": {}, "entries": [entry]}
    (job.parent / "entries.json").write_text(json.dumps(record))
    text = job.read_text().replace('file = "part-1.dmo"', 'file = "part-1.dmo"\nentered = ["entries.json"]')
    job.with_name("with.toml").write_text(text)
    return run("mill", "entries", job.with_name("with.toml"), status=3)


def test_records_that_no_job_has_written_are_refused(tmp_path: Path) -> None:
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    good = {"register": "radius", "of": "2", "change": 0.01, "unit": "mm"}
    for wrong in (
        {"register": "Radius"},
        {"register": ""},
        {"of": 2},
        {"unit": "inch"},
        {"change": 1e300},
        {"change": float("nan")},
    ):
        assert "MIL-RECORD" in _with_record(job, **(good | wrong))


def test_records_of_what_cannot_move_a_feature_are_refused(tmp_path: Path) -> None:
    """Another work offset; the radius of a tool whose paths are its centre's: both would count as never entered."""
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    assert "moves no feature" in _with_record(job, register="x", of="G55", change=0.01, unit="mm")
    finish = job.with_name("finish.nc")
    finish.write_text(re.sub(r"G4[12] D\d+ ", "", finish.read_text()))
    own = "\n[[tool]]\nnumber = {}\ncutter_radius = 1.0"
    job.write_text(job.read_text().replace("[[measured]]", own.format(1) + own.format(2) + "\n\n[[measured]]"))
    for name, size in (("B", -2.0), ("S", 2.0)):  # the circles are now those of centres, a radius of 1 mm away
        resized = lambda one, by=size: f"{one[1]}{float(one[2]) - by}"  # noqa: E731
        text = re.sub(rf'(name = "{name}\d"(?:\n.*){{2}}\nsize = )(.*)', resized, job.read_text())
        job.write_text(text)
    assert "moves no feature" in _with_record(job, register="radius", of="2", change=0.01, unit="mm")


def test_names_are_found_without_case_and_runs_of_one_part_are_one_part(tmp_path: Path) -> None:
    run("examples", "plate", "-o", tmp_path)
    job, file = tmp_path / "plate" / "plate.toml", tmp_path / "plate" / "part-1.dmo"
    before = run("mill", "entries", job, "--json")
    job.write_text(job.read_text().replace('name = "B', 'name = "b-'))
    assert json.loads(run("mill", "entries", job, "--json"))["rms_um"] == json.loads(before)["rms_um"]
    one = read_measured_file(file, StatedFacts()).inspections[0]
    file.write_text(dmis_results([one, one], "part"))
    twice = json.loads(run("mill", "entries", job, "--json"))
    assert twice["parts"] == ["1"]


def test_two_devices_that_measured_one_part_are_of_one_part(tmp_path: Path) -> None:
    """A bore gauge beside the measuring machine: B0 60 µm larger by the gauge, of which either may be off by 30 µm."""
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    (job.parent / "gauge.csv").write_text("feature,serial,diameter_mm\nB0,1,12.021\n")
    text = job.read_text().replace('"part-1.dmo"', '"part-1.dmo"\ndevice = "CMM"')
    text += '\n[[measured]]\nfile = "gauge.csv"\nentered = []\ndevice = "bore gauge"\n'
    job.write_text(text)
    found = json.loads(run("mill", "entries", job, "--json"))
    assert found["parts"] == ["1"]
    off = {one["name"]: one["off_um"] for one in found["devices"]}
    assert off == {"bore gauge": pytest.approx(-30.0, abs=2.0), "CMM": pytest.approx(30.0, abs=2.0)}
    assert "'bore gauge' may read all walls -30 ± " in run("mill", "entries", job)
    # a ring of 25 mm is read right by the measuring machine: the gauge is off, and the radius as without it
    calibrated = '\n[[device]]\nname = "CMM"\nring = 25.0\nring_measured = 25.0\n'
    job.write_text(text + calibrated)
    printed = run("mill", "entries", job)
    assert "tool 2, radius (D22): add -0.020 mm" in printed and "'CMM'" not in printed
    job.write_text(text + calibrated + calibrated.replace("CMM", "bore gauge"))
    printed = run("mill", "entries", job)  # both read it right: the reading is at fault
    assert "B0, diameter: 2 readings on part '1', -39.1 to +21.0 µm, contradict each other" in printed
    assert "tool 2, radius (D22): add -0.020 mm" in printed


def test_what_cuts_each_feature_is_printed_with_its_line(tmp_path: Path) -> None:
    run("examples", "plate", "-o", tmp_path)
    printed = run("mill", "entries", tmp_path / "plate" / "plate.toml")
    lines = (tmp_path / "plate" / "finish.nc").read_text().splitlines()
    row = re.search(r"^B0 +2 +control +G54 +climb +(\d+)$", printed, re.M)
    assert row is not None
    contour = next(k for k, line in enumerate(lines, 1) if k > int(row[1]) and line.startswith("G40"))
    start = max(k for k, line in enumerate(lines, 1) if k < contour and line.startswith("G41 D22"))
    last = max(k for k, line in enumerate(lines, 1) if line == "G41 D22 G1 X-44.0000 Y-30.0000")
    assert start == last < int(row[1]) < contour


@pytest.mark.parametrize("control", CONTROLS)
def test_the_program_of_any_control_leads_to_the_same_numbers(tmp_path: Path, control: Control) -> None:
    """The example's own program against that of another control, and against a job that states what cuts."""
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    text = job.read_text()
    features, program, measured = text[: text.index("[program]")], text[text.index("[program]") :], ""
    program, measured = program[: program.index("[[measured]]")], program[program.index("[[measured]]") :]
    tools = '[[tool]]\nnumber = 1\nradius = "control"\n[[tool]]\nnumber = 2\nradius = "control"\n'
    stated = re.sub(
        r'^(name = "(.).*")$', lambda one: f"{one[1]}\ntool = {2 if one[2] == 'B' else 1}", features, flags=re.M
    )
    stated = stated.replace('name = "plate"\ntool = 1', 'name = "plate"')
    (job.parent / "own.nc").write_text(plate(control))
    (job.with_name("stated.toml")).write_text(stated + tools + measured)
    (job.with_name("own.toml")).write_text(
        features + program.replace("finish.nc", "own.nc").replace("fanuc-mill", control) + measured
    )
    by_statement, by_program = (
        json.loads(run("mill", "entries", job.with_name(name), "--json")) for name in ("stated.toml", "own.toml")
    )
    numbers = [
        [
            (one["register"], one["change_urad" if one["register"] == "turn" else "change_um"])
            for one in found["entries"]
        ]
        for found in (by_statement, by_program)
    ]
    assert len(numbers[0]) == 6 and numbers[0] == numbers[1]
    printed = run("mill", "entries", job.with_name("own.toml"))
    words = {
        "linuxcnc": "tool 2, diameter (D2): add -0.040 mm",
        "siemens": "tool 2, radius (D1): add -0.020 mm",
        "heidenhain": "tool 2, radius: add -0.020 mm",
    }
    assert printed.startswith(words.get(control, "tool 2, radius (D22): add -0.020 mm"))
    assert f"{'preset 1' if control == 'heidenhain' else 'G54'}, X: add -0.030 mm" in printed
