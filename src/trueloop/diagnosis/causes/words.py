"""The evidence of a cause in words with figures, and which measurement would decide between causes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.diagnosis.causes.cause import Candidate, Over, SeenBy, SeenSeries
from trueloop.diagnosis.causes.surface import SurfaceErrors
from trueloop.diagnosis.causes.ways import Way
from trueloop.diagnosis.causes.weighing import Size
from trueloop.wording import Um, Wording, wording

OPEN, SETTLED = 0.02, 0.98
"""Causes between these probabilities are separated by a further measurement."""


@dataclass(frozen=True)
class CauseEvidence:
    """The feature on which a cause shows most: its mean error as each device saw it, over how many parts.

    Means are of the points there, as they had been without correction. `by_part_mm` is what the cause leaves on each
    part that was cut, `minutes` the longest time in cut there; `first_serial` is the first part on which it acts.
    """

    feature: str
    mean_mm: Mapping[SeenBy, tuple[float, int]]
    by_part_mm: Mapping[int, float]
    minutes: float
    first_serial: str


def shown(way: Way, errors: SurfaceErrors, series: SeenSeries, size: Size) -> CauseEvidence | None:
    """Where a cause shows most; None where it leaves nothing on parts that were cut."""
    cut = errors.places.number("cut") == 1.0
    effect = np.where(cut, size.effect_mm, 0.0)
    if not np.any(effect):
        return None
    largest = int(np.argmax(np.abs(effect)))
    labels = errors.places.labels(("feature", "at", "device", "part"))
    feature, place = labels[largest][:2]
    # a shape that changes sign along the feature is shown at the place where it is largest, any other by its mean
    own = np.array([label[0] == feature for label in labels]) & cut
    changes = np.min(effect[own]) < -0.3 * abs(effect[largest]) and np.max(effect[own]) > 0.3 * abs(effect[largest])
    rows = own & np.array([label[1] == place for label in labels]) if changes and way.over is not Over.SCATTER else own
    means = {}
    for seen_by in SeenBy:
        some = np.flatnonzero(rows & np.array([label[2] == seen_by.value for label in labels]))
        if len(some):
            parts = len({labels[k][3] for k in some})
            means[seen_by] = (float(np.mean(errors.value_mm[some] + errors.corrected_mm[some])), parts)
    at_place = [k for k, label in enumerate(labels) if label[1] == place and cut[k] and effect[k]]
    by_part = {labels[k][3]: float(effect[k]) for k in at_place}
    minutes = float(errors.places.number("minutes")[at_place].max(initial=0.0))
    return CauseEvidence(str(feature), means, by_part, minutes, series.parts[way.step].serial)


def support(way: Way, evidence: CauseEvidence | None, size: Size) -> tuple[str, ...]:
    """Why it is probable."""
    if evidence is None:
        return ()
    said = [_by_device(evidence)] if _agrees(way, evidence) else []
    return (*said, *_course(way, evidence, size))


def against(way: Way, evidence: CauseEvidence | None, size: Size, series: SeenSeries) -> tuple[str, ...]:
    """Returns the contradictions and the unknowns as text."""
    if evidence is None:
        return ()
    said: list[str] = [] if _agrees(way, evidence) else [_by_device(evidence)]
    if way.over is Over.DEPTH and not any(part.depth_of_cut_mm for part in series.parts):
        said.append(wording("The depths of cut are not recorded."))
    if way.over is Over.WEAR and not any(part.minutes_in_cut for part in series.parts):
        said.append(wording("The minutes in cut are not recorded: parts since the tool was set are counted instead."))
    if abs(size.mm) < 2 * size.standard_u_mm:
        said.append(wording("Its size, {size}, is less than twice its standard uncertainty.", size=Um(size.mm)))
    return tuple(said)


def decide(candidates: Sequence[Candidate], series: SeenSeries) -> tuple[str, ...]:
    """Measurements that would separate the causes left; () without any."""
    left = [one for one in candidates if OPEN < one.probability < SETTLED]
    if not left:
        return ()
    said: list[str] = []
    seen = {by for part in series.parts if not part.standard for by, points in part.points.items() if points.feature}
    for seen_by, sentence in _MISSING.items():
        if seen_by not in seen:
            said.append(sentence)
    keys = {one.cause.key for one in left}
    if keys & _PROBE and not any(part.standard for part in series.parts):
        said.append(_STANDARD)
    return tuple(dict.fromkeys([*said, *[one.cause.decided_by for one in left]]))


_PROBE: Final = frozenset({"part-probe-offset", "machine"})
_STANDARD: Final = wording(
    "Probe a standard part under standard conditions: no tool and no cut is in what it shows, but the part probe and a "
    "constant error of the machine."
)
_MISSING: Final = {
    SeenBy.MACHINE: wording(
        "Probe the parts on the machine before they are unclamped: what its probe sees too is the process."
    ),
    SeenBy.CMM: wording(
        "Measure finished parts on a measuring machine: what it sees alone is the machine or the part probe."
    ),
}


def _agrees(way: Way, evidence: CauseEvidence) -> bool:
    """Returns whether the device that sees most of it is the expected one."""
    if len(evidence.mean_mm) < 2 or way.over is Over.SCATTER:
        return True
    (machine, _), (cmm, _) = evidence.mean_mm[SeenBy.MACHINE], evidence.mean_mm[SeenBy.CMM]
    alike = abs(machine - cmm) < 0.5 * max(abs(machine), abs(cmm))
    if len(way.seen_by) == 2:
        return alike
    return not alike and (abs(cmm) > abs(machine)) == (way.seen_by == (SeenBy.CMM,))


def _by_device(evidence: CauseEvidence) -> Wording:
    if len(evidence.mean_mm) == 2:
        (machine, parts), (cmm, _) = evidence.mean_mm[SeenBy.MACHINE], evidence.mean_mm[SeenBy.CMM]
        return wording(
            "{feature}: the machine's probe finds {machine}, the CMM or gauge {cmm}, on average of {parts} parts.",
            feature=evidence.feature, machine=Um(machine), cmm=Um(cmm), parts=parts,
        )  # fmt: skip
    ((seen_by, (mean, parts)),) = evidence.mean_mm.items()
    if seen_by is SeenBy.MACHINE:
        return wording(
            "{feature}: the machine's probe finds {mean} on average of {parts} parts; no CMM or gauge has measured it.",
            feature=evidence.feature, mean=Um(mean), parts=parts,
        )  # fmt: skip
    return wording(
        "{feature}: the CMM or gauge finds {mean} on average of {parts} parts; the machine has not probed it.",
        feature=evidence.feature, mean=Um(mean), parts=parts,
    )  # fmt: skip


def _course(way: Way, evidence: CauseEvidence, size: Size) -> list[Wording]:
    """How it goes over the parts."""
    low, high = Um(min(evidence.by_part_mm.values())), Um(max(evidence.by_part_mm.values()))
    u = Um(size.standard_u_mm)
    followed = {
        Over.WEAR: wording("It goes with the minutes in cut, from {low} to {high} in {minutes:.0f} min.",
                           low=low, high=high, minutes=evidence.minutes),
        Over.TEMPERATURE: wording("It goes with {signal}, from {low} to {high}.",
                                  signal=way.signal, low=low, high=high) if way.signal else
                          wording("It changes steadily over the parts, from {low} to {high}.", low=low, high=high),
        Over.DEPTH: wording("It goes with the depth of cut, from {low} to {high}.", low=low, high=high),
        Over.SETTING: wording("It changes where the tool was set anew, from {low} to {high}.", low=low, high=high),
        Over.SCATTER: wording("It is another one on every part, from {low} to {high}.", low=low, high=high),
        Over.STEP: wording("It begins at part {serial}, {size}.", serial=evidence.first_serial, size=Um(size.mm)),
        Over.CONSTANT: wording("It is the same on all parts: {size}, standard uncertainty {u}.", size=Um(size.mm), u=u),
    }  # fmt: skip
    changing = way.over not in (Over.CONSTANT, Over.STEP)
    return [] if changing and str(low) == str(high) else [followed[way.over]]
