"""Temperatures from pins of LinuxCNC's hardware layer: `read_pins`."""

import math
import subprocess
from collections.abc import Mapping, Sequence
from typing import Final

WAIT_S: Final = 5.0


def read_pins(pins: Mapping[str, str], program: str = "halcmd") -> tuple[dict[str, float], list[str]]:
    """°C by the name of the signal, of the pins that can be read; and of the others why not."""
    found, wrong = {}, []
    for name, pin in pins.items():
        try:
            said = subprocess.run(
                [program, "getp", pin],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=WAIT_S,
                check=True,
            ).stdout
            value = float(said)
            if not math.isfinite(value):
                raise ValueError(f"{said.strip()} is no temperature")
            found[name] = value
        except (OSError, subprocess.SubprocessError, ValueError) as error:
            said = (getattr(error, "stderr", None) or str(error)).strip()
            wrong.append(f"{name}, pin {pin!r}: {said}")
    return found, wrong


def _read(command: Sequence[str]) -> float:
    """Raises ValueError for what is no temperature."""
    said = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=WAIT_S, check=True
    ).stdout
    value = float(said)
    if not math.isfinite(value):
        raise ValueError(f"{said.strip()} is no temperature")
    return value
