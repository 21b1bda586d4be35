"""The process that runs programs in LinuxCNC: `Task` finds it, and sees when it has ended or is another one.

LinuxCNC's status stays in shared memory, unchanged, when that process was killed: it says nothing of it.
"""

import time
from pathlib import Path
from typing import Final

LOOK_S: Final = 1.0
"""How often all processes are looked at, while it is not there."""


class Task:
    """The task of one configuration: LinuxCNC gives it `-ini FILE`."""

    def __init__(self, ini: Path, program: str, processes: Path = Path("/proc")) -> None:
        """`program`: [TASK] TASK of the configuration."""
        self._ini, self._program, self._processes = ini.resolve(), program, processes
        self._pid: int | None = None
        self._next_look = 0.0

    def pid(self) -> int | None:
        """Its number now; None: it does not run."""
        if self._pid is not None and not self._is(self._pid):
            self._pid = None
        if self._pid is None and time.monotonic() >= self._next_look:
            self._next_look = time.monotonic() + LOOK_S
            numbers = (int(one.name) for one in self._processes.iterdir() if one.name.isdecimal())
            self._pid = next((number for number in numbers if self._is(number)), None)
        return self._pid

    def _is(self, number: int) -> bool:
        try:
            name, *given = (self._processes / str(number) / "cmdline").read_bytes().split(b"\0")
        except OSError:
            return False
        if Path(name.decode(errors="replace")).name != self._program or b"-ini" not in given[:-1]:
            return False
        return Path(given[given.index(b"-ini") + 1].decode(errors="replace")) == self._ini
