"""Characteristics in figures and a few words: what the terminal and JSON show of them."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Final

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.judged import Judged, Judgement
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.wording import wording

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
    words = [say("As measured: {counts}.", counts=_counted(before, say))] if before else []
    return [
        *words,
        say("Expected after the next cut: {counts}.", counts=_counted([one.after for one in judged], say)),
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
    counts = {kind: sum(one.verdict == kind for one in judgements) for kind in ("in", "out", "undecided")}
    found = ", ".join(f"{count} {say.note(VERDICTS[kind])}" for kind, count in counts.items() if count)
    if len(judgements) == 1:
        return say("{counts} of 1 characteristic", counts=found)
    return say("{counts} of {n} characteristics", counts=found, n=len(judgements))


def _asked(one: Characteristic) -> dict[str, object]:
    return {**asdict(one), "quantity": str(one.quantity), "unit": one.quantity.unit}


def _of(judgement: Judgement | None) -> dict[str, object] | None:
    return None if judgement is None else asdict(judgement)
