"""The cell at work: `run`."""

import stat
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from trueloop.controllers.linuxcnc.cell.client import Client, Pace, Service
from trueloop.controllers.linuxcnc.cell.decide import Patience
from trueloop.controllers.linuxcnc.cell.journal import Journal
from trueloop.controllers.linuxcnc.cell.linuxcnc import LinuxCnc, Temperature, read_pins
from trueloop.controllers.linuxcnc.realtime.signals.component import linuxcnc_module
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.cell_toml import CellFile, read_cell


@dataclass(frozen=True)
class Cell:
    """A cell's settings, and the service that they name. `beside`: the folder that names in them count from."""

    settings: CellFile
    beside: Path
    service: Service

    @property
    def journal(self) -> Path:
        """Returns the path of the journal."""
        return self.beside / self.settings.cell.journal

    @property
    def ini(self) -> Path:
        """Returns the path of LinuxCNC's configuration."""
        return self.beside / self.settings.linuxcnc.ini

    @property
    def programs(self) -> Path:
        """Returns the folder of programs."""
        return self.beside / self.settings.linuxcnc.programs

    @property
    def pace(self) -> Pace:
        """Returns how long the cell waits, from its settings."""
        table = self.settings.linuxcnc
        return Pace(patience=Patience(table.settled_s, table.start_s, table.away_s))


def opened(path: Path) -> Cell:
    """Opens a cell; connects to nothing yet. Raises CEL-FILE for unusable settings, keys or certificates."""
    found = read_cell(path)
    table, beside = found.model.cell, path.parent
    with found.at("cell", "key"):
        key = _key(beside / table.key)
    certificates = str(beside / table.certificates) if table.certificates else None
    try:
        return Cell(found.model, beside, Service(table.service, key, certificates))
    except OSError as error:  # ssl's errors are such
        raise Code.CEL_FILE.refusal(
            f"certificates {certificates!r}: {error}",
            hint="name a PEM file with the certificate of the authority",
            place=Place(str(path)),
        ) from error


def _key(file: Path) -> str:
    """Raises CEL-FILE also where others than its owner may read it: a key opens the machine."""
    try:
        mode, key = file.stat().st_mode, file.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise _refused(
            f"the key cannot be read from {file}: {error}", "write there what `trueloop key add` printed"
        ) from error
    if mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise _refused(f"the key in {file} may be read by others: mode {stat.S_IMODE(mode):o}", f"chmod 600 {file}")
    if not key or len(key.split()) != 1:
        raise _refused(
            f"{file} holds {len(key.split())} words, a key is 1", "write there what `trueloop key add` printed"
        )
    return key


def _refused(why: str, hint: str) -> TrueloopError:
    return Code.CEL_FILE.refusal(why, hint=hint)


Tell = Callable[[str], None]


def run(cell: Cell, stop: threading.Event, tell: Tell) -> None:
    """Works until `stop` is set; what the machine does goes on. `tell` gets what it waits for, as it changes.

    Raises CEL-JOURNAL, CTL-LINUXCNC and RTC-CONNECTION where it cannot begin, or must not go on.
    """
    control = LinuxCnc(cell.ini, cell.programs, linuxcnc_module("linuxcnc"))
    with _journal(cell.journal, tell) as journal:
        client = Client(cell.settings.cell.machine, control, cell.service, journal, cell.pace)
        tell(f"cell of {cell.settings.cell.machine!r}, {len(journal.entries)} entries in its journal")
        temperatures, said = _Temperatures(cell, client, tell), ""
        while not stop.is_set():
            moved = client.step()
            temperatures.step()
            now = _words(client)
            if now != said:
                tell(now)
                said = now
            if not moved:
                stop.wait(cell.pace.look_s)


def _words(client: Client) -> str:
    run = f"{client.known.run.key}: " if client.known.run else ""
    fault = f" [{client.fault}]" if client.fault else ""
    return f"{run}{client.said or 'asks for work'}{fault}"


class _Temperatures:
    """Read in a thread of their own: a pin that hangs holds nothing up."""

    def __init__(self, cell: Cell, client: Client, tell: Tell) -> None:
        self._cell, self._client, self._tell = cell, client, tell
        self._next_s = 0.0
        self._reading: threading.Thread | None = None
        self._found: dict[str, Temperature] = {}
        self._read_at_s = 0.0
        self._wrong: list[str] = []

    def step(self) -> None:
        """Tells what was read, and begins to read again when it is time."""
        table = self._cell.settings.temperatures
        if self._reading is not None and self._reading.is_alive():
            return
        if self._reading is not None:
            self._reading = None
            for age_s in sorted({temperature.age_s for temperature in self._found.values()}):
                of_it = {
                    name: temperature.celsius for name, temperature in self._found.items() if temperature.age_s == age_s
                }
                self._client.temperatures(of_it, age_s + time.monotonic() - self._read_at_s)
        if table.pins and time.monotonic() >= self._next_s:
            self._next_s = time.monotonic() + table.every_s
            self._reading = threading.Thread(target=self._read, daemon=True)
            self._reading.start()

    def _read(self) -> None:
        table = self._cell.settings.temperatures
        self._read_at_s = time.monotonic()
        self._found, wrong = read_pins(table.pins, table.ages)
        for one in wrong:
            if one not in self._wrong:
                self._tell(f"temperature {one}")
        self._wrong = wrong


@contextmanager
def _journal(file: Path, tell: Tell) -> Iterator[Journal]:
    journal = Journal(file)
    if journal.torn:
        tell(f"{len(journal.torn)} bytes of a last line were left by a crash: it was not acted on")
    try:
        yield journal
    finally:
        journal.close()
