"""Names that the data cannot divide, as sets: never one name out of a set."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.diagnosis.terms.question import Hypothesis
from trueloop.diagnosis.terms.suspects import Suspect, Wrong
from trueloop.machine.model.names import ErrorName

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
        """EXX, EBZ … and `nominal X` for what is no error of an axis."""
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
        errors = frozenset(one.error for one in hypothesis)
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
    first, *more = sorted(found, key=lambda one: -one.probability)
    return (first, *(one for one in more if one.probability >= SECOND))


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
        for one in hypothesis:
            if one.error == error:
                by_suspect[one] = by_suspect.get(one, 0.0) + probability
    return max(by_suspect, key=lambda one: by_suspect[one])


def with_separators(one: TermSet, separated_by: Sequence[str]) -> TermSet:
    """Returns the set with the measurements that would separate its terms."""
    return replace(one, separated_by=tuple(separated_by))
