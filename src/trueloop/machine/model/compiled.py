"""A model compiled for the evaluator `error-eval`: signals and tool put in, numbers only.

For machines whose linear axes X, Y, Z move; rotary axes stand still at given positions. What was a sum of splines
times signals becomes one piecewise polynomial an error, over the union of the breaks, and an arm that is linear in the
positions of the axes between it and the tool point.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from trueloop._core import MachineEvaluator
from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.machine.model.chain import ZERO, ErrorName, Vector
from trueloop.machine.model.kinematics import PROBE_MM, Influence, bed_to_work, influences
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import Signals, Term

LINEAR = "XYZ"


@dataclass(frozen=True)
class Body:
    """Six errors that act on one frame: local powers (1 or 3, segments, powers, 6), and the arm to the tool.

    Three tables of powers are for travel that is not known, forward and return. `carries` is 1 for axes whose position
    adds to the arm. Displacements in mm, rotations in rad, machine directions.
    """

    axis: int
    breaks: Array
    powers: Array
    arm_mm: Array
    carries: Array


@dataclass(frozen=True)
class CompiledModel:
    """Bodies and slopes in bed axes; `error_mm` evaluates them in Rust. E in work axes is `E_bed @ bed_to_work`."""

    bodies: tuple[Body, ...]
    slope: Array
    bed_to_work: Array
    core: MachineEvaluator = field(repr=False, compare=False)

    def error_mm(self, positions: Array, travel: Array | None = None, threads: int = 1) -> Array:
        """Returns E at (n, 3) positions of X, Y, Z; `travel` (n, 3) as in `State`."""
        error = self.bed_error_mm(positions, travel, threads)
        return error if np.array_equal(self.bed_to_work, np.eye(3)) else error @ self.bed_to_work

    def bed_error_mm(self, positions: Array, travel: Array | None = None, threads: int = 1) -> Array:
        """Returns the error along the machine's own X, Y, Z, however the table is turned."""
        ways = None if travel is None else np.ascontiguousarray(travel, dtype=np.float64)
        return self.core.error(np.ascontiguousarray(positions, dtype=np.float64), ways, threads)


def compile_model(
    model: MachineModel, signals: Signals, tool_mm: Array | Vector = ZERO, fixed: Mapping[str, float] | None = None
) -> CompiledModel:
    """Compiles a model. Raises MCH-SIGNAL for a signal that is not given, MCH-STRUCTURE for a linear axis other than X,
    Y, Z.

    `fixed` holds positions of rotary axes in rad, 0 without. Exact: the same numbers as `MachineModel.error_mm`.
    """
    chain = model.machine.chain
    other = [name for name in chain.order if name not in (*LINEAR, "A", "B", "C")]
    if other:
        raise Code.MCH_STRUCTURE.refusal(
            f"axes {' '.join(other)} are not X, Y, Z: {len(other)} too many for the evaluator",
            hint="describe the machine by X, Y, Z and rotary axes that stand",
        )
    parts = _Parts(model, signals, tool_mm, dict(fixed or {}))
    bodies = tuple(body for axis in chain.axes for body in parts.bodies(axis.name))
    slope = parts.slope()
    return CompiledModel(bodies, slope, parts.bed_to_work, evaluator_of(bodies, slope))


def evaluator_of(bodies: Iterable[Body], slope: Array) -> MachineEvaluator:
    """Returns the Rust evaluator of these errors."""
    given = [
        (
            *(b.axis, b.breaks.tolist(), b.powers.shape[2], b.powers.reshape(-1, 6).tolist()),
            *(b.arm_mm.tolist(), b.carries.tolist()),
        )
        for b in bodies
    ]
    return MachineEvaluator(given, slope.tolist())


class _Parts:
    """Arms by probing `influences` at zero and with each axis moved: they are linear in the positions."""

    def __init__(self, model: MachineModel, signals: Signals, tool_mm: Array | Vector, fixed: dict[str, float]) -> None:
        chain = model.machine.chain
        self.model, self.signals = model, signals
        probes = np.vstack([np.zeros(3), PROBE_MM * np.eye(3)])
        given: dict[str, Array | float] = dict(fixed)
        given |= {name: probes[:, k] for k, name in enumerate(LINEAR) if name in chain.order}
        positions = np.broadcast_to(chain.positions(given), (4, len(chain.order)))
        self.bed_to_work = bed_to_work(chain, fixed)
        bed = self.bed_to_work.T
        self.columns = {
            name: Influence(found.displacement @ bed, found.rotation @ bed)
            for name, found in influences(chain, positions, tool_mm).items()
        }
        self.fixed = fixed
        self.coefficients = dict(
            zip([t.name for t in model.terms], [model.coefficients[where] for where in model.slices()], strict=True)
        )
        self.terms = {term.name: term for term in model.terms}

    def bodies(self, axis: str) -> list[Body]:
        """Returns motion errors of a linear axis as one body; place errors of rotary axes and spindles constant."""
        motion = [name for name in self.terms if name.axis == axis and not name.place]
        place = [name for name in self.terms if name.axis == axis and name.place and not self._is_slope(name)]
        return [self._body(axis, names) for names in (motion, place) if names]

    def slope(self) -> Array:
        """Returns the addition of squareness to E per millimetre of each axis, (3, 3)."""
        slope = np.zeros((3, 3))
        for name in self.terms:
            if name.place and self._is_slope(name):
                values = self.terms[name].values(self.coefficients[name], np.zeros(1), np.zeros(1), self.signals)
                value = float(values[0])
                displacement = self.columns[name].displacement
                slope += value * (displacement[1:] - displacement[0]) / PROBE_MM
        return slope

    def _is_slope(self, name: ErrorName) -> bool:
        return name.axis in LINEAR

    def _body(self, axis: str, names: list[ErrorName]) -> Body:
        terms = [self.terms[name] for name in names]
        linear = axis in LINEAR
        breaks = self._breaks(terms) if linear else np.array([0.0, 1.0])
        powers = 1 + max(part.basis.degree for term in terms for part in term.parts) if linear else 1
        both = linear and any(term.both_ways for term in terms)
        ways = (0.0, 1.0, -1.0) if both else (0.0,)
        tables = np.array([self._powers(terms, breaks, powers, way, linear) for way in ways])
        displaced = self._directions(names)
        arm, carries = self._arm(axis, names)
        # errors act along the frame's own axes, which rotary axes that stand still may have turned
        turned = np.concatenate([tables[..., :3] @ displaced, tables[..., 3:] @ displaced], axis=-1)
        axis_number = LINEAR.index(axis) if linear else 0
        return Body(axis_number, breaks, turned, arm, carries)

    def _breaks(self, terms: list[Term]) -> Array:
        bases = [part.basis for term in terms for part in term.parts if part.basis.size > 1]
        return np.unique(np.concatenate([basis.breaks for basis in bases])) if bases else np.array([0.0, 1.0])

    def _powers(self, terms: list[Term], breaks: Array, powers: int, way: float, linear: bool) -> Array:
        """Returns local powers by exact interpolation of the polynomials of each segment, (segments, powers, 6)."""
        found = np.zeros((len(breaks) - 1, powers, 6))
        nodes = 0.5 - 0.5 * np.cos(np.pi * (np.arange(powers) + 0.5) / powers)
        vandermonde = np.vander(nodes, powers, increasing=True)
        for segment, (low, high) in enumerate(pairwise(breaks)):
            at = low + nodes * (high - low) if linear else np.full(powers, self.fixed.get(terms[0].name.axis, 0.0))
            ways = np.full(powers, way if linear else 0.0)
            for term in terms:
                values = np.broadcast_to(term.values(self.coefficients[term.name], at, ways, self.signals), (powers,))
                local = np.linalg.solve(vandermonde, values) / (high - low) ** np.arange(powers)
                found[segment, :, term.name.number + 3 * term.name.is_rotation] = local
        return found

    def _directions(self, names: list[ErrorName]) -> Array:
        """Returns the machine directions of the frame's three axes with the sense of the error, as rows: (3, 3)."""
        axis, place = names[0].axis, names[0].place
        rows = np.eye(3)
        for number in range(3):
            for component in ("XYZ"[number], "ABC"[number]):
                name = ErrorName(component, axis, place)
                if name in self.columns:
                    influence = self.columns[name]
                    rows[number] = influence.rotation[0] if name.is_rotation else influence.displacement[0]
                    break
        return rows

    def _arm(self, axis: str, names: list[ErrorName]) -> tuple[Array, Array]:
        """Returns (arm at zero, carries): from r × arm of the three rotations at the probes."""
        place = names[0].place
        pairs = [ErrorName(c, axis, place) for c in "ABC"]
        known = [self.columns[name] for name in pairs if name in self.columns]
        rows = np.concatenate([_cross_matrix(influence.rotation[0]) for influence in known])
        arms = [
            np.linalg.lstsq(rows, np.concatenate([i.displacement[k] for i in known]), rcond=None)[0] for k in range(4)
        ]
        moves = (np.array(arms[1:]) - arms[0]) / PROBE_MM
        if np.abs(moves - np.diag(np.diag(moves))).max() > 1e-9:
            raise Code.MCH_STRUCTURE.refusal(
                f"a rotary axis carries the axis whose errors are {names[0]} to {names[-1]}, and is turned",
                hint="describe the machine by X, Y, Z and rotary axes that stand",
            )
        carries = np.asarray(np.round(np.diag(moves)), dtype=np.float64)
        return arms[0], carries


def _cross_matrix(r: Array) -> Array:
    """Returns the matrix of r × ·."""
    x, y, z = r
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
