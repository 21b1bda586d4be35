"""What an axis error that the machine's model has wrong leaves on a turned part, typed from the report's formulas.

Outside diameters and faces that look to +z [4773 Eqs 1 and 2 with the sign of what is left on]:

    e_r = −ε_y(s) z_w − δ_x(s) + [ε_y(z) + ε_y(x)] Z_T + δ_x(x) + δ_x(z)
    e_z = +ε_y(s) x_w − δ_z(s) − [ε_y(z) + ε_y(x)] X_T − ε_y(z) x + δ_z(x) + δ_z(z)

to first order: of 50 µrad the neglected products are some nanometres. Nothing of `trueloop.machine` is used.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from studies.diagnosed.truth import Truth, Wrong
from trueloop.arrays import Array

CHUCK_MM: Final = 120.0
"""From where the spindle tilts to the jaws' face."""
TOOLS_MM: Final[Mapping[str, tuple[float, float]]] = {"T1": (40.0, 60.0), "T2": (65.0, 130.0), "T3": (25.0, 5.0)}
"""(X_T, Z_T): from the turret's reference to the tool point."""
SIGNALS: Final = ("T spindle", "T carriage", "T cross slide")
REFERENCE_C, SPAN_K = 20.0, 8.0
X_RANGE_MM, Z_RANGE_MM = (-65.0, 50.0), (-10.0, 255.0)
"""Travel of cross slide and carriage that the parts need."""


def left_mm(truth: Truth, at_mm: Array, tool_mm: Array, temperatures: Mapping[str, Array | float]) -> Array:
    """(e_r, e_z) at n points of the part's frame, (n, 2); `tool_mm` (n, 2), temperatures in °C, each () or (n,)."""
    radius, z_w = at_mm[:, 0], at_mm[:, 1] + CHUCK_MM
    x_tool, z_tool = tool_mm.T
    x, z = radius - x_tool, z_w - z_tool
    e_r, e_z = np.zeros(len(at_mm)), np.zeros(len(at_mm))
    for one in truth.wrong:
        if not one.error:
            continue
        value = _value(one, x, z, temperatures[one.signal])
        if one.error == "EB0C":
            e_r, e_z = e_r - value * z_w, e_z + value * radius
        elif one.error == "EX0C":
            e_r = e_r - value
        elif one.error == "EZ0C":
            e_z = e_z - value
        elif one.error == "EBZ":
            e_r, e_z = e_r + value * z_tool, e_z - value * x_tool - value * x
        elif one.error == "EBX":
            e_r, e_z = e_r + value * z_tool, e_z - value * x_tool
        elif one.error in ("EXX", "EXZ"):
            e_r = e_r + value
        elif one.error in ("EZX", "EZZ"):
            e_z = e_z + value
        else:
            raise ValueError(f"{one.error} does not show on a turned part")
    return np.column_stack([e_r, e_z])


def _value(one: Wrong, x: Array, z: Array, temperature: Array | float) -> Array:
    """The error's value, straight over temperature; over its axis' travel a line from 0.2 to 1.2, and a bend."""
    warm = one.constant + (np.asarray(temperature) - REFERENCE_C) / SPAN_K
    if one.error.endswith("C"):
        return one.size_mm * warm * np.ones(len(x))
    at, (low, high) = (x, X_RANGE_MM) if one.error.endswith("X") else (z, Z_RANGE_MM)
    share = (at - low) / (high - low)
    value: Array = one.size_mm * warm * (0.2 + share + 4 * one.bend * share * (1 - share))
    return value
