"""Parts of a surface one after the other: what is noticed of each new one, and which are left out of the pattern."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.errors import Code, Finding, Severity
from trueloop.loops.surface.surface import Part, kept_parts
from trueloop.memory.noticing import BY_CHANCE, Alarm, What
from trueloop.surface.options import SurfaceOptions
from trueloop.surface.pattern.pattern import (
    LEAST_PARTS,
    Outlier,
    Pattern,
    drift_of,
    last_judged,
    on_square,
    outliers,
    pattern_of,
)
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

BEYOND_DOUBT: Final = 1e-6
"""The probability by chance below which a part is left out of the pattern automatically."""
FAR: Final = 3.0
"""So many times as far from the others as these are, too: a probability alone trusts the law of the scatter."""
LEAST_LEFT: Final = 4
"""The largest number of parts of which none is left out: with three others 0.5 % of sound parts would be, with four
0.05 %.
"""


@dataclass(frozen=True)
class NoticedPart:
    """The findings as a part was added: `left_out` where it does not count for the pattern."""

    name: str
    alarms: tuple[Alarm, ...]
    left_out: bool = False


def notice_in_order(parts: Sequence[Part], new: Collection[str]) -> Iterator[NoticedPart]:
    """Tests each new part, given those before it, in cutting order: for a different surface, and for a drift of the
    pattern.

    Each test alarms by chance in one part of a thousand. From the fourth part on, drift from the fifth. A part that is
    outlying beyond doubt is not taken for what the later ones are compared with.
    """
    good = list[Part]()
    for part in parts:
        together = [*good, part]
        odd = False
        if part.deviations.name in new or len(together) > LEAST_LEFT:
            noticed = _noticed(together)
            odd = noticed.left_out
            if part.deviations.name in new:
                yield noticed
        if not odd:
            good = together


def without_outliers(parts: Sequence[Part], options: SurfaceOptions) -> tuple[SurfaceOptions, tuple[Finding, ...]]:
    """Returns the options with the parts excluded that are outlying beyond doubt, and a warning of each.

    One after the other, the most outlying first: with it gone, the others are judged anew. Never more than a quarter.
    """
    kept = kept_parts(parts, options)
    most, found = len(kept) // LEAST_LEFT, list[Outlier]()
    while len(found) < most and len(kept) > LEAST_LEFT:
        pattern = _pattern(kept)
        stack = on_square(pattern.models)
        odd = [outlier for outlier in outliers(stack, pattern.names, 1 - BEYOND_DOUBT) if outlier.times > FAR]
        if not odd:
            break
        found.append(max(odd, key=lambda outlier: outlier.times))
        kept = [part for part in kept if part.deviations.name != found[-1].name]
    named = tuple(outlier.name for outlier in found)
    return replace(options, exclude=(*options.exclude, *named)), tuple(map(_left_out, found))


def as_findings(noticed: NoticedPart) -> tuple[Finding, ...]:
    """Returns the alarms of a part as findings."""
    codes = {What.SHAPE: Code.SRF_OUTLIER, What.DRIFT: Code.SRF_DRIFT}
    left = "; it does not count for the pattern" if noticed.left_out else ""
    return tuple(
        Finding(
            Severity.WARNING,
            codes[alarm.what],
            f"part {noticed.name!r}: {alarm.says} (p {alarm.probability:.2g}){left}",
            "look at its clamping, the cutter, the measurement, and which program cut it: a part of a corrected one "
            "does not belong here",
            values={"p_value": alarm.probability},
        )
        for alarm in noticed.alarms
    )


def _noticed(together: Sequence[Part]) -> NoticedPart:
    """Tests the last of the parts, given the others."""
    name = together[-1].deviations.name
    if len(together) < LEAST_PARTS:
        return NoticedPart(name, ())
    pattern = _pattern(together)
    stack = on_square(pattern.models)
    odd, alarms = last_judged(stack, name), list[Alarm]()
    if odd is not None and odd.p_value < BY_CHANCE:
        alarms.append(Alarm(What.SHAPE, odd.p_value, _of_shape(odd)))
    few = len(together) <= LEAST_LEFT
    left_out = odd is not None and not few and odd.p_value < BEYOND_DOUBT and odd.times > FAR
    drift = None if left_out else drift_of(pattern.models)
    if drift is not None and drift.p_value < BY_CHANCE:
        alarms.append(Alarm(What.DRIFT, drift.p_value, _of_drift(drift.per_part_mm, len(together))))
    return NoticedPart(name, tuple(alarms), left_out)


def _pattern(parts: Sequence[Part]) -> Pattern:
    return pattern_of([part.separation for part in parts], [part.deviations.name for part in parts])


def _of_shape(odd: Outlier) -> str:
    return wording(
        "the form of the error differs by {form} RMS from that of earlier parts, {times:.1f} times as much as these "
        "do: the cutter was changed or chipped, the work was clamped otherwise, or the stock is another",
        form=Um(odd.off_mm),
        times=odd.times,
    )


def _of_drift(per_part_mm: float, parts: int) -> str:
    return wording(
        "the pattern of {parts} parts changes by {change} RMS from part to part: the cutter wears, or the machine "
        "warms up",
        parts=parts,
        change=Um(per_part_mm, ".2f"),
    )


def _left_out(odd: Outlier) -> Finding:
    return Finding(
        Severity.WARNING,
        Code.SRF_OUTLIER,
        f"part {odd.name!r} is left out of the pattern: it differs from the mean of the others by "
        f"{odd.off_mm * UM_PER_MM:.2f} µm rms, {odd.times:.1f} times as much as parts do (p {odd.p_value:.2g})",
        "look at its clamping, tool and measurement, and which program cut it: a part of a corrected one does not "
        f"belong here; model.exclude = [{odd.name!r}] leaves it out for good, with --keep-outliers it counts",
        values={"p_value": odd.p_value},
    )
