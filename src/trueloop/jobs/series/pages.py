"""Series as values and as files: page, JSON and table."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trueloop.domain.page_options import Language, LengthUnit
from trueloop.factory.book import Book
from trueloop.formats.outputs import write_all
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.loops.post_process.replay import replay
from trueloop.loops.post_process.simulated import simulate
from trueloop.report.series.page import series_page
from trueloop.report.series.shapes import SeriesShape
from trueloop.report.series.table import series_csv
from trueloop.report.series.values import replay_shape, status_shape
from trueloop.report.texts.texts import Texts
from trueloop.simulator.series import Event, Shop, What
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class WhatIf:
    """A series to simulate. Parts count from 1; `jump_um` is an offset on X (a radius) that nobody knows of."""

    parts: int = 30
    seed: int = 0
    gain: float = 1.0
    tool_changed_at: int | None = None
    jump_at: int | None = None
    jump_um: float = 20.0


def status_of(book: Book, options: SeriesOptions) -> SeriesShape:
    """The series as they are."""
    return status_shape(book.part_type, book.tracked, len(book.parts), book.findings, options)


def replay_of(book: Book) -> SeriesShape:
    """The series as they would have been with memory."""
    replays = [replay(one.series) for one in book.tracked]
    return replay_shape(book.part_type, replays, len(book.parts), book.findings)


def simulated(given: WhatIf) -> SeriesShape:
    """A simulated series, corrected as memory proposes."""
    events = [] if given.jump_at is None else [Event(What.OFFSET, given.jump_at - 1, given.jump_um / UM_PER_MM)]
    changed = None if given.tool_changed_at is None else given.tool_changed_at - 1
    shop = Shop(parts=given.parts, gain=given.gain, changed_at=changed)
    found = simulate(shop, np.random.default_rng(given.seed), events)
    return replay_shape(found.series.part_type.name, [found], given.parts, (), simulated=True)


def write_series(
    series: SeriesShape, name: str, folder: Path | None, language: Language, unit: LengthUnit
) -> list[str]:
    """`name`.csv, `name`.json and `name`.html in a folder, all or none; nothing without one. Raises OUT errors."""
    if folder is None:
        return []
    contents = [
        (f"{name}.csv", series_csv(series).encode()),
        (f"{name}.json", (series.model_dump_json(indent=1) + "\n").encode()),
        (f"{name}.html", series_page(series, Texts(language, unit)).encode()),
    ]
    return [str(file) for file in write_all(folder, contents)]
