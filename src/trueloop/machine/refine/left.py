"""The residuals of a machine's model on parts: ERROR_MTG,RESID at gauging points of many parts [6876 §3.5].

Guilty axis errors in the model: parts that they lack are added, and columns state how far each may move.

A machine's model refined from its residuals on many parts [4773 §3.4], its own covariance being the prior.

Where parts were cut with COMP_MTG = −E_model, what is left along the normal is n · (E − E_model): to first order
n · D · x, x being what the coefficients lack. So the coefficients move by the posterior mean of

    residual = n · D · x + set-up of the part + what no form of the model has at this place + noise

with x ~ N(0, c² · covariance of the model + freedom of the guilty errors), c and the freedom as the evidence asks. The
gain of this update is the weight of [4773 §2.5]: little where the model is known well or the parts scatter, nearly 1
where neither holds. Time constants of lags are considered and not moved (Schmidt 1966): their uncertainty stays,
correlations with them count.
It holds to first order, with the guilty errors named rightly; its worth is judged by parts left out (`refine.py`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array, Flags, Integers, by_content
from trueloop.errors import Code
from trueloop.estimate.blocks import Block, Mixed, mixed
from trueloop.machine.model.chain import Chain, ErrorName
from trueloop.machine.model.model import MachineModel, State, design
from trueloop.machine.model.term import CONSTANT, Part, PositionBasis, Term
from trueloop.units import UM_PER_MM

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


NEW_DEGREE = 2
"""The degree, along its axis, of an error that the model does not have yet."""


@dataclass(frozen=True)
class Guilty:
    """An axis error that the model has wrong, and the signal that it follows where that is known."""

    error: ErrorName
    signal: str = ""


def with_guilty(model: MachineModel, guilty: Sequence[Guilty], state: State) -> MachineModel:
    """Adds to the model the parts it lacks of the guilty errors, all of them zero: its errors stay as before
    everywhere.

    An error that it does not have becomes a term, a parabola along its axis or a constant of a spindle; a signal that
    it does not follow becomes a part, a line along the axis times the signal less its mean. The range of such a signal
    is added to what is known. Raises MCH-AXIS for an error that the machine does not have, MCH-SIGNAL for a signal that
    is not given.
    """
    for one in guilty:
        possible = model.machine.chain.errors()
        if one.error not in possible:
            raise Code.MCH_AXIS.refusal(
                f"the machine cannot have {one.error}; it has {len(possible)} errors: {' '.join(map(str, possible))}",
                hint="check that the guilty errors belong to this machine",
            )
        missing = tuple(_missing(model, one, state))
        if missing:
            model = _grown(model, one.error, missing)
        if one.signal and one.signal not in model.identified:
            values = np.asarray(state.signals[one.signal], np.float64)
            known = {**model.identified, one.signal: (float(values.min()), float(values.max()))}
            model = replace(model, identified=known)
    return model


def freedom(model: MachineModel, guilty: Sequence[Guilty], residuals: LeftOnParts) -> dict[str, Array]:
    """Columns (coefficients and lags, k) by which each guilty error may move beyond its covariance.

    One block for what it does whatever the temperature and one for each signal, each scaled so that normal numbers of
    variance 1 leave 1 mm RMS along the normals.
    """
    found: dict[str, Array] = {}
    slices = dict(zip((term.name for term in model.terms), model.slices(), strict=True))
    terms = {term.name: term for term in model.terms}
    whole = len(model.coefficients) + len(model.lags)
    along = np.einsum("ni,nij->nj", residuals.normal, design(model.machine.chain, model.terms, residuals.state))
    for error in dict.fromkeys(one.error for one in guilty):
        blocks: dict[str, list[Array]] = {}
        for part, own in _columns(terms[error]):
            columns = np.zeros((whole, own.shape[1]))
            columns[slices[error]] = own
            size = float(np.sqrt(np.mean(np.sum((along @ columns[: along.shape[1]]) ** 2, axis=1))))
            if size > 0.0:
                blocks.setdefault(part.signal or "", []).append(columns / size)
        found |= {f"{error} {signal}".strip(): np.hstack(columns) for signal, columns in blocks.items()}
    return found


def _columns(term: Term) -> Iterator[tuple[Part, Array]]:
    """Yields each part with the term's coefficients that its functions have; both ways of travel move together."""
    at, one_way = 0, sum(part.basis.size for part in term.parts)
    for part in term.parts:
        own = np.zeros((one_way, part.basis.size))
        own[at : at + part.basis.size] = np.eye(part.basis.size)
        at += part.basis.size
        yield part, np.vstack([own @ part.basis.admissible()] * (2 if term.both_ways else 1))


def _missing(model: MachineModel, guilty: Guilty, state: State) -> Iterator[Part]:
    term = next((term for term in model.terms if term.name == guilty.error), None)
    curve, line = _bases(model.machine.chain, guilty.error, state)
    if term is None:
        yield Part(curve)
    if guilty.signal and (term is None or guilty.signal not in term.needs()):
        reference = float(np.mean(Part(CONSTANT, guilty.signal).factor(state.signals)))
        yield Part(line, guilty.signal, reference)


def _bases(chain: Chain, error: ErrorName, state: State) -> tuple[PositionBasis, PositionBasis]:
    if error.place or error.axis not in chain.order:
        return CONSTANT, CONSTANT
    low, high = chain.axis(error.axis).travel
    at = state.positions[:, chain.order.index(error.axis)]
    ends = (low, high) if np.isfinite([low, high]).all() else (float(at.min()), float(at.max()))
    if ends[1] <= ends[0]:
        return CONSTANT, CONSTANT
    return PositionBasis(ends, NEW_DEGREE), PositionBasis(ends, 1)


def _grown(model: MachineModel, error: ErrorName, more: tuple[Part, ...]) -> MachineModel:
    """Returns the model with parts added to a term, or a term to it; their coefficients are zero, and known."""
    old = next((term for term in model.terms if term.name == error), None)
    if old is None:
        terms = (*model.terms, Term(error, more))
    else:
        terms = tuple(replace(t, parts=(*t.parts, *more)) if t is old else t for t in model.terms)
    kept = np.concatenate(
        [_had(term, sum(part.basis.size for part in more) if term.name == error else 0) for term in terms]
    )
    places = np.concatenate([np.flatnonzero(kept), len(kept) + np.arange(len(model.lags))]).astype(int)
    covariance = np.zeros((len(kept) + len(model.lags),) * 2)
    covariance[np.ix_(places, places)] = model.covariance
    coefficients = np.zeros(len(kept))
    coefficients[kept] = model.coefficients
    return replace(model, terms=terms, coefficients=coefficients, covariance=covariance)


def _had(term: Term, added: int) -> Flags:
    """Returns which coefficients of a term the model had before, when the last `added` functions are new."""
    one_way = np.arange(sum(part.basis.size for part in term.parts))
    return np.tile(one_way < len(one_way) - added, 2 if term.both_ways else 1)


LEAST_MM, MOST_MM = 1e-5, 0.064
"""RMS along the normals of what a guilty error may lack, a set-up or a place may leave."""
WIDER = 16.0
"""Largest factor by which all coefficients' uncertainty may be too small: a fit's readings do not know its form."""
MODEL, SET_UP, PLACE = "model", "set-up", "place"


@dataclass(frozen=True)
class UpdatedTerm:
    """The model with its coefficients moved, and the quantities of the update.

    `outlier` (n,) are points more than five standard deviations off, which hardly counted. `noise_mm`, `set_up_mm` and
    `place_mm` are standard deviations found: of a point, of a part's set-up, of what stays at a place whatever the
    coefficients are. `wider`: by what factor the standard uncertainties of all coefficients had to be larger than
    the model says.
    """

    model: MachineModel
    outlier: Flags
    noise_mm: float
    set_up_mm: float
    place_mm: float
    wider: float


def guilty_ones(terms: Sequence[ErrorName | Guilty]) -> tuple[Guilty, ...]:
    """Axis errors by name alone, or with the signal that each follows."""
    return tuple(term if isinstance(term, Guilty) else Guilty(term) for term in terms)


def update(
    model: MachineModel, residuals: LeftOnParts, guilty: Sequence[ErrorName | Guilty], *, share: float = 1.0
) -> UpdatedTerm:
    """Updates the model by its residuals on the parts: its coefficients moved by `share` of the change [4773 §2.5].

    Raises DIA-FEW for fewer than three parts, MCH-SHAPE for points that do not belong together, MCH-AXIS for a guilty
    error that the machine does not have, MCH-SIGNAL where a temperature is not given.
    """
    require_usable(residuals)
    named = guilty_ones(guilty)
    grown = replace(with_guilty(model, named, residuals.state), version=None)
    along = np.einsum("ni,nij->nj", residuals.normal, grown.sensitivities(residuals.state)) * UM_PER_MM
    # Columns whose products sum to the covariance, as many as it has directions
    scale = np.sqrt(np.maximum(np.diag(grown.covariance), 0.0))
    unit = np.where(scale > 0.0, scale, 1.0)
    values, vectors = np.linalg.eigh(grown.covariance / np.outer(unit, unit))
    kept = values > 1e-12 * max(float(values.max(initial=0.0)), 1e-300)
    root: Array = unit[:, None] * vectors[:, kept] * np.sqrt(values[kept])
    moves = {MODEL: root, **freedom(grown, named, residuals)}
    blocks = {
        name: Block(along @ move, *((1.0, WIDER) if name == MODEL else (LEAST_MM, MOST_MM)))
        for name, move in moves.items()
    }
    blocks |= {SET_UP: _in_um(residuals.set_ups()), PLACE: _in_um(residuals.places())}
    fit = mixed(residuals.residual_mm * UM_PER_MM, blocks, residuals.weights, residuals.u_mm * UM_PER_MM)
    to_all = np.hstack([fit.scales[name] * move for name, move in moves.items()])
    refined = _moved(grown, to_all, fit, share)
    set_up, place = fit.scales[SET_UP], fit.scales[PLACE] if blocks[PLACE].rows.size else 0.0
    return UpdatedTerm(
        model=refined,
        outlier=fit.outlier,
        noise_mm=fit.noise / UM_PER_MM,
        set_up_mm=set_up,
        place_mm=place,
        wider=fit.scales[MODEL],
    )


def _in_um(rows: Array) -> Block:
    return Block(rows * UM_PER_MM, LEAST_MM, MOST_MM)


def _moved(model: MachineModel, to_all: Array, fit: Mixed, share: float) -> MachineModel:
    """Coefficients by the posterior mean; covariance of what is then unknown, lags considered and left where they are.

    With the gain G of z and M that leaves out lags and makes only a share of the change, the error of the change is
    (T − M T (I − V)) z − noise: V the posterior covariance of z, T from z to coefficients and lags (Joseph's form).
    """
    own = len(model.coefficients)
    made = np.zeros(len(to_all))
    made[:own] = share
    z = np.concatenate(list(fit.mean.values()))[: to_all.shape[1]]
    change = made * (to_all @ z)
    whole = np.hstack([to_all, np.zeros((len(to_all), len(fit.covariance) - to_all.shape[1]))])
    posterior = made[:, None] * (whole @ fit.covariance)
    missed = whole - made[:, None] * whole + posterior
    covariance = missed @ missed.T + posterior @ fit.fisher @ posterior.T
    return replace(model, coefficients=model.coefficients + change[:own], covariance=covariance)
