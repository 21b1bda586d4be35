"""Settings of a machine's cell: a TOML file."""

import re
from pathlib import Path
from typing import Annotated, Final

from pydantic import AfterValidator, Field

from trueloop.errors import Code
from trueloop.formats.toml_tables import Located, Positive, Table, read_located

HINT: Final = "docs/cell.md shows every key"
Text = Annotated[str, Field(min_length=1)]


def _address(text: str) -> str:
    if re.fullmatch(r"https?://[^/@\s]+/?", text) is None:
        raise ValueError("must be an http(s) address without path, such as https://factory.shop.example")
    return text


class TemperaturesTable(Table):
    """Temperatures that are sent to the service."""

    every_s: Positive = 60.0
    """How often they are read."""
    pins: dict[str, Text] = Field(default_factory=dict)
    """By the name of the signal, the pin of LinuxCNC's hardware layer that has it, °C."""
    ages: dict[str, Text] = Field(default_factory=dict)
    """By the name of the signal, the pin that has its age, s, as `rtec-signals.age-0`; left out, it is of now."""


class CellTable(Table):
    """The cell and its service."""

    machine: Text
    """The machine's name in the store."""
    service: Annotated[str, AfterValidator(_address)]
    """The service's address."""
    key: Text = "cell.key"
    """A file with the key that `trueloop key add` printed; nobody else may read it."""
    certificates: str = ""
    """A PEM file of the authority that vouches for the service; left out, the system's are used."""
    journal: Text = "cell.journal"
    """The cell's facts, and those still to be sent. Never delete it while a run is in hand."""


class LinuxcncTable(Table):
    """Settings of the LinuxCNC at the machine."""

    ini: Text
    """LinuxCNC's configuration."""
    programs: Text = "cell-programs"
    """A folder for the programs that the cell loads; nothing else belongs there."""
    settled_s: Positive = 1.0
    """A control that stands still for so long has ended its program."""
    start_s: Positive = 10.0
    """A run that was sent to start, and was not seen to, is unknown after this."""
    away_s: Positive = 30.0
    """So long a LinuxCNC that has gone in mid-run is waited for."""


class CellFile(Table):
    """One machine's cell. Relative names count from the folder of this file."""

    cell: CellTable
    linuxcnc: LinuxcncTable
    temperatures: TemperaturesTable = TemperaturesTable()


def read_cell(path: Path) -> Located[CellFile]:
    """The settings. Raises CEL-FILE, with the line, for a key that is wrong."""
    return read_located(path, CellFile, Code.CEL_FILE, hint=HINT)
