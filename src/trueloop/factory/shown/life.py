"""All that is known of one part: `part_life`."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

from sqlalchemy import Select, bindparam, select

from trueloop.domain.characteristic import Quantity
from trueloop.domain.factory.run import Run, RunFact
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.record import Product, Record
from trueloop.factory.load import Known, step_now
from trueloop.factory.shown.paging import known_of
from trueloop.factory.shown.parts import part_of
from trueloop.factory.shown.records import certificate_rows_of, event_view
from trueloop.factory.views.parts import (
    CorrectionView,
    EventView,
    FactView,
    InspectionView,
    PartLife,
    Result,
    StepView,
)
from trueloop.storage.factory_tables import EVENT, ORDER_STATE, STEP
from trueloop.storage.kept import Kept
from trueloop.storage.kinds import joined, kind_of, searchable
from trueloop.storage.life import Life, life_in
from trueloop.storage.reading import decoded
from trueloop.storage.store import Store
from trueloop.storage.tables import TABLES
from trueloop.units import UM_PER_MM

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
    """One part's life, all of it of one moment. Its `etag` is that of its order. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        row, part = part_of(known, number)
        version = known.connection.scalar(_VERSION, {"order": row.order}) if row.order else None
        steps, events = tuple(_steps(known, number)), tuple(events_of(known, f"part:{number}"))
        certificates = certificate_rows_of(known, number)
        found = life_in(known.connection, known.codec, part)
    cut_with = {one.values.get("correction", ""): one.values for one in events if one.what == "corrected"}
    return PartLife(
        *(row, str(version or 0), part.serial, _tool(found), steps),
        tuple(_inspection(found, one) for one in found.inspections),
        tuple(correction_view(one.value, cut_with) for one in found.corrections),
        *(certificates, events),
    )


def events_of(known: Known, subject: str) -> Iterator[EventView]:
    """The latest events of a subject, oldest first."""
    yield from (event_view(one) for one in reversed(known.rows(_EVENTS, subject=subject)))


def _steps(known: Known, number: int) -> Iterator[StepView]:
    steps = [step_now(one) for one in known.rows(_STEPS, part=number)]
    keys = [one.run for one in steps if one.run]
    runs = {one.key: one for one in _values(known, Run, [joined((key,)) for key in keys])}
    facts: dict[str, list[RunFact]] = {}
    for one in _values(known, RunFact, keys):
        facts.setdefault(one.run, []).append(one)
    for step in steps:
        told = sorted(facts.get(step.run, []), key=lambda one: one.at)
        yield StepView(
            *(step.no, step.kind, step.state, step.attempts, step.run, step.program_sha256),
            runs[step.run].sent_sha256 if step.run in runs else "",
            tuple(FactView(one.what, one.at, one.witness, dict(one.values)) for one in told),
        )


def _values(known: Known, kind: type[Run | RunFact], wanted: list[str]) -> list[Any]:
    """Runs of these identities, or facts of these runs, in one query."""
    rows = known.rows(_OF_RUNS[kind], wanted=[searchable(one) for one in wanted]) if wanted else []
    return [decoded(known.codec, kind_of(kind), row) for row in rows]


def _tool(found: Life) -> str:
    settings = [one.value.setting for one in found.cuts if one.value.setting is not None]
    return " ".join(filter(None, settings[-1].edge.identity)) if settings else ""


def _inspection(found: Life, kept: Kept[Inspection]) -> InspectionView:
    one = kept.value
    cut = found.cut_of(one)
    errors = [touch.error_mm * UM_PER_MM for touch in one.touches if touch.error_mm is not None]
    results = tuple(result(reading) for reading in one.readings if reading.nominal is not None)
    errors = errors or [each.deviation_um for each in results if each.deviation_um is not None]
    rms = math.sqrt(sum(each**2 for each in errors) / len(errors)) if errors else None
    return InspectionView(
        *(kept.row, one.measured_at, one.device or one.measured, "" if cut is None else cut.stage.value, one.sha256),
        *(len(one.touches) + len(one.points), rms, results),
    )


def result(reading: Reading) -> Result:
    """A reading against its limits: in, out; empty where it has none."""
    nominal, actual = reading.nominal or 0.0, reading.actual
    low, high = reading.lower_limit, reading.upper_limit
    inside = (low is None or low <= actual) and (high is None or actual <= high)
    verdict = "" if low is None and high is None else "in" if inside else "out"
    deviation = None if reading.quantity is Quantity.ANGLE else (actual - nominal) * UM_PER_MM
    return Result(
        *(reading.characteristic, reading.quantity.unit, nominal, low, high, actual, reading.standard_u),
        *(deviation, verdict),
    )


def correction_view(record: Record, cut_with: Mapping[str, Mapping[str, str]]) -> CorrectionView:
    """A correction by its record; `cut_with`: what was said as its program was given to a finish cut, by id."""
    program = cut_with.get(record.id, {}).get("program_sha256", "")
    source = ("", "") if record.program is None else (record.program.name, record.program.sha256)
    return CorrectionView(
        *(record.id, record.product.value, record.made_at, record.made_by, tuple(record.decision), *source, program),
        record.product is Product.TURNED,
    )
