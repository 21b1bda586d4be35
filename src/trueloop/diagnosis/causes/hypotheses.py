"""Hypotheses of causes and their probabilities: none, one, two at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.causes.catalogue import CAUSES, SIZES_OF_FORM
from trueloop.diagnosis.causes.columns import Variant, columns, variants
from trueloop.diagnosis.causes.form import Cell, log_form
from trueloop.diagnosis.causes.rows import Row, values_mm
from trueloop.diagnosis.causes.seen_part import SeenSeries
from trueloop.diagnosis.causes.weighing import Weighed, log_evidence, weighed

NONE, ONE, TWO = 0.85, 0.135, 0.015
"""Beforehand: how probable no cause, one cause and two are."""
LIKELY: Final = 12
"""Variants of which all pairs are tried, beside those of the likeliest half of them with every other."""
Hypothesis = tuple[int, ...]


@dataclass(frozen=True)
class Asked:
    """Variants with their columns beside each other: variant v has `columns[:, blocks[v]]`; `prior` is its share."""

    variants: tuple[Variant, ...]
    blocks: tuple[slice, ...]
    columns: Array
    prior: tuple[float, ...]


def asked(rows: Sequence[Row], form: Mapping[Cell, tuple[str, float, float]], series: SeenSeries) -> Asked:
    """All variants that could show on these errors; of two that would leave the same, both."""
    kept, blocks, found, at = [], [], [np.zeros((len(rows), 0))], 0
    for cause in CAUSES:
        of_form = any((sign.kind, by) in form for sign in cause.signs for by in sign.seen_by if sign.needed)
        of_form = of_form and all(sign.kind in SIZES_OF_FORM for sign in cause.signs if sign.needed)
        seen: list[Array] = []
        for variant in variants(cause, series):
            block = columns(variant, rows, series)
            known = any(one.shape == block.shape and np.array_equal(one, block) for one in seen)
            if known or not (block.shape[1] or of_form):
                continue
            seen.append(block)
            kept.append(variant)
            blocks.append(slice(at, at + block.shape[1]))
            found.append(block)
            at += block.shape[1]
    return Asked(tuple(kept), tuple(blocks), np.hstack(found), _shares(kept))


def log_weights(
    given: Asked, rows: Sequence[Row], form: Mapping[Cell, tuple[str, float, float]], series: SeenSeries, gain: float
) -> dict[Hypothesis, float]:
    """Prior times likelihood of every hypothesis, as logarithms, by the numbers of its variants."""
    tools = {name: place.tool for name, place in series.features.items()}
    one = weighed(rows, tools, given.columns, values_mm(tuple(rows), gain))
    found: dict[Hypothesis, float] = {(): np.log(NONE) + log_evidence(one, [])}
    for v, share in enumerate(given.prior):
        found[(v,)] = np.log(ONE * share) + _log_likelihood(given, one, form, (v,))
    return found | _pairs(given, one, form, found)


def _pairs(
    given: Asked, one: Weighed, form: Mapping[Cell, tuple[str, float, float]], singles: Mapping[Hypothesis, float]
) -> dict[Hypothesis, float]:
    """Pairs of the likeliest variants with each other, and of the likeliest few with all."""
    order = sorted((h[0] for h in singles if h), key=lambda v: -singles[(v,)])
    best: dict[tuple[str, str], int] = {}
    for v in order:
        best.setdefault(given.variants[v].who, v)
    first = list(best.values())
    tried = {*combinations(sorted(first), 2)}
    tried |= {(min(a, b), max(a, b)) for a in [*order[:3], *first[:4]] for b in order if a != b}
    found: dict[Hypothesis, float] = {}
    for a, b in sorted(tried):
        if given.variants[a].who != given.variants[b].who:
            prior = TWO * 2 * given.prior[a] * given.prior[b]
            found[(a, b)] = np.log(prior) + _log_likelihood(given, one, form, (a, b))
    return found


def _log_likelihood(
    given: Asked, one: Weighed, form: Mapping[Cell, tuple[str, float, float]], chosen: Hypothesis
) -> float:
    blocks = [given.blocks[v] for v in chosen if given.blocks[v].stop > given.blocks[v].start]
    return log_evidence(one, blocks) + log_form(form, [given.variants[v].cause for v in chosen])


def _shares(kept: Sequence[Variant]) -> tuple[float, ...]:
    """A cause's prior in equal shares for its tools and ways to show; steps share one of these."""
    ways: dict[str, set[object]] = {}
    for one in kept:
        ways.setdefault(one.cause.key, set()).add(_way(one))
    steps: dict[object, int] = {}
    for one in kept:
        steps[(one.cause.key, _way(one))] = steps.get((one.cause.key, _way(one)), 0) + 1
    found = [one.cause.prior / len(ways[one.cause.key]) / steps[(one.cause.key, _way(one))] for one in kept]
    return tuple(share / sum(found) for share in found)


def _way(one: Variant) -> object:
    return one.tool, one.over, one.signs
