"""By how much a refined model differs from its parent: each axis error at places along its axis and temperatures."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.names import ErrorName
from trueloop.machine.model.term import Term

PLACES = 5
LEAST = 0.05
"""µm or µrad: what changed by less everywhere is not listed."""


@dataclass(frozen=True)
class Change:
    """One axis error at one position of its axis (NaN: it has none) and at signals: old and new value and the new u.

    Values are in mm or rad; `shown` says them in µm or µrad.
    """

    error: ErrorName
    at: float
    signals: dict[str, float]
    old: float
    new: float
    u: float

    @property
    def change(self) -> float:
        """New less old, mm or rad."""
        return self.new - self.old


def changes(old: MachineModel, new: MachineModel) -> tuple[Change, ...]:
    """Every error that changed, at five places over what is known of its axis, at the least and greatest temperature
    of the signals that it follows, all of them together.
    """
    found = []
    for term, where in zip(new.terms, new.slices(), strict=True):
        rows = list(_of_term(old, new, term, where))
        if max((abs(row.change) for row in rows), default=0.0) * 1e3 ** (2 if term.name.is_rotation else 1) >= LEAST:
            found += rows
    return tuple(found)


def _of_term(old: MachineModel, new: MachineModel, term: Term, where: slice) -> Iterator[Change]:
    before = next((t for t in zip(old.terms, old.slices(), strict=True) if t[0].name == term.name), None)
    covariance = new.covariance[where, where]
    at = _places(new, term)
    for signals in _temperatures(new, term):
        rows = _rows(term, at, signals)
        u = np.sqrt(np.maximum(np.einsum("nj,jk,nk->n", rows, covariance, rows), 0.0))
        values = rows @ new.coefficients[where]
        was = np.zeros(len(at)) if before is None else _rows(before[0], at, signals) @ old.coefficients[before[1]]
        for k, place in enumerate(at.tolist()):
            yield Change(term.name, place, signals, float(was[k]), float(values[k]), float(u[k]))


def _rows(term: Term, at: Array, signals: dict[str, float]) -> Array:
    position = np.nan_to_num(at)
    rows: Array = np.broadcast_to(term.design(position, np.zeros(len(at)), signals), (len(at), term.size))
    return rows


def _places(model: MachineModel, term: Term) -> Array:
    axis = term.name.axis
    if term.name.place or axis not in model.machine.chain.order or all(part.basis.size == 1 for part in term.parts):
        return np.array([np.nan])
    low, high = model.identified.get(axis, model.machine.chain.axis(axis).travel)
    return np.linspace(low, high, PLACES) if np.isfinite([low, high]).all() and high > low else np.array([low])


def _temperatures(model: MachineModel, term: Term) -> Iterator[dict[str, float]]:
    needed = term.needs()
    if not needed:
        yield {}
        return
    for end in (0, 1):
        yield {name: float(model.identified[name][end]) for name in needed}
