"""`trueloop cell run` beside the lathe, and an operator who arms it there."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from scripts.factory_demo.lathe import TEMPERATURE_PIN
from scripts.factory_demo.office import COMMAND, MACHINE, trueloop
from scripts.running_lathe import RunningLathe

SETTINGS: Final = """\
[cell]
machine = "{machine}"
service = "{address}"

[linuxcnc]
ini = "{ini}"
programs = "{ini}-programs"

[temperatures]
every_s = 5
pins = {{ spindle = "{pin}" }}
"""
WAIT_S: Final = 20.0


class Cell:
    """Its settings, for the one who arms it."""

    def __init__(self, settings: Path) -> None:
        self._settings = settings

    def arm(self, order: str, parts: int) -> None:
        """The next parts start by themselves."""
        words = ("--parts", str(parts), "--why", "otto, for the night", "--settings", str(self._settings))
        trueloop("cell", "arm", order, *words)


@contextmanager
def cell(folder: Path, lathe: RunningLathe, address: str, key: str) -> Iterator[Cell]:
    """One that runs."""
    secret, settings = folder / "cell.key", folder / "cell.toml"
    secret.touch(0o600)
    secret.write_text(key)
    settings.write_text(SETTINGS.format(machine=MACHINE, address=address, ini=lathe.ini, pin=TEMPERATURE_PIN))
    with (folder / "cell.log").open("w") as log:
        process = lathe.python(*COMMAND[1:], "cell", "run", "--settings", str(settings), stdout=log, stderr=log)
    try:
        yield Cell(settings)
    finally:
        process.terminate()
        process.wait(WAIT_S)
