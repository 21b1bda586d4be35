"""Errors of single features from readings of several: a length between faces that two edges cut."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.turned.touches.seen import Seen
from trueloop.wording import all_of, wording

SOLVED: Final = 1.0 - 1e-6
"""A place that readings determine: less is one whose error another one's may take."""
Place = tuple[int, float]
"""Feature and arc length, mm."""


def determined(seen: Sequence[Seen]) -> dict[Place, tuple[float, float]]:
    """Returns the errors at places that readings determine, (error, standard uncertainty) in mm, in the order of the
    places, by weighted least squares. What holds by definition is exact.
    """
    exact = {_places(one)[0]: one.value_mm / float(one.weight[0]) for one in seen if one.standard_u_mm == 0.0}
    rows = [one for one in seen if one.standard_u_mm > 0.0]
    free = sorted({place for one in rows for place in _places(one)} - exact.keys())
    terms, values = np.zeros((len(rows), len(free))), np.zeros(len(rows))
    for row, one in enumerate(rows):
        values[row] = one.value_mm / one.standard_u_mm
        for place, weight in zip(_places(one), (one.weight / one.standard_u_mm).tolist(), strict=True):
            if place in exact:
                values[row] -= weight * exact[place]
            else:
                terms[row, free.index(place)] += weight
    inverse = np.linalg.pinv(terms, rcond=1e-9)
    error, solved, u = inverse @ values, np.diag(inverse @ terms), np.linalg.norm(inverse, axis=1)
    by_rows = {p: (float(error[k]), float(u[k])) for k, p in enumerate(free) if solved[k] >= SOLVED}
    return {place: (error_mm, 0.0) for place, error_mm in exact.items()} | by_rows


def own_seen(seen: Sequence[Seen], own: Collection[int]) -> tuple[Seen, ...]:
    """Returns what readings state of the features `own` alone: those that see no others, and shared ones in which the
    remaining readings determine the errors of all others: these are taken out, their variance is added.
    """
    return tuple(alone for one in seen if (alone := own_part(one, seen, own)) is not None)


def own_part(one: Seen, seen: Sequence[Seen], own: Collection[int]) -> Seen | None:
    """Returns what one of `seen` states of the features `own` alone; None where it states nothing of them, or the
    errors of others cannot be taken out.
    """
    mine = np.isin(one.feature_index, list(own))
    if mine.all() or not mine.any():
        return one if mine.all() else None
    others = [k for k, is_mine in enumerate(mine.tolist()) if not is_mine]
    known, places = determined([other for other in seen if other is not one]), _places(one)
    if any(places[k] not in known for k in others):
        return None
    weights = one.weight[others]
    errors_mm, u_mm = np.array([known[places[k]] for k in others]).T
    return replace(
        one,
        feature_index=one.feature_index[mine],
        arc_length_mm=one.arc_length_mm[mine],
        weight=one.weight[mine],
        value_mm=one.value_mm - float(weights @ errors_mm),
        standard_u_mm=float(np.linalg.norm([one.standard_u_mm, *(weights * u_mm)])),
    )


def _places(one: Seen) -> list[Place]:
    return list(zip(one.feature_index.tolist(), one.arc_length_mm.tolist(), strict=True))


def shared_words(seen: Sequence[Seen], owns: Sequence[Collection[int]], names: Sequence[str]) -> list[str]:
    """Returns in words what readings of features of several owners correct; `owns` are the features of each, `names`
    those of all features.
    """
    found: list[str] = []
    unused: list[str] = []
    for one in seen:
        of = {*one.feature_index.tolist()}
        if any(of <= {*own} for own in owns):
            continue
        corrected = [of & {*own} for own in owns if own_part(one, seen, own) is not None]
        found.extend(
            wording(
                "{name}: taken as the error of {feature}, counted from {other}.",
                name=one.name,
                feature=all_of([names[index] for index in sorted(mine)]),
                other=all_of([names[index] for index in sorted(of - mine)]),
            )
            for mine in corrected
        )
        unused.extend([] if corrected else [one.name])
    if unused:
        found.append(
            wording(
                "{names}: between features that are not cut together, and corrects none of them: no other reading "
                "states where one of them is.",
                names=all_of(unused),
            )
        )
    return found
