"""Which further measurement would divide a set of names: computed from what each predicts there.

A part is imagined like that on which most is wrong, but cut with another tool, at another place, or with one element
warmer. Two names that explain the data alike predict its residuals as normal distributions, from their coefficients as
the data leave them and the noise and set-ups found. How far these lie apart is the expected logarithm of the Bayes
factor: the mean of both Kullback–Leibler divergences.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.diagnosis.terms.question import Hypothesis, Posterior, Question, TakenOut, posterior, set_ups
from trueloop.diagnosis.terms.suspects import Suspect, Wrong
from trueloop.machine.model.chain import ErrorName
from trueloop.machine.model.model import State
from trueloop.wording import wording

WITHIN: Final = 0.995
"""Of the hypotheses that something is wrong, those that hold so much probability are not ruled out."""
FOUND: Final = 0.8
"""Probability that something is wrong from which it is named."""
SECOND: Final = 0.95
"""Probability from which a second error is named beside the first."""


@dataclass(frozen=True)
class TermSet:
    """One error is wrong, one of `errors`, likeliest first (`at_least` of them, where two are).

    `probability` that one of them is wrong; what is missing to 1 is that nothing is, or another. `each` has the
    probability of every one. `suspects` says what each likeliest follows. `separated_by` are measurements in words that
    would divide it, the best first; none for a single name.
    """

    errors: tuple[Wrong, ...]
    probability: float
    each: tuple[float, ...]
    suspects: tuple[Suspect, ...]
    at_least: int = 1
    separated_by: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """EXX, EBZ … and `nominal X` for anything that is not an error of an axis."""
        return tuple(str(error) for error in self.errors)

    @property
    def axis_errors(self) -> tuple[ErrorName, ...]:
        """Those that are errors of an axis."""
        return tuple(error for error in self.errors if isinstance(error, ErrorName))


def sets(hypotheses: Sequence[tuple[Hypothesis, float]]) -> tuple[TermSet, ...]:
    """Of hypotheses with probabilities, the surest first; none while something wrong is not likely.

    As many sets as the likeliest hypothesis has errors, so large that every hypothesis which is not ruled out has an
    error in each: one that exchanges an error brings its own into the set of that.
    """
    by_errors: dict[frozenset[Wrong], float] = {}
    for hypothesis, probability in hypotheses:
        errors = frozenset(suspect.error for suspect in hypothesis)
        by_errors[errors] = by_errors.get(errors, 0.0) + probability
    wrong = 1.0 - by_errors.pop(frozenset(), 0.0)
    if wrong < FOUND:
        return ()
    found = []
    for group, at_least in _groups(_credible(by_errors, wrong), by_errors):
        chance = {error: _share(by_errors, {error}) for error in group}
        ordered = tuple(sorted(group, key=lambda error: -chance[error]))
        likeliest = tuple(_likeliest(hypotheses, error) for error in ordered)
        each = tuple(chance[error] for error in ordered)
        found.append(TermSet(ordered, _share(by_errors, group), each, likeliest, at_least))
    first, *more = sorted(found, key=lambda term_set: -term_set.probability)
    return (first, *(term_set for term_set in more if term_set.probability >= SECOND))


def _credible(by_errors: Mapping[frozenset[Wrong], float], wrong: float) -> list[frozenset[Wrong]]:
    """The fewest that hold `WITHIN` of the probability that something is wrong, likeliest first."""
    found, total = [], 0.0
    for errors, probability in sorted(by_errors.items(), key=lambda item: -item[1]):
        found.append(errors)
        total += probability
        if total >= WITHIN * wrong:
            break
    return found


def _groups(
    possible: Sequence[frozenset[Wrong]], by_errors: Mapping[frozenset[Wrong], float]
) -> list[tuple[set[Wrong], int]]:
    """Names that stand for each other, and how many of them are wrong at least."""
    groups: list[set[Wrong]] = [{error} for error in possible[0]]
    for errors in possible[1:]:
        missed = [group for group in groups if not group & errors]
        free = errors - set().union(*groups)
        two = len(errors) > 1
        if missed and two and (not free or len(missed) == len(groups) > 1):
            return [(set().union(*possible), len(groups))]
        if free:
            likeliest = max(free, key=lambda error: _share(by_errors, {error}))
            for group in missed:
                group.add(likeliest)
    return [(group, 1) for group in groups]


def _share(by_errors: Mapping[frozenset[Wrong], float], group: set[Wrong]) -> float:
    return min(sum(p for errors, p in by_errors.items() if not group.isdisjoint(errors)), 1.0)


def _likeliest(hypotheses: Sequence[tuple[Hypothesis, float]], error: Wrong) -> Suspect:
    by_suspect: dict[Suspect, float] = {}
    for hypothesis, probability in hypotheses:
        for suspect in hypothesis:
            if suspect.error == error:
                by_suspect[suspect] = by_suspect.get(suspect, 0.0) + probability
    return max(by_suspect, key=lambda suspect: by_suspect[suspect])


def with_separators(terms: TermSet, separated_by: Sequence[str]) -> TermSet:
    """Returns the set with the measurements that would separate its terms."""
    return replace(terms, separated_by=tuple(separated_by))


LONGER_MM: Final = 50.0
FURTHER_MM: Final = 50.0
WARMER_K: Final = 5.0
TELLS: Final = 1.0
"""An expected logarithm of the Bayes factor from which a measurement is worth naming: odds of e to 1 from one part."""
NAMED: Final = 3
POINTS: Final = 60
"""Points of a part that are looked at, at most."""
COMPARED: Final = 4
"""The likeliest names of a set that are compared."""


@dataclass(frozen=True)
class Imagined:
    """A part that could be measured: `words` say what is different, `apart` is the expected log Bayes factor."""

    words: str
    state: State
    apart: float = 0.0


def separators(
    question: Question, products: TakenOut, terms: TermSet, hypotheses: Sequence[tuple[Hypothesis, float]]
) -> tuple[str, ...]:
    """In words, the best first; none for a single name."""
    if len(terms.errors) <= terms.at_least:
        return ()
    telling = [design.words for design in ranked(question, products, terms, hypotheses) if design.apart >= TELLS]
    return tuple(telling[:NAMED]) or (wording("the axes themselves measured: no further part would divide these"),)


def ranked(
    question: Question, products: TakenOut, terms: TermSet, hypotheses: Sequence[tuple[Hypothesis, float]]
) -> list[Imagined]:
    """Imagined parts by how well they divide the likeliest names of a set that come worst apart."""
    rivals = [
        posterior(question, products, _with(hypotheses, terms, number))
        for number in range(len(terms.errors))[:COMPARED]
    ]
    rows = _one_part(question, rivals[0])
    normal = question.seen.normal[rows]
    designs = []
    for imagined in _designs(question, rows):
        at = [_prediction(question, rival, imagined.state, normal) for rival in rivals]
        designs.append(replace(imagined, apart=float(np.mean([_apart(a, b) for a, b in combinations(at, 2)]))))
    return sorted(designs, key=lambda design: -design.apart)


def _with(hypotheses: Sequence[tuple[Hypothesis, float]], terms: TermSet, number: int) -> Hypothesis:
    """The likeliest hypothesis with one name of the set and no other."""
    error, others = terms.errors[number], set(terms.errors) - {terms.errors[number]}
    errors_at_once = max(len(hypotheses[0][0]), 1)
    for hypothesis, _ in hypotheses:
        errors = {suspect.error for suspect in hypothesis}
        if len(errors) == errors_at_once and error in errors and (not errors & others or terms.at_least > 1):
            return hypothesis
    return (terms.suspects[number],)


def _one_part(question: Question, likeliest: Posterior) -> Integers:
    """Rows of the part on which most is wrong, spread over it: what is imagined is as warm as that one."""
    index, _ = question.index(likeliest.hypothesis, question.count(likeliest.hypothesis))
    numbers, of = np.unique(question.seen.part, return_inverse=True)
    left = np.bincount(of, (question.rows[:, index] @ likeliest.mean) ** 2)
    rows = np.flatnonzero(question.seen.part == numbers[int(np.argmax(left))])
    chosen: Integers = rows[np.unique(np.linspace(0, len(rows) - 1, min(POINTS, len(rows))).astype(int))]
    return chosen


def _designs(question: Question, rows: Integers) -> Iterator[Imagined]:
    """Parts that differ from those measured in one thing."""
    state, count = question.seen.state, len(rows)
    signals = {name: np.broadcast_to(values, question.seen.part.shape)[rows] for name, values in state.signals.items()}
    mean = {name: np.full(count, np.mean(np.asarray(values))) for name, values in state.signals.items()}
    tool = np.broadcast_to(state.tool_mm, (len(question.seen.part), 3))[rows]
    here = State(state.positions[rows], _of(state.travel, rows), signals, tool)
    for name in (axis for axis in question.chain.order if axis in "XYZ"):
        moved = LONGER_MM * np.eye(3)["XYZ".index(name)]
        # the same part: a longer tool, the axis back by as much
        yield Imagined(
            wording("a tool or stylus longer or shorter by {mm:g} mm along {axis}", mm=LONGER_MM, axis=name),
            replace(here, tool_mm=tool + moved, positions=_shifted(question, here.positions, name, -LONGER_MM)),
        )
    for name in (axis for axis in question.chain.order if axis in "XYZ"):
        yield Imagined(
            wording("a part at positions of {axis} further on by {mm:g} mm", mm=FURTHER_MM, axis=name),
            replace(here, positions=_shifted(question, here.positions, name, FURTHER_MM)),
        )
    for signal in sorted(set(question.seen.element.values())):
        yield Imagined(
            wording("a part probed with {signal} alone warmer or colder by {k:g} K", signal=signal, k=WARMER_K),
            replace(here, signals={**mean, signal: mean[signal] + WARMER_K}),
        )


def _of(travel: Array | float, rows: Integers) -> Array | float:
    return travel if np.ndim(travel) == 0 else np.asarray(travel)[rows]


def _shifted(question: Question, positions: Array, axis: str, by_mm: float) -> Array:
    moved = positions.copy()
    if axis in question.chain.order:
        moved[:, question.chain.order.index(axis)] += by_mm
    return moved


def _prediction(question: Question, rival: Posterior, state: State, normal: Array) -> tuple[Array, Array]:
    """Mean (n,) and covariance (n, n) of the residuals of one more part, units of the noise to begin with."""
    shapes = [question.columns[part] for suspect in rival.hypothesis for part in suspect.parts]
    rows = np.hstack([shape.rows(question.chain, state, normal) for shape in shapes])
    own = set_ups(np.zeros(len(normal), int), normal)
    spread = rival.noise * np.eye(len(rows)) + (own.rows * rival.setting[own.way]) @ own.rows.T
    return rows @ rival.mean, spread + rows @ rival.covariance @ rows.T


def _apart(pair: tuple[Array, Array], other: tuple[Array, Array]) -> float:
    """Mean of both Kullback–Leibler divergences of two normal distributions."""
    (a, cov_a), (b, cov_b) = pair, other
    between = a - b
    total = np.trace(np.linalg.solve(cov_a, cov_b)) + np.trace(np.linalg.solve(cov_b, cov_a)) - 2 * len(a)
    total += between @ np.linalg.solve(cov_a, between) + between @ np.linalg.solve(cov_b, between)
    return float(total) / 4
