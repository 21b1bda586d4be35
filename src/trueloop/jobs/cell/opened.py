"""Settings, key, service and journal of a cell: `opened`."""

import stat
from dataclasses import dataclass
from pathlib import Path

from trueloop.controllers.linuxcnc.cell.client import Pace
from trueloop.controllers.linuxcnc.cell.decide import Patience
from trueloop.controllers.linuxcnc.cell.service import Service
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
        raise TrueloopError(
            Code.CEL_FILE,
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
    return TrueloopError(Code.CEL_FILE, why, hint=hint)
