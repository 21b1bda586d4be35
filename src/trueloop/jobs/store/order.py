"""In which order an edge cut its parts, by what was stated and by times; parts that contradict are in doubt."""

import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Final

from trueloop.domain.life import Cut, EdgeEvent, lives, time_of
from trueloop.domain.tool import Edge
from trueloop.storage.kinds import joined
from trueloop.storage.store import Kept, Store, find

NUMBER: Final = re.compile(r"\d+(\.\d+)?")
"""The beginning of a serial number."""


@dataclass(frozen=True)
class Dated:
    """A finish cut with when its part was inspected and, before that, touched, where that is known. `kept` counts cuts
    as they were stored.
    """

    cut: Cut
    inspected_at: datetime | None
    kept: int
    touched_at: datetime | None = None


@dataclass(frozen=True)
class Ordered:
    """Cuts as they are taken to have been made, each with its place in the order, from 0, and whether that is sure."""

    places: tuple[int, ...]
    in_doubt: tuple[bool, ...]


def cutting_order(cuts: Sequence[Dated]) -> Ordered:
    """Orders cuts by the stated order where all have one, else by the time of the cut, of the inspection, of the
    touches, else as they were stored.

    In doubt are cuts that are marked so, and the fewest without which the stated orders, these times and, where no
    order and no time of the cut is stated, the serial numbers agree: a part was inspected before one that is stated
    to have been cut earlier.
    """
    stated = [None if one.cut.order is None else float(one.cut.order) for one in cuts]
    made, inspected = _times([one.cut.at for one in cuts]), _times([one.inspected_at for one in cuts])
    touched = _times([one.touched_at for one in cuts])
    kept: list[float | None] = [float(one.kept) for one in cuts]
    base = next(known for known in (stated, made, inspected, touched, kept) if None not in known)
    places = sorted(range(len(cuts)), key=lambda k: (base[k] or 0.0, cuts[k].kept))
    facts = [stated, made, inspected, touched, *([] if base is stated or base is made else [_by_number(cuts)])]
    doubted = {k for by in facts for k in _against([k for k in places if by[k] is not None], by)}
    unordered = base is kept and len(cuts) > 1
    return Ordered(tuple(places), tuple(unordered or k in doubted or cuts[k].cut.order_in_doubt for k in places))


def _times(of: Sequence[datetime | None]) -> list[float | None]:
    return [None if one is None else one.timestamp() for one in of]


def _by_number(cuts: Sequence[Dated]) -> list[float | None]:
    """Serial numbers within a part type rise as parts are made; of several part types they say nothing."""
    kinds = {one.cut.part.part_type.identity for one in cuts}
    found = [NUMBER.match(one.cut.part.serial) for one in cuts]
    return [None if one is None or len(kinds) > 1 else float(one[0]) for one in found]


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


def since_mounting(store: Store, edge: Edge, cuts: Sequence[Kept[Cut]]) -> list[Kept[Cut]]:
    """Returns the cuts since the latest mounting of an edge, each with its setting by the events of the edge.

    A new insert of the same designation has another form: what earlier ones cut tells nothing of it. A cut stated to
    be after the edge was turned away or removed is another edge's (EDG-ENDED names it). A cut of unknown time counts as
    long as there was one mounting alone. Without events the cuts are as they were kept.
    """
    return [kept for ago, kept in mountings(store, edge, cuts) if not ago]


def mountings(store: Store, edge: Edge, cuts: Sequence[Kept[Cut]]) -> Iterator[tuple[int, Kept[Cut]]]:
    """Yields cuts as `since_mounting` takes them, of all mountings, each with how many mountings ago it was made."""
    known = lives(kept.value for kept in find(store, EdgeEvent, edge=joined(edge.identity)))
    for kept in cuts:
        at = time_of(kept.value)
        life = next((life for life in reversed(known) if at is not None and life.began <= at), None)
        then = None if at is None or life is None else life.before(at)
        if not known or (at is None and len(known) == 1):
            yield 0, kept
        elif then is not None and life is not None and then.ended is None:
            ago = len(known) - 1 - known.index(life)
            yield ago, replace(kept, value=replace(kept.value, setting=then.setting))
