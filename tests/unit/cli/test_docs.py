"""docs/cli.md and `--help` say the same commands, options and exit statuses."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from trueloop.cli.main import app
from trueloop.cli.terminal import ExitStatus

DOCUMENT = (Path(__file__).parents[3] / "docs" / "cli.md").read_text(encoding="utf-8")
COMMANDS = (
    "new",
    "compensate",
    "demo",
    "examples",
    "part show",
    "part from-program",
    "part from-dxf",
    "part from-step",
    "nc path",
    "nc check",
    "nc diff",
    "nc features",
    "nc map",
    "probe plan",
    "probe program",
    "probe read",
    "probe trials",
    "probe calibrate",
    "measure map",
    "measure convert",
    "measure next",
    "measure plan",
    "measure read",
    "measure sheet",
    "offsets read",
    "offsets apply",
    "offsets program",
    "link list",
    "link get",
    "link put",
    "link compare",
    "link offsets",
    "mtconnect devices",
    "mtconnect serve",
    "mtconnect read",
    "tool mount",
    "tool turn",
    "tool set",
    "tool wear",
    "tool remove",
    "tool show",
    "tool list",
    "mill entries",
    "mill new",
    "mill probe",
    "series add",
    "series status",
    "series propose",
    "series accept",
    "series reject",
    "series replay",
    "series simulate",
    "monitor chart",
    "monitor certify",
    "monitor gauge",
    "record show",
    "db init",
    "db import",
    "db find",
    "db show",
    "db export",
    "db check",
    "db replace",
    "db backup",
    "db restore",
    "serve",
    "user add",
    "user list",
    "user disable",
    "user link",
    "user role",
    "user password",
    "key add",
    "key list",
    "key end",
    "cell run",
    "cell status",
    "cell arm",
    "explain",
    "docs",
    "simulate",
    "linuxcnc loop",
    "machine fit",
    "machine show",
    "machine check",
    "machine compensate",
    "machine export",
    "machine positioning",
    "machine circular",
    "machine drift",
    "machine drift-fit",
    "machine drift-predict",
    "machine add-drift",
    "machine plates",
    "machine points",
    "machine decompose",
    "machine accept",
    "diagnose part",
    "diagnose series",
    "diagnose fixture",
    "diagnose machine",
    "diagnose refine",
    "diagnose standard",
    "surface deviations",
    "surface model",
    "surface pattern",
    "surface compensate",
    "surface add",
    "surface simulate",
    "surface sampling",
    "surface compare",
    "surface path",
    "realtime image",
    "realtime install",
    "realtime hal",
    "realtime show",
    "realtime signals",
    "realtime watch",
    "realtime check",
    "realtime demo",
)
HELP = {"--help", "-h"}


def _section(title: str) -> str:
    found = re.search(rf"^### `trueloop {re.escape(title)}[ `].*?(?=^##)", DOCUMENT, re.M | re.S)
    assert found, f"docs/cli.md has no section for {title}"
    return found[0]


def _help(*command: str) -> str:
    result = CliRunner().invoke(app, [*command, "--help"], env={"TERMINAL_WIDTH": "200"})
    assert result.exit_code == 0
    return result.stdout


def test_every_command_has_a_section_and_every_section_a_command() -> None:
    rooms = (
        "part |nc |probe |measure |link |mtconnect |linuxcnc |machine |surface |mill |record |offsets |tool |series |"
        "monitor |diagnose |db |user |key |cell |realtime "
    )
    sections = re.findall(rf"^### `trueloop ((?:{rooms})?[a-z-]+)", DOCUMENT, re.M)
    assert sorted(sections) == sorted(COMMANDS)
    groups: dict[str, list[str]] = {command.rpartition(" ")[0]: [] for command in COMMANDS}
    for command in COMMANDS:
        group, _, name = command.rpartition(" ")
        groups[group].append(name)
    for group, names in groups.items():
        listed = re.findall(r"^  ([a-z-]+)  ", _help(*group.split()).split("Commands:")[1], re.M)
        assert sorted(set(listed) - (set() if group else set(groups))) == sorted(names)


@pytest.mark.parametrize("command", COMMANDS)
def test_options_are_those_of_help(command: str) -> None:
    in_help = set(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", _help(*command.split()).split("Options:")[1])) - HELP
    rows = re.findall(r"^\| (`-.*?) \|", _section(command), re.M)
    in_document = {option for row in rows for option in re.findall(r"`(-[a-z-]+)`", row)}
    assert in_document == in_help


def test_exit_statuses_are_those_of_the_code() -> None:
    in_document = [int(status) for status in re.findall(r"^\| (\d+) \|", DOCUMENT, re.M)]
    assert in_document == [status.value for status in ExitStatus]


GROUPS = ("part", "nc", "probe", "measure", "linuxcnc", "tool", "record", "db")
HELP_OF_ALL = """
import contextlib, io, json, sys
from trueloop.cli.main import app
heavy = {"numpy", "scipy", "rich", "ezdxf", "plotly", "trueloop._core"}
found = {}
for command in sys.argv[1:]:
    with contextlib.redirect_stdout(io.StringIO()) as help:
        try:
            app([*command.split(), "--help"])
        except SystemExit as end:
            found[command] = [end.code or 0, "Usage:" in help.getvalue(), sorted(heavy & set(sys.modules))]
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def helped() -> dict[str, object]:
    """Of every command, one after the other in one process: exit status, whether help came, heavy modules by then."""
    commands = ("", *COMMANDS, *GROUPS)
    run = subprocess.run([sys.executable, "-c", HELP_OF_ALL, *commands], capture_output=True, text=True, check=True)
    found: dict[str, object] = json.loads(run.stdout)
    return found


@pytest.mark.parametrize("command", ["", *COMMANDS, *GROUPS])
def test_help_needs_nothing_heavy(helped: dict[str, object], command: str) -> None:
    """What takes time to import is imported when a command runs."""
    assert helped[command] == [0, True, []]


@pytest.mark.parametrize("group", ["", *sorted({command.split()[0] for command in COMMANDS if " " in command})])
def test_no_summary_is_cut_at_80_columns(group: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    commands = CliRunner().invoke(app, [*group.split(), "--help"]).stdout.partition("Commands:\n")[2].splitlines()
    assert commands and [line for line in commands if line.endswith("...")] == []


def test_the_version() -> None:
    import trueloop

    result = CliRunner().invoke(app, ["--version"])
    assert (result.exit_code, result.stdout) == (0, f"trueloop {trueloop.__version__}\n")


def test_without_arguments_the_help_is_shown() -> None:
    result = CliRunner().invoke(app, [])
    assert "Commands:" in result.output
    assert result.exit_code == ExitStatus.USAGE


def test_an_unknown_command_is_a_usage_error() -> None:
    result = CliRunner().invoke(app, ["compensat", "job.toml"])
    assert (result.exit_code, result.stdout) == (ExitStatus.USAGE, "")
    assert "'compensat'" in result.stderr and "'compensate'" in result.stderr
