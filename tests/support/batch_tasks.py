"""What the tests give to worker processes: apart, for each of these imports the module and all that it imports."""

import os
import signal
import time
from pathlib import Path

from trueloop.errors import Code, TrueloopError


def killed_once(task: tuple[int, str]) -> int:
    """Kills the process it runs in, the first time it is given task 3."""
    number, folder = task
    mark = Path(folder) / "killed"
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.02)
    return number * number


def squared(number: int) -> int:
    return number * number


def refused(number: int) -> int:
    raise TrueloopError(Code.SRF_POINTS, f"{number} points", hint="more")


def slowly(number: int) -> int:
    time.sleep(0.2)
    return number


def always_killed(number: int) -> int:
    if number == 5:
        time.sleep(2.0)  # those before it are told by then
        os.kill(os.getpid(), signal.SIGKILL)
    return number
