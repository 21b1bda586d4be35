"""Causes of a series' errors: probabilities of causes from errors at all points of all parts [4773 §4]."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.diagnosis.causes.catalogue import CAUSES
from trueloop.diagnosis.causes.cause import (
    Candidate,
    Diagnosis,
    Over,
    SeenBy,
    SeenSeries,
    SurfaceErrors,
    surface_errors,
)
from trueloop.diagnosis.causes.ways import SEEN_MM, Way, block_of, ways
from trueloop.diagnosis.causes.weighing import (
    Products,
    Size,
    WhitenedProducts,
    log_beside,
    log_evidence,
    products_of,
    size_of,
)
from trueloop.errors import Code, Finding, Severity
from trueloop.estimate.weights import shares
from trueloop.wording import Um, Wording, wording

OPEN, SETTLED = 0.02, 0.98
"""Causes between these probabilities are separated by a further measurement."""


@dataclass(frozen=True)
class Mean:
    """The mean error of a feature's points by one device, over how many parts, and what the process left."""

    measured_mm: float
    uncorrected_mm: float
    parts: int

    @property
    def words(self) -> object:
        """Returns the measured mean and, where it differs, that of the process without corrections."""
        measured, uncorrected = Um(self.measured_mm), Um(self.uncorrected_mm)
        if str(measured) == str(uncorrected):
            return measured
        return wording(
            "{measured} ({uncorrected} of the process without corrections)", measured=measured, uncorrected=uncorrected
        )


@dataclass(frozen=True)
class CauseEvidence:
    """The feature on which a cause shows most: its mean error as each device saw it.

    `by_part_mm` is what the cause leaves on each part that was cut, `minutes` the longest time in cut there (None: not
    recorded); `first_serial` is the first part on which it acts.
    """

    feature: str
    means: Mapping[SeenBy, Mean]
    by_part_mm: Mapping[int, float]
    minutes: float | None
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
            of_process, carried, taken_off = (
                float(np.mean(of[some])) for of in (errors.value_mm, errors.carried_mm, errors.corrected_mm)
            )
            means[seen_by] = Mean(of_process + carried, of_process + taken_off, parts)
    at_place = [k for k, label in enumerate(labels) if label[1] == place and cut[k] and effect[k]]
    by_part = {labels[k][3]: float(effect[k]) for k in at_place}
    timed = any(part.minutes_in_cut for part in series.parts)
    minutes = float(errors.places.number("minutes")[at_place].max(initial=0.0)) if timed else None
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
    left = [candidate for candidate in candidates if OPEN < candidate.probability < SETTLED]
    if not left:
        return ()
    said: list[str] = []
    seen = {by for part in series.parts if not part.standard for by, points in part.points.items() if points.feature}
    for seen_by, sentence in _MISSING.items():
        if seen_by not in seen:
            said.append(sentence)
    keys = {candidate.cause.key for candidate in left}
    if keys & _PROBE and not any(part.standard for part in series.parts):
        said.append(_STANDARD)
    return tuple(dict.fromkeys([*said, *[candidate.cause.decided_by for candidate in left]]))


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
    if len(evidence.means) < 2 or way.over is Over.SCATTER:
        return True
    machine, cmm = (evidence.means[by].uncorrected_mm for by in (SeenBy.MACHINE, SeenBy.CMM))
    alike = abs(machine - cmm) < 0.5 * max(abs(machine), abs(cmm))
    if len(way.seen_by) == 2:
        return alike
    return not alike and (abs(cmm) > abs(machine)) == (way.seen_by == (SeenBy.CMM,))


def _by_device(evidence: CauseEvidence) -> Wording:
    if len(evidence.means) == 2:
        machine, cmm = (evidence.means[by] for by in (SeenBy.MACHINE, SeenBy.CMM))
        return wording(
            "{feature}: the machine's probe finds {machine}, the CMM or gauge {cmm}, on average of {parts} parts.",
            feature=evidence.feature, machine=machine.words, cmm=cmm.words, parts=machine.parts,
        )  # fmt: skip
    ((seen_by, mean),) = evidence.means.items()
    if seen_by is SeenBy.MACHINE:
        return wording(
            "{feature}: the machine's probe finds {mean} on average of {parts} parts; no CMM or gauge has measured it.",
            feature=evidence.feature, mean=mean.words, parts=mean.parts,
        )  # fmt: skip
    return wording(
        "{feature}: the CMM or gauge finds {mean} on average of {parts} parts; the machine has not probed it.",
        feature=evidence.feature, mean=mean.words, parts=mean.parts,
    )  # fmt: skip


def _course(way: Way, evidence: CauseEvidence, size: Size) -> list[Wording]:
    """How it goes over the parts."""
    low, high = Um(min(evidence.by_part_mm.values())), Um(max(evidence.by_part_mm.values()))
    u = Um(size.standard_u_mm)
    followed = {
        Over.WEAR: wording("It goes with the minutes in cut, from {low} to {high} in {minutes:.0f} min.",
                           low=low, high=high, minutes=evidence.minutes) if evidence.minutes is not None else
                   wording("It goes with the parts since the tool was set, from {low} to {high}.", low=low, high=high),
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


NONE, ONE, TWO = 0.85, 0.135, 0.015
"""Beforehand: how probable no cause, one cause and two are."""
LIKELY: Final = 3
"""The likeliest ways are looked at with every other."""
BEST: Final = 8
"""So many of the likeliest causes are tried with each other, and so many with each of the likeliest ways."""
WIDE: Final = 60
"""Columns of two blocks together beyond which they are not tried as a pair."""
Hypothesis = tuple[int, ...]


@dataclass(frozen=True)
class WayColumns:
    """Ways with their columns: way v has `columns[:, blocks[v]]`, several may share one; `prior` is its share."""

    ways: tuple[Way, ...]
    blocks: tuple[Integers, ...]
    columns: Array
    prior: tuple[float, ...]
    products: Products


def asked(errors: SurfaceErrors, series: SeenSeries) -> WayColumns:
    """All ways that an instrument would see; of two causes that would leave the same, both."""
    kept, blocks, found = list[Way](), list[Integers](), dict[bytes, Array]()
    number: dict[bytes, int] = {}
    for cause in CAUSES:
        seen = set[tuple[int, ...]]()
        for way in ways(cause, errors, series):
            block = block_of(way, errors)
            keys = [column.tobytes() for column in block.T]
            found |= dict(zip(keys, block.T, strict=True))
            columns = tuple(number.setdefault(key, len(number)) for key in keys)
            if columns in seen or not (columns or way.wavy):
                continue
            seen.add(columns)
            kept.append(way)
            blocks.append(np.array(columns, dtype=np.intp))
    joined = np.column_stack([np.zeros((len(errors), 0)), *(found[key] for key in number)])
    products = products_of(errors, joined)
    visible = [v for v, way in enumerate(kept) if way.wavy or _visible(products, blocks[v])]
    chosen = [kept[v] for v in visible]
    return WayColumns(tuple(chosen), tuple(blocks[v] for v in visible), joined, _shares(chosen), products)


def log_weights(ways: WayColumns, gain: float) -> dict[Hypothesis, float]:
    """Prior times likelihood of every hypothesis, as logarithms, by the numbers of its ways."""
    whole = ways.products.at(gain)
    by_waves = (whole.only(wavy=False), whole.only(wavy=True))
    found: dict[Hypothesis, float] = {(): np.log(NONE) + log_evidence(by_waves[0], [])}
    for v, share in enumerate(ways.prior):
        found[(v,)] = np.log(ONE * share) + _log_likelihood(ways, by_waves, (v,))
    return found | _pairs(ways, by_waves, found)


def acting(ways: WayColumns, chosen: Hypothesis) -> list[int]:
    """Those that have columns."""
    return [v for v in chosen if len(ways.blocks[v])]


def _visible(products: Products, block: Integers) -> bool:
    """Returns whether the largest size that matters would be seen with more than one standard uncertainty."""
    information = np.diagonal(products.joined[0])[block]
    return bool(np.max(information, initial=0.0) * SEEN_MM**2 > 1.0)


def _pairs(
    ways: WayColumns, by_waves: tuple[WhitenedProducts, WhitenedProducts], singles: Mapping[Hypothesis, float]
) -> dict[Hypothesis, float]:
    """Pairs of the likeliest ways with each other, and of the likeliest few with all."""
    order = sorted((h[0] for h in singles if h), key=lambda v: -singles[(v,)])
    best: dict[tuple[str, str], int] = {}
    for v in order:
        best.setdefault(ways.ways[v].who, v)
    first = list(best.values())
    tried = {*combinations(sorted(first[:BEST]), 2)}
    for a in {*order[:LIKELY], *first[:LIKELY]}:
        others = [b for b in order if _may_join(ways, a, b)]
        looked = log_beside(by_waves[ways.ways[a].wavy], ways.blocks[a], [ways.blocks[b] for b in others])
        weights = [np.log(ways.prior[b]) + log for b, log in zip(others, looked, strict=True)]
        promising = sorted(range(len(others)), key=lambda k: -weights[k])[:BEST]
        waves = [k for k, b in enumerate(others) if ways.ways[b].wavy]
        tried |= {(min(a, others[k]), max(a, others[k])) for k in (*promising, *waves)}
    found: dict[Hypothesis, float] = {}
    for a, b in sorted(tried):
        if _may_join(ways, a, b):
            prior = TWO * 2 * ways.prior[a] * ways.prior[b]
            found[(a, b)] = np.log(prior) + _log_likelihood(ways, by_waves, (a, b))
    return found


def _may_join(ways: WayColumns, a: int, b: int) -> bool:
    """Returns whether two ways are of two causes, and no more columns than can be tried."""
    wide = len(ways.blocks[a]) + len(ways.blocks[b]) > WIDE
    return ways.ways[a].who != ways.ways[b].who and not wide


def _log_likelihood(ways: WayColumns, by_waves: tuple[WhitenedProducts, WhitenedProducts], chosen: Hypothesis) -> float:
    wavy = any(ways.ways[v].wavy for v in chosen)
    return log_evidence(by_waves[wavy], [ways.blocks[v] for v in acting(ways, chosen)])


def _shares(kept: Sequence[Way]) -> tuple[float, ...]:
    """A cause's prior in equal shares for its tools and ways to show; steps share one of these."""
    of: dict[str, set[object]] = {}
    steps: dict[object, int] = {}
    for way in kept:
        of.setdefault(way.cause.key, set()).add(_way(way))
        steps[_way(way)] = steps.get(_way(way), 0) + 1
    found = [way.cause.prior / len(of[way.cause.key]) / steps[_way(way)] for way in kept]
    return tuple(share / sum(found) for share in found)


def _way(way: Way) -> object:
    return way.cause.key, way.tool, way.over, way.form, way.seen_by


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
    for seen_part, two in pairwise(cut):
        if seen_part.order == two.order:
            message = (
                f"parts {seen_part.serial} and {two.serial} are both number {seen_part.order} in the order of cutting"
            )
        elif seen_part.at and two.at and two.at < seen_part.at:
            early = seen_part.at - two.at
            message = (
                f"part {two.serial} follows {seen_part.serial} in the order of cutting, and was cut {early} before"
            )
        else:
            continue
        hint = "mend the times or the order; wear, steps and temperatures were taken in the order of cutting"
        found.append(Finding(Severity.WARNING, Code.DIA_CLOCK, message, hint, values={"part": two.serial}))
    return tuple(found)


GAINS: Final = {1.0: 0.98, 0.0: 0.01, 2.0: 0.01}
"""Possible shares of a recorded correction that arrived on the parts, with their prior probabilities."""
SHOWN: Final = 0.001
"""Candidates that are less probable are left out."""
LINE: Final = 2
"""Coefficients of a line."""


def judge(series: SeenSeries) -> Diagnosis:
    """Probabilities of the causes in the catalogue, with evidence, and what would decide where several are left.

    The answer is a set: causes that leave the same share the probability as they had it beforehand. Errors are taken as
    they had been without the corrections that are recorded. Raises DIA-FEW where there is no point at all. Valid while
    errors add, scatter is normal and at most two causes act.
    """
    errors = surface_errors(series)
    if errors is None:
        raise Code.DIA_FEW.refusal(
            f"{len(series.parts)} parts with 0 points on their features, of at least 1 that a diagnosis needs",
            hint="inspect the parts on the machine, by a gauge or on a measuring machine; --job states the features of "
            "readings without a nominal value",
            values={"count": 0, "needed": 1},
        )
    given = asked(errors, series)
    by_gain = {gain: log_weights(given, gain) for gain in GAINS if gain == 1.0 or np.any(errors.corrected_mm)}
    whole = {gain: np.log(GAINS[gain]) + np.logaddexp.reduce(list(log.values())) for gain, log in by_gain.items()}
    gain, certain = next(iter(shares(whole).items()))
    found = shares(by_gain[gain])
    candidates = _candidates(given, errors, series, gain, found)
    return Diagnosis(
        candidates=candidates,
        hypotheses=_by_key(given, found),
        sound=found[()],
        decide=decide(candidates, series),
        gain=gain,
        findings=noticed(series, gain, certain),
    )


def _by_key(ways: WayColumns, probabilities: Mapping[Hypothesis, float]) -> tuple[tuple[tuple[str, ...], float], ...]:
    by_key: dict[tuple[str, ...], float] = {}
    for hypothesis, share in probabilities.items():
        key = tuple(sorted({ways.ways[v].cause.key for v in hypothesis}))
        by_key[key] = by_key.get(key, 0.0) + share
    return tuple(sorted(by_key.items(), key=lambda item: -item[1]))


def _candidates(
    ways: WayColumns, errors: SurfaceErrors, series: SeenSeries, gain: float, probabilities: Mapping[Hypothesis, float]
) -> tuple[Candidate, ...]:
    """One a cause and tool, sized as in the likeliest hypothesis that holds it."""
    total: dict[tuple[str, str], float] = {}
    first: dict[tuple[str, str], tuple[Hypothesis, int]] = {}
    for hypothesis, share in probabilities.items():
        for v in hypothesis:
            who = ways.ways[v].who
            total[who] = total.get(who, 0.0) + share
            first.setdefault(who, (hypothesis, v))
    whole = ways.products.at(gain)
    made = []
    for who, probability in sorted(total.items(), key=lambda item: -item[1]):
        if probability >= SHOWN:
            hypothesis, v = first[who]
            size = _size(ways, whole, errors, hypothesis, v)
            seen = shown(ways.ways[v], errors, series, size)
            made.append(_candidate(ways, errors, series, seen, size, v, probability))
    return tuple(made)


def _size(ways: WayColumns, whole: WhitenedProducts, errors: SurfaceErrors, hypothesis: Hypothesis, v: int) -> Size:
    if ways.ways[v].wavy:
        return _waviness(errors)
    used = acting(ways, hypothesis)
    some = whole.only(wavy=any(ways.ways[u].wavy for u in hypothesis))
    return size_of(some, [ways.blocks[u] for u in used], used.index(v), ways.columns[:, ways.blocks[v]])


def _waviness(errors: SurfaceErrors) -> Size:
    """Scatter of points about a line on the waviest feature, root mean square over parts and devices."""
    share, found = errors.places.number("share"), dict[str, list[tuple[float, float, int]]]()
    labels = errors.places.labels(("part", "device", "feature"))
    for label in dict.fromkeys(labels):
        rows = np.array([one == label for one in labels]) & (errors.places.number("face") == 0.0)
        if rows.sum() > LINE and np.ptp(share[rows]):
            line = np.polynomial.Polynomial.fit(share[rows], errors.value_mm[rows], 1)
            rest = errors.value_mm[rows] - line(share[rows])
            noise = float(np.mean(errors.standard_u_mm[rows] ** 2))
            spare = int(rows.sum()) - LINE
            found.setdefault(str(label[2]), []).append((float(rest @ rest) / spare, noise, spare))
    if not found:
        return Size(0.0, 0.0, np.zeros(len(errors)))
    means = {name: np.mean(some, axis=0) for name, some in found.items()}
    name = max(means, key=lambda one: float(means[one][0]))
    squares, noise, spare = means[name].tolist()
    size = float(np.sqrt(max(squares - noise, 0.0)))
    u = float(np.sqrt(squares / (2.0 * spare * len(found[name]))))
    own = np.array([label[2] == name for label in labels])
    return Size(size, u, np.where(own, size, 0.0))


def _candidate(
    ways: WayColumns,
    errors: SurfaceErrors,
    series: SeenSeries,
    evidence: CauseEvidence | None,
    size: Size,
    v: int,
    probability: float,
) -> Candidate:
    way = ways.ways[v]
    return Candidate(
        cause=way.cause,
        features=_features(errors, size),
        probability=probability,
        size_mm=size.mm,
        standard_u_mm=size.standard_u_mm,
        supports=support(way, evidence, size),
        contradicts=against(way, evidence, size, series),
        tool=way.tool,
    )


def _features(errors: SurfaceErrors, size: Size) -> tuple[str, ...]:
    """Those on which it leaves a third of its largest effect or more."""
    much = np.abs(size.effect_mm) >= max(abs(size.mm), 1e-12) / 3
    labels = [feature for (feature,) in errors.places.labels(("feature",))]
    return tuple(dict.fromkeys(name for name, is_much in zip(labels, much, strict=True) if is_much))
