"""The intended form of a model, and the model of that form that readings give."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.errors import Code, Finding, Severity
from trueloop.machine.identify.choice import Choice, Chosen, choose_signals
from trueloop.machine.identify.identify import Identification, identify, unknown_columns, weighted_rows
from trueloop.machine.identify.observations import Observations
from trueloop.machine.identify.robust import orthonormal, without
from trueloop.machine.model.history import Lag
from trueloop.machine.model.model import Machine
from trueloop.machine.model.term import Term

DETERMINED: Final = 1e-3
"""Share of a frame term's influence on the readings that no other term may have, for it to be taken."""

KNOWN: Final = 0.01
"""Largest standard uncertainty with which it is taken, mm or mrad: a guess is worse than the convention."""


@dataclass(frozen=True)
class Form:
    """Error terms, signals made of the past of others, and what terms may choose from.

    `frame` terms join as far as the readings determine them, in their order; the others are 0 by convention.
    """

    terms: tuple[Term, ...]
    lags: tuple[Lag, ...] = ()
    choices: tuple[Choice, ...] = ()
    frame: tuple[Term, ...] = ()


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
    terms, chosen = choose_signals(machine, form.terms, form.choices, readings, form.lags)
    frame = _determined(machine, terms, form, readings)
    found = identify(machine, (*terms, *frame), readings, robust=robust, lags=form.lags)
    left = [term for term in form.frame if term not in frame]
    return replace(found, findings=(*found.findings, *([_by_convention(left)] if left else []))), chosen


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
