"""Suspected errors: an axis error or the nominal size, everywhere alike or following a temperature, time or travel.

[4773 Table 1] has an error follow the temperature of its own element; its other correlations "that should be tracked"
are here another element's temperature or any other signal, the order of the parts (time), the way of travel (lost
motion) and the nominal size of the part, which a part or a gauge away from 20 °C errs in proportion to.

What a suspect leaves along the normals, as columns that can be evaluated at other states too.

The influence of an axis error on the tool point at every gauging point (Table 1's δ, ε·Z_T, ε·X_T, ε·x follow from it,
for any chain) times a polynomial in the position of its axis, and the deviation of the signal that it follows from the
mean. Columns of one suspect are orthogonal over the points and of
size 1 (root mean square), so that what it leaves has one prior size whatever the units.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers, by_content
from trueloop.machine.model.chain import Chain, ErrorName
from trueloop.machine.model.kinematics import tool_in_work_mm
from trueloop.machine.model.model import State, design
from trueloop.machine.model.term import CONSTANT, Part, PositionBasis, Term


@by_content
@dataclass(frozen=True)
class Residuals:
    """ERROR_MTG,RESID at n gauging points of many parts: `residual_mm` (n,) along the outward normals (n, 3).

    Positive where material is left on [6876 §3.5]. `part` (n,) numbers the parts in the order in which they were cut.
    `state` is the machine in each point at which it erred so: positions (n, axes), tool, signals () or (n,), travel
    where it is known. What CMM and corrected touches differ by arose while probing: then `tool_mm` is the stylus.
    `element` names the signal that is the temperature of each axis' element, as
    {"X": "cross slide", "Z": "carriage", "C": "spindle"}.
    """

    part: Integers
    normal: Array
    state: State
    residual_mm: Array
    element: Mapping[str, str]


ORDER: Final = "order of the parts"
TRAVEL: Final = "way of travel"

STEADY: Final = 0.3
"""Share of the prior that an error is the same at all temperatures."""
MIXED: Final = 0.5
"""Share of an error that follows something that it has a steady part too."""
DEGREES: Final = (0.4, 0.4, 0.2)
"""Shares of what an error of motion is over travel: the same everywhere, a line, a parabola."""
LINE: Final = 1
OTHER: Final = 0.1
"""How probable other correlations are together, beside that with the temperature of the error's own element."""


@dataclass(frozen=True)
class NominalSize:
    """An error in proportion to the nominal coordinate of the part along a direction 0, 1, 2: no error of an axis."""

    number: int

    def __str__(self) -> str:
        return f"nominal {'XYZ'[self.number]}"


Wrong = ErrorName | NominalSize


@dataclass(frozen=True)
class Suspect:
    """`error` is wrong: at all temperatures alike if `steady`, and by what `follows` a signal if that is named.

    Both are polynomials of that `degree` in the axis' position, what follows a line at most.
    """

    error: Wrong
    follows: str = ""
    steady: bool = False
    degree: int = 0

    def __str__(self) -> str:
        return f"{self.error} with {self.follows}" if self.follows else f"{self.error}"

    @property
    def parts(self) -> tuple["Suspect", ...]:
        """Its two parts: a steady one, and one that follows."""
        alone = (Suspect(self.error, "", True, self.degree),) if self.steady else ()
        return (*alone, Suspect(self.error, self.follows, False, min(self.degree, LINE))) if self.follows else alone


def suspects(chain: Chain, residuals: Residuals) -> Iterator[tuple[Suspect, float]]:
    """All of them with their share of the prior; each error has 1, the nominal size along each direction less."""
    for name in chain.errors():
        linear = name.axis in chain.order
        if linear != name.place:
            yield from _of(name, residuals.element.get(name.axis, ""), residuals, linear)
    for number in range(3):
        yield Suspect(NominalSize(number), "", True), OTHER / 2
        yield Suspect(NominalSize(number), ORDER), OTHER / 2


def _of(name: ErrorName, own: str, residuals: Residuals, linear: bool) -> Iterator[tuple[Suspect, float]]:
    """Of one axis error; a place has no travel."""
    shapes = tuple(enumerate(DEGREES)) if linear else ((0, 1.0),)
    others = [*sorted(set(residuals.state.signals) - {own, ORDER}), ORDER, *([TRAVEL] if linear else [])]
    for degree, shape in shapes:
        yield Suspect(name, "", True, degree), STEADY * shape
    for signal in [*([own] if own else []), *others]:
        share = (1 - STEADY) * (1 - OTHER if signal == own else OTHER / len(others))
        for degree, shape in shapes:
            yield Suspect(name, signal, True, degree), share * shape * MIXED
            if degree <= LINE:
                yield Suspect(name, signal, False, degree), share * shape * (1 - MIXED)


ALIKE: Final = 0.01
"""A combination of columns this small beside the largest says nothing here: as positions that hardly differ."""
BEYOND_MM: Final = 50.0
"""How far positions may lie beyond those measured, at least, for the functions to go on as they are."""


@dataclass(frozen=True)
class Columns:
    """Columns of a suspect: raw functions (n, m) and the matrix (m, k) that makes them of size 1."""

    error: Wrong
    parts: tuple[Part, ...]
    both_ways: bool
    mixing: Array

    def rows(self, chain: Chain, state: State, normal: Array) -> Array:
        """(n, k), mm per mm of size, at points with these normals."""
        found: Array = raw(chain, self.error, self.parts, self.both_ways, state, normal) @ self.mixing
        return found


def columns(chain: Chain, suspect: Suspect, residuals: Residuals) -> Columns | None:
    """Of a suspect that is steady or follows something, not both; None where it would leave nothing that differs."""
    parts, both_ways = _functions(chain, suspect, residuals), suspect.follows == TRAVEL
    if not parts:
        return None
    first = np.array([[1.0], [-1.0]]) if both_ways else None
    rows = raw(chain, suspect.error, parts, both_ways, residuals.state, residuals.normal)
    mixed = rows if first is None else rows @ first
    _, strength, directions = np.linalg.svd(mixed, full_matrices=False)
    # Below 1e-9 of this a column is rounding: 1 mm for displacements, the arms' size for rotations
    reach = np.abs(tool_in_work_mm(chain, residuals.state.positions, residuals.state.tool_mm)).max()
    displacement = not isinstance(suspect.error, NominalSize) and not suspect.error.is_rotation
    scale = 1.0 if displacement else float(max(reach, 1.0))
    kept = strength > np.maximum(ALIKE * strength[0], 1e-9 * scale * np.sqrt(len(rows)))
    if not kept.any():
        return None
    unit = directions[kept].T / strength[kept] * np.sqrt(len(rows))
    return Columns(suspect.error, parts, both_ways, unit if first is None else first @ unit)


def raw(chain: Chain, error: Wrong, parts: tuple[Part, ...], both_ways: bool, state: State, normal: Array) -> Array:
    """N · what 1 mm or 1 rad of each function leaves, (n, m)."""
    if isinstance(error, NominalSize):
        place = tool_in_work_mm(chain, state.positions, state.tool_mm)[:, error.number]
        along = normal[:, error.number] * place
        factors = [np.broadcast_to(part.factor(state.signals), along.shape) for part in parts]
        return np.stack([along * factor for factor in factors], axis=1)
    rows = design(chain, (Term(error, parts, both_ways),), state)
    found: Array = np.einsum("ni,nik->nk", normal, rows)
    return found


def with_order(residuals: Residuals) -> Residuals:
    """With the order of the parts as a signal, counted from 0."""
    order = np.unique(residuals.part, return_inverse=True)[1].astype(np.float64)
    state = State(
        residuals.state.positions,
        residuals.state.travel,
        {**residuals.state.signals, ORDER: order},
        residuals.state.tool_mm,
    )
    return Residuals(residuals.part, residuals.normal, state, residuals.residual_mm, residuals.element)


def _functions(chain: Chain, suspect: Suspect, residuals: Residuals) -> tuple[Part, ...]:
    """Functions of position and signal; none of a signal or a travel that does not change."""
    if suspect.follows == TRAVEL and float(np.ptp(_travel(chain, suspect, residuals))) == 0.0:
        return ()
    if suspect.follows == TRAVEL:
        return (Part(CONSTANT),)
    if not suspect.follows:
        return (Part(_basis(chain, suspect, residuals)),)
    values = np.asarray(residuals.state.signals[suspect.follows], np.float64)
    if float(np.ptp(values)) == 0.0:
        return ()
    return (Part(_basis(chain, suspect, residuals), suspect.follows, float(values.mean())),)


def _basis(chain: Chain, suspect: Suspect, residuals: Residuals) -> PositionBasis:
    if isinstance(suspect.error, NominalSize) or not suspect.degree:
        return CONSTANT
    at = residuals.state.positions[:, chain.order.index(suspect.error.axis)]
    low, high = float(at.min()), float(at.max())
    margin = max(BEYOND_MM, high - low)
    return PositionBasis((low - margin, high + margin), suspect.degree)


def _travel(chain: Chain, suspect: Suspect, residuals: Residuals) -> Array:
    """Of the axis that errs."""
    assert not isinstance(suspect.error, NominalSize)
    ways: Array = np.broadcast_to(np.asarray(residuals.state.travel, np.float64), residuals.state.positions.shape)
    return ways[:, chain.order.index(suspect.error.axis)]
