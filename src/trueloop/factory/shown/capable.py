"""Cpk of what was made today: of the latest parts of each type, so that a page that is asked often costs little."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np
from sqlalchemy import and_, select

from trueloop.domain.life import Stage
from trueloop.errors import Code, TrueloopError
from trueloop.factory.load import Known
from trueloop.factory.views.today import Cpk
from trueloop.loops.post_process.tracked import CAPABLE_FROM
from trueloop.monitoring.capability import capability
from trueloop.storage.factory_tables import PART_STATE
from trueloop.storage.kinds import searchable
from trueloop.storage.tables import ROWS, TABLES

LATEST: Final = 100
"""Inspections of a type that are looked at, the latest."""
MOST: Final = 12
"""Characteristics shown, those with the least Cpk."""
_Limits = tuple[float | None, float | None, float | None]
_Cpk = tuple[float | None, float | None, float | None]
NONE: Final[_Cpk] = (None, None, None)


def cpk_of_today(known: Known, finished: Sequence[str], began: str) -> tuple[Cpk, ...]:
    """Of the part types of which parts came to one of the states `finished` since `began`; the least first."""
    part = TABLES["part"]
    made = select(part.c.part_type).join(PART_STATE, PART_STATE.c.part == part.c.id).distinct()
    today = made.where(PART_STATE.c.changed_at >= began, PART_STATE.c.state.in_(finished))
    names: Sequence[str] = known.connection.scalars(today).all()
    found = [one for name in names for one in _of_type(known, name)]
    return tuple(sorted(found, key=lambda one: (one.cpk is None, one.cpk or 0.0))[:MOST])


def _of_type(known: Known, part_type: str) -> Iterator[Cpk]:
    """Each characteristic with the nominal and limits of its latest part; earlier ones of others are another series."""
    series: dict[str, tuple[_Limits, dict[int, float]]] = {}
    for row in _readings(known, part_type):
        limits: _Limits = (row.nominal, row.lower_limit, row.upper_limit)
        asked, values = series.setdefault(row.characteristic, (limits, {}))
        if asked == limits:
            values.setdefault(row.inspection, row.actual)
    for name, ((_, lower, upper), values) in series.items():
        if lower is not None or upper is not None:
            in_order = tuple(values.values())[::-1]
            cpk, low, high = _cpk(in_order, lower, upper) if len(values) >= CAPABLE_FROM else NONE
            yield Cpk(part_type, name, cpk, low, high, len(values), CAPABLE_FROM)


def _readings(known: Known, part_type: str) -> Iterator[Any]:
    """Of the last inspection of each of the latest parts, the latest first; of no part that was not finished yet."""
    inspection, reading = TABLES["inspection"], ROWS["reading"]
    later = inspection.alias("later")
    query = (
        select(inspection.c.id, inspection.c.identity, inspection.c.serial)
        .outerjoin(later, later.c.supersedes == inspection.c.id)
        .where(inspection.c.part_type == searchable(part_type), later.c.id.is_(None))
    )
    seen: dict[str, int] = {}
    rows = known.rows(query.order_by(inspection.c.id.desc()).limit(LATEST))
    early = _early(known, part_type, [one.serial for one in rows])
    for row in rows:
        if row.identity not in early:
            seen.setdefault(row.serial, row.id)
    wanted = and_(reading.c.inspection.in_(seen.values()), reading.c.nominal.is_not(None))
    return iter(known.rows(select(reading).where(wanted).order_by(reading.c.inspection.desc(), reading.c.position)))


def _early(known: Known, part_type: str, serials: Sequence[str]) -> set[str]:
    """Inspections that show an earlier cut than the finish cut."""
    cut, link = TABLES["cut"], TABLES["inspection_link"]
    cuts = select(cut.c.identity).where(
        *(cut.c.part_type == searchable(part_type), cut.c.serial.in_(serials), cut.c.stage != Stage.FINISH.value)
    )
    return set(known.connection.scalars(select(link.c.identity).where(link.c.cut.in_(cuts))))


@lru_cache(maxsize=4096)
def _cpk(values: tuple[float, ...], lower: float | None, upper: float | None) -> _Cpk:
    """Cpk with its 95 % interval; None of values that are all equal, or of limits that are none."""
    try:
        found = capability(np.array(values), lower, upper).indices
    except TrueloopError as refused:
        if refused.code not in (Code.MON_FEW, Code.MON_LIMITS):
            raise
        return NONE
    one = next(each for each in found if each.name == "Cpk")
    return one.value, one.low, one.high
