"""The new numbers of a row in a control's tool table: the old ones and the change, in the table's unit."""

from decimal import ROUND_HALF_EVEN, Decimal
from typing import Literal


def changed_number(
    old: Decimal, change_mm: float, unit_mm: float, counts: Literal["radius", "diameter"], step: Decimal
) -> Decimal:
    """Returns `old` plus a change along an axis, rounded to `step`; a table that counts diameters gets twice the
    change.

    `change_mm` of x is that of the radius; `unit_mm` is the table's unit.
    """
    factor = 2 if counts == "diameter" else 1
    return old + Decimal(factor * change_mm / unit_mm).quantize(step, ROUND_HALF_EVEN)


def in_mm(value: Decimal, unit_mm: float, counts: Literal["radius", "diameter"]) -> float:
    """Returns a number of a table in mm, a diameter as a radius."""
    return float(value) * unit_mm / (2 if counts == "diameter" else 1)
