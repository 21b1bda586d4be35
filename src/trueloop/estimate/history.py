"""The state after parts that are all known beforehand: exact, in as few coefficients as their values follow.

Part after part with all coefficients (`State.given`) takes ten times as long for the same numbers:

- Values of a part type follow as many combinations of its coefficients as it has places, not all coefficients. In units
  of their deviations beforehand these are x = S q, and values H S q. Combinations at right angles to the rows of H S
  stay as they were believed, independent of all others: they are added at the end.
- Coefficients of one part are covariance of its own values, and never in the state.
- All cuts of a part are taken in at once: their weights follow one after the other from the factor of the covariance.
- A part type that the next part is not of leaves the state with what it has shown of the others.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas, qr, solve_triangular

from trueloop.arrays import Array
from trueloop.estimate.catalogue import PART, Catalogue, Sizes, Term
from trueloop.estimate.places import Observed, joined, together
from trueloop.estimate.state import Key, State
from trueloop.estimate.weights import Heavy, more_noise, weighted

ROUNDING: Final = 1e-14
"""Combinations that values follow by less than this share of the one they follow most."""


@dataclass(frozen=True, eq=False)
class Taken:
    """An observation as it was taken in: how probably each value is a gross error, the variance of its noise if it is
    none, what all terms leave of it, (n,) each; `scales` as in `state.Updated`.
    """

    gross: Array
    noise_mm2: Array
    left_mm: Array
    scales: Mapping[Key, float]


@dataclass(frozen=True, eq=False)
class History:
    """The state after all parts, without what is of single ones, and the observations of each."""

    state: State
    taken: tuple[tuple[Taken, ...], ...]


def after_parts(
    catalogue: Catalogue,
    sizes: Sizes,
    parts: Sequence[Sequence[Observed]],
    kept: Mapping[str, Collection[Any]] = MappingProxyType({}),
) -> History:
    """Returns what `State.given` comes to with one observation after the other; those of a part are all at one time.

    `kept`: of terms whose scope begins with this column only those of these labels stay in the state.
    """
    wholes = [together(part) for part in parts if part]
    if not wholes:
        return History(State.before(catalogue, sizes), tuple(() for _ in parts))
    going = _Going(catalogue, sizes, wholes)
    taken = iter([going.take(k, part) for k, part in enumerate(part for part in parts if part)])
    return History(going.state(kept), tuple(next(taken) if part else () for part in parts))


@dataclass(frozen=True, eq=False)
class Group:
    """Coefficients of all terms of one label, (m,), and the places that follow them by `design`, part after part.

    `keys` has the place of each block among them; the first `single` of them stay as they are in the state: they walk,
    or have heavy tails. `times` has the latest time of each part for those that walk, `spread` (m,) is what they
    scatter by beforehand. Places `bounds[k]` to `bounds[k + 1]` of `rows` are of part k, whose first is `starts[k]`.
    """

    column: str
    label: tuple[Any, ...]
    rows: NDArray[np.intp]
    starts: NDArray[np.intp]
    bounds: NDArray[np.intp]
    terms: Mapping[Key, Term]
    keys: Mapping[Key, slice]
    times: Mapping[Key, Array]
    single: int
    spread: Array
    design: Array

    @property
    def parts(self) -> list[int]:
        """Returns which parts its places are of."""
        return np.flatnonzero(np.diff(self.bounds)).tolist()

    @property
    def heavy(self) -> dict[Key, float]:
        """Returns the tails of the blocks that have heavy ones."""
        return {key: term.tail for key, term in self.terms.items() if term.tail is not None}

    def shown(self, k: int, observed: Observed) -> Array:
        """Returns the matrix by which the values of part k follow the coefficients, (n, m)."""
        first, end = self.bounds[k : k + 2]
        design, at = self.design[first:end], self.rows[first:end] - self.starts[k]
        if observed.functional is not None:
            return np.asarray(observed.functional[:, at] @ design)
        every = np.zeros((len(observed), design.shape[1]))
        every[at] = design
        return every


def groups_of(catalogue: Catalogue, sizes: Sizes, wholes: Sequence[Observed]) -> list[Group]:
    """Returns the groups in the order in which parts come to them."""
    places = joined([whole.places for whole in wholes])
    starts = np.cumsum([0, *(len(whole.places) for whole in wholes)])
    found: dict[tuple[str, Any], dict[Key, tuple[Term, NDArray[np.intp]]]] = {}
    for term in sorted(catalogue.terms, key=lambda term: term.step is None and term.tail is None):
        at = term.scope.index(PART) if term.of_part else 0
        for label, rows in places.groups(term.scope).items():
            of = (term.scope[at], label[at]) if label else ("", None)
            found.setdefault(of, {})[term.name, *label] = (term, rows)
    values, groups = {term.name: term.basis(places) for term in catalogue.terms}, list[Group]()
    for (column, name), blocks in found.items():
        rows = places.groups((column,))[name,] if column else np.arange(len(places))
        spreads = [term.spread(sizes) for term, _ in blocks.values()]
        ends = np.cumsum([0, *map(len, spreads)]).tolist()
        keys = {key: slice(start, end) for key, start, end in zip(blocks, ends, ends[1:], strict=False)}
        design = np.zeros((len(rows), ends[-1]))
        for key, (term, mine) in blocks.items():
            design[np.searchsorted(rows, mine), keys[key]] = values[term.name][mine]
        groups.append(
            Group(
                column=column,
                label=name,
                rows=rows,
                starts=starts,
                bounds=np.searchsorted(rows, starts),
                terms={key: term for key, (term, _) in blocks.items()},
                keys=keys,
                times={
                    key: _latest(
                        places.number(term.clock)[mine], np.searchsorted(starts, mine, "right") - 1, len(wholes)
                    )
                    for key, (term, mine) in blocks.items()
                    if term.step is not None
                },
                single=ends[sum(term.step is not None or term.tail is not None for term, _ in blocks.values())],
                spread=np.concatenate(spreads),
                design=design,
            )
        )
    return sorted(groups, key=lambda group: int(group.rows[0]))


def _latest(times: Array, part: NDArray[np.intp], parts: int) -> Array:
    """Returns the latest time of each part, (parts,)."""
    latest = np.full(parts, -np.inf)
    np.maximum.at(latest, part, times)
    return latest


@dataclass(frozen=True, eq=False)
class _Lasting:
    """A group in the state, at `where`: its single coefficients, then the combinations `followed` (m − single, k) of
    the others. `shown` are the matrices by which the values of its parts follow these.
    """

    group: Group
    where: slice
    followed: Array
    shown: Mapping[int, Array]

    @classmethod
    def of(cls, group: Group, start: int, wholes: Sequence[Observed]) -> "_Lasting":
        """Returns the group with its first coefficient at `start`."""
        single = group.single
        shown = {k: group.shown(k, wholes[k]) for k in group.parts}
        scaled = np.vstack([one[:, single:] for one in shown.values()]) * group.spread[single:]
        followed = _row_space(scaled)
        ahead = group.spread[single:, None] * followed
        stop = start + single + followed.shape[1]
        reduced = {k: np.hstack([one[:, :single], one[:, single:] @ ahead]) for k, one in shown.items()}
        return cls(group, slice(start, stop), followed, reduced)

    @property
    def variance(self) -> Array:
        """Returns the variances of its coefficients beforehand."""
        group, count = self.group, self.followed.shape[1]
        return np.concatenate([group.spread[: group.single] ** 2, np.ones(count)])

    def at(self, key: Key) -> slice:
        """Returns the place of a block of single coefficients in the state."""
        block = self.group.keys[key]
        return slice(self.where.start + block.start, self.where.start + block.stop)


def _row_space(rows: Array) -> Array:
    """Returns an orthonormal basis of the space of rows (n, m), (m, k)."""
    if not rows.size:
        return np.zeros((rows.shape[1], 0))
    basis, factor, _ = qr(rows.T, mode="economic", pivoting=True, check_finite=False)
    size = np.abs(np.diag(factor))
    return np.asarray(basis[:, : np.count_nonzero(size > ROUNDING * size[0])])


class _Going:
    """The state from part to part, from the beginning with the coefficients of all groups."""

    def __init__(self, catalogue: Catalogue, sizes: Sizes, wholes: Sequence[Observed]) -> None:
        self._before, self._wholes = State.before(catalogue, sizes), wholes
        self._own, self._lasting = [list[Group]() for _ in wholes], list[_Lasting]()
        for group in groups_of(catalogue, sizes, wholes):
            if group.column == PART:
                for k in group.parts:
                    self._own[k].append(group)
            else:
                start = self._lasting[-1].where.stop if self._lasting else 0
                self._lasting.append(_Lasting.of(group, start, wholes))
        variance = np.concatenate([np.zeros(0), *(lasting.variance for lasting in self._lasting)])
        self._mean, self._covariance = np.zeros(len(variance)), np.diag(variance)
        self._clocks, self._observed = dict[Key, float](), set[Key]()

    def take(self, k: int, cuts: Sequence[Observed]) -> tuple[Taken, ...]:
        """Takes in all observations of part k, the next."""
        whole, lasting = self._wholes[k], [one for one in self._lasting if k in one.shown]
        own = [(group, group.shown(k, whole)) for group in self._own[k]]
        for one in lasting:
            self._walk(one, k)
        at = np.concatenate([np.arange(one.where.start, one.where.stop) for one in lasting])
        rows, noise = np.hstack([one.shown[k] for one in lasting]), self._before.noise_mm2(whole)
        gain = rows @ self._covariance[at]
        covariance, off = gain[:, at] @ rows.T + noise, whole.value_mm - rows @ self._mean[at]
        for group, shown in own:
            covariance += (shown * group.spread**2) @ shown.T
        heavy = [*_heavy_of(own), *self._heavy_in_state(k, lasting)]
        factor, solved, taken, start = np.zeros_like(covariance), np.zeros_like(off), list[Taken](), 0
        for cut in cuts:
            before, now = slice(0, start), slice(start, start + len(cut))
            start = now.stop
            factor[now, before] = _solved(factor[before, before], covariance[before, now]).T
            rest = covariance[now, now] - factor[now, before] @ factor[now, before].T
            differs = off[now] - factor[now, before] @ solved[before]
            first = [it for it in heavy if it.key not in self._observed and np.any(it.heavy.design[now])]
            tails = [replace(it.heavy, design=it.heavy.design[now]) for it in first]
            good_mm2 = np.diag(noise)[now]
            found = weighted(rest, good_mm2, differs, self._before.catalogue, tails)
            factor[now, now], solved[now] = found.factor, _solved(found.factor, differs)
            scales = dict(zip((it.key for it in first), found.scales.tolist(), strict=True))
            for it in first:
                design, more = it.heavy.design, (scales[it.key] - 1.0) * it.heavy.variance
                covariance += (design * more) @ design.T
                if it.where is not None:
                    self._covariance[it.where, it.where] *= scales[it.key]
                    gain[:, it.where] *= scales[it.key]
            self._observed |= scales.keys()
            with_gross = noise[now, now] + np.diag(more_noise(good_mm2, found.gross, self._before.catalogue))
            left = with_gross @ solve_triangular(found.factor, solved[now], lower=True, trans=1, check_finite=False)
            taken.append(Taken(found.gross, good_mm2, left, scales))
        drawn = _solved(factor, gain)
        self._mean += drawn.T @ solved
        # in place: half of the time of a product and a difference
        blas.dgemm(-1.0, drawn.T, drawn.T, 1.0, self._covariance.T, trans_b=True, overwrite_c=True)
        return tuple(taken)

    def _walk(self, lasting: _Lasting, k: int) -> None:
        """Moves random walks to the time of part k."""
        for key, times in lasting.group.times.items():
            term, now = lasting.group.terms[key], float(times[k])
            since = self._clocks.setdefault(key, now)
            if now > since and term.step is not None:
                at = np.arange(lasting.at(key).start, lasting.at(key).stop)
                self._covariance[at, at] += term.step(self._before.sizes) ** 2 * (now - since)
                self._clocks[key] = now

    def _heavy_in_state(self, k: int, lasting: Sequence[_Lasting]) -> Iterator["_Displaced"]:
        variance = np.diag(self._covariance)
        for one in lasting:
            for key, tail in one.group.heavy.items():
                if key not in self._observed:
                    where, columns = one.at(key), one.group.keys[key]
                    yield _Displaced(key, Heavy(one.shown[k][:, columns], variance[where].copy(), tail), where)

    def state(self, kept: Mapping[str, Collection[Any]]) -> State:
        """Returns the state of all coefficients, those of the labels that are `kept`."""
        every = [
            lasting
            for lasting in self._lasting
            if lasting.group.label in kept.get(lasting.group.column, [lasting.group.label])
        ]
        sizes, blocks, count = [len(lasting.group.spread) for lasting in every], dict[Key, slice](), 0
        at = np.concatenate(
            [np.zeros(0, np.intp), *(np.arange(lasting.where.start, lasting.where.stop) for lasting in every)]
        )
        spread, left = np.zeros((sum(sizes), len(at))), np.zeros((sum(sizes), sum(sizes)))
        column = 0
        for lasting, size in zip(every, sizes, strict=True):
            single, rest = lasting.group.single, slice(count + lasting.group.single, count + size)
            spread[count : rest.start, column : column + single] = np.eye(single)
            column += single
            own = lasting.group.spread[single:, None]
            spread[rest, column : column + lasting.followed.shape[1]] = own * lasting.followed
            column += lasting.followed.shape[1]
            left[rest, rest] = own * (np.eye(len(own)) - lasting.followed @ lasting.followed.T) * own.T
            blocks |= {key: slice(count + of.start, count + of.stop) for key, of in lasting.group.keys.items()}
            count += size
        return State(
            catalogue=self._before.catalogue,
            sizes=self._before.sizes,
            mean=spread @ self._mean[at],
            covariance=spread @ self._covariance[np.ix_(at, at)] @ spread.T + left,
            blocks=blocks,
            clocks={key: time for key, time in self._clocks.items() if key in blocks},
        )


@dataclass(frozen=True, eq=False)
class _Displaced:
    """A block with heavy tails that a part may show, and where it is in the state; None: of the part alone."""

    key: Key
    heavy: Heavy
    where: slice | None


def _heavy_of(own: Sequence[tuple[Group, Array]]) -> Iterator[_Displaced]:
    for group, shown in own:
        for key, tail in group.heavy.items():
            columns = group.keys[key]
            yield _Displaced(key, Heavy(shown[:, columns], group.spread[columns] ** 2, tail), None)


def _solved(factor: Array, values: Array) -> Array:
    solved: Array = solve_triangular(factor, values, lower=True, check_finite=False) if len(factor) else values
    return np.ascontiguousarray(solved)
