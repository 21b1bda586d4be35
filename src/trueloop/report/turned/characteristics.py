"""Characteristics in figures and a few words: what the terminal and JSON show of them."""

from collections.abc import Sequence
from dataclasses import asdict

from trueloop.domain.characteristic import Characteristic
from trueloop.tolerances.judged import Judged, Judgement


def characteristics_as_dicts(judged: Sequence[Judged]) -> list[dict[str, object]]:
    """One a characteristic: what is asked for, with its unit, and the judgements; `before` null: not judged."""
    return [{**_asked(one.characteristic), "before": _of(one.before), "after": _of(one.after)} for one in judged]


def characteristics_words(judged: Sequence[Judged]) -> list[str]:
    """How many are in and out, before and expected after, and which is the tightest; nothing without any."""
    if not judged:
        return []
    before = [one.before for one in judged if one.before is not None]
    tightest = tightest_of(judged)
    words = [f"As measured: {_counted(before)}."] if before else []
    return [
        *words,
        f"Expected after the next cut: {_counted([one.after for one in judged])}.",
        f"Tightest: {tightest.characteristic.name}, in with a probability of {share(tightest.after.probability_in)}.",
    ]


def tightest_of(judged: Sequence[Judged]) -> Judged:
    """The one least likely to be in after the next cut."""
    return min(judged, key=lambda one: one.after.probability_in)


def share(probability: float) -> str:
    """A probability in per cent, never 100 % of what is not certain."""
    if 0.9995 < probability < 1.0:
        return "over 99.9 %"
    return "under 0.1 %" if 0.0 < probability < 0.0005 else f"{100.0 * probability:.1f} %"


def _counted(judgements: Sequence[Judgement]) -> str:
    counts = {kind: sum(one.verdict == kind for one in judgements) for kind in ("in", "out", "undecided")}
    found = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
    return f"{found} of {len(judgements)} characteristic{'' if len(judgements) == 1 else 's'}"


def _asked(one: Characteristic) -> dict[str, object]:
    return {**asdict(one), "quantity": str(one.quantity), "unit": one.quantity.unit}


def _of(judgement: Judgement | None) -> dict[str, object] | None:
    return None if judgement is None else asdict(judgement)
