"""What a series says about its own records: corrections that did not arrive, times that contradict the order."""

from itertools import pairwise

from trueloop.diagnosis.causes.seen_part import SeenSeries
from trueloop.errors import Code, Finding, Severity

PROBABLE = 0.5


def noticed(series: SeenSeries, gain: float, probability: float) -> tuple[Finding, ...]:
    """Findings DIA-GAIN and DIA-CLOCK."""
    return (*_gain(gain, probability), *_clocks(series))


def _gain(gain: float, probability: float) -> tuple[Finding, ...]:
    if gain == 1.0 or probability < PROBABLE:
        return ()
    message = f"{gain:g} times the recorded correction arrived on the parts (probability {probability:.0%})"
    hint = "see whether the corrected program was run, and that it was not corrected twice; the recorded gain is 1"
    return (Finding(Severity.WARNING, Code.DIA_GAIN, message, hint, values={"gain": gain}),)


def _clocks(series: SeenSeries) -> tuple[Finding, ...]:
    """Parts that were cut before the one that precedes them, or as the same in number."""
    cut = [part for part in sorted(series.parts, key=lambda part: part.order) if not part.standard]
    found = []
    for one, two in pairwise(cut):
        if one.order == two.order:
            message = f"parts {one.serial} and {two.serial} are both number {one.order} in the order of cutting"
        elif one.at and two.at and two.at < one.at:
            message = (
                f"part {two.serial} follows {one.serial} in the order of cutting, and was cut {one.at - two.at} before"
            )
        else:
            continue
        hint = "mend the times or the order; wear, steps and temperatures were taken in the order of cutting"
        found.append(Finding(Severity.WARNING, Code.DIA_CLOCK, message, hint, values={"part": two.serial}))
    return tuple(found)
