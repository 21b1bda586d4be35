"""Numbers to enter at the control: which, how much, and what the next part is expected to be with them.

An entry of +1 leaves, as an error of the cut: of a tool's radius +1 on every wall that the control compensates with it,
of its length +1 on faces that look up, of a work offset n along its axis, of its turn n·(ẑ × p) per radian. The changes
c of entries minimize the expected sum of squares Σ w²(m + A·c − aim)² over the sizes and coordinates that were
measured; m is their expectation with the entries in force, w is 1 over half of the tolerance. Entries are taken one by
one, the most useful first, as long as they are known to more than twice their standard uncertainty: so an error that
one number explains is put into one number, and what nothing determines stays as it is.
"""

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Judgement
from trueloop.estimate.history import after_parts
from trueloop.estimate.sizes import fitted_sizes, log_evidence
from trueloop.estimate.state import Key, Normal, State
from trueloop.estimate.weights import shares
from trueloop.milled.entry import (
    PARTS_FOR_SIZES,
    PLAINEST,
    SHOWS,
    Contradictory,
    Entered,
    Entry,
    Exchanged,
    Part,
    against_earlier,
)
from trueloop.milled.observed import (
    LASTING,
    UNCALIBRATED_MM,
    ObservedSize,
    milled_catalogue,
    odd_features,
    places_of,
    with_device_off,
    with_scales,
)
from trueloop.statistics import rms
from trueloop.tolerances.conformance import judge

KNOWN: Final = 2.0
"""An entry is made where it is known to more than so many of its standard uncertainties."""
ALIKE: Final = 1.05
"""Entries that leave less than so many times the least are as good: the plainest of them is taken."""
STEP_RAD: Final = math.radians(0.001)
"""A control takes angles in steps of 0.001°."""
OFF: Final = 0.03
"""So probably a device was not calibrated, before anything was measured."""
LIKELY: Final = 0.05
"""With this probability it is named, and has a part in the numbers and their bands, which hold in 95 of 100 cases."""
GROSS_MM: Final = 0.1
"""A reading that others of its size contradict, as by a chip, may be off by so much."""
MOST_PARTS: Final = 12
"""Devices are judged by so many of the latest parts."""
DEPENDENT: Final = 1e-6
"""Share of an entry's effect that others do not have already, below which it is not determined beside them."""


@dataclass(frozen=True)
class ProposedEntry:
    """A number to enter: its change from what is in force, the total with it, and its standard uncertainty; mm, rad."""

    entry: Entry
    change: float
    total: float
    standard_u: float


@dataclass(frozen=True)
class ExpectedSize:
    """A size or coordinate: its deviation on the last part, mm, and of the next one without and with the entries."""

    seen: ObservedSize
    measured_mm: float | None
    unchanged: Judgement
    changed: Judgement


@dataclass(frozen=True)
class DeviceOff:
    """A device that may read walls out of place all around: how probably, and by how much out of the material, mm."""

    name: str
    probability: float
    off_mm: float
    standard_u_mm: float


@dataclass(frozen=True, eq=False)
class Proposal:
    """The answer for the next part. `unlike`: features so far off what tools and work offsets explain, by a chip, a
    recut or an error of their own, that they have no part in the entries. `by_one_reading`: proposed entries that a
    single reading shows, with its name: a chip there is entered as well. `contradictory`: sizes whose readings on one
    part contradict each other; they have no part in the entries. `suspected`: slips that the last part looks like, "as
    if …", of less than what is refused.
    """

    proposed: tuple[ProposedEntry, ...]
    expected: tuple[ExpectedSize, ...]
    unlike: tuple[str, ...]
    by_one_reading: Mapping[Entry, str]
    contradictory: tuple[Contradictory, ...]
    suspected: str = ""
    devices: tuple[DeviceOff, ...] = ()
    exchanged: tuple[Exchanged, ...] = ()

    @property
    def rms_mm(self) -> tuple[float, float]:
        """Returns the expected deviation from what is aimed at over all sizes, RMS: without and with the entries."""
        off = [
            (size.unchanged.value - target(size.seen), size.changed.value - target(size.seen)) for size in self.expected
        ]
        before, after = zip(*off, strict=True)
        return rms(np.array(before)), rms(np.array(after))


def target(size: ObservedSize) -> float:
    """Returns the size that is aimed at, mm."""
    return size.nominal_mm + size.aim_mm


@dataclass(frozen=True, eq=False)
class _Known:
    """The knowledge that parts give, `off` being the devices that may be off: how probably that is so, the state, and
    by how much terms of the last part and what lasts are larger than usual.
    """

    probability: float
    off: tuple[str, ...]
    state: State
    scales: Mapping[Key, float]

    @classmethod
    def of(cls, parts: Sequence[Part], off: tuple[str, ...], probability: float) -> "_Known":
        """Takes in the parts with those devices off."""
        catalogue, values = milled_catalogue(), [with_device_off(part.as_first_set(), off) for part in parts]
        sizes = fitted_sizes(catalogue, values) if len(parts) >= PARTS_FOR_SIZES else catalogue.medians
        known = after_parts(catalogue, sizes, [[observed] for observed in values])
        *earlier, shows = [taken.scales for of_part in known.taken for taken in of_part]
        scales = {key: scale for mapping in earlier for key, scale in mapping.items() if key[0] in LASTING}
        return cls(probability, off, replace(known.state, sizes=with_scales(sizes)), {**scales, **shows})

    def device(self) -> DeviceOff:
        """Returns the device that is off."""
        [name] = self.off
        at = self.state.blocks["device", name].start
        u = math.sqrt(self.state.covariance[at, at])
        return DeviceOff(name, self.probability, UNCALIBRATED_MM * float(self.state.mean[at]), UNCALIBRATED_MM * u)


def propose(
    part_type: str,
    parts: Sequence[Part],
    possible: Sequence[Entry],
    step_mm: float = 1e-3,
    calibrated: Collection[str] = (),
) -> Proposal:
    """Returns the numbers to enter before the next part, in the control's steps; `possible`: those it can be given.

    `calibrated`: devices that are known to be.
    """
    shown = _together(parts)
    contradictory, parts = _without_contradictory(parts, _devices(parts) - set(calibrated))
    exchanged = [part.exchanged() for part in parts]
    parts = [
        part.without({name for one in own for name in one.names}) for part, own in zip(parts, exchanged, strict=True)
    ]
    likely = {device: share for device, share in devices_off(parts, calibrated).items() if share >= LIKELY}
    again, parts = _without_contradictory(parts, likely)
    last = parts[-1]
    compared = against_earlier([part.with_device_off(likely) for part in parts], possible)
    parts = [part.without((), names) for part, names in zip(parts, compared.odd, strict=True)]
    readings = Counter(size.name for part in parts for size in part.shown)
    doubtful = [_Known.of(parts, (device,), share) for device, share in likely.items()]
    each = [_Known.of(parts, (), 1.0 - sum(likely.values())), *doubtful]
    scales = max(each, key=lambda known: known.probability).scales
    places, functional = places_of(tuple(shown.values()), part_type, int(last.observed.places.number("part")[0]) + 1)
    unlike = {**odd_features(scales), **compared.odd[-1]}
    alike = [
        readings[size.name] > 0 and all(feature.name not in unlike for feature in size.features)
        for size in shown.values()
    ]
    weight = _weights(list(shown.values())) * alike
    aim = np.array([size.aim_mm for size in shown.values()])
    lasting = _mixed(
        [(one.probability, one.state.predict(places, functional, LASTING, repeatability=False)) for one in each]
    )
    effects = {one: functional @ one.basis(places) for one in {**dict.fromkeys(possible), **last.in_force}}
    error = lasting.mean_mm + _effect(effects, last.in_force) - aim
    chosen = _chosen({one: effects[one] for one in possible}, weight, error, lasting.covariance_mm2)
    proposed = [
        ProposedEntry(one, change, last.in_force.get(one, 0.0) + change, u)
        for one, (value, u) in chosen.items()
        if (change := _in_steps(one, value, step_mm)) != 0.0
    ]
    totals = {**last.in_force, **{one.entry: one.total for one in proposed}}
    whole = _mixed([(one.probability, one.state.predict(places, functional)) for one in each])
    now = whole.mean_mm + _effect(effects, last.in_force)
    after = whole.mean_mm + _effect(effects, totals)
    u = whole.standard_u_mm
    read = [(size.name, value) for size, value in zip(last.shown, last.observed.value_mm.tolist(), strict=True)]
    measured = {name: float(np.mean([value for other, value in read if other == name])) for name, _ in read}
    expected = tuple(
        ExpectedSize(size, measured.get(size.name), *(_judged(size, value[k], u[k]) for value in (now, after)))
        for k, size in enumerate(shown.values())
    )
    by_one = dict[Entry, str]()
    for entry in (one.entry for one in proposed):
        moved = np.abs(effects[entry]) * alike
        names = [name for name, each in zip(shown, moved, strict=True) if each > SHOWS * np.max(moved)]
        if len(names) == 1 and readings[names[0]] == 1:
            by_one[entry] = names[0]
    return Proposal(
        proposed=tuple(proposed),
        expected=expected,
        unlike=tuple(unlike),
        by_one_reading=by_one,
        contradictory=(*contradictory, *again),
        suspected=compared.suspected,
        exchanged=tuple(one for own in exchanged for one in own),
        devices=tuple(known.device() for known in doubtful),
    )


def _devices(parts: Sequence[Part]) -> set[str]:
    return {name for part in parts for name in part.observed.places.columns["device"].tolist() if name}


def _without_contradictory(
    parts: Sequence[Part], off: Collection[str]
) -> tuple[tuple[Contradictory, ...], Sequence[Part]]:
    """Returns sizes whose readings contradict each other, with those devices off, and the parts without these."""
    found = [part.with_device_off(off).contradictory() for part in parts]
    named = [{name for one in own for name in one.names} for own in found]
    without = [part.without(names) for part, names in zip(parts, named, strict=True)]
    return tuple(one for own in found for one in own), without


def devices_off(parts: Sequence[Part], calibrated: Collection[str] = ()) -> dict[str, float]:
    """Returns how probably each device was not calibrated, one at most, the likeliest first.

    A tool that is larger by r than set and a device that reads walls out of place by −r show alike. The sizes of radii
    that fit the parts decide: of tools that are all off alike, one device is the likelier cause, and of two devices
    that differ the one with which the tools would be.
    """
    catalogue, names = milled_catalogue(), sorted(_devices(parts) - set(calibrated))
    if not names:
        return {}
    parts = parts[-MOST_PARTS:]
    values = [[with_device_off(part.as_first_set(), names)] for part in parts]
    taken = [one.scales for of_part in after_parts(catalogue, catalogue.medians, values).taken for one in of_part]
    parts = [part.without((), odd_features(scales)) for part, scales in zip(parts, taken, strict=True)]
    log_weights = dict[str, float]()
    for name, prior in (("", 1.0 - OFF * len(names)), *((name, OFF) for name in names)):
        assumed = [part.with_device_off({name}) for part in parts]
        gross = [{name for one in part.contradictory() for name in one.names} for part in assumed]
        more_mm2 = [
            GROSS_MM**2 * (size.name in names) for part, names in zip(parts, gross, strict=True) for size in part.shown
        ]
        log_weights[name] = (
            math.log(max(prior, OFF))
            + sum(map(len, gross)) * math.log(catalogue.gross)
            + log_evidence(catalogue, [part.as_first_set() for part in assumed], np.array(more_mm2))
        )
    return {name: share for name, share in shares(log_weights).items() if name}


def _mixed(normals: Sequence[tuple[float, Normal]]) -> Normal:
    """Returns mean and covariance of what has these distributions with these probabilities."""
    mean = np.asarray(sum((share * one.mean_mm for share, one in normals), np.zeros(1)))
    apart = [(share, one, one.mean_mm - mean) for share, one in normals]
    return Normal(mean, np.asarray(sum(share * (one.covariance_mm2 + np.outer(d, d)) for share, one, d in apart)))


def _weights(shown: Sequence[ObservedSize]) -> Array:
    """Returns 1 over half of each tolerance, 1/mm; of sizes without one the median of the others, or 1."""
    half = np.array(
        [
            np.nan if size.lower_mm is None or size.upper_mm is None else 0.5 * (size.upper_mm - size.lower_mm)
            for size in shown
        ]
    )
    known = half[half > 0.0]
    return np.asarray(1.0 / np.where(half > 0.0, half, np.median(known) if len(known) else 1.0))


def _together(parts: Sequence[Part]) -> dict[str, ObservedSize]:
    """Returns what was seen of all parts by name; limits that a later file leaves out are those of an earlier one."""
    shown = dict[str, ObservedSize]()
    for size in (size for part in parts for size in part.shown):
        before = shown.get(size.name)
        without = before is not None and size.lower_mm is None and size.upper_mm is None
        shown[size.name] = (
            replace(size, lower_mm=before.lower_mm, upper_mm=before.upper_mm) if before and without else size
        )
    return shown


def _chosen(
    effects: Mapping[Entry, Array], weight: Array, off: Array, covariance: Array
) -> dict[Entry, tuple[float, float]]:
    """Returns the changes of the chosen entries with their standard uncertainties.

    A rotation is tried only where it is seen beside both shifts of its work offset: one bore does not show it. What
    later entries have made uncertain again is dropped for good.
    """
    weighted, scatter = weight * off, covariance * np.outer(weight, weight)
    columns = {entry: weight * effect for entry, effect in effects.items()}
    smallest = DEPENDENT * max((float(np.linalg.norm(column)) for column in columns.values()), default=0.0)
    order, dropped = list(effects), set[Entry]()
    found = dict[Entry, tuple[float, float]]()
    while True:
        tried = dict[Entry, tuple[float, dict[Entry, tuple[float, float]]]]()
        for entry in effects:
            beside = [Entry("x", entry.of), Entry("y", entry.of)] if entry.register == "turn" else []
            others = [columns[k] for k in (*found, *(k for k in beside if k in columns and k not in found))]
            if entry in found or entry in dropped or not _determined(columns[entry], others, smallest):
                continue
            left, solved = _solved({k: columns[k] for k in (*found, entry)}, weighted, scatter)
            if abs(solved[entry][0]) > KNOWN * solved[entry][1]:
                tried[entry] = left, solved
        if not tried:
            return found
        least = min(left for left, _ in tried.values())
        floor = 1e-9 * float(np.sum(weighted**2))
        good = [entry for entry, (left, _) in tried.items() if left <= ALIKE * least + floor]
        best = min(good, key=lambda entry: (PLAINEST.index(entry.register), order.index(entry)))
        found = tried[best][1]
        while uncertain := [entry for entry, (value, u) in found.items() if abs(value) <= KNOWN * u]:
            dropped.add(uncertain[0])
            found = _solved({k: columns[k] for k in found if k != uncertain[0]}, weighted, scatter)[1]


def _solved(
    columns: Mapping[Entry, Array], weighted: Array, scatter: Array
) -> tuple[float, dict[Entry, tuple[float, float]]]:
    """Returns what changes of these entries leave, a weighted sum of squares, and the changes with their u."""
    if not columns:
        return float(np.sum(weighted**2)), {}
    matrix = np.column_stack(list(columns.values()))
    gain = -np.linalg.pinv(matrix)
    value, u = gain @ weighted, np.sqrt(np.maximum(np.diag(gain @ scatter @ gain.T), 0.0))
    solved = dict(zip(columns, zip(value.tolist(), u.tolist(), strict=True), strict=True))
    return float(np.sum((weighted + matrix @ value) ** 2)), solved


def _determined(column: Array, others: Sequence[Array], smallest: float) -> bool:
    """Returns whether a column is more than a combination of others."""
    rest = column
    if others:
        matrix = np.column_stack(others)
        rest = column - matrix @ np.linalg.lstsq(matrix, column, rcond=None)[0]
    return float(np.linalg.norm(rest)) > max(smallest, DEPENDENT * float(np.linalg.norm(column)))


def _in_steps(entry: Entry, change: float, step_mm: float) -> float:
    step = STEP_RAD if entry.register == "turn" else step_mm
    return step * round(change / step)


def _effect(effects: Mapping[Entry, Array], totals: Entered) -> Array:
    return np.asarray(sum((value * effects[entry] for entry, value in totals.items()), np.zeros(1)))


def _judged(size: ObservedSize, deviation_mm: float, u_mm: float) -> Judgement:
    return judge(size.nominal_mm + deviation_mm, u_mm, None, size.lower_mm, size.upper_mm)
