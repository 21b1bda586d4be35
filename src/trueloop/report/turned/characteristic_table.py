"""The characteristics of the drawing: inside their limits before, and as expected after; the tightest first."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Final

from trueloop.domain.characteristic import Characteristic, Judged, Judgement, Quantity, Verdict
from trueloop.report.markup import esc, table
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.turned.error_curve.curve import coverage_factor
from trueloop.wording import wording

SIGNS: Final = {"in": "✓", "out": "✗", "undecided": "?"}
QUANTITIES: Final = {
    Quantity.DIAMETER: wording("diameter"),
    Quantity.RADIUS: wording("radius"),
    Quantity.LENGTH: wording("length"),
    Quantity.ANGLE: wording("angle"),
    Quantity.RUNOUT: wording("runout"),
    Quantity.POSITION: wording("position"),
    Quantity.FORM: wording("form"),
    Quantity.OTHER: wording("other"),
}
BAR: Final = (96, 18)
"""Size of a bar, px."""


def characteristic_table(judged: Sequence[Judged], say: Texts = ENGLISH) -> str:
    """Writes the table, or how to state characteristics where there are none (HTML)."""
    if not judged:
        return "<p class='note' id='no-characteristics'>" + say(
            "The job states no tolerances: name them in tables <code>[[part.characteristic]]</code>, and this page "
            "states whether each is in or out (docs/report.md)."
        ) + "</p>"  # fmt: skip
    headings = (
        say("characteristic"), say("nominal"), say("limits"), say("measured"), say("before"),
        say("expected after<br>± U (95 %)"), say("after"), say("probability<br>of being in"), say("margin"),
        say("within the limits"),
    )  # fmt: skip
    rows = [_row(one, say) for one in tightest_first(judged)]
    summary = esc(" ".join(characteristics_words(judged, say)))
    legend = say(
        "Bar: the tolerance zone between its limits; ○ before, ◆ expected after with its ± U. in: inside the limits "
        "with U taken off on both sides, out: outside with U added, undecided: neither (ISO 14253-1)."
    )
    return (
        f"<p id='judged'><strong>{summary}</strong></p>"
        + table(headings, rows, words=(0, 4, 6, 9), name="characteristics", stacks=True)
        + f"<p class='note'>{legend}</p>"
    )


def tightest_first(judged: Sequence[Judged]) -> list[Judged]:
    """Sorts by the probability of being in after the correction, then by the margin; what has no limits comes last."""

    def place(judged: Judged) -> tuple[float, float]:
        probability = judged.after.probability_in
        return 2.0 if probability is None else probability, judged.after.margin or 0.0

    return sorted(judged, key=place)


def _row(judged: Judged, say: Texts) -> list[str]:
    asked, before, after = judged.characteristic, judged.before, judged.after
    unit = "°" if asked.quantity is Quantity.ANGLE else say.mm_name
    place = "" if asked.at_z_mm is None else say(", at z {z} {mm}", z=say.mm(asked.at_z_mm))
    expanded = expanded_u(after)
    return [
        f"<b>{esc(asked.name)}</b><br>{esc(say.note(QUANTITIES[asked.quantity]))}, {esc(asked.feature)}{place}",
        f"{_number(asked.nominal, asked, say)} {unit}" + (f"<br>{esc(asked.tolerance)}" if asked.tolerance else ""),
        f"{_limit(asked.lower_limit, asked, say)}<br>{_limit(asked.upper_limit, asked, say)}",
        "–" if before is None else _number(before.value, asked, say),
        "–" if before is None else _verdict(before, say),
        f"{_number(after.value, asked, say)}<br>± {_number(expanded, asked, say)}",
        _verdict(after, say),
        esc(share(after.probability_in, say)),
        "–" if after.margin is None else _number(after.margin, asked, say),
        "" if after.verdict is None else _bar(judged, after.verdict, expanded, say),
    ]


def expanded_u(judgement: Judgement) -> float:
    """Returns the half width that holds 95 %."""
    return coverage_factor(judgement.degrees_of_freedom) * judgement.standard_u


def _verdict(judgement: Judgement, say: Texts) -> str:
    """A sign and a word; the colour repeats them."""
    verdict = judgement.verdict
    if verdict is None:
        return "–"
    return f'<span class="verdict-{verdict}">{SIGNS[verdict]} {esc(say.note(VERDICTS[verdict]))}</span>'


def _number(value: float, characteristic: Characteristic, say: Texts) -> str:
    return say.number(value, 4) if characteristic.quantity is Quantity.ANGLE else say.mm(value, 4)


def _limit(value: float | None, characteristic: Characteristic, say: Texts) -> str:
    return "–" if value is None else _number(value, characteristic, say)


def _bar(one: Judged, verdict: Verdict, expanded: float, say: Texts) -> str:
    """The zone between the limits, and where the values are; a zone with one limit is open on the other side."""
    low, high = _zone(one, expanded)
    width, height = BAR

    def x(value: float) -> float:
        share = (value - low) / (high - low)
        return 4 + (width - 8) * min(max(0.15 + 0.7 * share, 0.0), 1.0)

    middle = height / 2
    left, right = x(one.after.value - expanded), x(one.after.value + expanded)
    value = x(one.after.value)
    before = "" if one.before is None else f'<circle cx="{x(one.before.value):.1f}" cy="{middle}" r="3.5" class="was"/>'
    limits = "".join(
        f'<path d="M{x(limit):.1f} 1V{height - 1}" class="limit"/>'
        for limit in (one.characteristic.lower_limit, one.characteristic.upper_limit)
        if limit is not None
    )
    words = say("{name}: {verdict} after the correction", name=esc(one.characteristic.name),
                verdict=esc(say.note(VERDICTS[verdict])))  # fmt: skip
    return (
        f'<svg class="bar" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" '
        f'aria-label="{words}"><path d="M{x(low):.1f} {middle}H{x(high):.1f}" class="zone"/>{limits}'
        f'<path d="M{left:.1f} {middle}H{right:.1f}" class="u"/>{before}'
        f'<path d="M{value:.1f} {middle - 4.5}l4.5 4.5l-4.5 4.5l-4.5 -4.5Z" class="will"/></svg>'
    )


def _zone(judged: Judged, expanded: float) -> tuple[float, float]:
    """From limit to limit; an open side reaches as far as the values do."""
    asked, after = judged.characteristic, judged.after
    values = [asked.nominal, after.value - expanded, after.value + expanded]
    low = min(values) if asked.lower_limit is None else asked.lower_limit
    high = max(values) if asked.upper_limit is None else asked.upper_limit
    return (low, high) if high > low else (low - 0.5, low + 0.5)


VERDICTS: Final = {"in": wording("in"), "out": wording("out"), "undecided": wording("undecided")}


def characteristics_as_dicts(judged: Sequence[Judged]) -> list[dict[str, object]]:
    """Converts each characteristic: what is required, with its unit, and judgements; `before` null: not judged."""
    return [{**_asked(one.characteristic), "before": _of(one.before), "after": _of(one.after)} for one in judged]


def characteristics_words(judged: Sequence[Judged], say: Texts = ENGLISH) -> list[str]:
    """Describes how many are in and out, before and expected after, and the tightest; nothing without any."""
    unlimited = sum(one.after.verdict is None for one in judged)
    without = [say("Without limits, and not judged: {n}.", n=unlimited)] if unlimited else []
    judged = [one for one in judged if one.after.verdict is not None]
    if not judged:
        return without
    before = [one.before for one in judged if one.before is not None]
    tightest = tightest_of(judged)
    words = [say("Characteristics as measured: {counts}.", counts=_counted(before, say))] if before else []
    after = _counted([one.after for one in judged], say)
    return [
        *words,
        say("Characteristics expected after the next cut: {counts}.", counts=after),
        say(
            "Tightest: {name}, in with a probability of {probability}.",
            name=tightest.characteristic.name,
            probability=share(tightest.after.probability_in, say),
        ),
        *without,
    ]


def tightest_of(judged: Sequence[Judged]) -> Judged:
    """Returns the one least likely to be in after the next cut."""
    return min(judged, key=lambda one: 2.0 if one.after.probability_in is None else one.after.probability_in)


def share(probability: float | None, say: Texts = ENGLISH) -> str:
    """Formats a probability in per cent, never 100 % of what is not certain; a dash where nothing was judged."""
    if probability is None:
        return "–"
    if 0.9995 < probability < 1.0:
        return say("over {percent:.1f} %", percent=99.9)
    if 0.0 < probability < 0.0005:
        return say("under {percent:.1f} %", percent=0.1)
    return say("{percent:.1f} %", percent=100.0 * probability)


def _counted(judgements: Sequence[Judgement], say: Texts) -> str:
    counts = {kind: sum(judgement.verdict == kind for judgement in judgements) for kind in VERDICTS}
    words = {
        "in": say("{n} within limits", n=counts["in"]),
        "out": say("{n} out of limits", n=counts["out"]),
        "undecided": say("{n} undecided", n=counts["undecided"]),
    }
    return ", ".join(words[kind] for kind, count in counts.items() if count)


def _asked(characteristic: Characteristic) -> dict[str, object]:
    return {**asdict(characteristic), "quantity": str(characteristic.quantity), "unit": characteristic.quantity.unit}


def _of(judgement: Judgement | None) -> dict[str, object] | None:
    return None if judgement is None else asdict(judgement)
