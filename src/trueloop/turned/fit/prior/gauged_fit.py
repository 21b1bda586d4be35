"""The curve of a chain that no probe touched, from the readings of gauges (`gauged`).

A line's error is straight in arc length, and its curve holds what the readings say without loss; an arc's is carried
over to a cubic spline as that of any feature without a touch is. Neighbours that join tangentially have one value
where they meet; an arc has their slope there too: a kink that nobody measured is not cut, least of all into a fillet,
which the nose would not reach.
"""

from dataclasses import astuple, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.chain import Chain
from trueloop.turned.fit.chain_fit import ChainFit, Sources, own_fit, touches_of
from trueloop.turned.fit.knots import fit_determined
from trueloop.turned.fit.prior.gauged import Known, Places
from trueloop.turned.fit.prior.untouched import NOISE_MM, SUPPORTED
from trueloop.turned.fit.prior.untouched_fit import chain_knots, chain_samples, name_of, root_of, through
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM


def is_supported(profile: Profile, chain: Chain, vectors: ErrorVectors, seen: Known) -> bool:
    """Whether the readings say enough of a chain to move it."""
    if np.any(np.isin(vectors.feature_index, chain.features)):
        return True
    _, index, along = chain_samples(profile, chain)
    return seen.at(Places.of(profile, index, along))[2] >= SUPPORTED


def fit_gauged(
    profile: Profile,
    chain: Chain,
    vectors: ErrorVectors,
    seen: Known,
    ends: EndConditions,
    touched: tuple[EndConditions, Sources],
    supported: bool,
) -> ChainFit:
    """The fit of one chain.

    `ends` are values and slopes of all tangent neighbours that are fitted, `touched` the conditions of those that were
    touched, and of the user, with their sources. `supported`: as of `is_supported`; else it stays as programmed.
    """
    conditions, sources = touched
    s, index, along = chain_samples(profile, chain)
    mean, covariance, _ = seen.at(Places.of(profile, index, along))
    held = np.array([conditions.start_value_mm is not None, conditions.end_value_mm is not None])
    rows = touches_of(profile, chain, vectors)
    mean, covariance = through(mean if supported else np.zeros_like(s), covariance, held, conditions)
    mean = _faded(s / chain.length_mm, mean, ends)
    root = root_of(covariance)
    once = np.append(np.diff(s) > 0.0, True)  # a joint is sampled from both sides
    degree = 3 if chain.curved else 1
    knots = chain_knots(chain, s)
    fit, kept = fit_determined(s[once], mean[once], knots, chain.length_mm, degree, _with_ends(ends, mean))
    columns = [
        fit_determined(s[once], one[once], kept, chain.length_mm, degree, _with_ends(_zero(conditions), one))[0]
        for one in root.T
    ]
    residual = rows.error_mm - fit.spline.of(fit.spline.value_form(rows.arc_length_mm))
    return replace(
        own_fit(chain, rows, fit, sources, _note(profile, chain, supported, len(rows.positions), mean, root)),
        residual_mm=residual,
        leave_one_out_mm=_left_out(vectors, rows.positions, seen),
        spare=0,
        from_model_mm=np.column_stack([one.spline.coefficients_mm for one in columns]),
        unsupported=not supported and not held.any(),
        scatter_mm=NOISE_MM,
    )


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


def _left_out(vectors: ErrorVectors, positions: "np.ndarray[tuple[int], np.dtype[np.intp]]", seen: Known) -> Array:
    """Each reading less what the others say of it; NaN for what is put together from several."""
    by_name = dict(zip(seen.names, seen.left_out_mm.tolist(), strict=True))
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
