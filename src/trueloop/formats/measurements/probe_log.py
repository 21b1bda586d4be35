"""The log of a control while probing: one position a touch.

LinuxCNC writes nine numbers a line, X a radius always. The others write lines with `X…` and `Z…` as the probing program
has them, X in the program's mode; blanks within a number's field are Fanuc's leading zeros.
"""

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.geometry.feature import Point
from trueloop.units import MM_PER_INCH

NUMBER: Final = r"([-+]?\s*[\d.]+(?:EX?[-+]?\d+)?)"
"""Fanuc may write blanks for leading zeros, behind the sign; Siemens an exponent as EX."""
WORDS: Final = re.compile(rf"X\s*{NUMBER}\s*Z\s*{NUMBER}(?![\w.])", re.IGNORECASE)
LINUXCNC_NUMBERS: Final = 9


@dataclass(frozen=True)
class LoggedTouch:
    """A position as logged, (x, z) in mm with x a radius, and its line."""

    position_mm: Point
    line: int


def read_probe_log(path: Path, control: str, *, inch: bool = False, diameter: bool = True) -> list[LoggedTouch]:
    """Reads the touches of a log in its order. Raises PRB-LOG for lines that are none, and for a log without any."""
    text = read_text(path, Code.PRB_LOG, hint="name the file that the probing program wrote")
    return parse_probe_log(text, str(path), control, inch=inch, diameter=diameter)


def parse_probe_log(
    text: str, name: str, control: str, *, inch: bool = False, diameter: bool = True
) -> list[LoggedTouch]:
    """Parses the text of a probe log; `name` is used in errors."""
    scale = MM_PER_INCH if inch else 1.0
    x_scale = scale if control == "linuxcnc" or not diameter else scale / 2
    touches = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.strip() in ("%", "MISSED"):
            continue
        pair = _numbers(line) if control == "linuxcnc" else _words(line)
        if pair is None or not all(map(math.isfinite, pair)):
            raise TrueloopError(
                Code.PRB_LOG,
                f"{line.strip()!r} is no touch as {control} writes it",
                hint="LinuxCNC writes nine numbers a line, the others X and Z; name the control with --control",
                place=Place(name, number),
            )
        touches.append(LoggedTouch((pair[0] * x_scale, pair[1] * scale), number))
    if not touches:
        raise TrueloopError(
            Code.PRB_LOG,
            f"{name!r} holds 0 touches",
            hint="did the program run to its end? LinuxCNC writes the file when it comes to LOGCLOSE",
            place=Place(name),
        )
    return touches


def _numbers(line: str) -> Point | None:
    words = line.split()
    try:
        values = [float(word) for word in words]
    except ValueError:
        return None
    return (values[0], values[2]) if len(values) == LINUXCNC_NUMBERS else None


def _words(line: str) -> Point | None:
    found = WORDS.search(line)
    try:
        return (_value(found[1]), _value(found[2])) if found else None
    except ValueError:
        return None


def _value(text: str) -> float:
    return float("".join(text.upper().split()).replace("EX", "E"))
