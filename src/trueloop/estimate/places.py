"""Places of cuts: where an error is, of which edge, type, part and cut; measured values are linear in the errors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trueloop.arrays import Array, by_content


@by_content
@dataclass(frozen=True)
class Places:
    """Columns of n values each, by name: whatever the terms of a catalogue use.

    Those of a turned part are listed in `catalogue`. Labels (edge, part, feature group) are arrays of text or whole
    numbers, all other columns of floating-point numbers.
    """

    columns: Mapping[str, NDArray[Any]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def number(self, name: str) -> Array:
        """Returns a column of numbers, (n,)."""
        return np.asarray(self.columns[name], dtype=np.float64)

    def labels(self, names: Sequence[str]) -> list[tuple[Any, ...]]:
        """Returns the values of some columns, one tuple per place."""
        if not names:
            return [()] * len(self)
        return list(zip(*(self.columns[name].tolist() for name in names), strict=True))

    def groups(self, names: Sequence[str]) -> dict[tuple[Any, ...], NDArray[np.intp]]:
        """Returns the positions of the places that agree in some columns by the values of these, first met first.

        They are computed once for each set of columns: every term of a scope takes the same.
        """
        key = tuple(names)
        if key not in self._groups:
            self._groups[key] = self._grouped(key)
        return self._groups[key]

    @cached_property
    def _groups(self) -> dict[tuple[str, ...], dict[tuple[Any, ...], NDArray[np.intp]]]:
        return {}

    def _grouped(self, names: Sequence[str]) -> dict[tuple[Any, ...], NDArray[np.intp]]:
        code = np.zeros(len(self), dtype=np.intp)
        for name in names:
            own = _numbered(self.columns[name])
            code = code * (int(np.max(own, initial=0)) + 1) + own
        _, first, of_place = np.unique(code, return_index=True, return_inverse=True)
        labels = self.chosen(np.sort(first)).labels(names)
        return {one: np.flatnonzero(of_place == k) for one, k in zip(labels, np.argsort(first), strict=True)}

    def chosen(self, rows: ArrayLike) -> "Places":
        """Returns some of the places, by position."""
        at = np.asarray(rows)
        return Places({name: column[at] for name, column in self.columns.items()})


def joined(parts: Sequence[Places]) -> Places:
    """Places one after the other; all with the same columns."""
    return Places({name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns})


def _numbered(column: NDArray[Any]) -> NDArray[np.intp]:
    """Returns a number for each value of a column, the same for values that are equal, (n,)."""
    if column.dtype != object:
        return np.asarray(np.unique(column, return_inverse=True)[1], dtype=np.intp)
    values = column.tolist()
    number = {value: k for k, value in enumerate(dict.fromkeys(values))}
    return np.array([number[value] for value in values], dtype=np.intp)


@by_content
@dataclass(frozen=True)
class Observed:
    """n values y = H·e(places) + noise, mm, of N places.

    `functional` is H (n, N); None: one value a place. `standard_u_mm` (n,) is that of the instrument, what a cut
    scatters from place to place not included. `correlated_mm2` (n, n) is what the instrument's errors have in common,
    their diagonal included; None: nothing. All values are of one part.
    """

    places: Places
    value_mm: Array
    standard_u_mm: Array
    functional: Array | None = None
    correlated_mm2: Array | None = None

    def __len__(self) -> int:
        return len(self.value_mm)

    @property
    def matrix(self) -> Array:
        """Returns H, (n, N)."""
        return np.eye(len(self.places)) if self.functional is None else self.functional

    def of(self, at_places: Array) -> Array:
        """Returns H times a quantity given at the places, (N, …)."""
        return at_places if self.functional is None else np.asarray(self.functional @ at_places)

    @property
    def instrument_mm2(self) -> Array:
        """Returns the covariance of the instrument's errors, (n, n)."""
        own = np.diag(self.standard_u_mm**2)
        return own if self.correlated_mm2 is None else own + self.correlated_mm2


def together(parts: Sequence[Observed]) -> Observed:
    """Observations whose instruments have nothing in common as one."""
    functional = correlated = None
    if any(part.functional is not None for part in parts):
        functional = _diagonal([part.matrix for part in parts])
    if any(part.correlated_mm2 is not None for part in parts):
        correlated = _diagonal(
            [np.zeros((len(part), len(part))) if part.correlated_mm2 is None else part.correlated_mm2 for part in parts]
        )
    return Observed(
        joined([part.places for part in parts]),
        np.concatenate([part.value_mm for part in parts]),
        np.concatenate([part.standard_u_mm for part in parts]),
        functional,
        correlated,
    )


def _diagonal(blocks: Sequence[Array]) -> Array:
    rows, columns = (np.cumsum([0, *(block.shape[k] for block in blocks)]) for k in (0, 1))
    whole = np.zeros((rows[-1], columns[-1]))
    for k, block in enumerate(blocks):
        whole[rows[k] : rows[k + 1], columns[k] : columns[k + 1]] = block
    return whole
