"""What a cause would leave on every feature error of a series, as columns with one unknown size each.

The columns follow from a cause's signs alone: on which kind of error, who sees it, how it goes over the parts, whether
features share a size, and by what it shows more on one than on another. A cause has several variants where it may go
over the parts in several ways; each is a hypothesis of its own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.causes.catalogue import SIZES_OF_FORM
from trueloop.diagnosis.causes.cause import Cause, Over, Sign, Weight
from trueloop.diagnosis.causes.rows import Row
from trueloop.diagnosis.causes.seen_part import SeenBy, SeenSeries
from trueloop.diagnosis.features.feature_error import ErrorKind

REFERENCE_C: Final = 20.0
"""Standard conditions [ISO 1]: there the machine's model is what it was identified at."""
LEAST_STEP: Final = 2
"""Parts on either side of a step."""


@dataclass(frozen=True)
class Variant:
    """One way in which a cause may show: which signs, how over the parts, on features of which tool.

    `signal` is the temperature that it follows, `step` the part in the series from which on it acts.
    """

    cause: Cause
    signs: tuple[Sign, ...]
    over: Over
    tool: str = ""
    signal: str = ""
    step: int = 0

    @property
    def who(self) -> tuple[str, str]:
        """The cause and the tool: variants of one of these are alternatives to each other."""
        return self.cause.key, self.tool


def variants(cause: Cause, series: SeenSeries) -> Iterator[Variant]:
    """All of a cause, for each tool (and all of them), temperature and part that a step could begin at."""
    tools = sorted({place.tool for place in series.features.values()}) if cause.of_tool else [""]
    tools = [*tools, ""] if len(tools) > 1 and cause.of_tool else tools
    signals = sorted({name for part in series.parts for name in part.temperatures})
    for signs in _choices(cause):
        for over in dict.fromkeys(over for sign in signs or cause.signs for over in sign.over):
            for tool in tools:
                if over is Over.TEMPERATURE:
                    yield from (Variant(cause, signs, over, tool, signal) for signal in signals)
                elif over is Over.STEP:
                    at = range(LEAST_STEP, len(series.parts) - LEAST_STEP + 1)
                    yield from (Variant(cause, signs, over, tool, step=step) for step in at)
                else:
                    yield Variant(cause, signs, over, tool)


def columns(variant: Variant, rows: Sequence[Row], series: SeenSeries) -> Array:
    """(n, k), the largest value of each column 1; k is 0 where it shows on none of the rows.

    Of scatter the largest is 2, so that sizes begin where those of a sound process end.
    """
    found: dict[tuple[object, ...], Array] = {}
    for number, row in enumerate(rows):
        for key, value in _entries(variant, row, series):
            if value:
                found.setdefault(key, np.zeros(len(rows)))[number] += value
    kept = [column / np.abs(column).max() for column in found.values() if np.abs(column).max() > 0]
    unlike = [column for k, column in enumerate(kept) if not any(np.allclose(column, one) for one in kept[:k])]
    return (
        (2.0 if variant.over is Over.SCATTER else 1.0) * np.column_stack(unlike) if unlike else np.zeros((len(rows), 0))
    )


def _choices(cause: Cause) -> Iterator[tuple[Sign, ...]]:
    """Which signs show together: what is needed, and that with what may; or each alone, and one of each kind."""
    signs = [sign for sign in cause.signs if sign.kind not in SIZES_OF_FORM]
    needed = [sign for sign in signs if sign.needed]
    together = [tuple({sign.kind: sign for sign in signs}.values())] if cause.any_of else [tuple(needed), tuple(signs)]
    alone = [(sign,) for sign in needed] if cause.any_of else []
    yield from dict.fromkeys((*alone, *together))


def _entries(variant: Variant, row: Row, series: SeenSeries) -> Iterator[tuple[tuple[object, ...], float]]:
    for sign in variant.signs:
        if sign.kind is not row.kind:
            continue
        share = _seen(sign, variant.cause, row, series) * _of_tool(variant, row, series) * _weight(sign, row, series)
        if share:
            shared = sign.weight is Weight.CANTILEVER
            of = (None if shared else sign.kind, None if sign.alike else (row.feature, row.other))
            for name, value in _over(variant, sign, row, series):
                yield (*of, name), share * value


def _seen(sign: Sign, cause: Cause, row: Row, series: SeenSeries) -> float:
    """1 where the device sees it. A standard part shows what is the probe's, and the machine's error turned round.

    A machine that stands off by E cuts E and, without a part of its own, reads a calibrated part by −E.
    """
    if not series.parts[row.part].standard:
        return float(row.seen_by in sign.seen_by)
    if row.seen_by is not SeenBy.MACHINE:
        return 0.0
    if cause.on_standard_part:
        return 1.0
    return -1.0 if sign.seen_by == (SeenBy.CMM,) and sign.weight is Weight.ALONG_X else 0.0


def _of_tool(variant: Variant, row: Row, series: SeenSeries) -> float:
    if not variant.tool:
        return float(not variant.cause.of_tool or variant.over is Over.WEAR)
    tool, other = tool_of(row.feature, series), tool_of(row.other, series)
    if variant.over is Over.WEAR and row.kind is ErrorKind.LENGTH:
        return float(variant.tool in (tool, other))
    return float(tool == variant.tool) - float(row.kind is ErrorKind.LENGTH and other == variant.tool)


def tool_of(feature: str, series: SeenSeries) -> str:
    """The tool that finished a feature, "" where it is not known."""
    place = series.features.get(feature)
    return place.tool if place else ""


def _weight(sign: Sign, row: Row, series: SeenSeries) -> float:
    place = series.features.get(row.feature)
    if sign.weight is Weight.ALONG_X:
        return row.normal_x
    if sign.weight is Weight.PLAIN or place is None:
        return 1.0
    if sign.weight is Weight.ACROSS:
        return place.radius_mm[1] - place.radius_mm[0]
    low = min(one.z_mm[0] for one in series.features.values())
    high = max(one.z_mm[1] for one in series.features.values())
    near, far = (((z - low) / (high - low)) ** 3 if high > low else 0.0 for z in place.z_mm)
    return near if row.kind is ErrorKind.RADIUS else far - near


def _over(variant: Variant, sign: Sign, row: Row, series: SeenSeries) -> list[tuple[object, float]]:
    """Names of sizes and what each is multiplied by on this part."""
    part = series.parts[row.part]
    tool = variant.tool or tool_of(row.feature, series)
    match variant.over:
        case Over.CONSTANT | Over.SETTING | Over.SCATTER as over:
            of = {Over.CONSTANT: None, Over.SETTING: part.setting.get(tool, 0), Over.SCATTER: row.part}
            return [(of[over], 1.0)]
        case Over.STEP:
            return [
                (
                    None,
                    float(row.part >= variant.step and part.setting.get(tool) == _at_step(variant, tool, series)),
                )
            ]
        case Over.TEMPERATURE:
            warm = part.temperatures.get(variant.signal, REFERENCE_C) - REFERENCE_C
            return [("constant", 1.0), (variant.signal, warm)]
        case Over.WEAR:
            minutes = minutes_in_cut(row.part, tool, series)
            if row.kind is ErrorKind.LENGTH:
                return [("even", minutes), ("between passes", 1.0)]
            return [(("even", tool), minutes), (("breaking in", tool), float(np.sqrt(minutes)))]
        case Over.DEPTH:
            return [(None, _depth(row, sign, series))]


def _at_step(variant: Variant, tool: str, series: SeenSeries) -> int | None:
    return series.parts[variant.step].setting.get(tool) if variant.step < len(series.parts) else None


def minutes_in_cut(place: int, tool: str, series: SeenSeries) -> float:
    """Of the tool's edge when the part was cut; where it is not known, parts since the tool was set."""
    part = series.parts[place]
    if tool in part.minutes_in_cut:
        return part.minutes_in_cut[tool]
    return float(sum(one.setting.get(tool) == part.setting.get(tool) for one in series.parts[: place + 1]))


def _depth(row: Row, sign: Sign, series: SeenSeries) -> float:
    """Of the feature; of a length with one size for all, the farther face's less the nearer one's; unknown, 1."""
    depths = series.parts[row.part].depth_of_cut_mm
    if row.feature not in depths:
        return 1.0
    if row.kind is ErrorKind.LENGTH and sign.alike:
        return depths[row.feature] - depths[row.other] if row.other in depths else 1.0
    return depths[row.feature]
