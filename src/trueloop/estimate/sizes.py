"""Sizes of the terms from what was measured: marginal likelihood times weak log-normal priors, at its maximum.

    log p(y | θ) = −½ yᵀC⁻¹y − ½ log|C| + …        ∂/∂ log v_j = ½ v_j d_jᵀ(ααᵀ − C⁻¹)d_j,   α = C⁻¹y

with d_j the column by which the values follow coefficient j of variance v_j: one inverse serves all terms.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from itertools import pairwise
from types import MappingProxyType
from typing import Any, Final, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.estimate.catalogue import PART, Catalogue, Sizes
from trueloop.estimate.history import Group, after_parts, groups_of
from trueloop.estimate.places import Observed, joined, together
from trueloop.estimate.state import JITTER_MM2, Key
from trueloop.estimate.weights import more_noise

Row: TypeAlias = np.ndarray[tuple[int], np.dtype[np.float64]]

BOUND: Final = 3.5
"""Logarithms stay within so many standard deviations of their priors' medians."""

DIFFERENCE: Final = 1e-5
"""Step of a logarithm by which the dependence of variances on sizes is differenced; the covariance is not."""

FAR: Final = 9.0
"""Scale of a variance with a heavy tail from which its coefficients are far off: more than five standard deviations."""

AGAIN: Final = 2
"""Sizes are fitted again so often at most, with what is far off by the sizes before."""

ROUNDS: Final = 40
"""The search for sizes takes so many steps at most."""

MOST_KNOWN: Final = 64
_KNOWN: Final = WeakKeyDictionary[Catalogue, dict[bytes, dict[str, float]]]()
"""So many of the latest sizes that were fitted with a catalogue, by the digest of what they were fitted to."""


def fitted_sizes(
    catalogue: Catalogue, parts: Sequence[Observed], starts: Sequence[Sizes] = (), rounds: int = ROUNDS
) -> dict[str, float]:
    """Returns the most probable sizes given observations, each of one part, in the order of the clocks.

    Where some of these are gross errors by sizes that were fitted to all values, the sizes are fitted again with these
    at their weights. So it is with displacements of a whole part that have heavy tails and are `FAR` off: an entry that
    nobody stated does not make the size of what all parts scatter by. Without observations: the priors' medians. The
    search begins at the most probable of the medians and of `starts`. To the same observations of the same catalogue
    sizes are fitted once.
    """
    if not any(map(len, parts)):
        return catalogue.medians
    known, key = _KNOWN.setdefault(catalogue, {}), _digest(parts, starts, rounds)
    found = known.get(key)
    if found is None:
        found = known[key] = _fitted(catalogue, parts, starts, rounds)
        for old in list(known)[:-MOST_KNOWN]:
            known.pop(old, None)
    return dict(found)


def log_evidence(catalogue: Catalogue, parts: Sequence[Observed], more_mm2: Array | float = 0.0) -> float:
    """Returns the logarithm, but for a constant, of the likelihood of values times the priors, at the most probable
    sizes: what is assumed of the values' places is compared by it. `more_mm2` (n,): added to the variances of values.
    """
    badness = Badness(catalogue, parts, more_mm2)
    found = _most_probable(badness, catalogue, catalogue.medians, ROUNDS)
    return -badness.of(catalogue.logarithms(found))[0]


def _digest(parts: Sequence[Observed], starts: Sequence[Sizes], rounds: int) -> bytes:
    """Returns the digest of all that sizes depend on beside the catalogue."""
    found = sha256(repr([rounds, *(sorted(start.items()) for start in starts)]).encode())
    for part in parts:
        for array in (part.value_mm, part.instrument_mm2, part.matrix, *part.places.columns.values()):
            found.update(f"{array.dtype} {array.shape}".encode())
            found.update(repr(array.tolist()).encode() if array.dtype == object else array.tobytes())
    return found.digest()


def _fitted(catalogue: Catalogue, parts: Sequence[Observed], starts: Sequence[Sizes], rounds: int) -> dict[str, float]:
    first = [catalogue.medians, *starts]
    _, far = _outliers(catalogue, catalogue.medians, parts)
    badness = Badness(catalogue, parts, far=far)
    start = (
        first[0] if len(first) == 1 else min(first, key=lambda mapping: badness.of(catalogue.logarithms(mapping))[0])
    )
    found, weighed = _most_probable(badness, catalogue, start, rounds), far.keys()
    for again in range(AGAIN):
        more, far = _outliers(catalogue, found, parts)
        if far.keys() == weighed and (again or not np.any(more)):
            break
        found, weighed = _most_probable(Badness(catalogue, parts, more, far), catalogue, found, rounds), far.keys()
    return found


def _most_probable(badness: "Badness", catalogue: Catalogue, start: Sizes, rounds: int) -> dict[str, float]:
    from scipy.optimize import minimize

    medians = catalogue.logarithms(catalogue.medians)
    reach = BOUND * np.array([prior.log_sd for prior in catalogue.priors.values()])
    found = minimize(
        badness.of,
        catalogue.logarithms(start),
        jac=True,
        method="L-BFGS-B",
        bounds=list(zip((medians - reach).tolist(), (medians + reach).tolist(), strict=True)),
        options={"maxiter": rounds, "ftol": 1e-6},
    )
    return catalogue.sizes(np.asarray(found.x, dtype=np.float64))


@dataclass(frozen=True, eq=False)
class _Columns:
    """The matrix (k, m) by which `rows` of the values follow coefficients, or scatter, of variances `which` (m,)."""

    rows: slice | Integers
    design: Array
    which: Integers


class Badness:
    """−log(marginal likelihood × priors) of the logarithms of all sizes, and its gradient."""

    def __init__(
        self,
        catalogue: Catalogue,
        parts: Sequence[Observed],
        more_mm2: Array | float = 0.0,
        far: Mapping[Key, float] = MappingProxyType({}),
    ) -> None:
        from scipy.linalg import block_diag

        self._catalogue, wholes = catalogue, [together(one) for one in _by_part(parts)]
        self._values = np.concatenate([whole.value_mm for whole in wholes])
        self._fixed = block_diag(*(whole.instrument_mm2 for whole in wholes))
        self._fixed[np.diag_indices(len(self._values))] += JITTER_MM2 + more_mm2
        self._median = catalogue.logarithms(catalogue.medians)
        self._log_sd = np.array([prior.log_sd for prior in catalogue.priors.values()])
        groups = groups_of(catalogue, catalogue.medians, wholes)
        present = {key[0] for group in groups for key in group.keys}
        terms = [term for term in catalogue.terms if term.name in present]
        scatter = _Scatter.of(catalogue, wholes)
        walking = {term.name: term.step for term in terms if term.step is not None}
        self._variances = [
            *(_squared(term.spread) for term in terms),
            *map(_squared, walking.values()),
            scatter.variances,
        ]
        sizes = [len(variance(catalogue.medians)) for variance in self._variances]
        ends = np.cumsum([0, *sizes]).tolist()
        self._ends, (*starts, of_scatter) = ends, ends[:-1]
        spread = dict(zip((term.name for term in terms), starts, strict=False))
        step = dict(zip(walking, starts[len(terms) :], strict=True))
        shared = [(rows, of_scatter + which) for rows, which in scatter.shared]
        self._scatter, self._columns = scatter.own, _columns(groups, wholes, (spread, step), far, shared)
        self._followed = [self._followed_by(variances) for variances in self._variances]

    def _followed_by(self, variances: Callable[[Sizes], Array]) -> list[str]:
        """Returns which sizes variances depend on: only these have to be varied for their gradient."""
        medians = self._catalogue.medians
        at_median = variances(medians)
        return [name for name, size in medians.items() if np.any(variances({**medians, name: 1.1 * size}) != at_median)]

    def of(self, logarithms: Row) -> tuple[float, Row]:
        """Returns value and gradient, (k,)."""
        from scipy.linalg import lapack

        sizes = self._catalogue.sizes(logarithms)
        variances = [of(sizes) for of in self._variances]
        spread, covariance = np.sqrt(np.concatenate(variances)), self._fixed.copy()
        np.einsum("ii->i", covariance)[:] += self._scatter @ variances[-1]
        for column in self._columns:
            scaled = column.design * spread[column.which]
            covariance[_square(column.rows)] += scaled @ scaled.T
        factor, failed = lapack.dpotrf(covariance.T, lower=True, clean=True, overwrite_a=True)
        if failed:
            return 1e9, np.zeros_like(logarithms)
        inverse, _ = lapack.dtrtri(factor, lower=True)  # of the factor
        solved = inverse @ self._values
        alpha, slope = inverse.T @ solved, np.zeros(len(spread))
        for column in self._columns:
            drawn = inverse[:, column.rows]
            if len(column.design) < len(column.which):
                squares = np.einsum("ij,ij->j", column.design, (drawn.T @ drawn) @ column.design)
            else:
                squares = np.sum((drawn @ column.design) ** 2, axis=0)
            own = squares - (alpha[column.rows] @ column.design) ** 2
            slope += 0.5 * np.bincount(column.which, own, len(slope))
        slope[self._ends[-2] :] += 0.5 * (np.einsum("ij,ij->j", inverse, inverse) - alpha**2) @ self._scatter
        gradient = dict.fromkeys(sizes, 0.0)
        for of, followed, start, end in zip(self._variances, self._followed, self._ends, self._ends[1:], strict=False):
            for name in followed:
                above, below = (of({**sizes, name: sizes[name] * math.exp(d)}) for d in (DIFFERENCE, -DIFFERENCE))
                gradient[name] += float(slope[start:end] @ (above - below)) / (2.0 * DIFFERENCE)
        away = (logarithms - self._median) / self._log_sd
        value = 0.5 * float(solved @ solved) + float(np.sum(np.log(np.diag(factor)))) + 0.5 * float(away @ away)
        return value, np.asarray(np.array([*gradient.values()]) + away / self._log_sd).reshape(len(logarithms))


def _columns(
    groups: Sequence[Group],
    wholes: Sequence[Observed],
    starts: tuple[Mapping[str, int], Mapping[str, int]],
    far: Mapping[Key, float],
    shared: Sequence[tuple[Array, Integers]],
) -> list[_Columns]:
    """Returns the columns of all terms, those of the same parts side by side.

    `starts`: where variances of a term's coefficients and of their walk begin. A walk is a step between two times one
    after the other, which all later parts have. `shared`: those of each part's places that several of its values see.
    """
    found: dict[tuple[int, ...], list[tuple[Array, Integers]]] = {(k,): [one] for k, one in enumerate(shared)}
    spread, step = starts
    for group in groups:
        of = found.setdefault(tuple(group.parts), [])
        shown = np.vstack([group.shown(k, wholes[k]) for k in group.parts])
        for key, at in group.keys.items():
            shown[:, at] *= math.sqrt(far.get(key, 1.0))
        of.append((shown, np.concatenate([spread[k[0]] + np.arange(a.stop - a.start) for k, a in group.keys.items()])))
        for key, times in group.times.items():
            own, at = times[group.parts], group.keys[key]
            of_value = np.repeat(own, [len(wholes[k]) for k in group.parts])[:, None]
            for since, now in pairwise(np.unique(own).tolist()):
                stepped = shown[:, at] * (of_value >= now) * math.sqrt(now - since)
                of.append((stepped, step[key[0]] + np.arange(stepped.shape[1])))
    ends = np.cumsum([0, *map(len, wholes)])
    return [
        _Columns(
            _rows(np.concatenate([np.arange(ends[k], ends[k + 1]) for k in parts])),
            np.hstack([design for design, _ in of]),
            np.concatenate([which for _, which in of]),
        )
        for parts, of in found.items()
    ]


@dataclass(frozen=True, eq=False)
class _Scatter:
    """The scatter of the cut from place to place, of few variances (c,).

    `own` (n, c): by how much the variance of each value grows with it, by the places that this value alone sees. Of
    each part, `shared` has the matrix by which its values follow places that several see, and their variances.
    """

    variances: Callable[[Sizes], Array]
    own: Array
    shared: tuple[tuple[Array, Integers], ...]

    @classmethod
    def of(cls, catalogue: Catalogue, wholes: Sequence[Observed]) -> "_Scatter":
        """Returns that of all parts: places alike for two sets of sizes that differ in each are alike for all."""
        places, logarithms = joined([whole.places for whole in wholes]), catalogue.logarithms(catalogue.medians)
        other = catalogue.sizes(logarithms + 0.01 * np.arange(1, len(logarithms) + 1))
        seen = np.array([catalogue.repeatability_mm2(places, sizes) for sizes in (catalogue.medians, other)])
        _, first, of_place = np.unique(seen, axis=1, return_index=True, return_inverse=True)
        chosen, own, shared = places.chosen(first), list[Array](), list[tuple[Array, Integers]]()
        ends = np.cumsum([len(whole.places) for whole in wholes])
        for observed, which in zip(wholes, np.split(of_place.reshape(-1), ends[:-1]), strict=True):
            if observed.functional is None:
                own.append(np.eye(len(first))[which])
                shared.append((np.zeros((len(observed), 0)), which[:0]))
                continue
            alone = np.count_nonzero(observed.functional, axis=0) == 1
            own.append(observed.functional[:, alone] ** 2 @ np.eye(len(first))[which[alone]])
            shared.append((observed.functional[:, ~alone], which[~alone]))
        return cls(lambda sizes: catalogue.repeatability_mm2(chosen, sizes), np.vstack(own), tuple(shared))


def _squared(spread: Callable[[Sizes], Array]) -> Callable[[Sizes], Array]:
    return lambda sizes: spread(sizes) ** 2


def _rows(rows: Integers) -> slice | Integers:
    """Returns rows side by side as a slice: a view takes a tenth of the time."""
    together = slice(int(rows[0]), int(rows[-1]) + 1) if len(rows) else slice(0, 0)
    return together if together.stop - together.start == len(rows) else rows


def _square(rows: slice | Integers) -> tuple[Any, ...]:
    return (rows, rows) if isinstance(rows, slice) else np.ix_(rows, rows)


def _by_part(parts: Sequence[Observed]) -> list[list[Observed]]:
    """Returns observations one after the other that are of one part together."""
    found: list[list[Observed]] = []
    for part in parts:
        if found and _of_one_part(found[-1][-1], part):
            found[-1].append(part)
        else:
            found.append([part])
    return found


def _outliers(catalogue: Catalogue, sizes: Sizes, parts: Sequence[Observed]) -> tuple[Array, dict[Key, float]]:
    """Returns by how much the noise of gross errors is larger, (n,), zero of values that are more probably good; and
    the scales of the variances of displacements of whole parts that are far off: not of single features, by which the
    bands of features without a touch are known.
    """
    whole = {term.name for term in catalogue.terms if term.scope == (PART,)}
    found = after_parts(
        catalogue, sizes, _by_part(parts), {column: () for term in catalogue.terms for column in term.scope}
    )
    taken = [one for of_part in found.taken for one in of_part]
    more = [more_noise(one.noise_mm2, np.where(one.gross > 0.5, one.gross, 0.0), catalogue) for one in taken]
    far = {k: scale for one in taken for k, scale in one.scales.items() if scale > FAR and k[0] in whole}
    return np.concatenate(more), far


def _of_one_part(observed: Observed, other: Observed) -> bool:
    own, others = (set(each.places.columns.get(PART, np.zeros(0)).tolist()) for each in (observed, other))
    return bool(own & others)
