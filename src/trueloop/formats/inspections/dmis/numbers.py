"""Numbers of DMIS statements: with a decimal point always, empty where a value is not stated."""

import math
import re
from typing import Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.dmis.settings import Settings

NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
SEXAGESIMAL: Final = re.compile(r"([+-]?)(\d+):(\d+)(?::(\d+\.?\d*))?")
FINEST: Final = 12
"""Decimals beyond which a number is exact in any sense that matters."""


def is_number(text: str) -> bool:
    """Returns whether it is a number or an angle in degrees, minutes and seconds."""
    return NUMBER.fullmatch(text) is not None or SEXAGESIMAL.fullmatch(text) is not None


def number_of(text: str, settings: Settings, line: int) -> float | None:
    """Its value in the file's unit; None for an empty field. Raises MSR-NUMBER for what is no finite number."""
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if math.isfinite(value) and "_" not in text:  # Python takes 1_000
        return value
    raise TrueloopError(
        Code.MSR_NUMBER,
        f"{text!r} stands where a number is expected",
        hint="write it with a decimal point; what was not measured is left empty",
        place=Place(str(settings.path), line),
        values={"text": text},
    )


def degrees_of(text: str, settings: Settings, line: int) -> float | None:
    """Returns an angle in degrees; of `12:30:00` where the file states ANGDMS."""
    found = SEXAGESIMAL.fullmatch(text) if settings.sexagesimal else None
    if found is None:
        value = number_of(text, settings, line)
        return None if value is None else value * settings.deg
    degrees = int(found[2]) + int(found[3]) / 60 + float(found[4] or 0) / 3600
    return -degrees if found[1] == "-" else degrees


def decimals_in(text: str) -> int:
    """Returns the number of decimals that a number is written with."""
    if "e" in text or "E" in text:
        mantissa, _, exponent = text.lower().partition("e")
        return min(max(decimals_in(mantissa) - int(exponent), 0), FINEST)
    point = text.find(".")
    return 0 if point < 0 else min(len(text) - point - 1, FINEST)
