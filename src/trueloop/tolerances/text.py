"""Tolerances as a drawing writes them, to absolute limits: `±0.02`, `+0.01/-0.02`, `h6`, `ISO 2768-m`."""

import re
from typing import Final, TypeAlias

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.tolerances import iso2768
from trueloop.tolerances.iso286 import deviations_mm

Limits: TypeAlias = tuple[float, float]
"""Lower and upper, absolute."""


NUMBER: Final = r"(\d+(?:[.,]\d+)?|[.,]\d+)"
BOTH: Final = re.compile(rf"(?:±|\+/-|\+-)\s*{NUMBER}")
ONE: Final = rf"([+-]\s*{NUMBER}|0(?:[.,]0+)?)"
TWO: Final = re.compile(rf"{ONE}\s*(?:/|;|\s)\s*{ONE}")
SIZED: Final = re.compile(rf"(?:[Øø⌀Φφ]?\s*{NUMBER}\s*)?([A-Za-z]{{1,2}}\s*\d{{1,3}})")
"""A tolerance class, with the size before it or without."""
WIDTH: Final = re.compile(NUMBER)
SIZES: Final = (Quantity.DIAMETER, Quantity.LENGTH, Quantity.RADIUS)
SAME_MM: Final = 1e-6
HINT: Final = (
    'write "±0.02", "+0.01/-0.02", a class such as "h6", "ISO 2768-m", or "0.01" of a form; or give the limits'
)


def limits_of(text: str, nominal: float, quantity: Quantity, edge_of: iso2768.Edge, mm_per_unit: float = 1.0) -> Limits:
    """Limits of a characteristic with this nominal, in mm or degrees; numbers of the text in the drawing's unit.

    `mm_per_unit` is 1 or 25.4; angles are in degrees either way. Raises TOL errors.
    """
    given = text.strip().replace("−", "-").replace("–", "-")
    lower, upper = _deviations(given, nominal, quantity, edge_of, 1.0 if quantity is Quantity.ANGLE else mm_per_unit)
    return nominal + lower, nominal + upper


def _deviations(text: str, nominal: float, quantity: Quantity, edge_of: iso2768.Edge, scale: float) -> Limits:
    if quantity is Quantity.FORM:
        return 0.0, _form(text) * scale
    if both := BOTH.fullmatch(text):
        deviation = _number(both[1]) * scale
        return -deviation, deviation
    if two := TWO.fullmatch(text):
        first, second = (_number(two[k]) * scale for k in (1, 3))
        return min(first, second), max(first, second)
    if (general := iso2768.deviation(text, quantity, nominal, edge_of)) is not None:
        return -general, general
    if (sized := SIZED.fullmatch(text)) is None or quantity not in SIZES:
        raise unread(text)
    if sized[1] is not None and abs(_number(sized[1]) * scale - nominal) > SAME_MM:
        raise _other_size(text, _number(sized[1]) * scale, nominal)
    return deviations_mm(sized[2], nominal)


def _form(text: str) -> float:
    """A form has a tolerance without sign, "0.01": the width of its zone."""
    if (width := WIDTH.fullmatch(text)) is None:
        raise unread(text)
    return _number(width[1])


def _other_size(text: str, size_mm: float, nominal_mm: float) -> TrueloopError:
    return Code.TOL_SIZE.refusal(
        f"the tolerance {text!r} is of {size_mm:.4f} mm, the nominal is {nominal_mm:.4f} mm",
        hint="give `characteristic.nominal` as the drawing has it; left out, it is the profile's",
        values={"tolerance": text, "nominal_mm": nominal_mm},
    )


def unread(text: str) -> TrueloopError:
    """TOL-TEXT."""
    return Code.TOL_TEXT.refusal(f"the tolerance {text!r} cannot be read", hint=HINT, values={"tolerance": text})


def _number(text: str) -> float:
    return float(text.replace(" ", "").replace(",", "."))
