"""The point of a lathe tool that a program moves: its nose's centre, or the imaginary tip of its orientation."""

from dataclasses import replace

import numpy as np

from trueloop.geometry.feature import Point
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.tool_path import NO_COMPENSATION, ToolPath

CENTRE: Point = (0.0, 0.0)
ORIENTATIONS = range(1, 9)
"""Those whose tip is not the nose's centre."""


def tip_mm(dialect: Dialect, orientation: int, nose_radius_mm: float) -> Point:
    """Returns the position of the tip of that orientation, by the control's number, from the nose's centre, (x, z)."""
    x, z = dialect.tips[orientation]
    return x * nose_radius_mm, z * nose_radius_mm


def of_centre(path: ToolPath, tip: Point) -> ToolPath:
    """Returns the path of the nose's centre, of a program that moves the point `tip` (x, z) off it.

    Moves under G41 and G42 stay: theirs is the contour.
    """
    if tip == CENTRE:
        return path
    off = np.where(path.compensation == NO_COMPENSATION, 1.0, 0.0)[:, None] * np.array([tip[0], 0.0, tip[1]])
    return replace(path, start_mm=path.start_mm - off, end_mm=path.end_mm - off, centre_mm=path.centre_mm - off)
