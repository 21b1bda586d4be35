"""Which program runs, on files that are changed and replaced as users do."""

import hashlib
import os
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.support.signals import until
from trueloop.controllers.linuxcnc.realtime.signals.component import Interpreter, ProgramThread, ProgramWatch, Running

OURS, OTHER, NONE = Running.OURS, Running.OTHER, Running.NONE
CONTENT = b"G21 G18\nG1 X10 F100\nM2\n"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "part.ngc"
    path.write_bytes(CONTENT)
    return path


def watching(content: bytes = CONTENT, processes: Path | None = None) -> ProgramWatch:
    return ProgramWatch(hashlib.sha256(content).hexdigest(), Interpreter(processes or Path("/proc")))


def running(
    watch: ProgramWatch,
    file: object,
    *,
    automatic: bool = True,
    idle: bool = False,
    call_level: int = 0,
    queued: int = 0,
) -> Running:
    return watch.running(str(file), automatic=automatic, idle=idle, call_level=call_level, queued=queued)


def test_ours_another_and_none(file: Path) -> None:
    assert running(watching(), file) is OURS
    assert running(watching(CONTENT + b"\n"), file) is OTHER
    assert running(watching(), file, automatic=False) is NONE
    assert running(watching(), file, idle=True) is NONE
    assert running(watching(), "") is NONE
    assert running(watching(), file.with_name("gone.ngc")) is OTHER
    assert running(ProgramWatch(""), file) is OTHER


def test_a_file_is_read_again_when_it_changes_between_runs(file: Path) -> None:
    watch = watching()
    assert running(watch, file) is OURS
    file.write_bytes(CONTENT + b"(changed)\n")
    running(watch, file, idle=True)
    assert running(watch, file) is OTHER
    file.write_bytes(CONTENT)
    running(watch, file, idle=True)
    assert running(watch, file) is OURS


def test_a_file_that_changes_while_it_runs_is_another(file: Path) -> None:
    watch = watching()
    assert running(watch, file) is OURS
    os.utime(file, ns=(1, 1))
    assert running(watch, file) is OTHER
    file.write_bytes(CONTENT)
    assert running(watch, file) is OTHER
    running(watch, file, idle=True)
    assert running(watch, file) is OURS


def test_a_subprogram_is_none_until_its_last_motion_is_done(file: Path) -> None:
    """The interpreter is back in the program while the subprogram's moves are still queued."""
    watch = watching()
    assert running(watch, file) is OURS
    assert running(watch, file, call_level=1, queued=5) is NONE
    assert running(watch, file, call_level=0, queued=5) is NONE
    assert running(watch, file, call_level=0, queued=0) is OURS
    assert running(watch, file, call_level=0, queued=5) is OURS


def processes_with(folder: Path, opened: Path, name: str = "milltask") -> Path:
    """A folder as /proc is, one process in it that has a file open."""
    (folder / "4711" / "fd").mkdir(parents=True)
    (folder / "4711" / "comm").write_text(f"{name}\n")
    (folder / "4711" / "fd" / "7").symlink_to(opened)
    (folder / "self").mkdir()
    return folder


def test_what_the_interpreter_has_open_is_what_runs(tmp_path: Path, file: Path) -> None:
    held = tmp_path / f"{file.name} (deleted)"
    held.write_bytes(CONTENT)
    processes = processes_with(tmp_path / "proc", held)
    file.write_bytes(b"M2\n")
    assert running(watching(processes=processes), file) is OURS
    assert running(watching(b"M2\n", processes=processes), file) is OTHER


@pytest.mark.parametrize("name", ["axis", "milltask"])
def test_other_processes_and_other_files_are_left_alone(tmp_path: Path, file: Path, name: str) -> None:
    other = tmp_path / "other.ngc"
    other.write_bytes(b"M2\n")
    opened = file if name == "axis" else other
    processes = processes_with(tmp_path / "proc", opened, name)
    assert Interpreter(processes).loaded(str(file)) == file


class FakeError(Exception):
    """LinuxCNC's module has one of its own."""


class FakeLinuxcnc:
    """LinuxCNC's Python module, as far as it is used: what its status says next, or an exception."""

    MODE_AUTO, INTERP_IDLE, error = 2, 1, FakeError

    def __init__(self, file: Path) -> None:
        self.next: Exception | None = None
        self.status = SimpleNamespace(
            file=str(file), task_mode=2, interp_state=3, call_level=0, queue=0, poll=self._poll
        )

    def stat(self) -> SimpleNamespace:
        return self.status

    def _poll(self) -> None:
        if self.next is not None:
            raise self.next


def test_no_program_runs_while_linuxcnc_does_not_answer(file: Path) -> None:
    fake, stop, said = FakeLinuxcnc(file), threading.Event(), list[str]()
    thread = ProgramThread(fake, watching(), stop, said.append)
    thread.start()
    until(lambda: thread.running is OURS)
    fake.next = FakeError()
    until(lambda: thread.running is NONE)
    fake.next = None
    until(lambda: thread.running is OURS)
    assert thread.healthy(thread.asked_s)
    fake.next = RuntimeError("unforeseen")
    until(lambda: not thread.is_alive())
    assert thread.running is NONE
    assert "unforeseen" in said[0]
    assert not thread.healthy(thread.asked_s)
    stop.set()
