"""Series of a part type's characteristics as they are shown."""

from collections.abc import Iterator

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Identity
from trueloop.errors import Code, TrueloopError
from trueloop.factory.book import Book, part_types, read_book
from trueloop.factory.views.series import SeriesPoint, SeriesRow, SeriesView
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.loops.post_process.tracked import COVERAGE, Tracked, TrackedPart, capability
from trueloop.storage.store import Store
from trueloop.units import UM_PER_MM


def series_rows(store: Store, part_type: str | None = None) -> tuple[SeriesRow, ...]:
    """The series of a part type, or of all; what is expected is of the next part."""
    types = part_types(store) if part_type is None else (part_type,)
    books = [read_book(store, name, SeriesOptions()) for name in types]
    return tuple(_row(one) for book in books for one in book.tracked)


def series_view(store: Store, part_type: str, characteristic: str, revision: str | None = None) -> SeriesView:
    """One series with its parts; without a revision the latest nominal and limits. Raises SER-UNKNOWN."""
    book = read_book(store, part_type, SeriesOptions()).named((characteristic,))
    chosen = [one for one in book.tracked if revision in (None, one.series.part_type.revision)]
    latest = [one for one in chosen if one.series.latest] or chosen
    if not latest:
        raise TrueloopError(
            Code.SER_UNKNOWN,
            f"{characteristic!r} of part type {part_type!r} has no revision {revision!r}",
            hint="see the list of series for those that there are",
            values={"characteristic": characteristic},
        )
    return _view(latest[-1], book)


def _view(one: Tracked, book: Book) -> SeriesView:
    asked, able = one.series.characteristic, capability(one.series)
    inspections = {seen.inspection.identity: seen.inspection for seen in book.parts}
    low, high = (_um(limit, asked) for limit in (asked.lower_limit, asked.upper_limit))
    return SeriesView(
        *(_row(one), asked.quantity.unit, asked.nominal, low, high, tuple(_points(one, inspections))),
        tuple(None if part.step.held else one.factor for part in one.parts),
        None if able is None else able.ppk,
    )


def _um(limit: float | None, asked: Characteristic) -> float | None:
    return None if limit is None else (limit - asked.nominal) * UM_PER_MM


def _row(one: Tracked) -> SeriesRow:
    alarm, last = one.open_alarm, one.last
    return SeriesRow(
        *(one.series.part_type.name, one.series.part_type.revision, one.series.name, len(one.parts)),
        *(last.made.serial, last.made.error_mm * UM_PER_MM),
        None if last.expected_mm is None else last.expected_mm * UM_PER_MM,
        "" if alarm is None else f"part {alarm.made.serial}",
    )


def _points(one: Tracked, inspections: dict[Identity, Inspection]) -> Iterator[SeriesPoint]:
    for part in one.parts:
        made, seen = part.made, inspections.get(part.made.inspection)
        yield SeriesPoint(
            *(made.serial, None if seen is None else seen.measured_at),
            *(made.error_mm * UM_PER_MM, made.uncorrected_mm * UM_PER_MM),
            None if part.expected_mm is None else part.expected_mm * UM_PER_MM,
            *(_band(part), "beyond what was expected" if part.alarm else ""),
            *("set" if made.set_before else "", not made.counts),
        )


def _band(part: TrackedPart) -> float | None:
    return None if part.expected_u_mm is None else COVERAGE * part.expected_u_mm * UM_PER_MM
