"""The residuals of a machine's model on parts: ERROR_MTG,RESID at gauging points of many parts [6876 §3.5]."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array, Flags, Integers, by_content
from trueloop.errors import Code
from trueloop.machine.model.chain import ErrorName
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Term

PLACES = 5
LEAST = 0.05
"""µm or µrad: what changed by less everywhere is not listed."""


@dataclass(frozen=True)
class Change:
    """One axis error at a position (NaN: none) and signals, before, after and u; mm or rad, `shown` in µm or µrad."""

    error: ErrorName
    at: float
    signals: dict[str, float]
    old: float
    new: float
    u: float

    @property
    def change(self) -> float:
        """Returns new less old, mm or rad."""
        return self.new - self.old


def changes(old: MachineModel, new: MachineModel) -> tuple[Change, ...]:
    """Returns every changed error at five places of its range, at the least and greatest temperatures."""
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
            yield Change(
                error=term.name, at=place, signals=signals, old=float(was[k]), new=float(values[k]), u=float(u[k])
            )


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


PLACE_DECIMALS = 3
"""Points of two parts are the same place where positions, tool and normal agree to so many decimals."""
LEAST_PARTS = 3


@by_content
@dataclass(frozen=True)
class LeftOnParts:
    """n gauging points of many parts: `residual_mm` (n,) along outward normals (n, 3), positive where material is left.

    The parts were cut with COMP_MTG = −E of the model in force, so that residual = n · (E − E_model) + set-up + noise.
    `part` (n,) numbers the parts, `part_type` (n,) their types; `state` is the machine at each point
    where it erred so: while probing, where touches and CMM differ.
    `u_mm` is the standard uncertainty of one residual, `weight` (n,) or a number in (0, 1] how much each counts.
    """

    part: Integers
    part_type: Integers
    normal: Array
    state: State
    residual_mm: Array
    u_mm: float = 0.001
    weight: Array | float = 1.0

    def __len__(self) -> int:
        return len(self.residual_mm)

    @property
    def weights(self) -> Array:
        """Returns one weight a point, (n,)."""
        return np.broadcast_to(np.asarray(self.weight, np.float64), self.residual_mm.shape)

    @property
    def parts(self) -> Integers:
        """Returns the parts' numbers, each once."""
        return np.unique(self.part)

    def only(self, kept: Flags) -> "LeftOnParts":
        """Returns some of the points."""
        state, n = self.state, len(self)

        def chosen(value: Array | float) -> Array | float:
            values = np.asarray(value, np.float64)
            return values[kept] if values.shape[:1] == (n,) else values

        tool = np.asarray(state.tool_mm, np.float64)
        kept_state = replace(
            state,
            positions=state.positions[kept],
            travel=chosen(state.travel),
            signals={name: chosen(value) for name, value in state.signals.items()},
            tool_mm=tool[kept] if tool.ndim == 2 else tool,
        )
        return replace(
            self,
            part=self.part[kept],
            part_type=self.part_type[kept],
            normal=self.normal[kept],
            state=kept_state,
            residual_mm=self.residual_mm[kept],
            weight=self.weights[kept],
        )

    def set_ups(self) -> Array:
        """Returns the effect along the normals of a part set up elsewhere, (n, k): a column a part and direction."""
        numbers, place = np.unique(self.part, return_inverse=True)
        rows = np.zeros((len(self), len(numbers), 3))
        rows[np.arange(len(self)), place] = self.normal
        flat = rows.reshape(len(self), -1)
        return flat[:, np.any(flat != 0.0, axis=0)]

    def places(self) -> Array:
        """Returns which points are the same place of the machine, (n, k): a column a place; none where few repeat."""
        tool = np.broadcast_to(np.asarray(self.state.tool_mm, np.float64), (len(self), 3))
        where = np.round(np.hstack([self.state.positions, tool, self.normal]), PLACE_DECIMALS)
        _, place = np.unique(where, axis=0, return_inverse=True)
        count = int(place.max()) + 1
        if 2 * count > len(self):
            return np.zeros((len(self), 0))
        return np.asarray(place.reshape(-1, 1) == np.arange(count), np.float64)


def require_usable(seen: LeftOnParts) -> None:
    """Refuses points that do not belong together (MCH-SHAPE) and too few parts (DIA-FEW)."""
    counts = [len(a) for a in (seen.part, seen.part_type, seen.normal, seen.state.positions, seen.residual_mm)]
    numbers = np.hstack([seen.residual_mm, seen.normal.ravel(), seen.weights, seen.u_mm])
    if len(set(counts)) != 1 or not np.isfinite(numbers).all() or seen.u_mm <= 0 or (seen.weights < 0).any():
        raise Code.MCH_SHAPE.refusal(
            f"parts, types, normals, positions and residuals number {counts}; {np.isnan(numbers).sum()} are no numbers",
            hint="give each gauging point once in each, finite, with a positive uncertainty",
            values={"counts": counts},
        )
    if len(seen.parts) < LEAST_PARTS:
        raise Code.DIA_FEW.refusal(
            f"{len(seen.parts)} parts were inspected on the machine and on the CMM, {LEAST_PARTS} are needed to refine",
            hint="keep both inspections of more parts with `trueloop machine decompose --serial`",
            values={"count": len(seen.parts), "needed": LEAST_PARTS},
        )
