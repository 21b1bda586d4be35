"""Bad input end to end: the command says what, where and how to mend it, and writes nothing."""

import json
import resource
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from typer.testing import Result

from tests.bad_input.mutations import Mutation, Rows, both, cell, job, rewrite, scaled, touches
from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus
from trueloop.errors import Code

EXAMPLES = Path(__file__).parents[2] / "examples"
GAUGING = 'touches = "touches.csv"'


@dataclass(frozen=True)
class Case:
    """What is done to the job, and how the refusal begins: place below the job's folder, code, words, hint."""

    mutate: Mutation
    place: str
    code: Code
    says: str
    hint: str


def _swap(rows: Rows) -> None:
    rows[14], rows[15] = rows[15], rows[14]


def _repeat(rows: Rows) -> None:
    rows.insert(15, {**rows[14], "point": "14 again"})


def _twice_over(rows: Rows) -> None:
    for row in rows:
        row["error_um"] = repr(2 * float(row["error_um"]))


def _one_dome_touch(rows: Rows) -> None:
    rows[:] = [row for row in rows if row["feature"] != "dome"] + [row for row in rows if row["feature"] == "dome"][:1]


def _into_another_program(folder: Path) -> None:
    shutil.copy(EXAMPLES / "piecs11" / "finish.nc", folder / "finish.nc")


def _correct_first(folder: Path) -> None:
    first = invoke("compensate", folder / "job.toml", "-o", folder / "first")
    assert first.exit_code == ExitStatus.DONE, first.stderr
    shutil.move(folder / "first" / "corrected.nc", folder / "finish.nc")
    shutil.rmtree(folder / "first")


CASES = {
    "touch on no feature": Case(
        cell(12, "feature", "dom"), "touches.csv:15", Code.TCH_FEATURE,
        "touch '13' is on feature 'dom', which the part does not have", "small-cylinder, dome",
    ),
    "point 5 mm off": Case(
        cell(7, "nominal_x_mm", "49.704"), "touches.csv:10", Code.TCH_OFF_PROFILE,
        "touch '8' at x 49.7040 mm (radius), z -77.0890 mm lies 5.000 mm off", "x as a radius",
    ),
    "NaN": Case(
        cell(20, "error_um", "NaN"), "touches.csv:23:5", Code.TCH_NUMBER,
        "error_um is 'NaN', not a finite number", "leave out the row",
    ),
    "text": Case(
        cell(20, "nominal_z_mm", "top"), "touches.csv:23:4", Code.TCH_NUMBER,
        "nominal_z_mm is 'top', not a finite number", "leave out the row",
    ),
    "inch for mm": Case(
        scaled({"nominal_x_mm": 1 / 25.4, "nominal_z_mm": 1 / 25.4}), "touches.csv:3", Code.TCH_UNIT,
        "the points look 25.4 times too small: 100% of 32 touches fit", "inches in a column named mm?",
    ),
    "diameter for radius": Case(
        scaled({"nominal_x_mm": 2}), "touches.csv:3", Code.TCH_DIAMETER,
        "the points look twice too large in x: 100% of 32 touches fit", "diameters in a column of radii?",
    ),
    "reversed sign": Case(
        both(touches(_twice_over, "after.csv"), job(GAUGING, f'{GAUGING}\nfinish_touches = "after.csv"')),
        "after.csv", Code.TCH_SIGN,
        "the errors after the finish cut are 2.00 times those before it", "positive = material left on",
    ),
    "duplicate point": Case(
        touches(_repeat), "touches.csv:18", Code.TCH_DUPLICATE,
        "touches '15' and '14 again' are 0.00 µm apart", "one row a point",
    ),
    "unordered points": Case(
        touches(_swap), "touches.csv:18", Code.TCH_ORDER,
        "touches '16' and '15' lie", "from chuck end to free end",
    ),
    "fewer points than the curve needs": Case(
        both(touches(_one_dome_touch), job("[output]", "[compensation]\nknot_every = 3\n\n[output]")),
        "touches.csv", Code.FIT_POINTS, "dome: 1 touches, but the knots asked for need 3", "",
    ),
    "unknown word": Case(
        rewrite("finish.nc", "N0390 G01 X", "N0390 G01 V7 X"), "finish.nc:26:11", Code.NC_WORD,
        '"V7" is no word of the dialect ge2000t', "programs.accept_unknown_words",
    ),
    "unknown code": Case(
        rewrite("semifinish.nc", "G94 G97", "G68 G97"), "semifinish.nc:11:7", Code.NC_CODE,
        '"G68" is no code of the dialect ge2000t', "programs.accept_unknown_words",
    ),
    "undefined parameter": Case(
        job("P46 = 3.52, ", ""), "finish.nc:17:35", Code.NC_PARAMETER,
        "parameter P46 has no value", "P46",
    ),
    "program that does not cut the profile": Case(
        _into_another_program, "finish.nc:20", Code.NC_NO_MATCH,
        "no feed move cuts 'collar' within 0.125 mm", "",
    ),
    "corrected already": Case(
        _correct_first, "finish.nc:2", Code.CMP_TWICE,
        "this program is corrected already", "correct the program that it was made from",
    ),
    "correction over the limit": Case(
        job("[output]", "[compensation]\nmax_correction_um = 50\n\n[output]"), "touches.csv", Code.CMP_SIZE,
        "the correction of 'cone' reaches 9", "(override: compensation.max_correction_um in the job)",
    ),
    "correction too steep": Case(
        job("[output]", "[compensation]\nmax_slope_um_per_mm = 1\n\n[output]"), "touches.csv", Code.CMP_SLOPE,
        "the correction of 'dome' reaches", "(override: compensation.max_slope_um_per_mm in the job)",
    ),
    "touches too old": Case(
        job(GAUGING, f"{GAUGING}\nmeasured_at = 1998-02-02T10:00:00"), "job.toml", Code.CMP_AGE,
        "h ago (1998-02-02T10:00", "(override: compensation.max_age_hours in the job)",
    ),
    "touches of another program": Case(
        job(GAUGING, f'{GAUGING}\nprogram_sha256 = "{"0" * 64}"'), "finish.nc", Code.CMP_OTHER_PROGRAM,
        "the touches belong to the program with sha256 0000000000000000…", "gauging.program_sha256",
    ),
    "program mistyped": Case(
        job('finish = "finish.nc"', 'finish = "finnish.nc"'), "finnish.nc", Code.NC_FILE,
        "there is no file", "finish.nc'?",
    ),
    "touches mistyped": Case(
        job(GAUGING, 'touches = "touchs.csv"'), "touchs.csv", Code.TCH_FILE, "there is no file", "touches.csv'?",
    ),
    "unknown dialect": Case(
        job('"ge2000t"', '"fanuc"'), "job.toml", Code.NC_DIALECT, "unknown NC dialect 'fanuc'", "ge2000t, linuxcnc",
    ),
    "option mistyped": Case(
        job("[output]", "[compensation]\nwieght = 0.5\n\n[output]"), "job.toml:34", Code.JOB_KEY,
        "'compensation.wieght' is no key of this file", "did you mean 'weight'?",
    ),
    "profile with a gap": Case(
        job("[0.0, 0.0], centre = [0.0, -1.46]", "[0.0, 0.0], centre = [0.0, -1.40]"), "job.toml", Code.GEO_ARC,
        "'dome', radius", "circle",
    ),
}  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the MODBAS2 job."""
    return Path(shutil.copytree(EXAMPLES / "modbas2", tmp_path / "parts" / "modbas2"))


def _snapshot(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def _run(folder: Path, *arguments: str) -> Result:
    return invoke("compensate", folder / "job.toml", *arguments)


def test_the_job_without_a_mistake_is_accepted(folder: Path) -> None:
    result = _run(folder)
    assert result.exit_code == ExitStatus.DONE, result.stderr
    assert len(list((folder.parents[1] / "out" / "modbas2").iterdir())) == 6


@pytest.mark.parametrize("name", CASES)
def test_it_is_refused_with_code_place_and_hint_and_nothing_is_written(folder: Path, name: str) -> None:
    case = CASES[name]
    case.mutate(folder)
    before = _snapshot(folder.parents[1])
    result = _run(folder)
    place = f"{folder / case.place}: " if case.place else ""
    first, hint = result.stderr.splitlines()
    assert first.startswith(f"{place}{case.code}: "), first
    assert case.says in first
    assert hint.startswith("  hint: ")
    assert case.hint in hint
    assert result.exit_code == ExitStatus.REFUSED
    assert result.stdout == ""
    assert _snapshot(folder.parents[1]) == before
    assert not (folder.parents[1] / "out").exists()


def test_unknown_words_are_let_through_when_the_job_says_so(folder: Path) -> None:
    rewrite("finish.nc", "N0390 G01 X", "N0390 G01 V7 X")(folder)
    job('dialect = "ge2000t"', 'dialect = "ge2000t"\naccept_unknown_words = true')(folder)
    assert _run(folder).exit_code == ExitStatus.DONE
    assert b"G01 V7 X(P46" in (folder.parents[1] / "out" / "modbas2" / "corrected.nc").read_bytes()


def test_refusals_are_json_for_machines(folder: Path) -> None:
    cell(20, "error_um", "NaN")(folder)
    result = _run(folder, "--json")
    error = json.loads(result.stderr)["error"]
    assert (error["code"], error["place"]["line"], error["place"]["column"]) == ("TCH-NUMBER", 23, 5)
    assert (result.exit_code, result.stdout) == (ExitStatus.REFUSED, "")


@pytest.mark.parametrize("output", ["finish.nc", "finish.nc/deeper", "/proc/trueloop"])
def test_a_folder_that_cannot_be_written_is_refused(folder: Path, output: str) -> None:
    """A file in the folder's place, and a folder that not even root may make."""
    before = _snapshot(folder.parents[1])
    result = _run(folder, "--output", str(folder / output))
    assert result.exit_code == ExitStatus.OUTPUT
    assert result.stderr.startswith(f"{folder / output}: OUT-FOLDER: nothing was written to ")
    assert "bytes were needed" in result.stderr
    assert "--output" in result.stderr.splitlines()[1]
    assert _snapshot(folder.parents[1]) == before


def test_a_full_disk_is_refused_and_leaves_the_results_before(folder: Path) -> None:
    """The system refuses to let a file grow: to the command that is a disk without room."""
    output = folder.parents[1] / "results"
    output.mkdir()
    (output / "corrected.nc").write_bytes(b"the one before")
    before = _snapshot(folder.parents[1])
    run = subprocess.run(
        [Path(sys.executable).with_name("trueloop"), "compensate", folder / "job.toml", "--output", output],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000)),
    )
    assert run.returncode == ExitStatus.OUTPUT
    assert run.stderr.startswith(f"{output}: OUT-FOLDER: nothing was written to {str(output)!r}: File too large; ")
    assert run.stdout == ""
    assert _snapshot(folder.parents[1]) == before


def test_results_never_overwrite_an_input(folder: Path) -> None:
    """A program that is called as one of the results, and the results put beside it."""
    (folder / "finish.nc").rename(folder / "corrected.nc")
    job('finish = "finish.nc"', 'finish = "corrected.nc"')(folder)
    before = _snapshot(folder.parents[1])
    result = _run(folder, "-o", str(folder))
    assert result.exit_code == ExitStatus.OUTPUT
    assert result.stderr.startswith(f"{folder / 'corrected.nc'}: OUT-INPUT: 'corrected.nc' would overwrite the input ")
    assert _snapshot(folder.parents[1]) == before


def test_a_mistyped_job_is_answered_with_the_nearest(folder: Path) -> None:
    result = invoke("compensate", folder / "jop.toml")
    assert result.exit_code == ExitStatus.REFUSED
    assert f"JOB-MISSING: there is no file {str(folder / 'jop.toml')!r}" in result.stderr
    assert f"did you mean {str(folder / 'job.toml')!r}?" in result.stderr
