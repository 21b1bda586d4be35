"""Charts of the characteristics of a part type, from the store to values and files."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from statistics import fmean
from typing import Any

from trueloop.domain.inspection import BothInspections, Inspection, StandardPart
from trueloop.domain.life import Cut, EdgeEvent, EdgeEventKind, Stage, time_of
from trueloop.domain.option import in_utc
from trueloop.domain.record import Correction
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.factory.book import Book, only_type, read_book
from trueloop.loops.monitor.chart import ChartOptions, MonitoredSeries, chart_of
from trueloop.loops.monitor.gauge import GaugeSeries, gauges
from trueloop.loops.monitor.known import PartFacts
from trueloop.loops.post_process.series import MadePart, Series, SeriesOptions
from trueloop.loops.turned import correction as turned
from trueloop.loops.turned.in_force import cut_with
from trueloop.loops.turned.made_parts import program_that_ran, taken_off_sizes_mm
from trueloop.report.monitor.chart_values import ChartsShape, charts_shape
from trueloop.report.monitor.gauge import GaugesShape, gauges_shape
from trueloop.storage.store import Store, find

ANEW = (EdgeEventKind.MOUNTED, EdgeEventKind.TURNED, EdgeEventKind.SET)
"""Events after which a tip lies elsewhere."""


@dataclass(frozen=True)
class StoredFacts:
    """All that the store holds of the parts of one type, by what it is found by."""

    book: Book
    cuts: Mapping[str, Cut]
    events: tuple[EdgeEvent, ...]
    stood: Mapping[str, Mapping[str, float]]
    failed: Mapping[str, tuple[tuple[datetime, str], ...]]
    corrections: Mapping[str, turned.Correction]

    def of(self, series: Series) -> tuple[PartFacts, ...]:
        """Facts of the parts of one series, in its order."""
        made = series.made
        # The earlier cuts of each cut's edge, as far back as all of them state their time
        age: dict[tuple[str, ...], float | None] = {}
        minutes: list[float | None] = []
        for cut in [self.cuts.get(made_part.serial) for made_part in made]:
            edge = None if cut is None or cut.setting is None else cut.setting.edge.identity
            if cut is None or edge is None:
                minutes.append(None)
                continue
            now, own_minutes = age.get(edge, 0.0), cut.conditions.time_in_cut_min
            minutes.append(now)
            age[edge] = None if now is None or own_minutes is None else now + own_minutes
        return tuple(
            replace(self._part(made, k, minutes[k]), **self._cut_with(made[k], series.name)) for k in range(len(made))
        )

    def _cut_with(self, made: MadePart, name: str) -> dict[str, Any]:
        """Returns what the correction that a part was cut with took off a size. Raises STO-PROGRAM."""
        cut = self.cuts.get(made.serial)
        correction = None if cut is None else self.corrections.get(cut.correction)
        if cut is None or correction is None:
            return {}
        ran = program_that_ran(correction, cut)
        taken_mm = taken_off_sizes_mm(correction, ran, self._inspection(made)).get(name, 0.0)
        return {"taken_off_mm": taken_mm, "cut_with": cut_with(correction.record, ran).words}

    def _part(self, made: Sequence[MadePart], k: int, minutes: float | None) -> PartFacts:
        inspection = self._inspection(made[k])
        cut, before = self.cuts.get(made[k].serial), self.cuts.get(made[k - 1].serial) if k else None
        at = inspection.measured_at if cut is None or time_of(cut) is None else time_of(cut)
        earlier = None if not k else self._at(made[k - 1])
        return PartFacts(
            serial=made[k].serial,
            at=at,
            cut=cut,
            events=tuple(self._events(before, cut)),
            proposals=tuple(self._accepted(earlier, at))
            if k and made[k].correction_mm != made[k - 1].correction_mm
            else (),
            minutes=minutes,
            temperatures=_temperatures(inspection) | dict(self.stood.get(made[k].serial, {})),
            device=inspection.device,
            failed=self._failed(inspection),
        )

    def _inspection(self, made: MadePart) -> Inspection:
        return next(part.inspection for part in self.book.parts if part.inspection.identity == made.inspection)

    def _at(self, made: MadePart) -> datetime | None:
        cut = self.cuts.get(made.serial)
        return self._inspection(made).measured_at if cut is None else time_of(cut)

    def _events(self, before: Cut | None, cut: Cut | None) -> Iterator[EdgeEvent]:
        """Returns the events of the cutting tool between two cuts whose times are known."""
        if before is None or cut is None or cut.setting is None or before.at is None or cut.at is None:
            return
        tool = cut.setting.edge.tool.identity
        for event in self.events:
            if (
                event.edge.tool.identity == tool
                and event.kind in ANEW
                and in_utc(before.at) < in_utc(event.at) <= in_utc(cut.at)
            ):
                yield event

    def _accepted(self, earlier: datetime | None, at: datetime | None) -> Iterator[str]:
        for decision in self.book.decisions:
            late = at is not None and in_utc(decision.at) > in_utc(at)
            early = earlier is not None and in_utc(decision.at) <= in_utc(earlier)
            if decision.verdict == "accepted" and not late and not early:
                yield decision.proposal

    def _failed(self, inspection: Inspection) -> str:
        """Returns the words on the device's last failed check before the inspection; "" without one."""
        checks = self.failed.get(inspection.device, ())
        if inspection.measured_at is None:
            return ""
        past = [said for at, said in checks if in_utc(at) <= in_utc(inspection.measured_at)]
        return past[-1] if past else ""


def stored_facts(
    store: Store, book: Book, failed: Mapping[str, tuple[tuple[datetime, str], ...]] | None = None
) -> StoredFacts:
    """Collects what the store holds of a book's parts; `failed`: what checks of devices reported, "" where passed."""
    cuts = [stored.value for stored in find(store, Cut, part_type=book.part_type, stage=Stage.FINISH)]
    both = [stored.value for stored in find(store, BothInspections, part_type=book.part_type)]
    made = [stored.value for stored in find(store, Correction, part_type=book.part_type)] if cuts else []
    return StoredFacts(
        book=book,
        cuts={cut.part.serial: cut for cut in cuts},
        events=tuple(stored.value for stored in find(store, EdgeEvent)) if cuts else (),
        stood={pair.part.serial: {f"{name} while cut": v for name, v in pair.cutting.signals.items()} for pair in both},
        failed=failed or {},
        corrections={
            correction.record.id: correction.payload
            for correction in made
            if isinstance(correction.payload, turned.Correction)
        },
    )


def _temperatures(inspection: Inspection) -> dict[str, float]:
    read = [reading.temperature_c for reading in inspection.readings if reading.temperature_c is not None]
    of_readings = {"part while measured": fmean(read)} if read else {}
    return {f"{name} while measured": value for name, value in inspection.temperatures.items()} | of_readings


def control_charts(
    store: Store, part_type: str | None = None, names: Sequence[str] = (), options: ChartOptions | None = None
) -> ChartsShape:
    r"""Charts the characteristics named, () all; those of earlier nominals and limits are left out.

    Raises SER-UNKNOWN for a part type that there is not, MON-NONE for a characteristic without values, MON-FEW where
    none of them has enough.

    >>> store = trueloop.make_store("shop.db")
    >>> rows = [f"SHAFT,{k},seat,seat,diameter,mm,30,29.98,30.02,{30.002 + 0.001 * (k * 3 % 7)}" for k in range(20)]
    >>> head = "part name,serial,characteristic,feature,quantity,unit,nominal,lower limit,upper limit,actual"
    >>> written = Path("seats.csv").write_text("\n".join([head, *rows]))
    >>> added = trueloop.add_inspections(store, ["seats.csv"])
    >>> seat = trueloop.control_charts(store, names=["seat"]).characteristics[0]
    >>> len(seat.parts), seat.segments[0].centre, seat.alarms  # µm
    (20, 4.95, [])
    """
    book = read_book(store, part_type or only_type(store), SeriesOptions())
    known = sorted({series.series.name for series in book.tracked})
    for name in names:
        if name not in known:
            raise Code.MON_NONE.refusal(
                f"the store holds no values of {name!r} among the {len(known)} characteristics of {book.part_type!r}",
                hint=f"they are: {', '.join(known)}",
                values={"characteristic": name},
            )
    facts, charted, few = (
        stored_facts(store, book, failed_checks(store)),
        list[MonitoredSeries](),
        list[TrueloopError](),
    )
    for series in book.tracked:
        if series.series.latest and (not names or series.series.name in names):
            try:
                charted.append(chart_of(series, facts.of(series.series), options or ChartOptions()))
            except TrueloopError as refused:
                if refused.code is not Code.MON_FEW:
                    raise
                refused.message = f"{series.series.name!r}: {refused.message}"
                few.append(refused)
    if not charted:
        raise few[0]
    findings = (*book.findings, *(_as_note(error) for error in few))
    return charts_shape(book.part_type, charted, options or ChartOptions(), findings)


def _as_note(refused: TrueloopError) -> Finding:
    return Finding(Severity.NOTE, refused.code, refused.message, refused.hint, values=refused.values)


def gauges_of(store: Store, device: str | None) -> GaugesShape:
    """Returns the checks of a device, or of all. Raises MON-NONE where there is none."""
    return gauges_shape(_checked(store, device))


def _checked(store: Store, device: str | None) -> tuple[GaugeSeries, ...]:
    standards = [stored.value for stored in find(store, StandardPart)]
    types = dict.fromkeys(standard.part.part_type.name for standard in standards)
    inspections = [stored.value for name in types for stored in find(store, Inspection, part_type=name)]
    return gauges(standards, inspections, device)


def failed_checks(store: Store) -> Mapping[str, tuple[tuple[datetime, str], ...]]:
    """Returns by device when it was checked, and what failed then in words; "" where nothing did."""
    try:
        checked = _checked(store, None)
    except TrueloopError as refused:
        if refused.code is not Code.MON_NONE:
            raise
        return {}
    said: dict[str, dict[datetime, str]] = {}
    for series in checked:
        for k, check in enumerate(series.checks):
            if check.at is not None:
                own = said.setdefault(series.device, {})
                own[check.at] = own.get(check.at) or series.failing(k)
    return {device: tuple(sorted(own.items())) for device, own in said.items()}
