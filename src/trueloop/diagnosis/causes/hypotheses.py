"""Hypotheses of causes and their probabilities: none, one, two at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.diagnosis.causes.catalogue import CAUSES
from trueloop.diagnosis.causes.seen_part import SeenSeries
from trueloop.diagnosis.causes.surface import SurfaceErrors
from trueloop.diagnosis.causes.ways import SEEN_MM, Way, block_of, ways
from trueloop.diagnosis.causes.weighing import Products, Weighed, log_beside, log_evidence, products_of

NONE, ONE, TWO = 0.85, 0.135, 0.015
"""Beforehand: how probable no cause, one cause and two are."""
LIKELY: Final = 3
"""The likeliest ways are looked at with every other."""
BEST: Final = 8
"""So many of the likeliest causes are tried with each other, and so many with each of the likeliest ways."""
WIDE: Final = 60
"""Columns of two blocks together beyond which they are not tried as a pair."""
Hypothesis = tuple[int, ...]


@dataclass(frozen=True)
class Asked:
    """Ways with their columns: way v has `columns[:, blocks[v]]`, several may share one; `prior` is its share."""

    ways: tuple[Way, ...]
    blocks: tuple[Integers, ...]
    columns: Array
    prior: tuple[float, ...]
    products: Products


def asked(errors: SurfaceErrors, series: SeenSeries) -> Asked:
    """All ways that an instrument would see; of two causes that would leave the same, both."""
    kept, blocks, found = list[Way](), list[Integers](), dict[bytes, Array]()
    number: dict[bytes, int] = {}
    for cause in CAUSES:
        seen = set[tuple[int, ...]]()
        for way in ways(cause, errors, series):
            block = block_of(way, errors)
            keys = [column.tobytes() for column in block.T]
            found |= dict(zip(keys, block.T, strict=True))
            columns = tuple(number.setdefault(key, len(number)) for key in keys)
            if columns in seen or not (columns or way.wavy):
                continue
            seen.add(columns)
            kept.append(way)
            blocks.append(np.array(columns, dtype=np.intp))
    joined = np.column_stack([np.zeros((len(errors), 0)), *(found[key] for key in number)])
    products = products_of(errors, joined)
    visible = [v for v, way in enumerate(kept) if way.wavy or _visible(products, blocks[v])]
    chosen = [kept[v] for v in visible]
    return Asked(tuple(chosen), tuple(blocks[v] for v in visible), joined, _shares(chosen), products)


def log_weights(given: Asked, gain: float) -> dict[Hypothesis, float]:
    """Prior times likelihood of every hypothesis, as logarithms, by the numbers of its ways."""
    whole = given.products.at(gain)
    by_waves = (whole.only(wavy=False), whole.only(wavy=True))
    found: dict[Hypothesis, float] = {(): np.log(NONE) + log_evidence(by_waves[0], [])}
    for v, share in enumerate(given.prior):
        found[(v,)] = np.log(ONE * share) + _log_likelihood(given, by_waves, (v,))
    return found | _pairs(given, by_waves, found)


def acting(given: Asked, chosen: Hypothesis) -> list[int]:
    """Those that have columns."""
    return [v for v in chosen if len(given.blocks[v])]


def _visible(products: Products, block: Integers) -> bool:
    """Returns whether the largest size that matters would be seen with more than one standard uncertainty."""
    information = np.diagonal(products.joined[0])[block]
    return bool(np.max(information, initial=0.0) * SEEN_MM**2 > 1.0)


def _pairs(
    given: Asked, by_waves: tuple[Weighed, Weighed], singles: Mapping[Hypothesis, float]
) -> dict[Hypothesis, float]:
    """Pairs of the likeliest ways with each other, and of the likeliest few with all."""
    order = sorted((h[0] for h in singles if h), key=lambda v: -singles[(v,)])
    best: dict[tuple[str, str], int] = {}
    for v in order:
        best.setdefault(given.ways[v].who, v)
    first = list(best.values())
    tried = {*combinations(sorted(first[:BEST]), 2)}
    for a in {*order[:LIKELY], *first[:LIKELY]}:
        others = [b for b in order if _may_join(given, a, b)]
        looked = log_beside(by_waves[given.ways[a].wavy], given.blocks[a], [given.blocks[b] for b in others])
        weights = [np.log(given.prior[b]) + log for b, log in zip(others, looked, strict=True)]
        promising = sorted(range(len(others)), key=lambda k: -weights[k])[:BEST]
        waves = [k for k, b in enumerate(others) if given.ways[b].wavy]
        tried |= {(min(a, others[k]), max(a, others[k])) for k in (*promising, *waves)}
    found: dict[Hypothesis, float] = {}
    for a, b in sorted(tried):
        if _may_join(given, a, b):
            prior = TWO * 2 * given.prior[a] * given.prior[b]
            found[(a, b)] = np.log(prior) + _log_likelihood(given, by_waves, (a, b))
    return found


def _may_join(given: Asked, a: int, b: int) -> bool:
    """Returns whether two ways are of two causes, and no more columns than can be tried."""
    wide = len(given.blocks[a]) + len(given.blocks[b]) > WIDE
    return given.ways[a].who != given.ways[b].who and not wide


def _log_likelihood(given: Asked, by_waves: tuple[Weighed, Weighed], chosen: Hypothesis) -> float:
    wavy = any(given.ways[v].wavy for v in chosen)
    return log_evidence(by_waves[wavy], [given.blocks[v] for v in acting(given, chosen)])


def _shares(kept: Sequence[Way]) -> tuple[float, ...]:
    """A cause's prior in equal shares for its tools and ways to show; steps share one of these."""
    of: dict[str, set[object]] = {}
    steps: dict[object, int] = {}
    for one in kept:
        of.setdefault(one.cause.key, set()).add(_way(one))
        steps[_way(one)] = steps.get(_way(one), 0) + 1
    found = [one.cause.prior / len(of[one.cause.key]) / steps[_way(one)] for one in kept]
    return tuple(share / sum(found) for share in found)


def _way(one: Way) -> object:
    return one.cause.key, one.tool, one.over, one.form, one.seen_by
