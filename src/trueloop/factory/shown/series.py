"""Series of a part type's characteristics as they are shown."""

from collections.abc import Iterator, Mapping
from itertools import pairwise

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Identity, Stage, edge_name
from trueloop.domain.tool import Edge
from trueloop.errors import Code
from trueloop.factory.book import Book, part_types, read_book
from trueloop.factory.views.series import SeriesPoint, SeriesRow, SeriesView, WeightMove
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.loops.post_process.tracked import TrackedPart, TrackedSeries, capability
from trueloop.report.series.page import MOVED
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.statistics import NORMAL_95
from trueloop.storage.store import Store, find
from trueloop.units import UM_PER_MM

Edges = Mapping[str, tuple[int, Edge]]
"""By serial number the edge of the finish cut, with its row."""


def series_rows(store: Store, part_type: str | None = None) -> tuple[SeriesRow, ...]:
    """Returns the series of a part type, or of all."""
    types = part_types(store) if part_type is None else (part_type,)
    books = [read_book(store, name, SeriesOptions()) for name in types]
    return tuple(_row(series) for book in books for series in book.tracked)


def series_view(
    store: Store, part_type: str, characteristic: str, revision: str | None = None, say: Texts = ENGLISH
) -> SeriesView:
    """Returns one series with its parts; without a revision the latest nominal and limits. Raises SER-UNKNOWN."""
    book = read_book(store, part_type, SeriesOptions()).named((characteristic,))
    chosen = [series for series in book.tracked if revision in (None, series.series.part_type.revision)]
    latest = [series for series in chosen if series.series.latest] or chosen
    if not latest:
        raise Code.SER_UNKNOWN.refusal(
            f"{characteristic!r} of part type {part_type!r} has no revision {revision!r}",
            hint="see the list of series for those that there are",
            values={"characteristic": characteristic},
        )
    return _view(latest[-1], book, _edges(store, part_type), say)


def _edges(store: Store, part_type: str) -> Edges:
    rows = {kept.value.identity: kept.row for kept in find(store, Edge)}
    cuts = [kept.value for kept in find(store, Cut, part_type=part_type, stage=Stage.FINISH)] if rows else []
    used = [(cut.part.serial, cut.setting.edge) for cut in cuts if cut.setting is not None]
    return {serial: (rows[edge.identity], edge) for serial, edge in used if edge.identity in rows}


def _view(series: TrackedSeries, book: Book, edges: Edges, say: Texts) -> SeriesView:
    asked, able = series.series.characteristic, capability(series.series)
    inspections = {seen.inspection.identity: seen.inspection for seen in book.parts}
    low, high = (_um(limit, asked) for limit in (asked.lower_limit, asked.upper_limit))
    waiting = [item.id for item in book.waiting if any(of.series == series.series.identity for of in item.effects)]
    return SeriesView(
        row=_row(series),
        unit=asked.quantity.unit,
        nominal=asked.nominal,
        lower_um=low,
        upper_um=high,
        points=tuple(_points(series, inspections, edges)),
        weight=_acted_on(series, series.last),
        moves=tuple(_moves(series, say)),
        ppk=None if able is None else able.ppk,
        ppk_lower=None if able is None else able.lower,
        proposals=tuple(waiting),
    )


def _acted_on(series: TrackedSeries, part: TrackedPart) -> float:
    """The share of what a part shows that is acted on."""
    return 0.0 if part.step.held else series.factor * part.step.weight.value


def _moves(series: TrackedSeries, say: Texts) -> Iterator[WeightMove]:
    for before, after in pairwise(series.parts):
        shares = _acted_on(series, before), _acted_on(series, after)
        if abs(shares[1] - shares[0]) > MOVED:
            yield WeightMove(after.made.serial, *shares, say.note(after.step.weight.reason))


def _um(limit: float | None, characteristic: Characteristic) -> float | None:
    return None if limit is None else (limit - characteristic.nominal) * UM_PER_MM


def _row(series: TrackedSeries) -> SeriesRow:
    alarm, last = series.open_alarm, series.last
    return SeriesRow(
        part_type=series.series.part_type.name,
        revision=series.series.part_type.revision,
        characteristic=series.series.name,
        parts=len(series.parts),
        last_serial=last.made.serial,
        last_deviation_um=last.made.error_mm * UM_PER_MM,
        expected_um=None if last.step.level_mm is None else series.next_mm * UM_PER_MM,
        alarm="" if alarm is None else f"part {alarm.made.serial}",
    )


def _points(series: TrackedSeries, inspections: dict[Identity, Inspection], edges: Edges) -> Iterator[SeriesPoint]:
    for part in series.parts:
        made, seen = part.made, inspections.get(part.made.inspection)
        edge = edges.get(made.serial)
        yield SeriesPoint(
            serial=made.serial,
            at=None if seen is None else seen.measured_at,
            deviation_um=made.error_mm * UM_PER_MM,
            without_correction_um=made.uncorrected_mm * UM_PER_MM,
            expected_um=None if part.expected_mm is None else part.expected_mm * UM_PER_MM,
            band_um=None if part.expected_u_mm is None else NORMAL_95 * part.expected_u_mm * UM_PER_MM,
            alarm="beyond what was expected" if part.alarm else "",
            tool_changed="set" if made.set_before else "",
            quarantined=not made.counts,
            edge=None if edge is None else edge[0],
            tool="" if edge is None else edge_name(edge[1]),
        )
