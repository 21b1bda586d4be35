"""Temperatures from pins of LinuxCNC's hardware layer: `read_pins`."""

import math
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

WAIT_S: Final = 5.0
OLDEST_S: Final = 86_400.0
"""A value of an older age is none: who sets the pin has never had one, or lost it long ago."""


@dataclass(frozen=True)
class Temperature:
    """°C, and how long ago that was measured, s."""

    celsius: float
    age_s: float = 0.0


def read_pins(
    pins: Mapping[str, str], ages: Mapping[str, str], program: str = "halcmd"
) -> tuple[dict[str, Temperature], list[str]]:
    """Reads pins: temperatures by the name of the signal, and for those that cannot be read, why not.

    `ages`: pins with the values' ages in s; a value without one is of now.
    """
    found, wrong = {}, []
    for name, pin in pins.items():
        try:
            age_s = _value(program, ages[name]) if name in ages else 0.0
            if not 0.0 <= age_s <= OLDEST_S:
                raise ValueError(f"its value is {age_s:g} s old")
            found[name] = Temperature(_value(program, pin), age_s)
        except (OSError, subprocess.SubprocessError, ValueError) as error:
            said = (getattr(error, "stderr", None) or str(error)).strip()
            wrong.append(f"{name}, pin {pin!r}: {said}")
    return found, wrong


def _value(program: str, pin: str) -> float:
    """Raises ValueError for what is no number."""
    said = subprocess.run(
        [program, "getp", pin], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=WAIT_S, check=True
    ).stdout
    value = float(said)
    if not math.isfinite(value):
        raise ValueError(f"{said.strip()} is no number")
    return value
