"""The machining pattern as a surface: the nominal one moved along its normals by what parts have alike, magnified."""

import math
from dataclasses import dataclass

from trueloop.domain.option import Limits
from trueloop.geometry.surface import Surface
from trueloop.surface.compensation.shift import CorrectedSurface, Deviation, corrected_surface
from trueloop.surface.options import SurfaceOptions

UNLIMITED = Limits(correction_mm=math.inf, slope=math.inf)


@dataclass(frozen=True, eq=False)
class WrittenPattern:
    """Nominal surface and pattern in CAD files of these names, the pattern magnified by `factor`."""

    files: tuple[str, ...]
    factor: float
    made: CorrectedSurface


def pattern_surface(
    nominal: Surface, pattern: Deviation, factor: float, tolerance_mm: float = SurfaceOptions.tolerance_mm
) -> CorrectedSurface:
    """N(u, v) + factor · MPM(u, v) · n(u, v): what the process makes of the nominal surface, material left on outwards
    [MPM §6], fitted to `tolerance_mm` times the factor where that magnifies.

    With a factor so large that the pattern reaches the surface's radius of curvature, the surface folds. Raises
    SRF-TOLERANCE where no fit comes that near.
    """
    allowed = tolerance_mm * max(1.0, factor)
    return corrected_surface(nominal, pattern, weight=-factor, tolerance_mm=allowed, limits=UNLIMITED)
