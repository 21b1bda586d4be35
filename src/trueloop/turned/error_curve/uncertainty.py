"""From fits to curves with their uncertainty: the scatter of the touches, and what is handed from chain to chain."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.turned.error_curve.process_scatter import Spread, process_scatter_mm
from trueloop.turned.error_curve.reference import reference_responses
from trueloop.turned.fit.chain_fit import ChainFit
from trueloop.turned.fit.conditions import conditions_covariance
from trueloop.turned.fit.spline import Spline
from trueloop.turned.touches.error_vectors import ErrorVectors


@dataclass(frozen=True)
class FittedChains:
    """The chains' fits and finished splines, each by the chain's index, in the profile's order.

    `scatter_mm` is the standard deviation of a touch about each chain's curve: the residuals of all chains with touches
    to spare, pooled over `degrees_of_freedom` of them, and never less than the touches' type B uncertainty. Pooling
    assumes that lines and arcs of one cut scatter alike; a curve too stiff for its feature makes all bands wider.
    `reference` (None: z has no reference): what each chain's coefficients follow the reference touch by, per unit of
    its own error, one and the same in all chains.
    """

    fits: Mapping[int, ChainFit]
    splines: Mapping[int, Spline]
    scatter_mm: Mapping[int, float]
    spreads: tuple[Spread, ...]
    reference: Mapping[int, Array] | None

    @property
    def degrees_of_freedom(self) -> int:
        """Touches to spare."""
        return sum(one.spare for one in self.spreads)

    def process_mm(self) -> float | None:
        """The process's part of the scatter, which the next cut scatters by again; None without a touch to spare."""
        return process_scatter_mm(self.spreads) if self.spreads else None


def finish(fits: Mapping[int, ChainFit], vectors: ErrorVectors) -> FittedChains:
    """Puts numbers to the covariances: σ² of the touches, and that of the end values taken from neighbours."""
    reference = reference_responses(fits, vectors) if np.any(vectors.at_reference) else None
    spreads = [_spread(fit, vectors) for fit in fits.values() if fit.spare > 0]
    spare = sum(one.spare for one in spreads)
    pooled = sum(one.squares_mm2 for one in spreads) / spare if spare else 0.0
    scatter = {i: _at_least_type_b(fit, vectors, pooled) for i, fit in fits.items()}
    splines: dict[int, Spline] = {}
    while len(splines) < len(fits):
        for i, fit in fits.items():
            givers = {source.neighbour.chain for source in fit.sources if source.neighbour is not None}
            if i not in splines and givers <= splines.keys():
                splines[i] = _finished(fit, scatter[i], splines)
    if reference is not None:
        own_mm = _reference_scatter_mm(fits, scatter, vectors)
        splines = {i: spline.with_common(own_mm * reference[i]) for i, spline in splines.items()}
    return FittedChains(fits, {i: splines[i] for i in fits}, scatter, tuple(spreads), reference)


def _reference_scatter_mm(
    fits: Mapping[int, ChainFit], scatter_mm: Mapping[int, float], vectors: ErrorVectors
) -> float:
    """Standard deviation of the reference touch: that of its chain's touches."""
    (k,) = np.flatnonzero(vectors.at_reference)
    return next(scatter_mm[i] for i, fit in fits.items() if k in fit.touches)


def _spread(fit: ChainFit, vectors: ErrorVectors) -> Spread:
    """What a chain's residuals say of the scatter, and how much of it is the probe's."""
    probe = float(np.mean(vectors.own_u_mm[fit.touches] ** 2))
    residual = fit.residual_mm if fit.scattered_mm is None else fit.scattered_mm
    return Spread(fit.spare, float(np.sum(residual**2)), probe)


def _at_least_type_b(fit: ChainFit, vectors: ErrorVectors, pooled_mm2: float) -> float:
    """Scatter of a chain; where it has no touch, the other touches' uncertainty stands in, unless it is stated."""
    if fit.scatter_mm is not None:
        return fit.scatter_mm
    u = vectors.standard_u_mm[fit.touches] if len(fit.touches) else vectors.standard_u_mm
    return float(np.sqrt(max(pooled_mm2, float(np.mean(u**2)))))


def _finished(fit: ChainFit, scatter_mm: float, splines: dict[int, Spline]) -> Spline:
    from_ends = conditions_covariance(fit, splines)
    if fit.from_model_mm is None:
        return fit.fit.scaled(scatter_mm**2, from_ends)
    spline = fit.fit.scaled(0.0, from_ends)
    return replace(spline, prescribed_mm=np.hstack([fit.from_model_mm, spline.prescribed_mm]))
