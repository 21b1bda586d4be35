"""Parts in lists."""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np
from sqlalchemy import Select, and_, bindparam, select

from trueloop.described import filled_from
from trueloop.domain.characteristic import Quantity
from trueloop.domain.factory import PartState, Run, RunFact
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.life import Stage
from trueloop.domain.part import Part
from trueloop.domain.record import Product, Record
from trueloop.errors import Code, TrueloopError
from trueloop.factory.known import unknown
from trueloop.factory.load import StoreReader, step_now
from trueloop.factory.shown.records import LIMIT, before, certificate_rows_of, event_view, known_of, page_of, time
from trueloop.factory.views.orders import Cpk, Page
from trueloop.factory.views.parts import (
    CorrectionView,
    EventView,
    FactView,
    InspectionView,
    PartLife,
    PartRow,
    Result,
    StepView,
)
from trueloop.loops.post_process.tracked import CAPABLE_FROM
from trueloop.monitoring.capability import capability
from trueloop.storage.keeping import decoded
from trueloop.storage.kinds import joined, kind_of, searchable
from trueloop.storage.schema import EVENT, ORDER_STATE, PART_STATE, ROWS, STEP, TABLES
from trueloop.storage.store import Life, Store, life_in
from trueloop.storage.value_rows import Kept
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

_PART = TABLES["part"]
_COLUMNS = (
    *(_PART.c.id, _PART.c.document, _PART.c.kept_at),
    *(PART_STATE.c.state, PART_STATE.c.order, PART_STATE.c.machine, PART_STATE.c.changed_at, PART_STATE.c.held_why),
)
_ONE = (
    select(*_COLUMNS)
    .select_from(_PART.join(PART_STATE, PART_STATE.c.part == _PART.c.id, isouter=True))
    .where(_PART.c.id == bindparam("number"))
)


def part_rows(
    store: Store,
    *,
    part_type: str | None = None,
    serial: str | None = None,
    state: PartState | None = None,
    limit: int = LIMIT,
    cursor: str | None = None,
) -> Page[PartRow]:
    """Parts, the latest that was named first; of a type, a serial number, a state."""
    key = _PART.c.id if state is None else PART_STATE.c.part
    query = select(*_COLUMNS).select_from(
        _PART.join(PART_STATE, PART_STATE.c.part == _PART.c.id, isouter=state is None)
    )
    if part_type is not None:
        query = query.where(_PART.c.part_type == searchable(part_type))
    if serial is not None:
        query = query.where(_PART.c.serial == searchable(serial))
    if state is not None:
        query = query.where(PART_STATE.c.state == state.value)
    with known_of(store) as known:
        rows = known.rows(before(query, key, limit, cursor))
        return page_of(rows, limit, lambda row: int(row.id), lambda row: row_of(known, row))


def part_of(reader: StoreReader, number: int) -> tuple[PartRow, Part]:
    """Returns one part, and its value. Raises FAC-UNKNOWN."""
    row = reader.connection.execute(_ONE, {"number": number}).one_or_none()
    if row is None:
        raise unknown(wording("part"), str(number), wording("the store has no such row"))
    part = reader.codec.from_json(row.document, Part)
    return _row(part, row), part


def row_of(reader: StoreReader, row: Any) -> PartRow:
    """Makes a part from its row, with what its order has made of it."""
    return _row(reader.codec.from_json(row.document, Part), row)


def _row(part: Part, row: Any) -> PartRow:
    return PartRow(
        id=row.id,
        part_type=part.part_type.name,
        revision=part.part_type.revision,
        serial=part.serial,
        state=None if row.state is None else PartState(row.state),
        order=row.order or "",
        machine=row.machine or "",
        changed_at=time(row.changed_at or row.kept_at),
    )


MOST_EVENTS = 500


def _of_runs(kind: type, column: str) -> Select[Any]:
    table = TABLES[kind_of(kind).table]
    return select(table).where(table.c[column].in_(bindparam("wanted", expanding=True))).order_by(table.c.id)


# made once: to make a query takes longer than the database
_VERSION = select(ORDER_STATE.c.version).where(ORDER_STATE.c.order == bindparam("order"))
_EVENTS = select(EVENT).where(EVENT.c.subject == bindparam("subject")).order_by(EVENT.c.id.desc()).limit(MOST_EVENTS)
_STEPS = select(STEP).where(STEP.c.part == bindparam("part")).order_by(STEP.c.no)
_OF_RUNS: Final[Mapping[type, Select[Any]]] = {Run: _of_runs(Run, "identity"), RunFact: _of_runs(RunFact, "run")}


def part_life(store: Store, number: int) -> PartLife:
    """Returns one part's life, all of it of one moment. Its `etag` is that of its order. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        row, part = part_of(known, number)
        version = known.connection.scalar(_VERSION, {"order": row.order}) if row.order else None
        steps, events = tuple(_steps(known, number)), tuple(events_of(known, f"part:{number}"))
        certificates = certificate_rows_of(known, number)
        found = life_in(known.connection, known.codec, part)
    cut_with = {event.values.get("correction", ""): event.values for event in events if event.what == "corrected"}
    return PartLife(
        part=row,
        etag=str(version or 0),
        label=part.serial,
        tool=_tool(found),
        steps=steps,
        inspections=tuple(_inspection(found, inspection) for inspection in found.inspections),
        corrections=tuple(correction_view(correction.value, cut_with) for correction in found.corrections),
        certificates=certificates,
        events=events,
    )


def events_of(reader: StoreReader, subject: str) -> Iterator[EventView]:
    """Yields the latest events of a subject, oldest first."""
    yield from (event_view(row) for row in reversed(reader.rows(_EVENTS, subject=subject)))


def _steps(reader: StoreReader, number: int) -> Iterator[StepView]:
    steps = [step_now(row) for row in reader.rows(_STEPS, part=number)]
    keys = [one.run for one in steps if one.run]
    runs = {value.key: value for value in _values(reader, Run, [joined((key,)) for key in keys])}
    facts: dict[str, list[RunFact]] = {}
    for value in _values(reader, RunFact, keys):
        facts.setdefault(value.run, []).append(value)
    for step in steps:
        told = sorted(facts.get(step.run, []), key=lambda run_fact: run_fact.at)
        yield filled_from(
            StepView,
            step,
            sent_sha256=runs[step.run].sent_sha256 if step.run in runs else "",
            facts=tuple(
                FactView(run_fact.what, run_fact.at, run_fact.witness, dict(run_fact.values)) for run_fact in told
            ),
        )


def _values(reader: StoreReader, kind: type[Run | RunFact], wanted: list[str]) -> list[Any]:
    """Runs of these identities, or facts of these runs, in one query."""
    rows = reader.rows(_OF_RUNS[kind], wanted=[searchable(one) for one in wanted]) if wanted else []
    return [decoded(reader.codec, kind_of(kind), row) for row in rows]


def _tool(life: Life) -> str:
    settings = [cut.value.setting for cut in life.cuts if cut.value.setting is not None]
    return " ".join(filter(None, settings[-1].edge.identity)) if settings else ""


def _inspection(life: Life, kept: Kept[Inspection]) -> InspectionView:
    one = kept.value
    cut = life.cut_of(one)
    errors = [touch.error_mm * UM_PER_MM for touch in one.touches if touch.error_mm is not None]
    results = tuple(result(reading) for reading in one.readings if reading.nominal is not None)
    errors = errors or [each.deviation_um for each in results if each.deviation_um is not None]
    rms = math.sqrt(sum(each**2 for each in errors) / len(errors)) if errors else None
    return InspectionView(
        id=kept.row,
        at=one.measured_at,
        source=one.device or one.measured,
        stage="" if cut is None else cut.stage.value,
        file=one.sha256,
        touches=len(one.touches) + len(one.points),
        rms_um=rms,
        results=results,
    )


def result(reading: Reading) -> Result:
    """Compares a reading with its limits: in, out; empty where it has none."""
    nominal, actual = reading.nominal or 0.0, reading.actual
    low, high = reading.lower_limit, reading.upper_limit
    inside = (low is None or low <= actual) and (high is None or actual <= high)
    verdict = "" if low is None and high is None else "in" if inside else "out"
    deviation = None if reading.quantity is Quantity.ANGLE else (actual - nominal) * UM_PER_MM
    return Result(
        characteristic=reading.characteristic,
        unit=reading.quantity.unit,
        nominal=nominal,
        lower_limit=low,
        upper_limit=high,
        actual=actual,
        standard_u=reading.standard_u,
        deviation_um=deviation,
        verdict=verdict,
    )


def correction_view(record: Record, cut_with: Mapping[str, Mapping[str, str]]) -> CorrectionView:
    """Makes a correction from its record; `cut_with`: what was stated with its program for a finish cut, by id."""
    return CorrectionView(
        id=record.id,
        product=record.product.value,
        made_at=record.made_at,
        made_by=record.made_by,
        summary=tuple(record.decision),
        source="" if record.program is None else record.program.name,
        source_sha256="" if record.program is None else record.program.sha256,
        corrected_sha256=cut_with.get(record.id, {}).get("program_sha256", ""),
        has_report=record.product is Product.TURNED,
    )


LATEST: Final = 100
"""Inspections of a type that are looked at, the latest."""
MOST: Final = 12
"""Characteristics shown, those with the least Cpk."""
_Limits = tuple[float | None, float | None, float | None]
_Cpk = tuple[float | None, float | None, float | None]
NONE: Final[_Cpk] = (None, None, None)


def cpk_of_today(reader: StoreReader, finished: Sequence[str], began: str) -> tuple[Cpk, ...]:
    """Returns Cpk by part type, where parts came to one of the states `finished` since `began`; the least first."""
    part = TABLES["part"]
    made = select(part.c.part_type).join(PART_STATE, PART_STATE.c.part == part.c.id).distinct()
    today = made.where(PART_STATE.c.changed_at >= began, PART_STATE.c.state.in_(finished))
    names: Sequence[str] = reader.connection.scalars(today).all()
    found = [capability for name in names for capability in _of_type(reader, name)]
    return tuple(sorted(found, key=lambda of: (of.cpk is None, of.cpk or 0.0))[:MOST])


def _of_type(reader: StoreReader, part_type: str) -> Iterator[Cpk]:
    """Each characteristic with the nominal and limits of its latest part; earlier ones of others are another series."""
    series: dict[str, tuple[_Limits, dict[int, float]]] = {}
    for row in _readings(reader, part_type):
        limits: _Limits = (row.nominal, row.lower_limit, row.upper_limit)
        asked, values = series.setdefault(row.characteristic, (limits, {}))
        if asked == limits:
            values.setdefault(row.inspection, row.actual)
    for name, ((_, lower, upper), values) in series.items():
        if lower is not None or upper is not None:
            in_order = tuple(values.values())[::-1]
            cpk, low, high = _cpk(in_order, lower, upper) if len(values) >= CAPABLE_FROM else NONE
            yield Cpk(
                part_type=part_type,
                characteristic=name,
                cpk=cpk,
                low=low,
                high=high,
                count=len(values),
                needed=CAPABLE_FROM,
            )


def _readings(reader: StoreReader, part_type: str) -> Iterator[Any]:
    """Of the last inspection of each of the latest parts, the latest first; of no part that was not finished yet."""
    inspection, reading = TABLES["inspection"], ROWS["reading"]
    later = inspection.alias("later")
    query = (
        select(inspection.c.id, inspection.c.identity, inspection.c.serial)
        .outerjoin(later, later.c.supersedes == inspection.c.id)
        .where(inspection.c.part_type == searchable(part_type), later.c.id.is_(None))
    )
    seen: dict[str, int] = {}
    rows = reader.rows(query.order_by(inspection.c.id.desc()).limit(LATEST))
    early = _early(reader, part_type, [one.serial for one in rows])
    for row in rows:
        if row.identity not in early:
            seen.setdefault(row.serial, row.id)
    wanted = and_(reading.c.inspection.in_(seen.values()), reading.c.nominal.is_not(None))
    return iter(reader.rows(select(reading).where(wanted).order_by(reading.c.inspection.desc(), reading.c.position)))


def _early(reader: StoreReader, part_type: str, serials: Sequence[str]) -> set[str]:
    """Inspections that show an earlier cut than the finish cut."""
    cut, link = TABLES["cut"], TABLES["inspection_link"]
    cuts = select(cut.c.identity).where(
        *(cut.c.part_type == searchable(part_type), cut.c.serial.in_(serials), cut.c.stage != Stage.FINISH.value)
    )
    return set(reader.connection.scalars(select(link.c.identity).where(link.c.cut.in_(cuts))))


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
