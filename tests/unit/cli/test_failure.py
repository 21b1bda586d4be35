"""Whatever happens, a user sees a message and the shell a documented status; never a traceback."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner, Result

from trueloop.cli.terminal import TRACEBACK_VARIABLE, AsJson, ExitStatus, guarded
from trueloop.errors import Code, Place, TrueloopError

TRUELOOP = str(Path(sys.executable).with_name("trueloop"))


def _refuse() -> None:
    raise TrueloopError(
        Code.CMP_SIZE,
        "the correction of 'dome [left]' reaches 200.0 µm",
        hint="look at the touches first",
        place=Place("job.toml", 4, 7),
        override="compensation.max_correction_um in the job",
        values={"size_um": 200.0, "limit_um": float("inf")},
    )


def _refuse_output() -> None:
    raise TrueloopError(Code.OUT_FOLDER, "nothing was written", hint="another folder")


def _break() -> None:
    os.environ["MISSING"]


def _interrupt() -> None:
    raise KeyboardInterrupt


def _usage() -> None:
    raise typer.BadParameter("no such thing")


def _run(body: Callable[[], None], *arguments: str) -> Result:
    app = typer.Typer(pretty_exceptions_enable=False)

    @app.command()
    @guarded
    def command(as_json: AsJson = False) -> None:
        body()

    return CliRunner().invoke(app, arguments)


@pytest.mark.parametrize(
    "body, status",
    [
        (lambda: None, ExitStatus.DONE),
        (_refuse, ExitStatus.REFUSED),
        (_refuse_output, ExitStatus.OUTPUT),
        (_break, ExitStatus.INTERNAL),
        (_interrupt, ExitStatus.INTERRUPTED),
        (_usage, ExitStatus.USAGE),
    ],
)
@pytest.mark.parametrize("arguments", [(), ("--json",)])
def test_every_end_has_its_status_and_leaves_stdout_alone(
    body: Callable[[], None], status: ExitStatus, arguments: tuple[str, ...]
) -> None:
    result = _run(body, *arguments)
    assert result.exit_code == status
    assert result.stdout == ""
    assert "Traceback" not in result.stderr


def test_a_refusal_reads_place_code_message_hint_override() -> None:
    assert _run(_refuse).stderr == (
        "job.toml:4:7: CMP-SIZE: the correction of 'dome [left]' reaches 200.0 µm\n"
        "  hint: look at the touches first (override: compensation.max_correction_um in the job)\n"
    )


def test_a_refusal_as_json_on_stderr() -> None:
    assert json.loads(_run(_refuse, "--json").stderr) == {
        "error": {
            "code": "CMP-SIZE",
            "message": "the correction of 'dome [left]' reaches 200.0 µm",
            "hint": "look at the touches first",
            "place": {"file": "job.toml", "line": 4, "column": 7},
            "override": "compensation.max_correction_um in the job",
            "values": {"size_um": 200.0, "limit_um": None},
        }
    }


def test_a_refusal_is_coloured_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    stderr = _run(_refuse).stderr
    assert "\x1b[1;31mCMP-SIZE\x1b[0m" in stderr


def test_an_internal_error_says_how_to_see_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TRACEBACK_VARIABLE, raising=False)
    stderr = _run(_break).stderr
    assert stderr.startswith("INTERNAL: KeyError: 'MISSING'\n  hint: ")
    assert "TRUELOOP_TRACEBACK=1" in stderr
    monkeypatch.setenv(TRACEBACK_VARIABLE, "1")
    result = _run(_break)
    assert result.stderr.startswith("Traceback (most recent call last):")
    assert "in _break" in result.stderr
    assert result.exit_code == ExitStatus.INTERNAL


def test_an_internal_error_as_json() -> None:
    assert json.loads(_run(_break, "--json").stderr)["error"]["code"] == "INTERNAL"


def test_ctrl_c_ends_a_running_command_with_130_and_no_traceback(tmp_path: Path) -> None:
    """The program comes through a pipe that nobody writes to, so that the command is sure to be waiting."""
    pipe = tmp_path / "finish.nc"
    os.mkfifo(pipe)
    command = [TRUELOOP, "nc", "path", str(pipe), "--dialect", "linuxcnc"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        writer = _open_once_read(pipe)
        run.send_signal(signal.SIGINT)
        stdout, stderr = run.communicate(timeout=60)
        os.close(writer)
    assert run.returncode == ExitStatus.INTERRUPTED
    assert (stdout, stderr) == ("", "")


def _open_once_read(pipe: Path) -> int:
    """Opens the pipe for writing as soon as the other side has it open for reading."""
    for _ in range(600):
        try:
            return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
        except OSError:
            time.sleep(0.1)
    raise AssertionError("the command never opened the program")


def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    """`trueloop nc path … | head -1` on a path longer than any pipe buffer."""
    program = tmp_path / "long.ngc"
    program.write_text("G21 G90\n" + "".join(f"G1 X{k} Z{k} F0.1\n" for k in range(20_000)) + "M2\n")
    command = [TRUELOOP, "nc", "path", str(program), "--dialect", "linuxcnc"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None and run.stderr is not None
        assert run.stdout.readline().startswith("line,column")
        run.stdout.close()
        stderr = run.stderr.read()
        assert run.wait(timeout=60) == ExitStatus.PIPE
    assert stderr == ""


def _status_without_a_reader(*arguments: str) -> int:
    """What the command ends with when nobody reads its stdout any more."""
    read, write = os.pipe()
    os.close(read)
    try:
        return subprocess.run([TRUELOOP, *arguments], stdout=write, stderr=subprocess.PIPE, check=False).returncode
    finally:
        os.close(write)


@pytest.mark.parametrize(
    "arguments",
    [
        ("compensate", "examples/facetst/job.toml", "-o", "{}"),
        ("compensate", "examples/facetst/job.toml", "-o", "{}", "--json"),
        ("part", "show", "examples/facetst/job.toml"),
        ("nc", "path", "examples/linuxcnc/finish.ngc", "--format", "csv"),
        ("--help",),
        ("nc", "--help"),
        ("--version",),
    ],
    ids=" ".join,
)
def test_a_closed_pipe_ends_a_command_as_it_ends_other_tools(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    root = Path(__file__).parents[3]
    given = [str(root / a) if a.startswith("examples") else a.format(tmp_path / "out") for a in arguments]
    assert _status_without_a_reader(*given) == ExitStatus.PIPE
