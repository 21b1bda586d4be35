"""What is wrong with a series of parts: probabilities of causes from feature errors of all parts [4773 §4]."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from trueloop.diagnosis.causes.candidate import Candidate, Diagnosis
from trueloop.diagnosis.causes.form import Cell, largest
from trueloop.diagnosis.causes.hypotheses import Asked, Hypothesis, asked, log_weights
from trueloop.diagnosis.causes.noticed import noticed
from trueloop.diagnosis.causes.rows import Row, rows_of, signed, sizes, values_mm
from trueloop.diagnosis.causes.seen_part import SeenSeries
from trueloop.diagnosis.causes.weighing import Size, Weighed, size_of, weighed
from trueloop.diagnosis.causes.words import against, decide, support
from trueloop.diagnosis.evidence import shares
from trueloop.errors import Code, TrueloopError

GAINS: Final = {1.0: 0.98, 0.0: 0.01, 2.0: 0.01}
"""What share of a recorded correction may have arrived on the parts, and how probable that is beforehand."""
SHOWN: Final = 0.001
"""Candidates that are less probable are left out."""


def judge(series: SeenSeries) -> Diagnosis:
    """Probabilities of the causes in the catalogue, with evidence, and what would decide where several are left.

    The answer is a set: causes that leave the same share the probability as they had it beforehand. Errors are taken as
    they had been without the corrections that are recorded. Raises DIA-FEW where there is no feature error at all.
    Valid while errors add, scatter is normal and at most two causes act.
    """
    rows = rows_of(series)
    if not rows:
        raise TrueloopError(
            Code.DIA_FEW,
            f"{len(series.parts)} parts with 0 feature errors, of at least 1 that a diagnosis needs",
            hint="inspect the parts on the machine, by a gauge or on a measuring machine",
            values={"count": 0, "needed": 1},
        )
    errors, form = signed(rows), largest(sizes(rows))
    given = asked(errors, form, series)
    by_gain = {gain: log_weights(given, errors, form, series, gain) for gain in _gains(errors)}
    whole = {gain: np.log(GAINS[gain]) + np.logaddexp.reduce(list(log.values())) for gain, log in by_gain.items()}
    gain, certain = next(iter(shares(whole).items()))
    found = shares(by_gain[gain])
    candidates = _candidates(given, errors, form, series, gain, found)
    return Diagnosis(
        candidates, _by_key(given, found), found[()], decide(candidates, series, rows), gain,
        noticed(series, gain, certain),
    )  # fmt: skip


def _gains(errors: Sequence[Row]) -> list[float]:
    return [gain for gain in GAINS if gain == 1.0 or any(row.corrected_mm for row in errors)]


def _by_key(given: Asked, found: Mapping[Hypothesis, float]) -> tuple[tuple[tuple[str, ...], float], ...]:
    by_key: dict[tuple[str, ...], float] = {}
    for hypothesis, share in found.items():
        key = tuple(sorted({given.variants[v].cause.key for v in hypothesis}))
        by_key[key] = by_key.get(key, 0.0) + share
    return tuple(sorted(by_key.items(), key=lambda item: -item[1]))


def _candidates(
    given: Asked,
    errors: Sequence[Row],
    form: Mapping[Cell, tuple[str, float, float]],
    series: SeenSeries,
    gain: float,
    found: Mapping[Hypothesis, float],
) -> tuple[Candidate, ...]:
    """One a cause and tool, sized as in the likeliest hypothesis that holds it."""
    total: dict[tuple[str, str], float] = {}
    first: dict[tuple[str, str], tuple[Hypothesis, int]] = {}
    for hypothesis, share in found.items():
        for v in hypothesis:
            who = given.variants[v].who
            total[who] = total.get(who, 0.0) + share
            first.setdefault(who, (hypothesis, v))
    tools = {name: place.tool for name, place in series.features.items()}
    one = weighed(errors, tools, given.columns, values_mm(tuple(errors), gain))
    made = []
    for who, probability in sorted(total.items(), key=lambda item: -item[1]):
        if probability >= SHOWN:
            made.append(_candidate(given, errors, form, series, one, *first[who], probability))
    return tuple(made)


def _candidate(
    given: Asked,
    errors: Sequence[Row],
    form: Mapping[Cell, tuple[str, float, float]],
    series: SeenSeries,
    one: Weighed,
    hypothesis: Hypothesis,
    v: int,
    probability: float,
) -> Candidate:
    variant, block = given.variants[v], given.blocks[v]
    cells = [
        cell
        for cell in form
        if any(s.needed and s.kind is cell[0] and cell[1] in s.seen_by for s in variant.cause.signs)
    ]
    if block.stop > block.start:
        acting = [u for u in hypothesis if given.blocks[u].stop > given.blocks[u].start]
        size = size_of(one, [given.blocks[u] for u in acting], acting.index(v), given.columns[:, block])
        features = _features(errors, size)
    else:
        feature, mean, u = max((form[cell] for cell in cells), key=lambda item: item[1])
        size, features = Size(mean, u, np.zeros(len(errors))), (feature,)
    return Candidate(
        variant.cause, features, probability, size.mm, size.standard_u_mm,
        support(variant, errors, form, series, size, cells), against(variant, errors, form, series, size, cells),
        variant.tool,
    )  # fmt: skip


def _features(errors: Sequence[Row], size: Size) -> tuple[str, ...]:
    """Those on which it leaves a third of its largest effect or more."""
    much = np.abs(size.effect_mm) >= abs(size.mm) / 3
    return tuple(dict.fromkeys(row.feature for row, is_much in zip(errors, much, strict=True) if is_much))
