"""Thermometers DS18B20 and alike at a 1-Wire bus, as the Linux kernel shows them: a folder each, a file to read."""

import re
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.controllers.linuxcnc.realtime.signals.readings import Intake, wait

FOLDER: Final = Path("/sys/bus/w1/devices")
POWER_ON_MILLI_DEGC: Final = 85000
"""What the sensor holds until its first conversion [DS18B20 data sheet]: a reset looks like it, so it is no reading."""

SCRATCHPAD: Final = re.compile(r"(?P<bytes>(?:[0-9a-f]{2} ){9}): crc=[0-9a-f]{2} (?P<verdict>YES|NO)\b")
TEMPERATURE: Final = re.compile(r"\bt=(-?\d+)\b")


@dataclass(frozen=True)
class OneWire:
    """A bus. `devices` are the names of folders by signal, such as 28-00000a1b2c3d."""

    devices: Mapping[str, str]
    every_s: float = 1.0
    folder: Path = FOLDER

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Reads one after the other; a conversion takes up to 0.75 s."""
        while not stop.is_set():
            began_s = time.monotonic()
            for name, device in self.devices.items():
                read_s = time.monotonic()
                try:
                    intake.put(name, temperature_degC(self.folder / device), read_s)
                except (OSError, ValueError) as error:
                    intake.refuse(name, str(error))
            wait(stop, began_s, self.every_s)


def temperature_degC(device: Path) -> float:
    """What a sensor says, °C. Raises `OSError` where it is not there, `ValueError` for what is no reading of it."""
    slave = device / "w1_slave"
    text = (slave if slave.exists() else device / "temperature").read_text(encoding="ascii", errors="replace")
    milli = _from_scratchpad(text) if slave.exists() else int(text)
    if milli == POWER_ON_MILLI_DEGC:
        raise ValueError("85 °C is what it says after power came on, before its first reading")
    return milli / 1000


def _from_scratchpad(text: str) -> int:
    """Raises `ValueError`. Nine zeros have a right checksum: a line that is pulled down reads so."""
    found, value = SCRATCHPAD.search(text), TEMPERATURE.search(text)
    if found is None or value is None:
        raise ValueError(f"{text[:80]!r} is no reading of a 1-Wire thermometer")
    if found["verdict"] == "NO":
        raise ValueError("its checksum is wrong: crc NO")
    if set(found["bytes"].split()) == {"00"}:
        raise ValueError("all nine bytes are 0: the line is pulled down")
    return int(value[1])
