"""A command imports its own module, not those of the others: `trueloop` starts at once."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[3] / "examples"

LOADED = """
import json, sys
from trueloop.cli.main import app
try:
    app(sys.argv[1:])
except SystemExit:
    print(json.dumps([name for name in sys.modules if name.startswith("trueloop")]))
"""


def loaded(*words: str) -> set[str]:
    """The modules of trueloop that a process holds after a command."""
    run = subprocess.run([sys.executable, "-c", LOADED, *words], capture_output=True, text=True, check=True)
    return set(json.loads(run.stdout.splitlines()[-1]))


def test_the_version_imports_no_command() -> None:
    assert loaded("--version") == {"trueloop", "trueloop.cli", "trueloop.cli.main"}


def test_a_job_without_a_store_loads_no_store(tmp_path: Path) -> None:
    found = loaded("compensate", str(EXAMPLES / "modbas2" / "job.toml"), "-o", str(tmp_path / "made"))
    assert "trueloop.jobs.turned.compensate" in found
    assert not [name for name in found if name.startswith("trueloop.storage")] and len(found) < 330


def test_a_file_of_measurements_without_a_job_loads_none_of_jobs_and_machines(tmp_path: Path) -> None:
    file = tmp_path / "readings.csv"
    file.write_text("feature,z_mm,diameter_mm\nshaft,-10,20.012\n")
    found = loaded("measure", "read", str(file))
    others = ("trueloop.jobs.turned", "trueloop.loops", "trueloop.machine", "trueloop.storage", "trueloop.surface")
    assert "trueloop.jobs.measure.measured" in found and not [name for name in found if name.startswith(others)]
    assert len(found) < 140


@pytest.mark.parametrize(("command", "own"), [("tool", "trueloop.cli.tool"), ("explain", "trueloop.cli.help")])
def test_a_command_imports_none_of_the_others(command: str, own: str) -> None:
    others = {"trueloop.cli.machine", "trueloop.cli.series", "trueloop.cli.db", "trueloop.cli.surface"}
    found = loaded(command, "--help")
    assert own in found and not others & found


WITHOUT_POSIX = """
import importlib, pkgutil, sys
for name in ("fcntl", "grp", "pwd", "resource", "termios"):
    sys.modules[name] = None
import trueloop
under_another_python = ("read_status", "read_streams")
for module in pkgutil.walk_packages(trueloop.__path__, "trueloop."):
    if not module.name.endswith(under_another_python):
        importlib.import_module(module.name)
"""


def test_every_module_is_imported_where_the_system_is_windows() -> None:
    """Service and links to controls run there; what needs Linux is refused when it is called."""
    subprocess.run([sys.executable, "-c", WITHOUT_POSIX], capture_output=True, text=True, check=True)
