"""Whether the order in which an edge cut its parts is sure, with one more cut."""

from collections.abc import Iterator
from datetime import datetime

from trueloop.domain.life import Cut, Stage
from trueloop.errors import Code, Finding, Severity
from trueloop.jobs.store.history import finish_inspection
from trueloop.jobs.store.order import Dated, cutting_order
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find


def order_in_doubt(store: Store, cut: Cut, inspected_at: datetime | None) -> Iterator[Finding]:
    """Yields a warning where the stated order and the times of an edge's finish cuts contradict each other."""
    if cut.setting is None:
        return
    edge = joined(cut.setting.edge.identity)
    others = [one for one in find(store, Cut, edge=edge, stage=Stage.FINISH) if one.value.identity != cut.identity]
    dated = [Dated(one.value, _inspected_at(store, one.value), one.row) for one in others]
    dated.append(Dated(cut, inspected_at, max((one.row for one in others), default=0) + 1))
    found = cutting_order(dated)
    doubted = [dated[k].cut.part.serial for k, doubt in zip(found.places, found.in_doubt, strict=True) if doubt]
    if doubted:
        yield Finding(
            Severity.WARNING,
            Code.STO_ORDER,
            f"in which order this edge cut {', '.join(map(repr, doubted[:6]))} is in doubt: what is stated, the times "
            "of the inspections and the serial numbers contradict each other, or neither an order nor times are stated",
            hint="state it: --order NUMBER counts the parts of the edge as they were cut",
            values={"serials": doubted[:6]},
        )


def _inspected_at(store: Store, cut: Cut) -> datetime | None:
    found = finish_inspection(store, cut)
    return None if found is None else found.measured_at
