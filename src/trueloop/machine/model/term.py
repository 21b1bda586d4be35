"""One error term: a sum of parts with adjustable parameters, as [4773] Eq. 3 and what generalises it.

    E(q, T) = Σ over parts  s(T) · f(q),   s = 1, or a signal minus its reference value

f is a function of the axis' position (`PositionBasis`). A signal is a temperature, the spindle speed, or one of them
after a first-order lag (`signals.py`). Eq. 3, δz(z) = A + B·T12 + C·z + D·z², is a quadratic part without signal and a
constant part with signal T12. Own parameters for forward and return travel model backlash.

Functions of one axis' position: splines over segments that join smoothly, polynomials and tables among them.

Segments of degree d join with d − 1 continuous derivatives [4773 §2.4: overlapping segments smoothly joined]. One
segment is a polynomial; degree 1 is a table with linear interpolation, as controls hold; degree 0 on one segment is a
constant. Coefficients are those of B-splines, so they have the unit of the error and the size of its values.

Structures in the letters of ISO 10791: from the work through the bed to the tool, as `w X b Y Z (C) t`.

Axes left of `b` carry the work, those right of it the tool; letters in brackets are spindles.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import Axis, AxisKind, Chain, ErrorName, error_name
from trueloop.wording import did_you_mean


@dataclass(frozen=True)
class PositionBasis:
    """`breaks` are the ends of the segments, ascending, in mm or rad. At positions `zero_at` every function vanishes.

    That takes away the shares of other errors: the constant of a positioning error (zero at the datum), and the
    straight line of a straightness error (zero at both ends of travel), which belongs to squareness.
    """

    breaks: tuple[float, ...]
    degree: int
    zero_at: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        ascending = len(self.breaks) > 1 and bool(np.all(np.diff(self.breaks) > 0))
        if not ascending or not np.all(np.isfinite(self.breaks)) or not 0 <= self.degree <= 5:
            raise Code.MCH_BASIS.refusal(
                f"segments ending at {list(self.breaks)} with degree {self.degree} make no function of position",
                hint="two ends at least, ascending, degree 0 to 5",
            )
        if self.degree == 0 and len(self.breaks) > 2:
            raise Code.MCH_BASIS.refusal(
                f"{len(self.breaks) - 1} segments of degree 0 would jump between them",
                hint="degree 1 joins segments; a constant has one segment",
            )

    @property
    def size(self) -> int:
        """Returns the number of coefficients."""
        return len(self.breaks) - 1 + self.degree

    @property
    def knots(self) -> Array:
        """Breaks with the ends repeated."""
        ends = [self.breaks[0]] * self.degree, [self.breaks[-1]] * self.degree
        return np.array([*ends[0], *self.breaks, *ends[1]])

    def design(self, position: Array) -> Array:
        """Values of the functions, (n, size). Beyond the breaks the value at the break holds."""
        from scipy.interpolate import BSpline

        inside = np.clip(position, self.breaks[0], self.breaks[-1])
        rows: Array = BSpline.design_matrix(inside, self.knots, self.degree).toarray()
        return rows

    def admissible(self) -> Array:
        """Returns orthonormal columns (size, free) that span the coefficients with a zero at each of `zero_at`."""
        if not self.zero_at:
            return np.eye(self.size)
        conditions = self.design(np.array(self.zero_at))
        whole = np.linalg.qr(conditions.T, mode="complete")[0]
        return whole[:, len(self.zero_at) :]


CONSTANT = PositionBasis((0.0, 1.0), 0)
"""The basis of values equal everywhere: errors of place, offsets, drift."""


def segments(low: float, high: float, count: int, degree: int, zero_at: tuple[float, ...] = ()) -> PositionBasis:
    """Returns a basis of `count` equal segments over the travel. Raises MCH-BASIS for a travel without end."""
    if not np.isfinite([low, high]).all():
        raise Code.MCH_BASIS.refusal(
            f"{count} equal segments over a travel from {low:g} to {high:g} have no ends",
            hint="give every axis of a term that varies along it its travel: [axes.X] with travel_mm or travel_deg",
        )
    return PositionBasis(tuple(float(p) for p in np.linspace(low, high, count + 1)), degree, zero_at)


Signals = Mapping[str, Array | float]
"""Values by signal name, () or (n,): °C, rev/min, or what the sensor gives."""


def means(signals: Signals) -> dict[str, float]:
    """Returns one value a signal: its mean, where it has several."""
    return {name: float(np.mean(value)) for name, value in signals.items()}


@dataclass(frozen=True)
class Part:
    """`basis` times (signal − reference), or `basis` alone."""

    basis: PositionBasis = CONSTANT
    signal: str | None = None
    reference: float = 0.0

    def factor(self, signals: Signals) -> Array | float:
        """Returns the factor of the functions of position. Raises MCH-SIGNAL when the signal is not given."""
        if self.signal is None:
            return 1.0
        if self.signal not in signals:
            raise Code.MCH_SIGNAL.refusal(
                f"the model needs the signal {self.signal!r}; given are {len(signals)}: {', '.join(signals) or 'none'}",
                hint="give its value, in the unit it had in the data that the model was made from",
                values={"signals": [self.signal]},
            )
        return signals[self.signal] - self.reference


@dataclass(frozen=True)
class Term:
    """The form of one axis error. `both_ways` gives forward and return travel parameters of their own."""

    name: ErrorName
    parts: tuple[Part, ...] = (Part(),)
    both_ways: bool = False

    @property
    def size(self) -> int:
        """Returns the number of coefficients: forward's, then return's where they differ."""
        return sum(part.basis.size for part in self.parts) * (2 if self.both_ways else 1)

    def design(self, position: Array, travel: Array, signals: Signals) -> Array:
        """Values of every function, (n, size). `travel` is +1 forward, −1 return, 0 unknown: the mean of both."""
        one_way = np.hstack([part.basis.design(position) * _column(part.factor(signals)) for part in self.parts])
        if not self.both_ways:
            return one_way
        return np.hstack([one_way * _column(0.5 * (1 + travel)), one_way * _column(0.5 * (1 - travel))])

    def admissible(self) -> Array:
        """Columns (size, free) that span the coefficients allowed by the parts' zeros."""
        from scipy.linalg import block_diag

        blocks = [part.basis.admissible() for part in self.parts] * (2 if self.both_ways else 1)
        if self.both_ways:
            blocks[len(self.parts) :] = [np.eye(part.basis.size) for part in self.parts]
        return block_diag(*blocks)

    def values(self, coefficients: Array, position: Array, travel: Array, signals: Signals) -> Array:
        """Returns the error, (n,), mm or rad."""
        return self.design(position, travel, signals) @ coefficients

    def needs(self) -> tuple[str, ...]:
        """Signals without which it cannot be evaluated."""
        return tuple(dict.fromkeys(part.signal for part in self.parts if part.signal is not None))


def _column(values: Array | float) -> Array:
    return np.asarray(values, dtype=np.float64).reshape(-1, 1)


SQUARENESS = ("EC0Y", "EB0Z", "EA0Z")


def mill_terms(
    chain: Chain, *, degree: int = 3, count: int = 1, datum: float | None = None, both_ways: bool = False
) -> tuple[Term, ...]:
    """Returns eighteen motion errors of X, Y, Z (splines of `count` segments) and three squareness errors."""
    motions = [_motion(chain.axis(axis), c, degree, count, datum, both_ways) for axis in "XYZ" for c in "XYZABC"]
    return tuple(motions) + tuple(Term(error_name(name)) for name in SQUARENESS)


def turning_terms(
    chain: Chain, *, degree: int = 3, count: int = 1, datum: float | None = None, both_ways: bool = False
) -> tuple[Term, ...]:
    """Cross slide and carriage in the plane of turning, squareness and parallelism to the spindle axis."""
    motions = [_motion(chain.axis(axis), c, degree, count, datum, both_ways) for axis in "XZ" for c in "XZB"]
    return tuple(motions) + tuple(Term(error_name(name)) for name in ("EB0X", "EB0Z"))


def five_axis_terms(
    chain: Chain, *, degree: int = 3, count: int = 1, datum: float | None = None, both_ways: bool = False
) -> tuple[Term, ...]:
    """Returns a mill's terms and six motion errors of each rotary axis, zero at 0; lines are `frame_terms`."""
    rotary = [axis for axis in chain.axes if axis.kind is AxisKind.ROTARY]
    turns = [_turn(axis, component, degree, count, both_ways) for axis in rotary for component in "XYZABC"]
    return mill_terms(chain, degree=degree, count=count, datum=datum, both_ways=both_ways) + tuple(turns)


def frame_terms(chain: Chain, terms: Sequence[Term]) -> tuple[Term, ...]:
    """Returns every constant of place not in `terms`: directions of linear axes, lines of rotary ones, the spindle."""
    taken = {term.name for term in terms}
    return tuple(Term(name) for name in chain.errors() if name.place and name not in taken)


def _turn(axis: Axis, component: str, degree: int, count: int, both_ways: bool) -> Term:
    zero = min(max(0.0, axis.travel[0]), axis.travel[1])
    return Term(ErrorName(component, axis.name), (Part(segments(*axis.travel, count, degree, (zero,))),), both_ways)


def _motion(axis: Axis, component: str, degree: int, count: int, datum: float | None, both_ways: bool) -> Term:
    assert axis.kind is AxisKind.LINEAR
    name = ErrorName(component, axis.name)
    low, high = axis.travel
    straightness = not name.is_rotation and name.number != axis.number
    zeros = (low, high) if straightness else (min(max(datum if datum is not None else low, low), high),)
    return Term(name, (Part(segments(low, high, count, degree, zeros)),), both_ways)


PRESETS: Final = {
    "turning": "w (C) b Z X t",
    "mill-table-xy": "w X Y b Z (S) t",
    "mill-table-yx": "w Y X b Z (S) t",
    "mill-table-x": "w X b Y Z (S) t",
    "mill-table-y": "w Y b X Z (S) t",
    "mill-travelling-column": "w b X Y Z (S) t",
    "mill-gantry": "w b Y X Z (S) t",
    "mill-horizontal-table-x": "w X b Z Y (S) t",
    "mill-horizontal-table-z": "w Z b X Y (S) t",
    "five-axis-table-table-ac": "w C A b X Y Z (S) t",
    "five-axis-table-table-bc": "w C B b X Y Z (S) t",
    "five-axis-head-table-bc": "w C b X Y Z B (S) t",
    "five-axis-head-table-ac": "w C b X Y Z A (S) t",
    "five-axis-head-head-ca": "w b X Y Z C A (S) t",
    "five-axis-head-head-cb": "w b X Y Z C B (S) t",
}
"""Usual configurations by name. In `turning` Z is the carriage and X the cross slide on it [4773 Fig. 6]."""

_TOKEN: Final = re.compile(r"\s*(\(([A-Z])\)|[A-Z]|[wbt])")
_DIRECTION: Final = {letter: number % 3 for number, letter in enumerate("XYZABCUVW")} | {"S": 2}


def chain_of(structure: str) -> Chain:
    """Returns the chain of a preset or of letters, all frames at the bed's origin. Raises MCH-STRUCTURE."""
    text = PRESETS.get(structure, structure)
    tokens = _TOKEN.findall(text)
    letters = [token for token, _ in tokens]
    whole = "".join(letters) == re.sub(r"\s", "", text)
    if not whole or [t for t in letters if t.islower()] != ["w", "b", "t"] or letters[0] != "w" or letters[-1] != "t":
        raise _no_structure(structure)
    axes = [token if token == "b" else _axis(token, spindle, structure) for token, spindle in tokens[1:-1]]
    bed = axes.index("b")
    work = [axis for axis in axes[:bed] if isinstance(axis, Axis)]
    return Chain(tuple(reversed(work)), tuple(axis for axis in axes[bed + 1 :] if isinstance(axis, Axis)))


def _axis(token: str, spindle: str, structure: str) -> Axis:
    letter = spindle or token
    if letter not in _DIRECTION:
        raise _no_structure(structure)
    if spindle:
        return Axis(letter, AxisKind.SPINDLE, _DIRECTION[letter])
    return Axis(letter, AxisKind.ROTARY if letter in "ABC" else AxisKind.LINEAR, _DIRECTION[letter])


def _no_structure(structure: str) -> TrueloopError:
    return Code.MCH_STRUCTURE.refusal(
        f"{structure!r} is neither one of the {len(PRESETS)} presets nor a structure from work to tool",
        hint=did_you_mean(structure, PRESETS)
        or "write the axes from work to bed to tool, spindles in brackets: w X b Y Z (S) t; presets: "
        + ", ".join(PRESETS),
    )
