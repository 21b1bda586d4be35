"""Which axis error the machine's model gets wrong: probabilities of nothing, one error, two.

The residuals ERROR_MTG,RESID along the normals [6876 §3.5] are compared with what each suspect would leave. Each
hypothesis has a marginal likelihood, so that one with more parameters has to earn them, and probabilities follow.
Errors that one tool, one place or equal temperatures cannot tell apart share the probability: the answer is a set, and
never one name out of a set. The model is linear: residuals beyond some 0.1 mm, or a wrong machine, are beyond it.

The source's own way to name axis errors: one correlation after another [4773 §3.3, Table 1].

A row of Table 1 is a product: the influence of an axis error, the temperature of its element, and for an error of
motion the position of its axis too or not. The product that correlates best with the residuals names the error; what it
explains is taken out, and the next is looked for. It names one error where the data cannot tell several
apart, and what looks alike to what was taken out is never seen: it is shown for comparison.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.terms.question import (
    Hypothesis,
    Question,
    TakenOut,
    log_evidence,
    log_grid,
    posterior,
    question,
)
from trueloop.diagnosis.terms.separators import TermSet, separators, sets, with_separators
from trueloop.diagnosis.terms.suspects import Residuals, Wrong, raw, with_order
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.estimate.weights import probabilities, shares
from trueloop.machine.model.chain import Chain, ErrorName
from trueloop.machine.model.term import CONSTANT, Part

PARTS: Final = 2
UNKNOWNS: Final = 2
"""Of an error that follows a temperature, beside where each part is set up."""
ALIKE_MM: Final = 1.0
ALIKE_K: Final = 0.5
"""Ranges below which tools, positions and temperatures count as alike."""


def check(chain: Chain, residuals: Residuals) -> tuple[Finding, ...]:
    """Returns what the data lack, as notes with DIA-ALIKE.

    Raises MCH-SHAPE for arrays that do not fit, MCH-AXIS for an element of no axis, DIA-SIGNAL for a temperature that
    is missing or not finite, DIA-POINTS for other values that are not finite, DIA-FEW for one part or few points.
    """
    _check_shapes(chain, residuals)
    for axis in residuals.element:
        chain.axis(axis)
    _check_signals(residuals)
    arrays = (
        residuals.residual_mm[:, None],
        residuals.normal,
        residuals.state.positions,
        np.atleast_2d(residuals.state.tool_mm),
    )
    finite = np.ones(len(residuals.part), bool)
    for values in arrays:
        finite &= np.isfinite(values).all(axis=1)
    if not finite.all():
        raise Code.DIA_POINTS.refusal(
            f"{int((~finite).sum())} of {len(finite)} points have a residual, normal, position or tool that is no "
            f"finite number, the first in row {int(np.argmin(finite)) + 1}",
            hint="leave out points that were not measured",
            values={"feature": ""},
        )
    parts, points = len(np.unique(residuals.part)), len(residuals.part)
    directions = int(np.any(np.abs(residuals.normal) > 1e-9, axis=0).sum()) if points else 0
    if parts < PARTS:
        raise _few(parts, PARTS, f"{parts} part of {points} points does not tell an axis error from its set-up")
    needed = parts * directions + UNKNOWNS
    if points < needed:
        raise _few(points, needed, f"{points} points on {parts} parts do not determine set-ups and an error")
    return (*_equal_temperatures(residuals), *_one_tool(residuals), *_one_place(chain, residuals))


def _check_shapes(chain: Chain, residuals: Residuals) -> None:
    count, state = len(residuals.residual_mm), residuals.state
    shapes = (residuals.part.shape, residuals.normal.shape, state.positions.shape, np.shape(state.tool_mm))
    wanted = ((count,), (count, 3), (count, len(chain.order)))
    signals = [np.shape(values) for values in state.signals.values()]
    if shapes[:3] != wanted or shapes[3] not in ((3,), (count, 3)) or any(s not in ((), (count,)) for s in signals):
        raise Code.MCH_SHAPE.refusal(
            f"{count} residuals with parts, normals, positions and tools of the shapes {shapes} do not fit",
            hint=f"give parts (n,), normals (n, 3), positions (n, {len(chain.order)}), tools (3,) or (n, 3)",
            values={"counts": [int(shape[0]) for shape in shapes]},
        )


def _check_signals(residuals: Residuals) -> None:
    for signal in sorted({*residuals.element.values(), *residuals.state.signals}):
        given = residuals.state.signals.get(signal)
        known = np.isfinite(np.broadcast_to(np.nan if given is None else np.asarray(given), residuals.part.shape))
        if not known.all():
            parts = [int(part) for part in np.unique(residuals.part[~known])]
            raise Code.DIA_SIGNAL.refusal(
                f"the signal {signal!r} is not known of {len(parts)} of {len(np.unique(residuals.part))} parts",
                hint="leave those parts out, or name another signal as the temperature of that element",
                values={"signal": signal, "parts": parts},
            )


def _few(count: int, needed: int, message: str) -> TrueloopError:
    return Code.DIA_FEW.refusal(
        f"{message}; needed are {needed}",
        hint="measure more parts, at other temperatures, with tools of other lengths, at more points",
        values={"count": count, "needed": needed},
    )


def _equal_temperatures(residuals: Residuals) -> list[Finding]:
    spans = {signal: _range(residuals.state.signals[signal]) for signal in sorted(set(residuals.element.values()))}
    equal = [signal for signal, span in spans.items() if span < ALIKE_K]
    if not equal:
        return []
    return [
        _alike(
            f"{', '.join(equal)} changed by less than {ALIKE_K:g} K over the parts: what follows it does not show",
            "measure parts cut when the machine was cold and when it was warm",
        )
    ]


def _one_tool(residuals: Residuals) -> list[Finding]:
    tools = np.atleast_2d(residuals.state.tool_mm)
    if float(np.ptp(tools, axis=0).max()) >= ALIKE_MM:
        return []
    return [
        _alike(
            f"one length of tool and stylus (to {ALIKE_MM:g} mm) at all points: angles and displacements look alike",
            "probe with longer and shorter styli too",
        )
    ]


def _one_place(chain: Chain, residuals: Residuals) -> list[Finding]:
    spans = np.ptp(residuals.state.positions, axis=0)
    fixed = [name for name, span in zip(chain.order, spans, strict=True) if span < ALIKE_MM and name in "XYZ"]
    if not fixed:
        return []
    return [
        _alike(
            f"{', '.join(fixed)} stood within {ALIKE_MM:g} mm at all points: what depends on it does not show",
            "measure parts of other diameters and lengths too",
        )
    ]


def _alike(message: str, hint: str) -> Finding:
    return Finding(Severity.NOTE, Code.DIA_ALIKE, message, hint)


def _range(values: Array | float) -> float:
    return float(np.ptp(np.atleast_1d(values)))


NOTHING_WRONG: Final = 0.9
ONE_WRONG: Final = 0.09
"""Beforehand. Two errors have the rest."""
FIRST: Final = 12
"""So many of the likeliest single suspects are looked at together with every second one."""
UNLIKELY: Final = 1e-4
"""Set-ups with a smaller share of every likely single error are not looked at for two."""
FREEDOM: Final = 4.0
"""Degrees of freedom of Student's t that points scatter by, where one lies further out than `FAR`."""
FAR: Final = 4.0


@dataclass(frozen=True)
class Verdict:
    """Hypotheses with their probabilities, most probable first; () is that nothing is wrong.

    `by_error` has the probability of each axis error to be among what is wrong. `sets` are what is found: names that
    the data cannot divide stand together; none where nothing wrong is likelier than not. `notes` say what the data
    lack. `noise_mm` is what points scatter by.
    """

    hypotheses: tuple[tuple[Hypothesis, float], ...]
    by_error: Mapping[ErrorName, float] = field(default_factory=dict)
    sets: tuple[TermSet, ...] = ()
    notes: tuple[Finding, ...] = ()
    noise_mm: float = 0.0

    @property
    def sound(self) -> float:
        """Returns the probability that no error is wrong by as much as the residuals could show."""
        return dict(self.hypotheses).get((), 0.0)


def judge(chain: Chain, residuals: Residuals, pairs: bool = True, *, turned: bool = False) -> Verdict:
    """Probabilities of what is wrong, and sets of names with what would divide them.

    With `pairs` two errors at once are looked for; with `turned` the frame of every part may be turned as well as
    moved. Raises DIA-FEW for one part and for fewer points than unknowns, DIA-SIGNAL for a temperature that is missing,
    MCH-SHAPE and DIA-POINTS for arrays that do not fit or are not finite.
    """
    notes = check(chain, residuals)
    asked = question(chain, with_order(residuals), turned=turned)
    log = _weights(asked, pairs)
    robust = _robust(asked, next(iter(shares(log))))
    if robust is not None:
        asked = replace(asked, scatter=robust)
        log = _weights(asked, pairs)
    found = tuple(shares(log).items())
    products = asked.products()
    best = posterior(asked, products, found[0][0])
    divided = tuple(with_separators(term_set, separators(asked, products, term_set, found)) for term_set in sets(found))
    return Verdict(found, _by_error(found), divided, notes, float(np.sqrt(best.noise)) * 1e-3)


def _weights(question: Question, pairs: bool) -> dict[Hypothesis, float]:
    """Logarithms of prior times likelihood."""
    products, whole = question.products(), sum(question.prior.values())
    log: dict[Hypothesis, float] = {(): float(log_evidence(question, products, [()])[0] + np.log(NOTHING_WRONG))}
    singles: list[Hypothesis] = [(suspect,) for suspect in question.prior]
    for one, value in zip(singles, log_evidence(question, products, singles) if singles else (), strict=True):
        log[one] = float(value + np.log(ONE_WRONG * question.prior[one[0]] / whole))
    if pairs:
        # Variances of set-ups that the likeliest hypotheses do not rule out, and smaller ones: two explain more
        best = sorted((one for one in log if one), key=lambda one: -log[one])[:FIRST]
        by_setting = np.array([np.logaddexp.reduce(grid, axis=1) for grid in log_grid(question, products, best)])
        largest = products.variances[np.any(probabilities(by_setting) > UNLIKELY, axis=0)].max(axis=0)
        log |= _pairs(question, products.only(np.all(products.variances <= largest, axis=1)), log, whole)
    return log


def _pairs(
    question: Question, products: TakenOut, log: Mapping[Hypothesis, float], whole: float
) -> dict[Hypothesis, float]:
    """Of two errors that are not the same, the likelier one among the `FIRST`."""
    ordered = sorted((one for one in log if one), key=lambda one: -log[one])
    two = [(a, b) for k, (a,) in enumerate(ordered[:FIRST]) for (b,) in ordered[k + 1 :] if a.error != b.error]
    if not two:
        return {}
    found = log_evidence(question, products, two)
    prior = (1 - NOTHING_WRONG - ONE_WRONG) * 2 / whole**2
    return {
        (a, b): float(value + np.log(prior * question.prior[a] * question.prior[b]))
        for (a, b), value in zip(two, found, strict=True)
    }


def _robust(question: Question, best: Hypothesis) -> Array | None:
    """Scatter of each point where some lie far out of the likeliest hypothesis: Student's t as a mixture of normals."""
    left = posterior(question, question.products(), best).left
    size = 1.4826 * float(np.median(np.abs(left)))
    if size == 0.0 or float(np.abs(left).max()) < FAR * size:
        return None
    scatter: Array = np.sqrt((FREEDOM + (left / size) ** 2) / (FREEDOM + 1))
    return np.maximum(scatter, 1.0)


def _by_error(ranked_terms: tuple[tuple[Hypothesis, float], ...]) -> dict[ErrorName, float]:
    by_error: dict[Wrong, float] = {}
    for hypothesis, share in ranked_terms:
        for suspect in hypothesis:
            by_error[suspect.error] = by_error.get(suspect.error, 0.0) + share
    ordered = sorted(by_error.items(), key=lambda item: -item[1])
    return {error: share for error, share in ordered if isinstance(error, ErrorName)}


LEAST: Final = 0.2
"""Below this correlation nothing is named."""
STEPS: Final = 3


@dataclass(frozen=True)
class Correlation:
    """One step: the error named, the signal that it follows, and the correlation with what was left till then."""

    error: str
    signal: str
    correlation: float


def one_after_another(chain: Chain, residuals: Residuals) -> tuple[Correlation, ...]:
    """At most three steps, the largest correlation of each; () where none reaches 0.2."""
    products, left, found = list(_products(chain, residuals)), residuals.residual_mm - residuals.residual_mm.mean(), []
    for _ in range(STEPS):
        best = max(products, key=lambda one: abs(_correlation(left, one[2])), default=None)
        if best is None or abs(_correlation(left, best[2])) < LEAST:
            break
        error, signal, rows = best
        found.append(Correlation(error, signal, _correlation(left, rows)))
        left = left - rows * float(rows @ left) / float(rows @ rows)
    return tuple(found)


def _products(chain: Chain, residuals: Residuals) -> Iterator[tuple[str, str, Array]]:
    """Error, signal and product, its mean taken out."""
    for name in chain.errors():
        signal = residuals.element.get(name.axis, "")
        if signal not in residuals.state.signals or (name.axis in chain.order) == name.place:
            continue
        warm = np.asarray(residuals.state.signals[signal], np.float64)
        part = Part(CONSTANT, signal, float(warm.mean()))
        rows = raw(chain, name, (part,), False, residuals.state, residuals.normal)[:, 0]
        factors = [np.ones(len(rows))]
        if name.axis in chain.order:
            factors.append(residuals.state.positions[:, chain.order.index(name.axis)])
        for factor in factors:
            product = rows * factor - float(np.mean(rows * factor))
            if float(np.abs(product).max()) > 0.0:
                yield str(name), signal, product


def _correlation(values: Array, product: Array) -> float:
    size = float(np.linalg.norm(values) * np.linalg.norm(product))
    return float(values @ product) / size if size > 0.0 else 0.0
