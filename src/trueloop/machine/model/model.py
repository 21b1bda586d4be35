"""A machine model: the machine, its error terms and their coefficients. Answers E and COMP_MTG anywhere.

COMP_MTG = −E [conventions of 6876 §3.5, 4773 Eqs 1–2]: what is added to a commanded position.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.errors import Code
from trueloop.machine.model.chain import ZERO, Chain, ErrorName, Vector
from trueloop.machine.model.history import Lag, moved_along
from trueloop.machine.model.kinematics import influences
from trueloop.machine.model.term import Signals, Term
from trueloop.units import UM_PER_MM, URAD_PER_RAD


@dataclass(frozen=True)
class Acceptance:
    """The acceptance of a version: by whom, when (ISO 8601, UTC), and why."""

    who: str
    at: str
    why: str = ""


@dataclass(frozen=True)
class Version:
    """Version `number`, counted from the fitted model, which is 0 and says nothing of versions.

    `parent_sha256` is the hash of the file it was refined from, `errors` are the axis errors whose coefficients
    were guilty, `reason` is why in words, `judged` the result on parts left out. `made_at` is ISO 8601, UTC.
    """

    number: int
    parent_sha256: str
    errors: tuple[str, ...]
    reason: str
    judged: str
    made_at: str
    made_by: str = ""
    accepted: Acceptance | None = None


@dataclass(frozen=True)
class Machine:
    """One machine: `name` and `serial` distinguish it from its sisters; the chain describes its motions."""

    name: str
    chain: Chain
    serial: str = ""


@dataclass(frozen=True)
class State:
    """The state of the machine: positions (n, axes) in `chain.order`, travel (+1, −1, 0 unknown) alike, signals by
    name.

    `tool_mm` is the tool point from the frame of the last axis that carries the tool, (3,) or (n, 3).
    """

    positions: Array
    travel: Array | float = 0.0
    signals: Signals = field(default_factory=dict)
    tool_mm: Array | Vector = ZERO


@by_content
@dataclass(frozen=True)
class MachineModel:
    """`coefficients` stand in the order of `terms`; `covariance` is theirs, mm² and rad², and that of ln τ of `lags`.

    `identified` holds the range of every axis and signal in the data: outside it the model is not known to hold.
    `lags` are signals made of the past of others (`history.py`); a state has to hold them like any other signal.
    `units` are those of the signals, where they are known. `version` is that of a refined model, which is in force only
    where it was accepted (`validity.require_in_force`); None: fitted from readings.
    """

    machine: Machine
    terms: tuple[Term, ...]
    coefficients: Array
    covariance: Array
    identified: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    lags: tuple[Lag, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    version: Version | None = None

    def slices(self) -> list[slice]:
        """Returns the slice of each term's coefficients."""
        ends = np.cumsum([term.size for term in self.terms])
        return [slice(int(end) - term.size, int(end)) for end, term in zip(ends, self.terms, strict=True)]

    def values(self, state: State) -> dict[ErrorName, Array]:
        """Returns every modelled axis error at each position, (n,), mm or rad."""
        rows = term_rows(self.machine.chain, self.terms, state)
        return {
            term.name: row @ self.coefficients[where]
            for term, row, where in zip(self.terms, rows, self.slices(), strict=True)
        }

    def error_mm(self, state: State) -> Array:
        """Returns E to first order, (n, 3), work coordinates: actual − commanded."""
        error: Array = design(self.machine.chain, self.terms, state) @ self.coefficients
        return error

    def comp_mtg_mm(self, state: State) -> Array:
        """Returns COMP_MTG = −E, (n, 3), to be added to the commanded position."""
        return -self.error_mm(state)

    def standard_u_mm(self, state: State) -> Array:
        """Returns the standard uncertainty of E by the coefficients' and, with slopes in `state`, the lags', (n, 3)."""
        rows = self.sensitivities(state)
        variance = np.einsum("nij,jk,nik->ni", rows, self.covariance, rows)
        root: Array = np.sqrt(np.maximum(variance, 0.0))
        return root

    def sensitivities(self, state: State) -> Array:
        """Returns DE by every coefficient and every ln τ, (n, 3, as `covariance`); by ln τ 0 where the state lacks the
        slope.

        E is linear in signals, so its slope by ln τ is its change when the lag moves by its own slope.
        """
        here, slopes = self.error_mm(state), np.zeros((len(state.positions), 3, len(self.lags)))
        for k, lag in enumerate(self.lags):
            slopes[:, :, k] = self.error_mm(replace(state, signals=moved_along(lag, state.signals))) - here
        return np.concatenate([design(self.machine.chain, self.terms, state), slopes], axis=2)

    def needs(self) -> tuple[str, ...]:
        """Signals without which the model cannot be evaluated."""
        return tuple(dict.fromkeys(signal for term in self.terms for signal in term.needs()))


def term_rows(chain: Chain, terms: tuple[Term, ...], state: State) -> list[Array]:
    """Returns the design of each term at the position and travel of its own axis: a list of (n, size)."""
    travel = np.broadcast_to(state.travel, state.positions.shape)
    rows = []
    for term in terms:
        if term.name.axis in chain.order:
            column = chain.order.index(term.name.axis)
            position, way = state.positions[:, column], travel[:, column]
        else:
            position = way = np.zeros(len(state.positions))
        rows.append(np.broadcast_to(term.design(position, way, state.signals), (len(state.positions), term.size)))
    return rows


def design(chain: Chain, terms: tuple[Term, ...], state: State, *, rotations: bool = False) -> Array:
    """Returns E (with `rotations` the tool's rotation, rad) as a linear map of all coefficients: (n, 3, all)."""
    columns = influences(chain, state.positions, state.tool_mm, {term.name for term in terms})
    blocks = []
    for term, rows in zip(terms, term_rows(chain, terms, state), strict=True):
        if term.name not in columns:
            possible = chain.errors()
            raise Code.MCH_AXIS.refusal(
                f"the machine cannot have {term.name}; it has {len(possible)} errors: {' '.join(map(str, possible))}",
                hint="check that the terms belong to this machine",
            )
        influence = columns[term.name].rotation if rotations else columns[term.name].displacement
        blocks.append(influence[:, :, None] * rows[:, None, :])
    return np.concatenate(blocks, axis=2)


POINTS = 101


@dataclass(frozen=True)
class TermCurve:
    """One error along its axis: `position` (m,) mm or rad; values and standard uncertainty (m,) in µm or µrad."""

    error: str
    unit: str
    position: Array
    forward: Array
    reverse: Array
    u: Array


@dataclass(frozen=True)
class TermRow:
    """A row of the overview as numbers."""

    error: str
    unit: str
    least: float
    most: float
    largest_u: float


def curves(model: MachineModel, signals: Signals) -> list[TermCurve]:
    """Returns every term over its axis' travel (or the range of its data), at the signals given.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> curve = trueloop.curves(found.model, {"T1": 25.0})[0]
    >>> print(f"{curve.error} at {curve.position[-1]:.0f} mm: {curve.forward[-1]:.1f} {curve.unit}")
    EXX at 500 mm: 20.0 µm
    """
    where = dict(zip(model.terms, model.slices(), strict=True))
    return [_curve(model, term, where[term], signals) for term in model.terms]


def overview(model: MachineModel, signals: Signals) -> list[TermRow]:
    """Returns every term's least and largest value. Raises MCH-SIGNAL for a signal that is not given.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> for row in trueloop.overview(found.model, {"T1": 25.0}):
    ...     print(f"{row.error} {row.least:.1f} to {row.most:.1f} {row.unit}")
    EXX 0.0 to 20.0 µm
    EYY -4.0 to 4.0 µm
    EZZ -2.6 to 0.0 µm
    EZ0S 7.3 to 7.3 µm
    """
    rows = []
    for curve in curves(model, signals):
        both = np.concatenate([curve.forward, curve.reverse])
        rows.append(TermRow(curve.error, curve.unit, float(both.min()), float(both.max()), float(curve.u.max())))
    return rows


def _curve(model: MachineModel, term: Term, where: slice, signals: Signals) -> TermCurve:
    axis = model.machine.chain.axis(term.name.axis)
    low, high = axis.travel if np.all(np.isfinite(axis.travel)) else model.identified.get(axis.name, (0.0, 0.0))
    position = np.linspace(low, high, POINTS)
    rows = [
        np.broadcast_to(term.design(position, np.full(POINTS, way), signals), (POINTS, term.size))
        for way in (1.0, -1.0)
    ]
    variance = np.einsum("ni,ij,nj->n", rows[0], model.covariance[where, where], rows[0])
    scale = URAD_PER_RAD if term.name.is_rotation else UM_PER_MM
    forward, reverse = scale * np.stack(rows) @ model.coefficients[where]
    u = scale * np.sqrt(np.maximum(variance, 0.0))
    return TermCurve(
        error=str(term.name), unit=term.name.unit, position=position, forward=forward, reverse=reverse, u=u
    )
