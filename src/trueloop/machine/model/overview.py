"""A model at a glance: each error's range over its axis' travel, in µm and µrad, and how well it is known."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import Signals, Term
from trueloop.units import UM_PER_MM, URAD_PER_RAD

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
    return TermCurve(str(term.name), term.name.unit, position, forward, reverse, u)
