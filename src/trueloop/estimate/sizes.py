"""Sizes of the terms from what was measured: marginal likelihood times weak log-normal priors, at its maximum.

    log p(y | θ) = −½ yᵀC⁻¹y − ½ log|C| + …        ∂/∂ log v_j = ½ v_j d_jᵀ(ααᵀ − C⁻¹)d_j,   α = C⁻¹y

with d_j the column by which the values follow coefficient j of variance v_j: one inverse serves all terms.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from types import MappingProxyType
from typing import Any, Final, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np

from trueloop.arrays import Array
from trueloop.estimate.history import after_parts
from trueloop.estimate.places import Observed, Places, together
from trueloop.estimate.state import JITTER_MM2, Key
from trueloop.estimate.term import PART, Catalogue, Sizes, Term
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

MOST_KNOWN: Final = 64
_KNOWN: Final = WeakKeyDictionary[Catalogue, dict[bytes, dict[str, float]]]()
"""So many of the latest sizes that were fitted with a catalogue, by the digest of what they were fitted to."""


def fitted_sizes(
    catalogue: Catalogue, parts: Sequence[Observed], starts: Sequence[Sizes] = (), rounds: int = 40
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


def _digest(parts: Sequence[Observed], starts: Sequence[Sizes], rounds: int) -> bytes:
    """Returns the digest of all that sizes depend on beside the catalogue."""
    found = sha256(repr([rounds, *(sorted(start.items()) for start in starts)]).encode())
    for one in parts:
        for array in (one.value_mm, one.instrument_mm2, one.matrix, *one.places.columns.values()):
            found.update(f"{array.dtype} {array.shape}".encode())
            found.update(repr(array.tolist()).encode() if array.dtype == object else array.tobytes())
    return found.digest()


def _fitted(catalogue: Catalogue, parts: Sequence[Observed], starts: Sequence[Sizes], rounds: int) -> dict[str, float]:
    first = [catalogue.medians, *starts]
    _, far = _outliers(catalogue, catalogue.medians, parts)
    badness = Badness(catalogue, parts, far=far)
    start = first[0] if len(first) == 1 else min(first, key=lambda one: badness.of(catalogue.logarithms(one))[0])
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
class _Block:
    """Coefficients of one term and scope: by how much k rows follow them (k, m), and where in a matrix these rows and
    their columns are: as a view of it where they stand side by side, which takes a tenth of the time.

    `earliest` (k, k): of two rows, the earlier time of the term's clock, since the first; 1 of a term without a walk.
    """

    where: tuple[Any, ...]
    design: Array
    earliest: Array


@dataclass(frozen=True, eq=False)
class _Scatter:
    """The scatter of the cut from place to place: N places of few variances, of each of which the values follow a
    sum.

    `places` are one of each variance, (c,), `shares` by how much the values' covariance grows with it, (n, n) each.
    """

    catalogue: Catalogue
    places: Places
    shares: tuple[Array, ...]

    @classmethod
    def of(cls, catalogue: Catalogue, observed: Observed) -> "_Scatter":
        """Returns those of observations: places alike for two sets of sizes that differ in each are alike for all."""
        logarithms = catalogue.logarithms(catalogue.medians)
        other = catalogue.sizes(logarithms + 0.01 * np.arange(1, len(logarithms) + 1))
        seen = [catalogue.repeatability_mm2(observed.places, sizes) for sizes in (catalogue.medians, other)]
        _, first, of_place = np.unique(np.array(seen), axis=1, return_index=True, return_inverse=True)
        shares = []
        for k in range(len(first)):
            mine = of_place.reshape(-1) == k
            if observed.functional is None:
                shares.append(np.diag(mine.astype(np.float64)))
            else:
                shares.append(observed.functional[:, mine] @ observed.functional[:, mine].T)
        return cls(catalogue, observed.places.chosen(first), tuple(shares))

    def variances(self, sizes: Sizes) -> Array:
        """Returns the variances at the places, (c,)."""
        return self.catalogue.repeatability_mm2(self.places, sizes)

    def covariance(self, sizes: Sizes) -> Array:
        """Returns that of the values, (n, n)."""
        return np.asarray(sum(v * share for v, share in zip(self.variances(sizes), self.shares, strict=True)))

    def pulled(self, pull: Array) -> Array:
        """Returns ∂(−log p)/∂v of each variance, (c,)."""
        return np.array([0.5 * float(np.sum(pull * share)) for share in self.shares])


class Badness:
    """−log(marginal likelihood × priors) of the logarithms of all sizes, and its gradient."""

    def __init__(
        self,
        catalogue: Catalogue,
        parts: Sequence[Observed],
        more_mm2: Array | float = 0.0,
        far: Mapping[Key, float] = MappingProxyType({}),
    ) -> None:
        self._catalogue = catalogue
        observed = together(parts)
        self._values = observed.value_mm
        self._scatter = _Scatter.of(catalogue, observed)
        self._fixed = observed.instrument_mm2 + np.diag(np.full(len(observed), JITTER_MM2) + more_mm2)
        self._median = catalogue.logarithms(catalogue.medians)
        self._log_sd = np.array([prior.log_sd for prior in catalogue.priors.values()])
        every = ((term, _blocks(term, observed, far)) for term in catalogue.terms)
        self._terms = [(term, blocks) for term, blocks in every if blocks]
        self._followed = [self._followed_by(variances) for variances in self._variances()]

    def _variances(self) -> list[Callable[[Sizes], Array]]:
        """Returns the variances of coefficients and scatter as functions of the sizes, in the order of their slopes."""
        variances: list[Callable[[Sizes], Array]] = []
        for term, _ in self._terms:
            variances.append(_squared(term.spread))
            if term.step is not None:
                variances.append(_squared(term.step))
        return [*variances, self._scatter.variances]

    def _followed_by(self, variances: Callable[[Sizes], Array]) -> list[int]:
        """Returns which sizes, by index, variances depend on: only these have to be varied for their gradient."""
        logarithms = self._median.copy()
        at_median, followed = variances(self._catalogue.sizes(logarithms)), list[int]()
        for k in range(len(logarithms)):
            logarithms[k] += 0.1
            if np.any(variances(self._catalogue.sizes(logarithms)) != at_median):
                followed.append(k)
            logarithms[k] = self._median[k]
        return followed

    def of(self, logarithms: Row) -> tuple[float, Row]:
        """Returns value and gradient, (k,)."""
        from scipy.linalg import lapack

        sizes, gradient = self._catalogue.sizes(logarithms), np.zeros(len(logarithms))
        covariance = self._fixed + self._scatter.covariance(sizes)
        for term, blocks in self._terms:
            _add(covariance, term.spread(sizes), blocks, walking=False)
            if term.step is not None:
                _add(covariance, term.step(sizes), blocks, walking=True)
        factor, failed = lapack.dpotrf(covariance, lower=True, clean=True)
        if failed:
            return 1e9, np.zeros_like(logarithms)
        inverse = lapack.dpotri(factor, lower=True)[0]
        inverse = np.tril(inverse) + np.tril(inverse, -1).T
        alpha = inverse @ self._values
        pull = inverse - np.outer(alpha, alpha)
        slopes = list[Array]()
        for term, blocks in self._terms:
            slopes.append(_pulled(pull, blocks, walking=False))
            if term.step is not None:
                slopes.append(_pulled(pull, blocks, walking=True))
        slopes.append(self._scatter.pulled(pull))
        beside = [self._beside(logarithms, k) for k in range(len(logarithms))]
        for variances, slope, followed in zip(self._variances(), slopes, self._followed, strict=True):
            for k in followed:
                above, below = beside[k]
                gradient[k] += float(slope @ (variances(above) - variances(below))) / (2.0 * DIFFERENCE)
        away = (logarithms - self._median) / self._log_sd
        value = 0.5 * float(self._values @ alpha) + float(np.sum(np.log(np.diag(factor)))) + 0.5 * float(away @ away)
        return value, np.asarray(gradient + away / self._log_sd).reshape(len(logarithms))

    def _beside(self, logarithms: Row, k: int) -> tuple[Sizes, Sizes]:
        """Returns the sizes with the k-th a little larger, and a little smaller."""
        step = np.zeros(len(logarithms))
        step[k] = DIFFERENCE
        return self._catalogue.sizes(logarithms + step), self._catalogue.sizes(logarithms - step)


def _squared(spread: Callable[[Sizes], Array]) -> Callable[[Sizes], Array]:
    return lambda sizes: spread(sizes) ** 2


def _blocks(term: Term, observed: Observed, far: Mapping[Key, float]) -> list[_Block]:
    values = term.basis(observed.places)
    times = None
    if term.step is not None:
        which = np.argmax(observed.matrix != 0.0, axis=1)
        times = observed.places.number(term.clock)[which]
    found = []
    for label, mine in observed.places.groups(term.scope).items():
        at, design = mine, math.sqrt(far.get((term.name, *label), 1.0)) * values[mine]
        if observed.functional is not None:
            at, design = np.arange(len(observed)), observed.functional[:, mine] @ design
        some = np.any(design != 0.0, axis=1)
        rows, design = at[some], design[some]
        if len(rows):
            since = np.ones(1) if times is None else times[rows] - np.min(times[rows])
            found.append(_Block(_square(rows), design, np.minimum.outer(since, since)))
    return found


def _square(rows: np.ndarray[Any, np.dtype[np.intp]]) -> tuple[Any, ...]:
    together = slice(int(rows[0]), int(rows[-1]) + 1)
    side_by_side = together.stop - together.start == len(rows)
    return (together, together) if side_by_side else np.ix_(rows, rows)


def _add(covariance: Array, spread: Array, blocks: Sequence[_Block], walking: bool) -> None:
    for block in blocks:
        scaled = block.design * spread
        own = scaled @ scaled.T
        covariance[block.where] += own * block.earliest if walking else own


def _pulled(pull: Array, blocks: Sequence[_Block], walking: bool) -> Array:
    """Returns ∂(−log p)/∂v of every coefficient's variance, summed over blocks, (m,)."""
    total = np.zeros(blocks[0].design.shape[1])
    for block in blocks:
        own = pull[block.where]
        own = own * block.earliest if walking else own
        total += 0.5 * np.einsum("ij,ij->j", own @ block.design, block.design)
    return total


def _outliers(catalogue: Catalogue, sizes: Sizes, parts: Sequence[Observed]) -> tuple[Array, dict[Key, float]]:
    """Returns by how much the noise of gross errors is larger, (n,), zero of values that are more probably good; and
    the scales of the variances of displacements of whole parts that are far off: not of single features, by which the
    bands of features without a touch are known.
    """
    whole = {term.name for term in catalogue.terms if term.scope == (PART,)}
    by_part: list[list[Observed]] = []
    for one in parts:
        if by_part and _of_one_part(by_part[-1][-1], one):
            by_part[-1].append(one)
        else:
            by_part.append([one])
    found = after_parts(catalogue, sizes, by_part, {column: () for term in catalogue.terms for column in term.scope})
    taken = [one for of_part in found.taken for one in of_part]
    more = [more_noise(one.noise_mm2, np.where(one.gross > 0.5, one.gross, 0.0), catalogue) for one in taken]
    far = {k: scale for one in taken for k, scale in one.scales.items() if scale > FAR and k[0] in whole}
    return np.concatenate(more), far


def _of_one_part(observed: Observed, other: Observed) -> bool:
    own, others = (set(each.places.columns.get(PART, np.zeros(0)).tolist()) for each in (observed, other))
    return bool(own & others)
