"""The intended form of a model, and the model of that form that readings give.

Signals are chosen among many one by one, each because blocks of data that were left out gain by it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity
from trueloop.machine.identify.identify import Identification, closed_rows, identify, unknown_columns, weighted_rows
from trueloop.machine.identify.observations import Observations, orthonormal, without
from trueloop.machine.model.chain import ErrorName
from trueloop.machine.model.history import Lag
from trueloop.machine.model.model import Machine
from trueloop.machine.model.term import Part, PositionBasis, Term, segments

GAIN: Final = 0.05
"""A sensor is taken when it lowers the mean square of what was left out by 5 %."""

BLOCKS: Final = 6
"""Blocks of consecutive readings where there are fewer than three runs: neighbours in time share their errors."""

CONSTANTS: Final = 6
"""Time constants at which a lag is tried, from bound to bound in equal ratios."""


@dataclass(frozen=True)
class Choice:
    """Signals among which an error's term may choose, `most` at the most."""

    error: ErrorName
    candidates: tuple[Part, ...]
    most: int


@dataclass(frozen=True)
class Chosen:
    """One signal taken: RMS of the weighted readings left out, without and with it."""

    error: ErrorName
    signal: str
    rms_without: float
    rms_with: float


def choose_signals(
    machine: Machine, terms: Sequence[Term], choices: Sequence[Choice], readings: Observations, lags: Sequence[Lag]
) -> tuple[tuple[Term, ...], tuple[Chosen, ...]]:
    """Returns the terms with the signals chosen, and the gain for which each was chosen.

    Forward the signal that helps most joins, until each term has its most, for two may help together where neither
    does alone; then the one that is missed least is dropped again, until each that is left is missed. A lag is tried
    at several constants; the right one is found when it joins.
    """
    if not choices:
        return tuple(terms), ()
    known, blocks = tuple(terms), _blocks(readings)
    while trials := list(_trials(known, choices, lags)):
        errors = [_left_out(machine, tried, readings, at, blocks) for tried, at in trials]
        known, lags = trials[int(np.argmin(errors))]
        lags = _refined(machine, known, readings, lags)
    best = _left_out(machine, known, readings, lags, blocks)
    while True:
        fewer = list(_fewer(known, choices, terms))
        constants = [_refined(machine, tried, readings, lags) for tried, _ in fewer]
        errors = [
            _left_out(machine, tried, readings, at, blocks) for (tried, _), at in zip(fewer, constants, strict=True)
        ]
        if not errors or min(errors) * (1 - GAIN) >= best:
            rms = np.sqrt([*errors, best])
            return known, tuple(
                Chosen(*what, float(u), float(rms[-1])) for (_, what), u in zip(fewer, rms, strict=False)
            )
        least = int(np.argmin(errors))
        known, lags, best = fewer[least][0], constants[least], errors[least]


def _fewer(
    kept: tuple[Term, ...], choices: Sequence[Choice], terms: Sequence[Term]
) -> Iterator[tuple[tuple[Term, ...], tuple[ErrorName, str]]]:
    """Yields every model with one of the chosen signals less, and the signal taken away."""
    given = {term.name: term.needs() for term in terms}
    for choice in choices:
        at = next(k for k, term in enumerate(kept) if term.name == choice.error)
        for signal in kept[at].needs():
            if signal not in given[choice.error]:
                yield (*kept[:at], _without(kept[at], signal), *kept[at + 1 :]), (choice.error, signal)


def _without(term: Term, signal: str) -> Term:
    return replace(term, parts=tuple(part for part in term.parts if part.signal != signal))


def _refined(machine: Machine, terms: tuple[Term, ...], readings: Observations, lags: Sequence[Lag]) -> list[Lag]:
    """Refines the constants of the lags in use together: a useless sensor would make up for a wrong one."""
    found = {lag.name: lag for lag in identify(machine, terms, readings, lags=lags).model.lags}
    return [found.get(lag.name, lag) for lag in lags]


def _trials(
    terms: tuple[Term, ...], choices: Sequence[Choice], lags: Sequence[Lag]
) -> Iterator[tuple[tuple[Term, ...], Sequence[Lag]]]:
    """Yields every model with one signal more: its terms, and the lags with the constant tried."""
    for choice in choices:
        at = next(k for k, term in enumerate(terms) if term.name == choice.error)
        taken = terms[at].needs()
        if sum(part.signal in taken for part in choice.candidates) >= min(choice.most, len(choice.candidates)):
            continue
        for part in choice.candidates:
            assert part.signal is not None
            if part.signal in taken:
                continue
            more = replace(terms[at], parts=(*terms[at].parts, part))
            for tried in _lags_tried(part.signal, lags, any(part.signal in term.needs() for term in terms)):
                yield (*terms[:at], more, *terms[at + 1 :]), tried


def _lags_tried(signal: str, lags: Sequence[Lag], settled: bool) -> Iterator[Sequence[Lag]]:
    lag = next((lag for lag in lags if lag.name == signal), None)
    if lag is None or lag.between_s is None or settled:
        yield lags
        return
    for constant in np.geomspace(*lag.between_s, CONSTANTS):
        yield [replace(other, constant_s=float(constant)) if other is lag else other for other in lags]


def _blocks(readings: Observations) -> list[NDArray[np.intp]]:
    runs = np.unique(readings.run, return_inverse=True)[1]
    if runs.max() >= 2:
        return [np.flatnonzero(runs == run) for run in range(int(runs.max()) + 1)]
    return [np.arange(a, b) for a, b in pairwise(np.linspace(0, len(readings), BLOCKS + 1).astype(int))]


def _left_out(
    machine: Machine,
    terms: tuple[Term, ...],
    readings: Observations,
    lags: Sequence[Lag],
    blocks: Sequence[NDArray[np.intp]],
) -> float:
    """Returns the mean square of the residual of each block from a model made from all others, in units of u."""
    used = [lag for lag in lags if any(lag.name in term.needs() for term in terms)]
    rows, values = closed_rows(machine, terms, readings.with_lags(used))
    parts = [(rows[block].T @ rows[block], rows[block].T @ values[block]) for block in blocks]
    normal, right = sum(part[0] for part in parts), sum(part[1] for part in parts)
    total = 0.0
    for block, (own_normal, own_right) in zip(blocks, parts, strict=True):
        rest = values[block] - rows[block] @ _solved(normal - own_normal, right - own_right)
        total += float(rest @ rest)
    return total / len(values)


def _solved(normal: Array, right: Array) -> Array:
    """Solves normal equations, by least norm where they have several solutions; scaled, because units differ."""
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    solution: Array = np.linalg.lstsq(normal / np.outer(scale, scale), right / scale, rcond=1e-12)[0] / scale
    return solution


DETERMINED: Final = 1e-3
"""Share of a frame term's influence on the readings that no other term may have, for it to be taken."""

KNOWN: Final = 0.01
"""Largest standard uncertainty with which it is taken, mm or mrad: a guess is worse than the convention."""


@dataclass(frozen=True)
class Form:
    """Error terms, signals made of the past of others, and what terms may choose from.

    `frame` terms join as far as the readings determine them, in their order; the others are 0 by convention. Terms in
    `free` have as many segments as predict left-out runs best.
    """

    terms: tuple[Term, ...]
    lags: tuple[Lag, ...] = ()
    choices: tuple[Choice, ...] = ()
    frame: tuple[Term, ...] = ()
    free: frozenset[ErrorName] = frozenset()


MOST_SEGMENTS: Final = 16
SWEEPS: Final = 2
PREDICTS: Final = 0.01
"""More segments are taken where they lower the mean square of what was left out by more than 1 %."""
ALONE: Final = 1e-7
"""Share of the information on a combination of terms that has to be left without a run."""


def with_segments(machine: Machine, form: Form, readings: Observations) -> tuple[Form, tuple[Finding, ...]]:
    """Returns a form with segments of its free terms, as many as predict left-out runs best, and a note."""
    if not form.free or len(set(readings.run)) < 2:
        return form, ()
    lags = [lag for lag in form.lags if any(lag.name in term.needs() for term in form.terms)]
    readings, terms = readings.with_lags(lags), form.terms
    least = _missed(machine, (*terms, *form.frame), readings)
    for axis in machine.chain.order * SWEEPS:  # an axis that is missed by far hides what another one lacks
        positions = readings.state.positions[:, machine.chain.order.index(axis)]
        most, count, tried = len(np.unique(np.round(positions, 9))) // 2, 2, [(least, terms)]
        while count <= min(MOST_SEGMENTS, most):
            finer = tuple(
                _cut(term, count) if term.name.axis == axis and term.name in form.free else term for term in terms
            )
            if finer == terms:
                break
            tried.append((_missed(machine, (*finer, *form.frame), readings), finer))
            if tried[-1][0] > tried[-2][0]:
                break
            count *= 2
        best = min(tried, key=lambda one: one[0])
        if best[0] < (1.0 - PREDICTS) * least:
            least, terms = best
    counts = dict[str, int]()
    for term in terms:
        if term.name in form.free and not term.name.place:
            counts[term.name.axis] = max(len(part.basis.breaks) - 1 for part in term.parts)
    note = Finding(
        Severity.NOTE,
        Code.MCH_BASIS,
        "segments by which left-out runs are predicted best: " + ", ".join(f"{axis} {n}" for axis, n in counts.items()),
        hint="`terms.segments` of the machine file states another number for all axes",
    )
    return replace(form, terms=terms, free=frozenset()), (note,)


def _cut(term: Term, count: int) -> Term:
    """Returns a term with so many segments of equal length."""

    def cut(basis: PositionBasis) -> PositionBasis:
        return segments(basis.breaks[0], basis.breaks[-1], count, basis.degree, basis.zero_at)

    return replace(
        term, parts=tuple(replace(part, basis=cut(part.basis)) if part.basis.degree else part for part in term.parts)
    )


def _missed(machine: Machine, terms: tuple[Term, ...], readings: Observations) -> float:
    """Returns the sum of squares, in units of u, by which the others miss each run; undetermined ones count as read."""
    rows, values = closed_rows(machine, terms, readings)
    q = orthonormal(rows)
    left, total = values - q @ (q.T @ values), 0.0
    runs = np.array(readings.run)
    for run in dict.fromkeys(readings.run):
        own = runs == run
        share, directions = np.linalg.eigh(q[own] @ q[own].T)
        spared = 1.0 - share
        missed = np.where(
            spared > ALONE, (directions.T @ left[own]) / np.maximum(spared, ALONE), directions.T @ values[own]
        )
        total += float(missed @ missed)
    return total


def fit_form(
    machine: Machine, form: Form, readings: Observations, *, robust: bool = True
) -> tuple[Identification, tuple[Chosen, ...]]:
    """Chooses the signals, then identifies everything together; raises as `identify`.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> round(found.scatter, 2), found.degrees_of_freedom
    (0.88, 61)
    """
    form, notes = with_segments(machine, form, readings)
    terms, chosen = choose_signals(machine, form.terms, form.choices, readings, form.lags)
    frame = _determined(machine, terms, form, readings)
    found = identify(machine, (*terms, *frame), readings, robust=robust, lags=form.lags)
    left = [term for term in form.frame if term not in frame]
    return replace(found, findings=(*notes, *found.findings, *([_by_convention(left)] if left else []))), chosen


def _determined(machine: Machine, terms: tuple[Term, ...], form: Form, readings: Observations) -> tuple[Term, ...]:
    """Returns those terms of the frame that the readings separate from all else, one after the other."""
    if not form.frame:
        return ()
    lags = [lag for lag in form.lags if any(lag.name in term.needs() for term in terms)]
    known, values, _ = weighted_rows(machine, terms, readings.with_lags(lags))
    frame = weighted_rows(machine, form.frame, readings)[0]
    span, found = np.hstack([known, unknown_columns(machine, terms, readings)]), []
    noise = float(np.median(np.abs(without(np.hstack([span, frame]), values)))) / 0.6745
    span = orthonormal(span)
    for term, column in zip(form.frame, frame.T, strict=True):
        rest, unit = column - span @ (span.T @ column), 1e-3 if term.name.is_rotation else 1.0
        if np.linalg.norm(rest) > max(DETERMINED * float(np.linalg.norm(column)), noise / (KNOWN * unit)):
            span = np.column_stack([span, rest / np.linalg.norm(rest)])
            found.append(term)
    return tuple(found)


def _by_convention(left: Sequence[Term]) -> Finding:
    names = ", ".join(str(term.name) for term in left)
    return Finding(
        Severity.NOTE,
        Code.MCH_COLLINEAR,
        f"{len(left)} constants of place are not determined by these readings and 0 by convention: {names}",
        hint="nothing to do, unless the frame matters: then mark absolute readings, or measure with several tools",
        values={"parameters": [str(term.name) for term in left]},
    )
