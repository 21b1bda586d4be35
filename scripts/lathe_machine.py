"""LinuxCNC as the machine of `cell_kills`: what was cut is seen by where the axes were, not by what anybody says.

Run as `python -m scripts.lathe_machine CONFIGURATION OUT` beside LinuxCNC it is that witness: X beyond 1 mm is a cut or
Z beyond 1 mm a touch; it is whole when it was at 2 mm and is back. It writes which file was loaded, and its text then.
"""

import json
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from scripts.running_lathe import RunningLathe, running_lathe
from trueloop.controllers.linuxcnc.cell.decide import ControlNow, Doing
from trueloop.controllers.linuxcnc.cell.journal import known, read
from trueloop.controllers.linuxcnc.cell.linuxcnc import LinuxCnc
from trueloop.controllers.linuxcnc.realtime.signals.component import linuxcnc_module
from trueloop.domain.factory import BlockKind

HOME_MM: Final = (300.0, 100.0)
PROBE_HAL: Final = b"""
loadrt comp count=1
addf comp.0 servo-thread
setp comp.0.in0 101.5
net z-actual joint.1.pos-fb => comp.0.in1
net probe comp.0.out => motion.probe-input
"""
SETTINGS: Final = """[cell]
machine = "lathe"
service = "{address}"
[linuxcnc]
ini = "{ini}"
programs = "{ini}-programs"
away_s = 1.5
start_s = 1.5
settled_s = 0.5
"""
_WAIT_S: Final = 20.0


class LatheMachine:
    """The lathe, its witness, and `trueloop cell run` beside it."""

    texts: Final = {
        BlockKind.SEMIFINISH: b"%\n(first cut)\nG21 G90 G94 G8 F300\nG1 X302.1\nG1 X300\nM30\n%\n",
        BlockKind.PROBE: (
            b"G21 G90 G94 G8\n(LOGOPEN,touches.txt)\nG38.2 Z103 F150\n(LOG,#5061 #5063)\nG1 Z100\n(LOGCLOSE)\nM2\n"
        ),
        BlockKind.FINISH: b"G21 G90 G94 G8\r\nG1 X302.09 F300 ; to the shoulder\r\nG1 X300\r\nM5\r\nM2\r\n",
    }
    longest_s: Final = 3600.0

    def __init__(self, folder: Path, lathe: RunningLathe) -> None:
        self.folder, self._lathe = folder, lathe
        self._witness: subprocess.Popen[str] | None = None

    def on(self) -> None:
        """Switches it on."""
        self._lathe.on()
        self.watched()

    def watched(self) -> None:
        """Begins the witness, and waits until it sees the machine."""
        panel = self.folder / "panel.json"
        panel.unlink(missing_ok=True)
        command = ("-m", "scripts.lathe_machine", str(self._lathe.ini), str(self.folder))
        self._witness = self._lathe.python(*command)
        until = time.monotonic() + _WAIT_S
        while not panel.exists():
            assert time.monotonic() < until, "the witness does not see LinuxCNC"
            time.sleep(0.02)

    def killed(self) -> None:
        """The power is gone; the witness writes what it has seen."""
        self._lathe.killed()
        if self._witness is not None:
            self._witness.send_signal(signal.SIGTERM)
            self._witness.wait(_WAIT_S)

    def shown(self) -> ControlNow:
        """As the witness sees it."""
        said = json.loads((self.folder / "panel.json").read_text())
        return ControlNow(Doing(said["doing"]), said["program"])

    def journal(self) -> Path:
        """The client's."""
        return self.folder / "cell.journal"

    def cell_killed(self, key: str, address: str, drawn: random.Random) -> None:
        """The real command, with its real pace."""
        with self._cell(key, address) as cell:
            time.sleep(drawn.uniform(0.5, 5.0))
            cell.kill()

    def settled(self, key: str, address: str) -> None:
        """Starts and ends clients until the journal holds nothing that is not delivered."""
        for _ in range(10):
            with self._cell(key, address) as cell:
                time.sleep(5.0)
                cell.terminate()
                assert cell.wait(_WAIT_S) == 0, "the cell did not end well"
            entries, _ = read(self.journal().read_bytes(), self.journal())
            if not known(entries).waiting:
                return

    @contextmanager
    def _cell(self, key: str, address: str) -> Iterator["subprocess.Popen[str]"]:
        secret, settings = self.folder / "cell.key", self.folder / "cell.toml"
        secret.touch(0o600)
        secret.write_text(key)
        settings.write_text(SETTINGS.format(address=address, ini=self._lathe.ini))
        program = "from trueloop.cli.main import main; main()"
        with (self.folder / "cell.log").open("a") as log:
            cell = self._lathe.python("-c", program, "cell", "run", "--settings", str(settings), stderr=log)
            try:
                yield cell
            finally:
                cell.kill()
                cell.wait(_WAIT_S)


@contextmanager
def lathe_machine(folder: Path) -> Iterator[LatheMachine]:
    """One that is on."""
    with running_lathe({"extra.hal": PROBE_HAL}) as lathe:
        machine = LatheMachine(folder, lathe)
        machine.watched()
        try:
            yield machine
        finally:
            machine.killed()


class _Witness:
    """Where the axes were, and with which program."""

    def __init__(self, control: LinuxCnc, folder: Path) -> None:
        self._control, self._folder = control, folder
        self._now: dict[str, Any] | None = None

    def look(self, x_mm: float, z_mm: float) -> None:
        """One position."""
        far_mm = max(abs(x_mm - HOME_MM[0]), abs(z_mm - HOME_MM[1]))
        if self._now is None and far_mm > 0.2:
            name = self._control.now().program
            text = self._control.read_back(name) or b""
            self._now = {
                "whole": False,
                "key": name.removesuffix(".ngc"),
                "text": text.decode("latin-1"),
                "touches": "",
            }
        elif self._now is not None and far_mm > 1.4:
            self._now["far"] = True
        elif self._now is not None and far_mm < 0.02 and self._now.get("far"):
            self.ended(whole=True)

    def ended(self, *, whole: bool) -> None:
        """Writes what it has seen."""
        if self._now is not None:
            self._now["whole"] = whole
            with (self._folder / "executed.jsonl").open("a") as file:
                file.write(json.dumps(self._now) + "\n")
            self._now = None


def main(ini: Path, folder: Path) -> None:
    """Watches until it is told to end."""
    ends: list[int] = []
    signal.signal(signal.SIGTERM, lambda *_: ends.append(1))
    module = linuxcnc_module("linuxcnc")
    control = LinuxCnc(ini, Path(f"{ini}-programs"), module)
    witness, status, panel = _Witness(control, folder), module.stat(), folder / "panel.json"
    while not ends:
        status.poll()
        witness.look(status.actual_position[0], status.actual_position[2])
        now = control.now()
        aside = folder / ".panel.json"
        aside.write_text(json.dumps({"doing": now.doing.value, "program": now.program}))
        aside.replace(panel)
        time.sleep(0.003)
    witness.ended(whole=False)


if __name__ == "__main__":
    with suppress(KeyboardInterrupt):
        main(Path(sys.argv[1]), Path(sys.argv[2]))
