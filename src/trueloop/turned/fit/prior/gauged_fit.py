"""The curve of a chain that no probe touched, from the readings of gauges (`part_state`).

A line is corrected by a straight line where that is near enough to what the readings show, else its curve is carried
over to a cubic spline, as that of any arc without a touch is. Neighbours that join tangentially have one value
where they meet; an arc has their slope there too: a kink that nobody measured is not cut, least of all into a fillet,
which the nose would not reach.
"""

from dataclasses import astuple, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.arc_fit import STRAIGHT_MM
from trueloop.turned.fit.chain import Chain
from trueloop.turned.fit.chain_fit import ChainFit, Sources, own_fit, touches_of
from trueloop.turned.fit.knots import Knots, fit_determined
from trueloop.turned.fit.prior.part_state import PartState
from trueloop.turned.fit.prior.untouched import SUPPORTED
from trueloop.turned.fit.prior.untouched_fit import chain_knots, chain_samples, name_of, root_of, through
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM


def is_supported(profile: Profile, chain: Chain, vectors: ErrorVectors, state: PartState) -> bool:
    """Returns whether the readings determine enough of a chain to move it."""
    if np.any(np.isin(vectors.feature_index, chain.features)):
        return True
    _, index, along = chain_samples(profile, chain)
    return state.explained(index, along) >= SUPPORTED


def fit_gauged(
    profile: Profile,
    chain: Chain,
    vectors: ErrorVectors,
    state: PartState,
    ends: EndConditions,
    touched: tuple[EndConditions, Sources],
    supported: bool,
    bends: bool = True,
) -> ChainFit:
    """Fits one chain.

    `ends` are values and slopes of all tangent neighbours that are fitted, `touched` the conditions of those that were
    touched, and of the user, with their sources. `supported`: as of `is_supported`; else it stays as programmed.
    `bends`: whether a line may follow a bow.
    """
    conditions, sources = touched
    s, index, along = chain_samples(profile, chain)
    found = state.at(index, along)
    mean, covariance = found.mean_mm, found.covariance_mm2
    held = np.array([conditions.start_value_mm is not None, conditions.end_value_mm is not None])
    rows = touches_of(profile, chain, vectors)
    mean, covariance = through(mean if supported else np.zeros_like(s), covariance, held, conditions)
    mean = _faded(s / chain.length_mm, mean, ends)
    root = root_of(covariance)
    once = np.append(np.diff(s) > 0.0, True)  # a joint is sampled from both sides
    straight = not bends or _is_straight(chain, s[once], mean[once], np.linalg.norm(root[once], axis=1))
    straight = not chain.curved and straight
    degree, knots = 1 if straight else 3, chain_knots(replace(chain, curved=not straight), s)
    at_ends, zero = (ends, _zero(conditions)) if straight else (_with_ends(ends, mean), None)
    fit, kept = fit_determined(s[once], mean[once], knots, chain.length_mm, degree, at_ends)
    columns = [
        fit_determined(s[once], one[once], kept, chain.length_mm, degree, zero or _with_ends(_zero(conditions), one))[0]
        for one in root.T
    ]
    residual = rows.error_mm - fit.spline.of(fit.spline.value_form(rows.arc_length_mm))
    return replace(
        own_fit(chain, rows, fit, sources, _note(profile, chain, supported, len(rows.positions), mean, root)),
        residual_mm=residual,
        leave_one_out_mm=_left_out(vectors, rows.positions, state),
        spare=0,
        from_model_mm=np.column_stack([one.spline.coefficients_mm for one in columns]),
        unsupported=not supported and not held.any(),
        scatter_mm=state.updated.state.sizes["repeatability"],
    )


def _is_straight(chain: Chain, s: Array, mean: Array, u: Array) -> bool:
    """Returns whether straight lines along a chain are within a standard uncertainty, or half a micrometre, of the
    mean.
    """
    knots = Knots((), chain.joints_mm, 1)
    line, _ = fit_determined(s, mean, knots, chain.length_mm, 1, EndConditions())
    return bool(np.all(np.abs(line.residual_mm) <= np.maximum(u, STRAIGHT_MM)))


def _faded(share: Array, mean: Array, ends: EndConditions) -> Array:
    """The mean with what neighbours have at the ends: where one is left as programmed, what little is said of it."""
    start, end = (
        0.0 if value is None else value - mean[k] for k, value in zip((0, -1), ends.numbers[::2], strict=True)
    )
    return np.asarray(mean + (1.0 - share) * start + share * end)


def _with_ends(conditions: EndConditions, values: Array) -> EndConditions:
    """The conditions, and at free ends the values themselves: neighbours meet to the last bit."""
    start, end = conditions.start_value_mm, conditions.end_value_mm
    return replace(
        conditions,
        start_value_mm=float(values[0]) if start is None else start,
        end_value_mm=float(values[-1]) if end is None else end,
    )


def _zero(conditions: EndConditions) -> EndConditions:
    return EndConditions(*(None if number is None else 0.0 for number in astuple(conditions)))


def _left_out(vectors: ErrorVectors, positions: "np.ndarray[tuple[int], np.dtype[np.intp]]", state: PartState) -> Array:
    """Returns each reading less its prediction by the others; NaN for readings put together from several."""
    by_name = dict(zip(state.names, state.updated.left_out_mm.tolist(), strict=True))
    return np.array([by_name.get(vectors.point[k], np.nan) for k in positions])


def _note(profile: Profile, chain: Chain, supported: bool, rows: int, mean: Array, root: Array) -> str:
    u_um = float(np.max(np.linalg.norm(root, axis=1), initial=0.0)) * UM_PER_MM
    low, high = float(np.min(mean)) * UM_PER_MM, float(np.max(mean)) * UM_PER_MM
    size = f"{low:.1f} µm" if high - low < 0.05 else f"{low:.1f} to {high:.1f} µm"
    what = f"{rows} of its own among them" if rows else "none of its own"
    if not supported:
        return (
            f"{name_of(profile, chain)}: the readings say nothing of it: left as programmed; standard uncertainty "
            f"{u_um:.0f} µm. Measure it to be sure"
        )
    return f"{name_of(profile, chain)}: {size} by all readings together, {what}; standard uncertainty {u_um:.1f} µm"
