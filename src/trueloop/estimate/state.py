"""Mean and covariance of all coefficients: updated by observations exactly, part after part."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from trueloop.arrays import Array, by_content
from trueloop.estimate.catalogue import Catalogue, Sizes, Term
from trueloop.estimate.places import Observed, Places
from trueloop.estimate.weights import Heavy, Weighted, plain, weighted

Key: TypeAlias = tuple[Any, ...]
"""Name of a term, then the values of its scope."""

JITTER_MM2: Final = 1e-12
"""(1 nm)², added to the variance of every value: keeps covariances of coincident touches positive definite."""


@by_content
@dataclass(frozen=True)
class Normal:
    """A normal distribution of n values, mm: mean (n,) and covariance (n, n)."""

    mean_mm: Array
    covariance_mm2: Array

    @property
    def standard_u_mm(self) -> Array:
        """Returns the standard deviations, (n,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance_mm2), 0.0))


@dataclass(frozen=True, eq=False)
class Updated:
    """A state with observations in it, and what these showed.

    `innovation` is what the values differ by from what was expected of them, with its covariance (noise included).
    `gross` (n,): probability that a value is a gross error. `left_out` of a value: its difference from what all others
    (with their weights) and everything earlier expect, its standard deviation in `left_out_u_mm`, (n,) each. `scales`:
    by how much the variances of coefficients with heavy tails are larger, of those that were not observed before.
    """

    state: "State"
    innovation: Normal
    gross: Array
    left_out_mm: Array
    left_out_u_mm: Array
    scales: Mapping[Key, float]


@dataclass(frozen=True, eq=False)
class State:
    """The knowledge of all coefficients.

    `blocks` gives the places of the coefficients of a term and scope in `mean` (m,) and `covariance` (m, m); `clocks`
    which time of its clock a random walk stands. Observations are to come in the order of the clocks.
    """

    catalogue: Catalogue
    sizes: Sizes
    mean: Array
    covariance: Array
    blocks: Mapping[Key, slice]
    clocks: Mapping[Key, float]

    @classmethod
    def before(cls, catalogue: Catalogue, sizes: Sizes | None = None) -> "State":
        """Returns the state before any measurement."""
        return cls(
            catalogue=catalogue,
            sizes=sizes or catalogue.medians,
            mean=np.zeros(0),
            covariance=np.zeros((0, 0)),
            blocks={},
            clocks={},
        )

    def given(self, observed: Observed, robust: bool = True) -> Updated:
        """Returns the state with observations; `robust` weighs each by the probability that it is a gross error."""
        state = self.at(observed.places)
        noise, rows = state.noise_mm2(observed), observed.of(state.design(observed.places))
        followed = _followed(rows)
        gain = rows[:, followed] @ state.covariance[followed]
        off = observed.value_mm - rows @ state.mean
        innovation = Normal(off, gain[:, followed] @ rows[:, followed].T + noise)
        scales = dict[Key, float]()
        where = state._unobserved_heavy() if robust else []
        if robust:
            variance = np.diag(state.covariance)
            heavy = [Heavy(rows[:, at], variance[at], tail) for _, at, tail in where]
            found = weighted(innovation.covariance_mm2, np.diag(noise), off, self.catalogue, heavy)
            scales = dict(zip((key for key, _, _ in where), found.scales.tolist(), strict=True))
        else:
            found = plain(innovation.covariance_mm2, off)
        after = state._after(gain, off, found, [at for _, at, _ in where])
        return Updated(
            state=after,
            innovation=innovation,
            gross=found.gross,
            left_out_mm=found.left_out_mm,
            left_out_u_mm=found.left_out_u_mm,
            scales=scales,
        )

    def noise_mm2(self, observed: Observed) -> Array:
        """Returns the covariance of instrument errors and the cut's repeatability in measured values, (n, n)."""
        scatter = self.catalogue.repeatability_mm2(observed.places, self.sizes)
        own = _scattered(scatter, observed.functional)
        return np.asarray(own + observed.instrument_mm2 + JITTER_MM2 * np.eye(len(observed)))

    def predict(
        self,
        places: Places,
        functional: Array | None = None,
        terms: Collection[str] | None = None,
        repeatability: bool = True,
    ) -> Normal:
        """Predicts the errors at places, (N,), or functionals (n, N) of them.

        `terms`: only these have a part in it, as a share of the whole. `repeatability`: with what one cut scatters from
        place to place; never with `terms`.
        """
        state = self.expecting(places)
        rows = state.design(places, terms)
        if functional is not None:
            rows = functional @ rows
        covariance = state.covariance_of(rows)
        if repeatability and terms is None:
            scatter = self.catalogue.repeatability_mm2(places, self.sizes)
            covariance = covariance + _scattered(scatter, functional)
        return Normal(rows @ state.mean, covariance)

    def covariance_of(self, rows: Array) -> Array:
        """Returns the covariance (n, n) of functionals of the coefficients, (n, m)."""
        followed = _followed(rows)
        rows = rows[:, followed]
        return np.asarray(rows @ self.covariance[np.ix_(followed, followed)] @ rows.T)

    def at(self, places: Places) -> "State":
        """Returns the state with coefficients for all that the places refer to, random walks at the places' clocks."""
        variances, blocks, clocks = list[Array](), dict(self.blocks), dict(self.clocks)
        moved, count = np.zeros(len(self.mean)), len(self.mean)
        for term in self.catalogue.terms:
            for key, now in _keys(term, places).items():
                step = None if term.step is None else term.step(self.sizes) ** 2
                if key in self.blocks:
                    if step is not None and now > clocks[key]:
                        moved[self.blocks[key]] += step * (now - clocks[key])
                        clocks[key] = now
                    continue
                variances.append(term.spread(self.sizes) ** 2)
                if step is not None:
                    clocks[key] = now
                blocks[key] = slice(count, count + len(variances[-1]))
                count = blocks[key].stop
        if count == len(self.mean) and not np.any(moved):
            return self
        covariance = np.zeros((count, count))
        old = len(self.mean)
        covariance[:old, :old] = self.covariance
        covariance[np.diag_indices(count)] += np.concatenate([moved, *variances])
        mean = np.concatenate([self.mean, np.zeros(count - old)])
        return replace(self, mean=mean, covariance=covariance, blocks=blocks, clocks=clocks)

    def expecting(self, places: Places) -> "State":
        """Returns the state with the coefficients of places that it is asked for: those with heavy tails of which
        nothing was measured have the variance of Student's distribution, ν/(ν − 2) times the square of its scale.
        """
        state = self.at(places)
        unseen = [(at, tail) for key, at, tail in state._unobserved_heavy() if key not in self.blocks]
        return state._scaled([at for at, _ in unseen], np.array([tail / (tail - 2.0) for _, tail in unseen]))

    def design(self, places: Places, terms: Collection[str] | None = None) -> Array:
        """Returns the matrix by which errors at places, all known to the state, follow the coefficients, (N, m)."""
        rows = np.zeros((len(places), len(self.mean)))
        for term in self.catalogue.terms:
            if terms is not None and term.name not in terms:
                continue
            values = term.basis(places)
            for label, mine in places.groups(term.scope).items():
                rows[mine, self.blocks[term.name, *label]] = values[mine]
        return rows

    def _unobserved_heavy(self) -> list[tuple[Key, slice, float]]:
        """Coefficients with heavy tails that no value has followed yet, so that they are independent of all others:
        where they are, their tails. Those of a finish cut come with the cut before, which does not show them.
        """
        tails = {term.name: term.tail for term in self.catalogue.terms}
        heavy = ((key, where, tails[key[0]]) for key, where in self.blocks.items())
        return [
            (key, where, tail)
            for key, where, tail in heavy
            if tail is not None and np.count_nonzero(self.covariance[where]) <= where.stop - where.start
        ]

    def _scaled(self, blocks: Sequence[slice], scales: Array) -> "State":
        """Returns the state with other variances of coefficients that are independent of all others."""
        if not blocks:
            return self
        covariance = self.covariance.copy()
        for where, scale in zip(blocks, scales, strict=True):
            covariance[where, where] *= scale
        return replace(self, covariance=covariance)

    def _after(self, gain: Array, off: Array, weighted: Weighted, scaled: Sequence[slice]) -> "State":
        """Returns the state given values that follow the coefficients with the covariance `gain` (n, m), before
        those in `scaled`, each independent of all others, have the variances of `weighted`.
        """
        more = np.zeros(len(self.mean))
        for where, scale in zip(scaled, weighted.scales, strict=True):
            gain[:, where] *= scale
            more[where] = (scale - 1.0) * np.diag(self.covariance)[where]
        drawn = solve_triangular(weighted.factor, gain, lower=True, check_finite=False)
        mean = self.mean + drawn.T @ solve_triangular(weighted.factor, off, lower=True, check_finite=False)
        covariance = drawn.T @ drawn
        np.subtract(self.covariance, covariance, out=covariance)
        covariance[np.diag_indices(len(more))] += more
        return replace(self, mean=mean, covariance=covariance)


def _followed(rows: Array) -> NDArray[np.intp]:
    """Returns which of the coefficients rows follow, (k,): some hundred, and none of other part types and edges."""
    return np.flatnonzero(np.any(rows, axis=0))


def _scattered(variance: Array, functional: Array | None) -> Array:
    """Returns the covariance (n, n) of functionals (n, N) of N independent values of these variances."""
    return np.diag(variance) if functional is None else np.asarray((functional * variance) @ functional.T)


def _keys(term: Term, places: Places) -> dict[Key, float]:
    """Blocks that places are of, in their order, each with the latest time of the term's clock."""
    if term.step is None:
        return {(term.name, *label): 0.0 for label in places.groups(term.scope)}
    times = places.number(term.clock)
    return {(term.name, *label): float(np.max(times[mine])) for label, mine in places.groups(term.scope).items()}
