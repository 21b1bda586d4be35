"""Guilty axis errors in the model: parts that they lack are added, and columns state how far each may move."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.model import MachineModel, State, design
from trueloop.machine.model.names import ErrorName
from trueloop.machine.model.term import CONSTANT, Part, PositionBasis, Term
from trueloop.machine.refine.left import LeftOnParts

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
        _require_of_machine(model.machine.chain, one.error)
        missing = tuple(_missing(model, one, state))
        if missing:
            model = _grown(model, one.error, missing)
        if one.signal and one.signal not in model.identified:
            values = np.asarray(state.signals[one.signal], np.float64)
            known = {**model.identified, one.signal: (float(values.min()), float(values.max()))}
            model = replace(model, identified=known)
    return model


def freedom(model: MachineModel, guilty: Sequence[Guilty], seen: LeftOnParts) -> dict[str, Array]:
    """Columns (coefficients and lags, k) by which each guilty error may move beyond its covariance.

    One block for what it does whatever the temperature and one for each signal, each scaled so that normal numbers of
    variance 1 leave 1 mm RMS along the normals.
    """
    found: dict[str, Array] = {}
    slices = dict(zip((term.name for term in model.terms), model.slices(), strict=True))
    terms = {term.name: term for term in model.terms}
    whole = len(model.coefficients) + len(model.lags)
    along = np.einsum("ni,nij->nj", seen.normal, design(model.machine.chain, model.terms, seen.state))
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
    """Yields each part with the coefficients of the term that its functions have; forward and return travel move
    alike.
    """
    at, one_way = 0, sum(part.basis.size for part in term.parts)
    for part in term.parts:
        own = np.zeros((one_way, part.basis.size))
        own[at : at + part.basis.size] = np.eye(part.basis.size)
        at += part.basis.size
        yield part, np.vstack([own @ part.basis.admissible()] * (2 if term.both_ways else 1))


def _missing(model: MachineModel, one: Guilty, state: State) -> Iterator[Part]:
    term = next((term for term in model.terms if term.name == one.error), None)
    curve, line = _bases(model.machine.chain, one.error, state)
    if term is None:
        yield Part(curve)
    if one.signal and (term is None or one.signal not in term.needs()):
        reference = float(np.mean(Part(CONSTANT, one.signal).factor(state.signals)))
        yield Part(line, one.signal, reference)


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
    """Returns the model with parts added to a term, or a term to the model; their coefficients are zero and known to
    be.
    """
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


def _require_of_machine(chain: Chain, error: ErrorName) -> None:
    possible = chain.errors()
    if error not in possible:
        raise Code.MCH_AXIS.refusal(
            f"the machine cannot have {error}; it has {len(possible)} errors: {' '.join(map(str, possible))}",
            hint="check that the guilty errors belong to this machine",
        )
