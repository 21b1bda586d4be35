"""Charts of the characteristics of a part type, from the store to values and files."""

from collections.abc import Sequence
from pathlib import Path

from trueloop.domain.page_options import Language, LengthUnit
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.factory.book import Book, only_type, read_book
from trueloop.formats.outputs import write_all
from trueloop.jobs.monitor.facts import stored_facts
from trueloop.jobs.monitor.gauges import failed_checks
from trueloop.loops.monitor.chart import MonitoredSeries, chart_of
from trueloop.loops.monitor.options import ChartOptions
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.report.monitor.chart_page import chart_page
from trueloop.report.monitor.chart_values import ChartsShape, charts_shape
from trueloop.report.texts.texts import Texts
from trueloop.storage.store import Store


def charts_of(store: Store, part_type: str | None, names: Sequence[str], options: ChartOptions) -> ChartsShape:
    """Charts of the characteristics asked for, () all; those of earlier nominals and limits are left out.

    Raises SER-UNKNOWN for a part type that there is not, MON-NONE for a characteristic without values, MON-FEW where
    none of them has enough.
    """
    book = read_book(store, part_type or only_type(store), SeriesOptions())
    _require_known(book, names)
    facts, charted, few = (
        stored_facts(store, book, failed_checks(store)),
        list[MonitoredSeries](),
        list[TrueloopError](),
    )
    for one in book.tracked:
        if one.series.latest and (not names or one.series.name in names):
            try:
                charted.append(chart_of(one, facts.of(one.series.made), options))
            except TrueloopError as refused:
                if refused.code is not Code.MON_FEW:
                    raise
                refused.message = f"{one.series.name!r}: {refused.message}"
                few.append(refused)
    if not charted:
        raise few[0]
    findings = (*book.findings, *(_as_note(one) for one in few))
    return charts_shape(book.part_type, charted, options, findings)


def _as_note(refused: TrueloopError) -> Finding:
    return Finding(Severity.NOTE, refused.code, refused.message, refused.hint, values=refused.values)


def _require_known(book: Book, names: Sequence[str]) -> None:
    known = sorted({one.series.name for one in book.tracked})
    for name in names:
        if name not in known:
            raise TrueloopError(
                Code.MON_NONE,
                f"the store holds no values of {name!r} among the {len(known)} characteristics of {book.part_type!r}",
                hint=f"they are: {', '.join(known)}",
                values={"characteristic": name},
            )


def write_charts(shown: ChartsShape, folder: Path | None, language: Language, unit: LengthUnit) -> list[str]:
    """monitor.json and monitor.html in a folder, both or none; nothing without one. Raises OUT errors."""
    if folder is None:
        return []
    contents = [
        ("monitor.json", (shown.model_dump_json(indent=1) + "\n").encode()),
        ("monitor.html", chart_page(shown, Texts(language, unit)).encode()),
    ]
    return [str(file) for file in write_all(folder, contents)]
