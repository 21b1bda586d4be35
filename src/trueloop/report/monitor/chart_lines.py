"""Charts as lines for a terminal."""

from collections.abc import Iterator
from typing import Final

from trueloop.report.monitor.chart_shapes import CapabilityShape, CharacteristicChartShape, ChartsShape, EpisodeShape
from trueloop.report.style import plain, signed

NAMED: Final = 0.05
"""Causes with a smaller probability stand in the JSON alone."""
UNITS: Final = {"um": "µm", "sigma": "σ"}


def chart_head(shown: ChartsShape) -> tuple[str, ...]:
    """The head of the table."""
    unit = UNITS[shown.unit]
    indices = ("Cpk", "Ppk") if shown.what == "value" else ()
    return ("characteristic", "parts", f"mean ({unit})", f"σ ({unit})", "baseline", "alarms", *indices)


def chart_rows(shown: ChartsShape) -> Iterator[tuple[str, ...]]:
    """Cells of the table, one row a characteristic."""
    for one in shown.characteristics:
        mean = sum(part.value for part in one.parts) / len(one.parts)
        yield (
            one.characteristic,
            str(len(one.parts)),
            signed(mean),
            plain(one.sigma, 2),
            str(one.baseline),
            str(len(one.alarms)),
            *(index_text(one.capability, name) for name in ("Cpk", "Ppk") if shown.what == "value"),
        )


def index_text(found: CapabilityShape | None, name: str) -> str:
    """An index with its interval; empty where there is none."""
    one = None if found is None else next(each for each in found.indices if each.name == name)
    if one is None or one.value is None or one.low is None or one.high is None:
        return ""
    return f"{plain(one.value, 2)} ({plain(one.low, 2)} to {plain(one.high, 2)})"


def alarm_lines(one: CharacteristicChartShape, shown: ChartsShape) -> Iterator[str]:
    """Alarms of a characteristic with what explains them, and its remarks."""
    for episode in one.alarms:
        yield f"{one.characteristic}: alarm at {_parts(episode)}"
        meanings = dict.fromkeys(f"{alarm.chart}: {alarm.meaning}" for alarm in episode.alarms)
        yield from (f"  {said}" for said in meanings)
        for cause in episode.causes:
            if cause.probability >= NAMED:
                size = f"{signed(cause.size)} ± {plain(1.96 * cause.size_u)} {UNITS[shown.unit]}"
                yield f"  {100 * cause.probability:.0f} %  {cause.kind}: {cause.words} ({size})"
        yield f"  {100 * episode.unknown:.0f} %  a step that nobody knows of: it would begin at part {episode.since}"
        yield f"  {100 * episode.chance:.0f} %  chance: nothing moved"
    yield from (f"{one.characteristic}: {remark}" for remark in one.remarks)


def _parts(one: EpisodeShape) -> str:
    return f"part {one.first}" if one.first == one.last else f"parts {one.first} to {one.last}"
