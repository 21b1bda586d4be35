"""In which order an edge cut its parts, by what was stated and by times; parts that contradict are in doubt."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from trueloop.domain.life import Cut


@dataclass(frozen=True)
class Dated:
    """A finish cut with when its part was inspected, where that is known. `kept` counts cuts as they were stored."""

    cut: Cut
    inspected_at: datetime | None
    kept: int


@dataclass(frozen=True)
class Ordered:
    """Cuts as they are taken to have been made, each with its place in the order, from 0, and whether that is sure."""

    places: tuple[int, ...]
    in_doubt: tuple[bool, ...]


def cutting_order(cuts: Sequence[Dated]) -> Ordered:
    """By the stated order where all have one, else by the time of the cut, else as they were stored.

    In doubt are cuts that say so, and the fewest without which the stated orders, the times of the cuts and those of
    the inspections agree: a part was inspected before one that is said to have been cut earlier.
    """
    stated = [None if one.cut.order is None else float(one.cut.order) for one in cuts]
    made = [None if one.cut.at is None else one.cut.at.timestamp() for one in cuts]
    inspected = [None if one.inspected_at is None else one.inspected_at.timestamp() for one in cuts]
    kept = [float(one.kept) for one in cuts]
    base = next(known for known in (stated, made, kept) if None not in known)
    places = sorted(range(len(cuts)), key=lambda k: (base[k] or 0.0, kept[k]))
    doubted = {k for by in (stated, made, inspected) for k in _against([k for k in places if by[k] is not None], by)}
    unordered = base is kept and len(cuts) > 1
    return Ordered(tuple(places), tuple(unordered or k in doubted or cuts[k].cut.order_in_doubt for k in places))


def _against(places: Sequence[int], by: Sequence[float | None]) -> set[int]:
    """The fewest whose value has to be left out so that the others do not fall: all but a longest rising sequence."""
    ends: list[float] = []
    reached: list[int] = []
    for k in places:
        value = by[k] or 0.0
        at = bisect_right(ends, value)
        ends[at : at + 1] = [value]
        reached.append(at)
    out, level = set[int](), len(ends) - 1
    for k, at in zip(reversed(places), reversed(reached), strict=True):
        if at == level:
            level -= 1
        else:
            out.add(k)
    return out
