"""What a LinuxCNC of this computer is busy with, by the Python module that it brings."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from trueloop.controllers.links.link import Busy
from trueloop.controllers.linuxcnc.cell.task import Task
from trueloop.errors import Code, TrueloopError

BY_HAND = "what is typed or done by hand"


def linuxcnc_busy(ini: Path, module: Callable[[], Any]) -> Callable[[], Busy | None]:
    """Asks the LinuxCNC of that configuration; `module` loads its `linuxcnc`. One that does not run does nothing.

    A program that is loaded and not begun counts: LinuxCNC has opened the file, and the next start cuts what it was
    then (LinuxCNC issue 2490). None: it comes up or goes just now, and does not say. The call raises CTL-LINUXCNC for a
    configuration that cannot be read.
    """

    def busy() -> Busy | None:
        nc = module()
        try:
            program = nc.ini(str(ini)).find("TASK", "TASK") or "milltask"
        except nc.error as error:
            raise TrueloopError(
                Code.CTL_LINUXCNC,
                f"LinuxCNC's configuration {str(ini)!r} cannot be read: {error}",
                hint="name it as `ini` in the settings of the link",
            ) from error
        if Task(ini, Path(program).name).pid() is None:
            return Busy()
        try:
            status = nc.stat()
            status.poll()
        except (nc.error, SystemError):  # the second where HOME is another's than LinuxCNC's: its tools are there
            return None
        return _busy(status, nc)

    return busy


def _busy(status: Any, nc: Any) -> Busy:
    loaded = (status.file,) if status.file else ()
    idle = status.interp_state == nc.INTERP_IDLE and status.exec_state in (nc.EXEC_DONE, nc.EXEC_ERROR)
    if idle and status.inpos and not status.paused:
        return Busy(loaded=loaded)
    by_hand = () if status.task_mode == nc.MODE_AUTO else (BY_HAND,)
    return Busy(by_hand or loaded, loaded)
