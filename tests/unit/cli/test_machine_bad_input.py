"""What `trueloop machine` says to mistyped files, keys and columns, mixed units and readings that cannot be."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.cli import invoke

MACHINE = """[machine]
name = "VMC 3"
structure = "mill-gantry"
[axes.X]
travel_mm = [0, 500]
[axes.Y]
travel_mm = [0, 400]
[[term]]
error = "EXX"
zero_at = [0]
[[term]]
error = "EX0S"
signals = { T1 = 20.0 }
"""
READINGS = "X_mm,along,reading_um,u_um,T1_degC\n" + "".join(
    f"{50 * k},X,{k * k},0.5,{20 + (k * 7) % 5}\n" for k in range(10)
)
COLLINEAR = READINGS.replace("T1_degC", "T1_degC,T2_degC").splitlines()
COLLINEAR = [COLLINEAR[0], *(f"{row},{2 * float(row.rsplit(',', 1)[1])}" for row in COLLINEAR[1:])]

Said = Callable[..., str]


@pytest.fixture
def said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Said:
    """What `fit` says to a machine file and readings; it has to refuse them."""
    monkeypatch.chdir(tmp_path)

    def run(machine: str = MACHINE, readings: str = READINGS, status: int = 3) -> str:
        Path("m.toml").write_text(machine)
        Path("r.csv").write_text(readings)
        result = invoke("machine", "fit", "m.toml", "r.csv", "-o", "out")
        assert result.exit_code == status, result.output
        assert Path("out").exists() == (status == 0)
        return result.output

    return run


def test_the_files_are_good_as_they_stand(said: Said) -> None:
    assert "2 terms from 10 readings" in said(status=0)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("structure =", "structur =", ("m.toml:3: MCH-FILE", "did you mean 'structure'")),
        ("mill-gantry", "mil-gantry", ("m.toml:3: MCH-STRUCTURE", "did you mean 'mill-gantry'")),
        ("travel_mm = [0, 400]", "travel_m = [0, 400]", ("m.toml:7: MCH-FILE: 'axes.Y.travel_m'", "'travel_mm'")),
        ("travel_mm = [0, 400]", "travel_mm = [400, 0]", ("m.toml:7: MCH-FILE: 'axes.Y.travel_mm'", "400")),
        ("travel_mm = [0, 400]", "travel_deg = [0, 400]", ("m.toml:6: MCH-UNIT", "400")),
        ("travel_mm = [0, 500]", "", ("m.toml:9: MCH-BASIS", "travel")),
        ("axes.Y", "axes.W", ("m.toml:6: MCH-AXIS", "'W'")),
        ("EX0S", "EX9S", ("m.toml:12: MCH-NAME", "EX9S")),
        ("EX0S", "EXX", ("m.toml:12: MCH-FILE", "EXX has 2 tables")),
        ("signals =", "signal =", ("m.toml:13: MCH-FILE: 'term.1.signal'", "did you mean 'signals'")),
        ("20.0", '"warm"', ("m.toml:13: MCH-FILE: 'term.1.signals.T1'", "warm")),
        ("T1 = 20.0", "T9 = 20.0", ("m.toml: MCH-SIGNAL", "T9", "T1")),
        ("[axes.X]", "[axes.X", ("m.toml:4:8: MCH-FILE",)),
    ],
)
def test_machine_files(said: Said, old: str, new: str, expected: tuple[str, ...]) -> None:
    answer = said(machine=MACHINE.replace(old, new))
    assert all(words in answer for words in expected), answer


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (READINGS, "", ("r.csv:1: MCH-FILE", "empty")),
        (READINGS, "X_mm,along,reading_um\n", ("r.csv:1: MCH-FILE", "no rows")),
        ("X_mm", "x_mm", ("r.csv:1:1: MCH-FILE: ", "'x_mm'", "did you mean 'X_mm'")),
        ("X_mm", "X_deg", ("r.csv:1:1: MCH-FILE: ", "'X_deg'", "X_mm")),
        ("X_mm", "C_deg", ("r.csv:1: MCH-AXIS", "'C'")),
        ("X_mm", "X_ft", ("r.csv:1: MCH-UNIT", "X_ft")),
        ("reading_um", "readng_um", ("r.csv:1:3: MCH-FILE", "did you mean 'reading_um'")),
        ("u_um", "u_urad", ("r.csv:1: MCH-UNIT", "u_urad", "reading_um")),
        ("u_um", "reading_mm", ("r.csv:1: MCH-UNIT", "2 columns")),
        ("T1_degC", "T1_degF", ("r.csv:1: MCH-UNIT", "T1_degF")),
        ("T1_degC", "T2_degC", ("m.toml: MCH-SIGNAL", "T1", "T2")),
        ("100,X", "nan,X", ("r.csv:4:1: MCH-FILE", "X_mm is 'nan'")),
        ("100,X", "1,00,X", ("r.csv:4:6: MCH-FILE", "6 cells under 5 columns")),
        ("100,X,4,0.5,24", "100,X", ("r.csv:4:3: MCH-FILE", "2 cells under 5 columns")),
        ("100,X", "900,X", ("r.csv:4: MCH-TRAVEL", "900 mm", "0 mm to 500 mm")),
        ("X_mm,", "Y_mm,", ("MCH-TRAVEL", "450 mm")),
        ("100,X,4,0.5", "100,X,4,1e9", ("r.csv:1: MCH-UNIT", "line 4 states", "1e+09 µm, the limit is 250 µm")),
    ],
)
def test_readings(said: Said, old: str, new: str, expected: tuple[str, ...]) -> None:
    answer = said(readings=READINGS.replace(old, new, 1))
    assert all(words in answer for words in expected), answer


def test_an_axis_without_data_and_collinear_sensors(said: Said) -> None:
    still = READINGS.replace("X_mm", "Z_mm", 1)
    answer = said(readings=still)
    assert "m.toml: MCH-DATA: EXX: axis X stands at 0 mm in all 10 readings" in answer
    answer = said(machine=MACHINE.replace("T1 = 20.0", "T1 = 20.0, T2 = 40.0"), readings="\n".join(COLLINEAR))
    assert "m.toml: MCH-COLLINEAR" in answer and "EX0S·T1" in answer and "condition index" in answer


def test_mistyped_names_of_files(said: Said) -> None:
    said(status=0)
    for arguments, meant in (
        (("fit", "m.tom", "r.csv", "-o", "x"), "m.toml"),
        (("fit", "m.toml", "r.cs", "-o", "x"), "r.csv"),
        (("show", "out/modl.json"), "out/model.json"),
        (
            (
                "decompose",
                "r.cvs",
                *[
                    "-m",
                    "out/model.json",
                    "--work-zero",
                    "0,0,0",
                    "--cutting",
                    "T1=21",
                    "--probing",
                    "T1=21",
                    "-o",
                    "x",
                ],
            ),
            "r.csv",
        ),
    ):
        result = invoke("machine", *arguments)
        assert result.exit_code == 3
        assert f"did you mean '{meant}'" in result.output


def test_tables_beyond_the_data_or_the_travel(said: Said) -> None:
    said(status=0)
    command = ["machine", "export", "out/model.json", "--control", "linuxcnc", "--axis", "X", "-o", "x.comp"]
    for more, code in (
        ("-t T1=45", "MCH-RANGE"),
        ("-t T1=21 --at Y=900", "MCH-TRAVEL"),
        ("-t T1=nan", "--temperatures"),
        ("-t T1=21 --axis Z", "out/model.json: MCH-TRAVEL: Z travels from -inf to inf mm"),
        ("-t T1=21 --error-of S", "out/model.json: MCH-AXIS: the table corrects S"),
        ("-t T1=21 --at A=3", "MCH-AXIS"),
        ("", "out/model.json: MCH-SIGNAL"),
    ):
        result = invoke(*command, *more.split())
        assert result.exit_code in (2, 3) and code in result.output
    assert not Path("x.comp").exists()
    assert invoke(*command, "-t", "T1=45", "--extrapolate", "T1").exit_code == 0
    assert all(len(row.split()) == 3 for row in Path("x.comp").read_text().splitlines())


def test_a_table_named_as_the_file_that_assigns_it_is_not_lost_to_it(said: Said) -> None:
    said(status=0)
    command = "machine export out/model.json --control heidenhain --axis X -t T1=21 -o t.cma"
    result = invoke(*command.split())
    assert result.exit_code == 4 and "t.cma: OUT-TWICE" in result.output
    assert not Path("t.cma").exists()


KINDS = (("nominal", "_mm"), ("normal", ""), ("controller", "_mm"), ("cmm", "_mm"))
POINT = "P1,3,4,5,0,0,1,3,4,5,3,4,5\n"
INSPECTED = ",".join(["point", *(f"{kind}_{c}{unit}" for kind, unit in KINDS for c in "xyz")])


def test_temperatures_beyond_the_data_are_used_by_name_only(said: Said) -> None:
    said(status=0)
    Path("i.csv").write_text(f"{INSPECTED}\n{POINT}")
    decompose = "decompose i.csv -m out/model.json --work-zero 0,0,0 --cutting T1=21 --probing T1={} -o x"
    for command in ("show out/model.json -t T1={}", decompose):
        at = ["machine", *command.format(45).split()]
        answer = invoke(*at)
        assert answer.exit_code == 3
        assert "MCH-RANGE: T1 is 45 °C; the model was found from 20 °C to 24 °C" in answer.output
        assert "--extrapolate T1" in answer.output
        assert answer.output.startswith(("out/model.json: ", "i.csv: "))
        assert invoke(*at, "--extrapolate", "X").exit_code == 3
        assert invoke(*at, "--extrapolate", "T1").exit_code == 0
        assert invoke("machine", *command.format(22).split()).exit_code == 0


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("3,4,5\n", "3,4,x\n", ("i.csv:2:13: MCH-FILE", "cmm_z_mm is 'x'")),
        ("3,4,5\n", "3,4\n", ("i.csv:2:13: MCH-FILE", "12 cells under 13 columns")),
        ("cmm_z_mm", "cmm_z", ("i.csv:1:13: MCH-FILE", "cmm_z_mm")),
        ("point,", "# touch_u_um many\npoint,", ("i.csv:1: MCH-FILE", "states no touch_u_um")),
        ("point,", "# touch_u_um = 0.5\npoint,", ("i.csv:1: MCH-FILE", "write `# touch_u_um 0.5`")),
        ("point,", "# touch_u_um: 0.5\npoint,", ("i.csv:1: MCH-FILE", "states no touch_u_um")),
        ("point,", "# cmm_u_mm 0.0005\npoint,", ("i.csv:1: MCH-FILE", "states no cmm_u_um")),
        ("point,", "# cmm_u_um -0.5\npoint,", ("i.csv:1: MCH-FILE", "states no cmm_u_um")),
        ("point,", "# cmm_u_um 0.5\n# cmm_u_um 0.4\npoint,", ("i.csv:2: MCH-FILE", "once")),
        ("point,", "comp_proc_mm,", ("i.csv:1:1: MCH-FILE", "convert it: known are comp_proc_um")),
        ("point,", "cmm_x_mm,", ("i.csv:1:11: MCH-FILE", "'cmm_x_mm' is there 2 times")),
    ],
)
def test_inspections(said: Said, old: str, new: str, expected: tuple[str, ...]) -> None:
    said(status=0)
    Path("i.csv").write_text(f"{INSPECTED}\n{POINT}".replace(old, new))
    command = "machine decompose i.csv -m out/model.json --work-zero 0,0,0 --cutting T1=21 --probing T1=21 -o x"
    answer = invoke(*command.split())
    assert answer.exit_code == 3
    assert all(words in answer.output for words in expected), answer.output
