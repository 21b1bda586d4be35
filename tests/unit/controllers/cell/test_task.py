"""The process that runs LinuxCNC's programs is found by its configuration, and seen to be gone."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

from trueloop.controllers.linuxcnc.cell.linuxcnc import Task, Temperature, read_pins


def _process(folder: Path, number: int, *words: str) -> None:
    (folder / str(number)).mkdir(exist_ok=True)
    (folder / str(number) / "cmdline").write_bytes(b"".join(word.encode() + b"\0" for word in words))


def test_only_the_task_of_its_own_configuration_counts(tmp_path: Path) -> None:
    ini = tmp_path / "lathe.ini"
    _process(tmp_path, 10, "io", "-ini", str(ini))
    _process(tmp_path, 11, "milltask", "-ini", str(tmp_path / "mill.ini"))
    _process(tmp_path, 12)
    assert Task(ini, "milltask", tmp_path).pid() is None
    _process(tmp_path, 13, "/usr/bin/milltask", "-ini", str(ini))
    assert Task(ini, "milltask", tmp_path).pid() == 13


def test_one_that_ended_is_not_believed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ini = tmp_path / "lathe.ini"
    _process(tmp_path, 13, "milltask", "-ini", str(ini))
    task = Task(ini, "milltask", tmp_path)
    assert task.pid() == 13
    _process(tmp_path, 13, "bash")  # its number is another's now
    assert task.pid() is None
    _process(tmp_path, 14, "milltask", "-ini", str(ini))
    later = time.monotonic() + 60
    monkeypatch.setattr(time, "monotonic", lambda: later)
    assert task.pid() == 14


def test_a_killed_process_of_this_computer_is_gone_at_once(tmp_path: Path) -> None:
    ini = tmp_path / "lathe.ini"
    name = Path(sys.executable).name
    program = "import time; print('runs', flush=True); time.sleep(60)"
    with subprocess.Popen([sys.executable, "-c", program, "-ini", str(ini)], stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        child.stdout.readline()  # its command line stands in /proc only some time after it was started
        task = Task(ini, name)
        assert task.pid() == child.pid
        child.kill()
        child.wait()
        assert task.pid() is None


@pytest.mark.parametrize("said", ["nan", "TRUE", "", "inf"])
def test_what_is_no_temperature_is_not_told(tmp_path: Path, said: str) -> None:
    program = tmp_path / "halcmd"
    program.write_text(f'#!/bin/sh\n[ "$2" = good ] && echo 20.5 || echo "{said}"\n')
    program.chmod(0o755)
    found, wrong = read_pins({"spindle": "good", "bed": "bad"}, {}, str(program))
    assert found == {"spindle": Temperature(20.5)}
    assert len(wrong) == 1 and "bed" in wrong[0] and "bad" in wrong[0]
    assert len(read_pins({"spindle": "good"}, {}, str(tmp_path / "none"))[1]) == 1


def test_a_value_is_as_old_as_its_pin_says_and_one_that_never_came_is_none(tmp_path: Path) -> None:
    """A pin keeps the last value of a sensor that is silent; `rtec-signals` gives 1e6 s for one that never came."""
    program = tmp_path / "halcmd"
    program.write_text('#!/bin/sh\ncase "$2" in value) echo 20.5;; old) echo 700;; never) echo 1e6;; esac\n')
    program.chmod(0o755)
    ages = {"spindle": "old", "bed": "never"}
    found, wrong = read_pins({"spindle": "value", "bed": "value", "air": "value"}, ages, str(program))
    assert found == {"spindle": Temperature(20.5, 700.0), "air": Temperature(20.5)}
    assert len(wrong) == 1 and "bed" in wrong[0] and "1e+06 s old" in wrong[0]
