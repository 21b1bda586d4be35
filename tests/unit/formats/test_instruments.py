"""Instruments' own files: the sign of each by hand, made files against their truth, and what is asked for."""

import csv
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.instrument_files import read_circles
from trueloop.jobs.machine.machine_model import FittedMachine, fit_machine
from trueloop.machine.model.model import MachineModel, State

MILL = """[machine]
name = "made"
structure = "mill-table-x"
[axes.X]
travel_mm = [0, 500]
[axes.Y]
travel_mm = [-200, 200]
[axes.Z]
travel_mm = [-300, 0]
"""
ROTARY = """[machine]
name = "made"
structure = "{structure}"
[axes.X]
travel_mm = [-250, 250]
[axes.Y]
travel_mm = [-250, 250]
[axes.Z]
travel_mm = [-150, 150]
"""
TABLE = '[axes.C]\ntravel_deg = [0, 360]\nsense = "{sense}"\n'
AT = "at = { X = 250, Y = 0, Z = -100 }\ntool_mm = [0, 0, -120]\n"
BAR = AT + 'length = "calibrated"\ncentre = "unknown"\n'
SPHERE = 'at = { X = 0, Y = 0, Z = 0 }\ntool_mm = [0, 0, 0]\nunit = "mm"\nball_radius_mm = 10\nstylus_radius_mm = 2\n'


def _term(error: str, more: str = "") -> str:
    return f'[[term]]\nerror = "{error}"\n{more}\n'


def _line(zero: float, ways: bool = False) -> str:
    return f"degree = 1\nzero_at = [{zero}]\nboth_ways = {str(ways).lower()}"


def _fitted(folder: Path, machine: str, tables: dict[str, str]) -> FittedMachine:
    """Fits the machine to instruments' files that lie in the folder, each with its keys."""
    (folder / "machine.toml").write_text(machine)
    named = "".join(f'[[readings]]\nfile = "{name}"\n{keys}' for name, keys in tables.items())
    (folder / "readings.toml").write_text(named)
    return fit_machine(folder / "machine.toml", [folder / "readings.toml"])


def _value_um(model: MachineModel, error: str, position: float = 0.0, way: float = 1.0) -> float:
    """The error there in µm or µrad; `position` in mm or rad."""
    for term, where in zip(model.terms, model.slices(), strict=True):
        if str(term.name) == error:
            row = term.design(np.array([position]), np.array([way]), {})
            return 1e3 * (1e3 if term.name.is_rotation else 1.0) * float((row @ model.coefficients[where])[0])
    raise AssertionError(error)


def _rtl(
    folder: Path, rows: list[str], *, targets: str = "0 100 200", owner: str = "Linear", flags: str = "0 0 2 0"
) -> None:
    text = (
        f"HEADER::\nOwner : {owner}\nTARGET DATA::\nTarget-count: 3\nTargets :\n{targets}\nFlags: {flags}\n"
        "USER-TEXT::\nAxis:X\nRUNS::\nRun-count: 2\nDEVIATIONS::\nRun Target Data: \n"
    )
    (folder / "x.rtl").write_text(text + "\n".join(rows) + "\n\nEOF::\n", newline="\r\n")


LASER = ["1 1 0", "1 2 5", "1 3 10", "2 3 8", "2 2 3", "2 1 -2"]


def test_a_laser_reads_plus_where_the_axis_travels_too_far(tmp_path: Path) -> None:
    """+5 µm at target 100, machine X 350: it stands at 350.005. Coming back it stands 2 µm lower."""
    _rtl(tmp_path, LASER)
    model = _fitted(tmp_path, MILL + _term("EXX", _line(250, True)), {"x.rtl": AT}).found.model
    np.testing.assert_allclose([_value_um(model, "EXX", x) for x in (250, 350, 450)], [0, 5, 10], atol=1e-6)
    np.testing.assert_allclose([_value_um(model, "EXX", x, -1) for x in (250, 450)], [-2, 8], atol=1e-6)


def test_padded_return_runs_of_a_one_way_test_are_not_read(tmp_path: Path) -> None:
    rows = [*LASER[:3], "2 3 0", "2 2 0", "2 1 0", "3 1 0", "3 2 5", "3 3 10"]
    _rtl(tmp_path, rows, flags="0 1 2 0")
    machine = MILL + _term("EXX", _line(250))
    fitted = _fitted(tmp_path, machine, {"x.rtl": AT})
    assert len(fitted.data) == 6
    np.testing.assert_allclose(_value_um(fitted.found.model, "EXX", 450), 10, atol=1e-6)
    _rtl(tmp_path, rows)
    with pytest.raises(TrueloopError, match="run 2: all 3 deviations are 0"):
        _fitted(tmp_path, machine, {"x.rtl": AT})


def _bar(folder: Path, deviation_um: Callable[[float, float], float], ways: tuple[int, ...] = (1, -1)) -> None:
    """A bar of 100 mm every 10°, beside the reversals; the deviation of angle and way round."""
    rows = ["test_id,axis,angle_deg,radius_nominal_mm,deviation_um"]
    for way in ways:
        degrees = range(5, 360, 10) if way > 0 else range(355, 0, -10)
        rows += [f"{'ccw' if way > 0 else 'cw'},XY,{a},100,{deviation_um(math.radians(a), way):.7f}" for a in degrees]
    (folder / "bar.csv").write_text("\n".join(rows) + "\n")


def test_a_ball_bar_reads_plus_where_the_tool_is_too_far_out(tmp_path: Path) -> None:
    """X travels 100 µm/m too far, so at 100 mm the bar is 10 µm longer; +Y leans towards +X by 40 µrad, so it is 2 µm
    longer at 45°; X lags by 3 µm, so on its way to −X, above the centre, the tool is 1.5 µm too far towards +X. The
    centre lies 7 µm off.
    """

    def deviation(t: float, way: float) -> float:
        back = way * math.copysign(1.5, math.sin(t)) * math.cos(t)
        return 10 * math.cos(t) ** 2 + 4 * math.sin(t) * math.cos(t) + back + 7 * math.sin(t)

    _bar(tmp_path, deviation)
    terms = _term("EXX", _line(250, True)) + _term("EYY", _line(0)) + _term("EC0Y")
    model = _fitted(tmp_path, MILL + terms, {"bar.csv": BAR}).found.model
    np.testing.assert_allclose(_value_um(model, "EXX", 350), 10, atol=1e-4)
    np.testing.assert_allclose(_value_um(model, "EXX", 250, -1), 3, atol=1e-4)
    np.testing.assert_allclose([_value_um(model, "EYY", 100), _value_um(model, "EC0Y")], [0, -40], atol=1e-3)


def test_a_ball_bar_in_another_unit_than_its_heading_is_refused_and_stated(tmp_path: Path) -> None:
    """12 µm at the most: in millimetres below `_um`, in micrometers below `_mm`."""
    _bar(tmp_path, lambda t, _: 12 * math.cos(2 * t))
    text = (tmp_path / "bar.csv").read_text()
    right = [circle.deviation_mm for circle in read_circles(tmp_path / "bar.csv")]
    (tmp_path / "mm.csv").write_text(text.replace("deviation_um", "deviation_mm"))
    _bar(tmp_path, lambda t, _: 12e-3 * math.cos(2 * t))
    for file, unit, other in (("mm.csv", "um", "mm"), ("bar.csv", "mm", "um")):
        with pytest.raises(TrueloopError, match="as the heading states") as refused:
            read_circles(tmp_path / file)
        assert refused.value.code is Code.MCH_UNIT and f"--unit {unit}, or --unit {other}" in (refused.value.hint or "")
        np.testing.assert_allclose([c.deviation_mm for c in read_circles(tmp_path / file, unit)], right, atol=1e-7)


def test_squareness_of_one_way_round_could_be_the_servos(tmp_path: Path) -> None:
    _bar(tmp_path, lambda t, _: math.sin(2 * t), (1,))
    with pytest.raises(TrueloopError) as refused:
        _fitted(tmp_path, MILL + _term("EC0Y"), {"bar.csv": BAR})
    assert refused.value.code is Code.MCH_COLLINEAR


@pytest.mark.parametrize(("absolute", "scale_um"), [("length", 10.0), ("no", None), ("centre", None)])
def test_a_bar_of_known_length_measures_scales_though_its_centre_is_open(
    tmp_path: Path, absolute: str, scale_um: float | None
) -> None:
    """Both axes travel 100 µm/m too far, with a centre 7 µm off in X: the circle is 10 µm larger."""
    rows = ["X_mm,Y_mm,Z_mm,along_x,along_y,along_z,reading_um,run,absolute"]
    for a in np.arange(0.0, 360.0, 10.0):
        c, s = math.cos(math.radians(a)), math.sin(math.radians(a))
        rows.append(f"{250 + 100 * c},{100 * s},-100,{c},{s},0,{10 + 7 * c},bar,{absolute}")
    (tmp_path / "bar.csv").write_text("\n".join(rows) + "\n")
    machine = tmp_path / "machine.toml"
    machine.write_text(MILL + _term("EXX", _line(250)) + _term("EYY", _line(0)))
    if scale_um is None:
        with pytest.raises(TrueloopError) as refused:
            fit_machine(machine, [tmp_path / "bar.csv"])
        assert refused.value.code is Code.MCH_COLLINEAR
        return
    model = fit_machine(machine, [tmp_path / "bar.csv"]).found.model
    values = [_value_um(model, "EXX", 350), _value_um(model, "EYY", 100)]
    np.testing.assert_allclose(values, [scale_um, scale_um], atol=1e-6)


def _touches(folder: Path, centres: dict[float, tuple[float, float, float]], scale: float = 1.0) -> None:
    """+X −X +Y −Y +Z of a sphere of 10 mm with a stylus of 2 mm, as LinuxCNC logs them."""
    ways = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
    rows = [
        " ".join(f"{v * scale:.9f}" for v in np.array(centre) + 12 * way) + f" 0 0 {c} 0 0 0"
        for c, centre in centres.items()
        for way in ways
    ]
    (folder / "ball.txt").write_text("\n".join(rows) + "\n")


@pytest.mark.parametrize(("unit", "scale"), [("mm", 1.0), ("inch", 1 / 25.4)])
@pytest.mark.parametrize("sense", ["iso-841", "opposite"])
def test_the_line_of_a_table_lies_where_the_ball_turns_about_it(
    tmp_path: Path, sense: str, unit: str, scale: float
) -> None:
    """C's line is at X +0.020. The ball, 99.98 mm from it at C 0, is on the other side of it at 180°, at −99.960; at
    90° it is at Y −99.98 by ISO 841, where a table turns left-handed as C grows, and at +99.98 in the opposite sense.
    """
    y = -99.98 if sense == "iso-841" else 99.98
    _touches(tmp_path, {0: (100, 0, 5), 90: (0.02, y, 5), 180: (-99.96, 0, 5), 270: (0.02, -y, 5)}, scale)
    terms = _term("EX0C") + _term("EY0C")
    keys = SPHERE.replace('unit = "mm"', f'unit = "{unit}"')
    structure = ROTARY.format(structure="w C b X Y Z (S) t")
    model = _fitted(tmp_path, structure + TABLE.format(sense=sense) + terms, {"ball.txt": keys}).found.model
    np.testing.assert_allclose([_value_um(model, "EX0C"), _value_um(model, "EY0C")], [20, 0], atol=2e-5)
    other = "opposite" if sense == "iso-841" else "iso-841"
    with pytest.raises(TrueloopError, match=r"at C90 the sphere lies .* off") as refused:
        _fitted(tmp_path, structure + TABLE.format(sense=other) + terms, {"ball.txt": keys})
    assert "sense" in (refused.value.hint or "")


def test_radii_that_the_touches_contradict_are_refused(tmp_path: Path) -> None:
    _touches(tmp_path, {0: (100, 0, 5), 90: (0, -100, 5), 180: (-100, 0, 5)})
    machine = ROTARY.format(structure="w C b X Y Z (S) t") + TABLE.format(sense="iso-841") + _term("EX0C")
    with pytest.raises(TrueloopError, match=r"\+5\.0 µm larger") as refused:
        _fitted(tmp_path, machine, {"ball.txt": SPHERE.replace("= 2\n", "= 1.995\n")})
    assert "2.0000 mm" in (refused.value.hint or "")


@pytest.mark.parametrize(
    ("name", "keys", "words"),
    [
        ("x.rtl", AT.replace("X = 250, ", ""), "'at' has to name X Y Z, 1 differ: X"),
        ("x.rtl", "tool_mm = [0, 0, 0]\n", "a laser's file, needs the key 'at'"),
        ("x.rtl", AT + 'length = "unknown"\n', "has no use for the key 'length'"),
        ("bar.csv", AT + 'centre = "known"\n', "needs the key 'length'"),
        ("bar.csv", AT + 'length = "unknown"\n', "needs the key 'centre'"),
        ("ball.txt", SPHERE.replace("ball_radius_mm = 10\n", ""), "needs the key 'ball_radius_mm'"),
        ("ball.txt", SPHERE.replace("stylus_radius_mm = 2\n", ""), "needs the key 'stylus_radius_mm'"),
        ("ball.txt", SPHERE.replace('unit = "mm"\n', ""), "needs the key 'unit'"),
        ("machine.toml", AT, "is of an unknown kind"),
    ],
)
def test_what_a_file_does_not_hold_is_asked_for(tmp_path: Path, name: str, keys: str, words: str) -> None:
    _rtl(tmp_path, LASER)
    _bar(tmp_path, lambda _, way: way)
    _touches(tmp_path, {0: (100, 0, 5)})
    with pytest.raises(TrueloopError, match=words) as refused:
        _fitted(tmp_path, MILL + _term("EXX", _line(250)), {name: keys})
    assert refused.value.code is Code.MCH_FILE and refused.value.place is not None and refused.value.place.line == 1
    if name != "machine.toml":
        with pytest.raises(TrueloopError, match="where the machine stood is not in it"):
            fit_machine(tmp_path / "machine.toml", [tmp_path / name])


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("x.rtl", "Linear", "Angular", "only Linear is read"),
        ("x.rtl", "Axis:X", "Axis:C", "not the letter of a linear axis"),
        ("x.rtl", "2 3 8", "2 1 8", "do not go one way"),
        ("x.rtl", "0 100 200", "0 100", "2 targets where Target-count is 3"),
        ("bar.csv", "ccw,XY,15,", "ccw,XY,3,", "do not go one way round"),
        ("bar.csv", "ccw,", "cw ,", "do not go one way round"),
        ("bar.csv", "XY", "XQ", "not a plane"),
        ("ball.txt", "112.000000000", "112.300000000", "mm off a sphere"),
        ("ball.txt", "112.000000000 0.0", "nan 0.0", "is of an unknown kind|not 9 finite numbers"),
    ],
)
def test_a_damaged_file_is_refused(tmp_path: Path, file: str, old: str, new: str, words: str) -> None:
    _rtl(tmp_path, LASER)
    _bar(tmp_path, lambda t, _: math.cos(t))
    _touches(tmp_path, {0: (100, 0, 5), 90: (0, -100, 5), 180: (-100, 0, 5)})
    text = (tmp_path / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new))
    machine = ROTARY.format(structure="w C b X Y Z (S) t") + TABLE.format(sense="iso-841") + _term("EX0C")
    keys = {"x.rtl": AT, "bar.csv": BAR, "ball.txt": SPHERE}[file]
    with pytest.raises(TrueloopError, match=words):
        _fitted(tmp_path, machine if file == "ball.txt" else MILL + _term("EXX", _line(250)), {file: keys})


def test_the_way_round_is_that_of_the_angles(tmp_path: Path) -> None:
    _bar(tmp_path, lambda t, _: math.cos(t), (1,))
    (tmp_path / "bar.csv").write_text((tmp_path / "bar.csv").read_text().replace("ccw,", "cw,"))
    with pytest.raises(TrueloopError, match="grow: counter-clockwise"):
        _fitted(tmp_path, MILL + _term("EXX", _line(250)), {"bar.csv": BAR})


@pytest.fixture
def samples(corpus: Path, tmp_path: Path) -> Path:
    for file in (corpus / "instruments/samples").iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    return tmp_path


def _truth(folder: Path, file: str) -> dict[str, str]:
    with (folder / "truth.csv").open() as rows:
        return {row["name"]: row["value"] for row in csv.DictReader(rows) if row["file"] == file}


@pytest.mark.corpus
def test_the_made_laser_file(samples: Path) -> None:
    """Its drift of 0.15 µm a run would make 2.25 of the reversal of 2.4: it is taken out."""
    truth = _truth(samples, "laser_x.rtl")
    keys = "at = { X = 0, Y = 0, Z = -100 }\ntool_mm = [0, 0, -120]\n"
    model = _fitted(samples, MILL + _term("EXX", "degree = 2\nzero_at = [0]\nboth_ways = true"), {"laser_x.rtl": keys})
    ways = [[_value_um(model.found.model, "EXX", x, way) for x in np.linspace(0, 500, 101)] for way in (1, -1)]
    reversal = float(np.mean(ways[0]) - np.mean(ways[1]))
    assert abs(reversal - float(truth["reversal"])) < 0.1  # 0.3 µm in 110 readings, the drift beside it
    assert abs(float(np.ptp(np.mean(ways, axis=0))) - float(truth["scale"]) / 2) < 1.2  # a cyclic error of 1.2 µm


@pytest.mark.corpus
def test_the_made_ball_bar_file(samples: Path) -> None:
    truth = {name: float(value) for name, value in _truth(samples, "ballbar_xy.csv").items()}
    rows = (samples / "ballbar_xy.csv").read_text().splitlines()
    cells = [row.split(",") for row in rows[1:]]
    known = [f"{c[3]},XY,{c[5]},{c[6]},{1e3 * float(c[8]) - truth['bar length error']:.3f}" for c in cells]
    header = "test_id,axis,angle_deg,radius_nominal_mm,deviation_um"
    (samples / "calibrated.csv").write_text("\n".join([header, *known]) + "\n")
    terms = _term("EXX", _line(250, True)) + _term("EYY", _line(0, True)) + _term("EC0Y")
    model = _fitted(samples, MILL + terms, {"calibrated.csv": BAR + "u_um = 0.2\n"}).found.model
    assert abs(_value_um(model, "EC0Y") + truth["squareness"]) < 0.4
    for axis, zero in (("X", 250), ("Y", 0)):
        error = f"E{axis}{axis}"
        assert abs(_value_um(model, error, zero + 100) - 0.1 * truth[f"scale {axis}"]) < 0.1
        assert abs(_value_um(model, error, zero, -1) - truth[f"backlash {axis}"]) < 0.1


@pytest.mark.corpus
def test_the_made_touches_of_a_sphere(samples: Path) -> None:
    """The truth places C's line in the machine at A 0; the model in the frame that A carries, with A's own errors."""
    truth = _truth(samples, "sphere_xyzac.txt")
    machine = ROTARY.format(structure="five-axis-table-table-ac")
    machine += '[axes.A]\ntravel_deg = [-90, 30]\noffset_mm = [0, 9, -17]\nsense = "opposite"\n'
    machine += '[axes.C]\ntravel_deg = [0, 330]\noffset_mm = [7, -20, 17]\nsense = "opposite"\n'
    machine += _term("EAA", "degree = 3\nsegments = 2\nzero_at = [0]")
    machine += _term("ECC", "degree = 3\nsegments = 5\nzero_at = [0]")
    machine += "".join(_term(f"E{one}0A") for one in "YZBC") + "".join(_term(f"E{one}0C") for one in "XYAB")
    keys = SPHERE.replace("= 10", "= 12.7").replace("= 2\n", "= 2.9985\nu_um = 0.3\n")
    found = _fitted(samples, machine, {"sphere_xyzac.txt": keys}).found
    assert 0.7 < found.scatter < 1.3
    value = {str(term.name): _value_um(found.model, str(term.name)) for term in found.model.terms}
    shifts = {"A shift Y": value["EY0A"], "A shift Z": value["EZ0A"], "C shift X": value["EX0C"]}
    shifts["C shift Y"] = value["EY0C"] + value["EY0A"]
    tilts = {"A tilt Y": value["EB0A"], "A tilt Z": value["EC0A"], "C tilt X": value["EA0C"]}
    tilts["C tilt Y"] = value["EB0C"] + value["EB0A"]
    for name, um in shifts.items():
        assert abs(um - float(truth[name])) < 0.5, name
    for name, urad in tilts.items():
        assert abs(urad - float(truth[name])) < 4, name
    urad = 1e6 * math.radians(float(truth["C angle error"]))
    for degrees in (
        60,
        135,
        240,
    ):  # C overshoots: the tool turns left-handed as seen from a work that turns right-handed
        expected = -urad * (math.sin(math.radians(2 * degrees + 40)) - math.sin(math.radians(40)))
        assert abs(_value_um(found.model, "ECC", math.radians(degrees)) - expected) < 8


def test_the_sense_of_an_axis_stays_with_the_model(tmp_path: Path) -> None:
    """Written and read again, an opposite C still turns the other way."""
    y = 99.98
    _touches(tmp_path, {0: (100, 0, 5), 90: (0.02, y, 5), 180: (-99.96, 0, 5), 270: (0.02, -y, 5)})
    machine = ROTARY.format(structure="w C b X Y Z (S) t") + TABLE.format(sense="opposite") + _term("EX0C")
    fitted = _fitted(tmp_path, machine, {"ball.txt": SPHERE})
    from trueloop.formats.tables.model_file import read_model

    known = read_model(fitted.write(tmp_path / "out")[0])
    state = State(known.machine.chain.positions({"X": 50.0, "Y": 20.0, "C": math.radians(90)}))
    np.testing.assert_array_equal(known.error_mm(state), fitted.found.model.error_mm(state))
    # the work turned right-handed with a line 20 µm towards +X: where X pointed, it sees −Y, and the tool 20 µm short
    shift = known.error_mm(state)[0] - known.error_mm(State(known.machine.chain.positions({"X": 50.0, "Y": 20.0})))[0]
    np.testing.assert_allclose(1e3 * shift, [20.0, 20.0, 0.0], atol=2e-5)
