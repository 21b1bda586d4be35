"""Which cuts are of an edge as it is mounted now, and with which setting each was made, by the events of the edge."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from trueloop.domain.edge_life import lives, time_of
from trueloop.domain.life import Cut, EdgeEvent
from trueloop.domain.tool import Edge
from trueloop.storage.kinds import joined
from trueloop.storage.store import Kept, Store, find


def since_mounting(store: Store, edge: Edge, cuts: Sequence[Kept[Cut]]) -> list[Kept[Cut]]:
    """Returns the cuts since the latest mounting of an edge, each with its setting by the events of the edge.

    A new insert of the same designation has another form: what earlier ones cut tells nothing of it. A cut stated to
    be after the edge was turned away or removed is another edge's (EDG-ENDED names it). A cut of unknown time counts as
    long as there was one mounting alone. Without events the cuts are as they were kept.
    """
    known = lives(kept.value for kept in find(store, EdgeEvent, edge=joined(edge.identity)))
    if not known:
        return list(cuts)

    def of_latest() -> Iterator[Kept[Cut]]:
        for kept in cuts:
            at = time_of(kept.value)
            then = None if at is None else known[-1].before(at)
            if at is None and len(known) == 1:
                yield kept
            elif then is not None and then.ended is None:
                yield replace(kept, value=replace(kept.value, setting=then.setting))

    return list(of_latest())
