"""Where the scatter of measured parts comes from: one touch, one part, or points too far apart for the pattern."""

from typing import Final

from trueloop.domain.limits import Limits, check_scatter
from trueloop.errors import Code, TrueloopError
from trueloop.loops.surface.surface import SurfaceModel
from trueloop.surface.separation.outlying_point import scattering_part
from trueloop.units import UM_PER_MM

MOSTLY: Final = 0.5
"""Share of the scatter's variance that all parts have alike, from which on it is the pattern and no scatter."""


def check_surface_scatter(model: SurfaceModel, limits: Limits) -> None:
    """Refuses parts that scatter by more than the limit, naming touch and part where one stands out (CMP-SCATTER).

    Raises SRF-SUPPORT where all parts have most of the scatter alike: the points are too far apart for the pattern.
    """
    pattern = model.pattern
    if pattern.sigma_mm > limits.scatter_mm and pattern.missed_mm**2 > MOSTLY * pattern.sigma_mm**2:
        raise TrueloopError(
            Code.SRF_SUPPORT,
            f"the points are too far apart for the pattern: of {pattern.sigma_mm * UM_PER_MM:.1f} µm that touches lie "
            f"off what was fitted, {pattern.missed_mm * UM_PER_MM:.1f} µm are alike on all {pattern.parts} parts; "
            f"the limit is {limits.scatter_mm * UM_PER_MM:.1f} µm",
            hint="measure with points no farther apart than a quarter of the shortest wave",
            override="compensation.max_scatter_um in the job",
        )
    check_scatter(pattern.sigma_mm, limits, scatter_cause(model))


def scatter_cause(model: SurfaceModel) -> str:
    """The part that scatters most, and the touch that is worst, with their probabilities."""
    unlikely = 1.0 - model.options.confidence
    part = scattering_part([part.separation for part in model.parts])
    touch = min((part.worst for part in model.parts), key=lambda worst: worst.found.p_value)
    causes = []
    if part.p_value < unlikely:
        own, others = part.sigma_mm * UM_PER_MM, part.others_mm * UM_PER_MM
        name = model.parts[part.index].deviations.name
        causes.append(f"{name!r} scatters by {own:.1f} µm, the others by {others:.1f} µm (p {part.p_value:.2g})")
    if touch.found.p_value < unlikely:
        causes.append(touch.words)
    return ", and ".join(causes) or f"all {len(model.parts)} parts scatter alike, and no touch stands out"
