"""Tolerances as a drawing writes them, to absolute limits: `±0.02`, `+0.01/-0.02`, `h6`, `ISO 2768-m`."""

import re
from typing import Final, TypeAlias

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError

Limits: TypeAlias = tuple[float, float]
"""Lower and upper, absolute."""

NUMBER: Final = r"(\d+(?:[.,]\d+)?|[.,]\d+)"
BOTH: Final = re.compile(rf"(?:±|\+/-|\+-)\s*{NUMBER}")
ONE: Final = rf"([+-]\s*{NUMBER}|0(?:[.,]0+)?)"
TWO: Final = re.compile(rf"{ONE}\s*(?:/|;|\s)\s*{ONE}")
HINT: Final = 'write "±0.02", "+0.01/-0.02", a tolerance class such as "h6", or "ISO 2768-m"; or give the limits'


def limits_of(text: str, nominal: float, quantity: Quantity, mm_per_unit: float = 1.0) -> Limits:
    """Limits of a characteristic with this nominal, in mm or degrees; numbers of the text in the drawing's unit.

    `mm_per_unit` is 1 or 25.4; angles are in degrees either way. Raises TOL errors.
    """
    given = text.strip().replace("−", "-").replace("–", "-")
    scale = 1.0 if quantity is Quantity.ANGLE else mm_per_unit
    if both := BOTH.fullmatch(given):
        deviation = _number(both[1]) * scale
        return nominal - deviation, nominal + deviation
    if two := TWO.fullmatch(given):
        deviations = sorted(_number(two[k]) * scale for k in (1, 3))
        return nominal + deviations[0], nominal + deviations[1]
    raise unread(text)


def unread(text: str) -> TrueloopError:
    """TOL-TEXT."""
    return TrueloopError(Code.TOL_TEXT, f"the tolerance {text!r} cannot be read", hint=HINT, values={"tolerance": text})


def _number(text: str) -> float:
    return float(text.replace(" ", "").replace(",", "."))
