"""Known events along a series, each as the shape in which it would move the values: candidates for an alarm's cause.

Shapes are over the whole series (n,); a part that the fact does not touch has 0. Values are counted from the mean of
the baseline, so that what was there in the baseline already (wear, warmth) is counted from its mean too.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.life import Cut, EdgeEvent, EdgeEventKind
from trueloop.loops.post_process.series import MadePart
from trueloop.monitoring.segments import Explanation
from trueloop.wording import Um, Wording, wording


@dataclass(frozen=True)
class PartFacts:
    """One part, in cutting order. `events`: of its edge since the part before. `proposals`: accepted since then.

    `minutes` is what its edge had cut before it; None: not known. `temperatures` in °C by sensor. `failed`: that the
    last check of the device by which it was measured failed, in words; empty: it did not, or there was none.
    `taken_off_mm` is how much smaller the correction that it was cut with made its size, `cut_with` names that; empty:
    none was in force.
    """

    serial: str
    at: datetime | None = None
    cut: Cut | None = None
    events: tuple[EdgeEvent, ...] = ()
    proposals: tuple[str, ...] = ()
    minutes: float | None = None
    temperatures: Mapping[str, float] = field(default_factory=dict)
    device: str = ""
    failed: str = ""
    taken_off_mm: float = 0.0
    cut_with: str = ""


WARMER_K: Final = 0.5
"""A temperature is outside the baseline's where it is beyond its range by more."""
SHORT: Final = 8
"""Digits of a hash that are shown."""


def known(
    made: Sequence[MadePart], facts: Sequence[PartFacts], in_baseline: Flags, sigma_mm: float | None = None
) -> tuple[Explanation, ...]:
    """Returns all known explanations of values that left their centre; `sigma_mm` of these where they are errors."""
    return (
        *_settings(made, facts),
        *_corrections(made, facts),
        *_in_force(facts, in_baseline, sigma_mm),
        *_programs(facts),
        *_not_run(facts),
        *_wear(made, facts, in_baseline),
        *_temperatures(facts, in_baseline),
        *_devices(facts, in_baseline),
        *_checks(facts),
    )


def _settings(made: Sequence[MadePart], facts: Sequence[PartFacts]) -> Iterator[Explanation]:
    """Yields shapes that last until the next setting."""
    at = [k for k, made_part in enumerate(made) if made_part.set_before or facts[k].events]
    for k, end in pairwise([*at, len(made)]):
        yield Explanation(wording("tool set"), _set_words(facts[k]), _between(len(made), k, end))


def _set_words(fact: PartFacts) -> Wording:
    kinds = [event.kind for event in fact.events]
    if EdgeEventKind.TURNED in kinds:
        return wording("the insert was turned before part {serial}", serial=fact.serial)
    if EdgeEventKind.MOUNTED in kinds:
        return wording("a new edge was mounted before part {serial}", serial=fact.serial)
    return wording("the tool was set before part {serial}", serial=fact.serial)


def _corrections(made: Sequence[MadePart], facts: Sequence[PartFacts]) -> Iterator[Explanation]:
    at = [k for k in range(1, len(made)) if made[k].correction_mm != made[k - 1].correction_mm]
    for k, end in pairwise([*at, len(made)]):
        change, serial = Um(made[k - 1].correction_mm - made[k].correction_mm, "+.1f"), made[k].serial
        words = wording("the size was changed by {change} before part {serial}", change=change, serial=serial)
        if facts[k].proposals:
            ids = ", ".join(proposal[:SHORT] for proposal in facts[k].proposals)
            words = wording("{what}: proposal {ids} was accepted", what=words, ids=ids)
        yield Explanation(wording("proposal accepted"), words, _between(len(made), k, end))


def _in_force(facts: Sequence[PartFacts], in_baseline: Flags, sigma_mm: float | None) -> Iterator[Explanation]:
    """Yields what the corrections that parts were cut with made of their sizes: in words, with the largest change."""
    size_mm = np.array([-fact.taken_off_mm for fact in facts])
    change = np.diff(size_mm)
    if not len(change) or not change.any():
        return
    k = int(np.abs(change).argmax()) + 1
    words = wording("the size was changed by {change} before part {serial}",
                    change=Um(float(change[k - 1]), "+.1f"), serial=facts[k].serial)  # fmt: skip
    if facts[k].cut_with:
        words = wording("{what}: {cut_with}", what=words, cut_with=facts[k].cut_with)
    shape = (size_mm - size_mm[in_baseline].mean()) / change[k - 1]
    size = None if sigma_mm is None else float(change[k - 1]) / sigma_mm
    yield Explanation(wording("correction in force"), words, shape, size)


def _programs(facts: Sequence[PartFacts]) -> Iterator[Explanation]:
    """Yields runs of parts cut by another program than the part before it."""
    ran = ["" if fact.cut is None else fact.cut.program_sha256 for fact in facts]
    at = [k for k in range(1, len(ran)) if ran[k] and ran[k - 1] and ran[k] != ran[k - 1]]
    for k, end in pairwise([*at, len(ran)]):
        words = wording(
            "part {serial} was cut by another program: {new}… in place of {old}…",
            serial=facts[k].serial, new=ran[k][:SHORT], old=ran[k - 1][:SHORT],
        )  # fmt: skip
        yield Explanation(wording("another program"), words, _between(len(ran), k, end))


def _not_run(facts: Sequence[PartFacts]) -> Iterator[Explanation]:
    """Parts cut as programmed after others that were cut with a correction."""
    with_one = [fact.cut is not None and bool(fact.cut.correction) for fact in facts]
    without = np.array([fact.cut is not None and not fact.cut.correction for fact in facts])
    where = without & (np.cumsum(with_one) > 0)
    if where.any():
        words = wording("no correction ran on {parts}", parts=_parts(facts, where))
        yield Explanation(wording("correction not run"), words, where.astype(float))


def _wear(made: Sequence[MadePart], facts: Sequence[PartFacts], in_baseline: Flags) -> Iterator[Explanation]:
    minutes = [fact.minutes for fact in facts]
    timed = all(minute is not None for minute in minutes)
    set_at = np.maximum.accumulate(
        [k if made_part.set_before or facts[k].events else 0 for k, made_part in enumerate(made)]
    )
    age = np.array(minutes, dtype=float) if timed else np.arange(len(made)) - set_at
    if timed:
        words = wording("the edge wears: it had cut {minutes:.0f} min at the last part", minutes=float(age[-1]))
    else:
        n, serial = int(age[-1]) + 1, made[set_at[-1]].serial
        words = wording("the edge wears, or the machine drifts: {n} parts since part {serial}", n=n, serial=serial)
    yield from _proportional(wording("wear"), words, age.astype(float), in_baseline)


def _temperatures(facts: Sequence[PartFacts], in_baseline: Flags) -> Iterator[Explanation]:
    """Yields the temperatures of sensors that every part has, where a part is outside the baseline's range."""
    shared = set(facts[0].temperatures).intersection(*(fact.temperatures for fact in facts)) if facts else set()
    for name in sorted(shared):
        of_all = np.array([fact.temperatures[name] for fact in facts])
        low, high = of_all[in_baseline].min(), of_all[in_baseline].max()
        beyond = np.maximum(of_all - high, low - of_all)
        if beyond.max() > WARMER_K:
            words = wording(
                "{sensor}: {t:.1f} °C at part {serial}, {low:.1f} to {high:.1f} °C in the baseline",
                sensor=name, t=float(of_all[beyond.argmax()]), serial=facts[int(beyond.argmax())].serial,
                low=float(low), high=float(high),
            )  # fmt: skip
            yield from _proportional(wording("temperature"), words, of_all, in_baseline)


def _devices(facts: Sequence[PartFacts], in_baseline: Flags) -> Iterator[Explanation]:
    usual = {one.device for one, base in zip(facts, in_baseline, strict=True) if base}
    for device in sorted({fact.device for fact in facts} - usual):
        where = np.array([fact.device == device for fact in facts])
        words = wording("{device} measured {parts}", device=device or "?", parts=_parts(facts, where))
        yield Explanation(wording("another device"), words, where.astype(float))


def _checks(facts: Sequence[PartFacts]) -> Iterator[Explanation]:
    """Parts measured after a check that failed, up to one that passed: in the words of the first that failed."""
    at = [k for k, one in enumerate(facts) if one.failed and not (k and facts[k - 1].failed)]
    for k in at:
        stop = next((j for j in range(k, len(facts)) if not facts[j].failed), len(facts))
        yield Explanation(wording("gauge"), facts[k].failed, _between(len(facts), k, stop))


def _proportional(kind: str, words: str, cause: Array, in_baseline: Flags) -> Iterator[Explanation]:
    about = cause - cause[in_baseline].mean()
    if np.abs(about).max() > 0.0:
        yield Explanation(kind, words, about / np.abs(about).max())


def _between(count: int, first: int, stop: int) -> Array:
    shape = np.zeros(count)
    shape[first:stop] = 1.0
    return shape


def _parts(facts: Sequence[PartFacts], where: Flags) -> Wording:
    serials = [one.serial for one, here in zip(facts, where, strict=True) if here]
    if len(serials) == 1:
        return wording("part {serial}", serial=serials[0])
    return wording("{n} parts, {first} to {last}", n=len(serials), first=serials[0], last=serials[-1])


def only(explanations: Iterable[Explanation], span: slice) -> tuple[Explanation, ...]:
    """Returns their shapes over a part of the series."""
    return tuple(replace(explanation, shape=explanation.shape[span]) for explanation in explanations)
