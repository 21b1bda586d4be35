"""All chains of a profile, in the order in which they prescribe to each other, and their uncertainties.

Touched lines come first; touched arcs take their end values (and slopes, under the policy PATH) from them; lines
without a touch follow the arcs they are tangent to; what is left is guessed (`untouched`).
"""

from dataclasses import dataclass

import numpy as np

from trueloop.error_curve.chain import Chain, chains_of
from trueloop.error_curve.chain_fit import ChainFit, ConditionSource, fit_chain, touches_of
from trueloop.error_curve.conditions import Sources, chain_conditions, conditions_covariance
from trueloop.error_curve.options import FitOptions
from trueloop.error_curve.spline import EndConditions, Spline, least_squares_spline
from trueloop.error_curve.untouched import expect
from trueloop.errors import Code, TrueloopError
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.geometry.feature import contact_angle_rad
from trueloop.geometry.profile import Profile
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class FittedChains:
    """The chains with their fits and finished splines, in the profile's order.

    `scatter_mm` is the standard deviation of a touch about each chain's curve: the residuals of all chains with touches
    to spare, pooled over `degrees_of_freedom` of them, and never less than the touches' type B uncertainty.
    """

    chains: tuple[Chain, ...]
    fits: tuple[ChainFit, ...]
    splines: tuple[Spline, ...]
    scatter_mm: tuple[float, ...]
    degrees_of_freedom: int


def fit_chains(profile: Profile, vectors: ErrorVectors, options: FitOptions) -> FittedChains:
    """Fits every chain; see the module for the order."""
    chains = chains_of(profile)
    touched = [bool(np.any(np.isin(vectors.feature_index, chain.features))) for chain in chains]
    order = sorted(range(len(chains)), key=lambda i: (not touched[i], chains[i].curved))
    fits: dict[int, ChainFit] = {}
    for i in order:
        conditions, sources = chain_conditions(profile, chains, i, fits, options)
        fitted = _touched if touched[i] else _untouched
        fits[i] = fitted(profile, chains[i], vectors, options, conditions, sources)
    scatter, degrees_of_freedom = _scatter(fits, vectors)
    splines: dict[int, Spline] = {}
    for i in order:
        splines[i] = fits[i].fit.scaled(scatter[i] ** 2, conditions_covariance(fits[i], splines))
    in_order = range(len(chains))
    return FittedChains(
        chains,
        tuple(fits[i] for i in in_order),
        tuple(splines[i] for i in in_order),
        tuple(scatter[i] for i in in_order),
        degrees_of_freedom,
    )


def _touched(
    profile: Profile,
    chain: Chain,
    vectors: ErrorVectors,
    options: FitOptions,
    conditions: EndConditions,
    sources: Sources,
) -> ChainFit:
    touches = touches_of(profile, chain, vectors)
    fit, every, notes = fit_chain(profile, chain, touches, options, conditions)
    return ChainFit(chain, touches.positions, fit, sources, every, notes)


def _untouched(
    profile: Profile,
    chain: Chain,
    vectors: ErrorVectors,
    options: FitOptions,
    conditions: EndConditions,
    sources: Sources,
) -> ChainFit:
    """From its tangent neighbours where it has any, otherwise a guess with a large uncertainty."""
    name = " and ".join(profile.features[i].name for i in chain.features)
    note = f"{name}: no touch; continues its tangent neighbours' curves"
    if conditions.start_value_mm is None and conditions.end_value_mm is None:
        middle = profile.features[chain.features[len(chain.features) // 2]]
        angle = float(contact_angle_rad(middle.outward_normal(middle.length_mm / 2)))
        value, u, why = expect(vectors, angle)
        conditions, sources = EndConditions(value), (ConditionSource(standard_u_mm=u), ConditionSource())
        note = f"{name}: no touch; {why}; standard uncertainty {u * UM_PER_MM:.0f} µm. Touch it to be sure"
    fit = least_squares_spline([], [], [], chain.length_mm, min(conditions.count - 1, 3), conditions)
    return ChainFit(chain, np.array([], dtype=np.intp), fit, sources, (None,) * len(chain.features), (note,))


def _scatter(fits: dict[int, ChainFit], vectors: ErrorVectors) -> tuple[dict[int, float], int]:
    """Standard deviation of a touch about each chain's curve, and the degrees of freedom it is known with."""
    spare = [fit for fit in fits.values() if fit.fit.degrees_of_freedom > 0]
    degrees_of_freedom = sum(fit.fit.degrees_of_freedom for fit in spare)
    squares = float(sum(np.sum(fit.fit.residual_mm**2) for fit in spare))
    pooled = squares / degrees_of_freedom if degrees_of_freedom else 0.0
    type_b = {i: vectors.standard_u_mm[fit.touches] for i, fit in fits.items()}
    u2 = {i: float(np.mean(u**2)) if len(u) else 0.0 for i, u in type_b.items()}
    return {i: float(np.sqrt(max(pooled, u2[i]))) for i in fits}, degrees_of_freedom


def check_vectors(profile: Profile, vectors: ErrorVectors) -> None:
    """Refuses error vectors that no curve can be fitted to."""
    if len(vectors.point) == 0:
        raise TrueloopError(
            Code.FIT_POINTS,
            f"0 touches on the {len(profile.features)} features of the part: there is nothing to fit",
            hint="touch at least one point",
        )
    numbers = np.column_stack([vectors.arc_length_mm, vectors.error_mm, vectors.standard_u_mm])
    bad = ~np.all(np.isfinite(numbers), axis=1) | (vectors.standard_u_mm < 0.0)
    if np.any(bad):
        k = int(np.argmax(bad))
        raise TrueloopError(
            Code.FIT_VALUE,
            f"touch {vectors.point[k]!r}: arc length {vectors.arc_length_mm[k]} mm, error {vectors.error_mm[k]} mm, "
            f"standard uncertainty {vectors.standard_u_mm[k]} mm; all must be numbers, the last not negative",
            hint="mend or leave out this touch",
        )
    _check_order(vectors)


def _check_order(vectors: ErrorVectors) -> None:
    """Touches of one feature ascend, and no two stand in one place."""
    for k in range(1, len(vectors.point)):
        step = vectors.arc_length_mm[k] - vectors.arc_length_mm[k - 1]
        if vectors.feature_index[k] == vectors.feature_index[k - 1] and step <= 0.0:
            raise TrueloopError(
                Code.FIT_ORDER,
                f"touch {vectors.point[k]!r} at {vectors.arc_length_mm[k]:.4f} mm along its feature follows "
                f"{vectors.point[k - 1]!r} at {vectors.arc_length_mm[k - 1]:.4f} mm",
                hint="order touches along the profile and average those taken at one place",
            )
