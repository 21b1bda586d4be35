"""Finished parts that were measured one after the other: the next is corrected by all of them.

The record of a correction by a finished part holds the errors that this part and those before it would have had, had
nothing been corrected. The next part names that correction as the one in force, by its file or by the store, and so
goes on with the series, whichever way the correction was carried out.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.life import Ran
from trueloop.domain.record import GIVEN, Record
from trueloop.domain.tool import Edge
from trueloop.errors import Code
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.correction import Correction, FromMemory, Inputs, edge_words
from trueloop.loops.turned.deviations import places_along
from trueloop.loops.turned.made_parts import name_of
from trueloop.turned.compensation.shift import Shift
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.fit.chain_fit import chains_of
from trueloop.turned.fit.prior.part_state import STRETCHES, SeriesState, series_state
from trueloop.turned.fit.prior.remembered_fit import Remembered
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.wording import Um, wording

KEY: Final = "finished_parts"
"""The key of a record's `model` under which the parts are."""

FEWEST: Final = 3
"""The least number of parts: one difference of two parts does not show how much of it the next part has again."""

USED: Final = ("on", "bands")
"""Values of `memory.use` with which the parts of a series take part."""

IMPROBABLE: Final = 4.0
"""Standard deviations of the displacement of one cut against the next beyond which an offset is asked about."""

SHOWN: Final = 0.1
"""The least share of an offset along an axis that measured surfaces show; one that they show less does not count."""

KEPT: Final = 12
"""The largest number of parts kept: those of long ago tell little of the next."""


def next_finished(
    inputs: Inputs, matched: Commanded, own: ProfileErrorModel
) -> "tuple[Remembered | None, FromMemory | None, tuple[ErrorVectors, ...]]":
    """Returns what finished parts tell of the next one, its record, and the parts to be kept, this one as the last.

    `own` is the fit to this part's measurements alone, by which the first two parts of a series are corrected.
    """
    series = finished_series(inputs, matched, own)
    known, parts, arrived = series.known, series.parts, _arrived(inputs, matched, own)
    if known is None:
        notes = [words for words in (series.why, arrived) if words]
        return None, _noted(inputs, *notes) if notes else None, parts
    index, along, _ = places_along(inputs.profile, _measured(inputs.profile, parts[-1]), parts[-1])
    found, corrects = known.next_part(index, along), inputs.memory.memory == "on"
    rate, u = known.wear_rate_mm
    words = wording(
        "By {n} finished parts of this series, which grow by {rate} ± {u} a part.",
        n=known.parts,
        rate=Um(rate, "+.2f"),
        u=Um(2.0 * u, ".2f"),
    )
    left_mm = found.mean_mm + _Moved.of(inputs, matched, own.vectors).at(index, along)
    table = Remembered(index, along, left_mm, found.covariance_mm2, left_mm, corrects=corrects)
    return table, _noted(inputs, words, *([arrived] if arrived else [])), parts


@dataclass(frozen=True, eq=False)
class FinishedSeries:
    """The finished `parts` of a series, the latest as the last, as they would be uncorrected.

    `known` is the state after them by which the next part is corrected; None where the latest alone corrects it, with
    `why` in words, if that needs any.
    """

    known: SeriesState | None
    parts: tuple[ErrorVectors, ...]
    why: str = ""


def finished_series(inputs: Inputs, matched: Commanded, own: ProfileErrorModel) -> FinishedSeries:
    """Returns the series of which the finished part of these inputs is the latest; `own` is the fit to it alone."""
    (earlier, new_series), vectors = _earlier(inputs), own.vectors
    today = _Moved.of(inputs, matched, vectors).taken_out(_used(own))
    parts = (*earlier, today)[-KEPT:]
    if len(parts) < FEWEST:
        return FinishedSeries(None, parts, new_series)
    if inputs.memory.memory not in USED:
        unused = wording(
            "The {n} finished parts before this one are kept, and not used: `memory.use` is {use}.",
            n=len(parts) - 1,
            use=inputs.memory.memory,
        )
        return FinishedSeries(None, parts, unused)
    known = series_state(inputs.profile, parts)
    if known is None:
        why = wording(
            "This finished part contradicts the {n} before it: the correction is by this part alone. Look what "
            "happened: was the tool set, an insert changed, or an offset entered twice?",
            n=len(earlier),
        )
        return FinishedSeries(None, (today,), why)
    return FinishedSeries(known, parts)


def recorded_series(correction: Correction) -> SeriesState | None:
    """Returns the finished parts' state of a kept correction; None: by its part alone. Raises REC-KEY."""
    memory, record = correction.memory, correction.record
    if memory is None or memory.use not in USED or KEY not in record.model:
        return None
    parts = [one for one in _recorded(record, correction.profile) if one is not None]
    return series_state(correction.profile, parts) if len(parts) >= FEWEST else None


def finished_parts(parts: Sequence[ErrorVectors], profile: Profile) -> dict[str, object]:
    """Returns finished parts as a record's `model` holds them, lengths in mm, in the order in which they were cut."""
    return {KEY: [_as_dict(part, profile) for part in parts]} if parts else {}


@dataclass(frozen=True)
class _Moved:
    """The correction in force: by how much it moved the surface outwards, mm.

    `offset_mm` (x as a radius, z) is that of the tool, `contour` by feature that of the program. Where a place of the
    part is at z = 0 by definition, `zero` (feature, arc length), errors and what moved them count from there.
    """

    profile: Profile
    offset_mm: tuple[float, float]
    contour: Sequence[Shift]
    zero: tuple[int, float] | None

    @classmethod
    def of(cls, inputs: Inputs, matched: Commanded, vectors: ErrorVectors) -> "_Moved":
        zero = None
        for k in np.flatnonzero(vectors.at_reference):
            zero = int(vectors.feature_index[k]), float(vectors.arc_length_mm[k])
        for observation in vectors.seen:
            if observation.standard_u_mm == 0.0 and len(observation.weight) == 1:
                zero = int(observation.feature_index[0]), float(observation.arc_length_mm[0])
        return cls(inputs.profile, inputs.in_force.cut_with.offset_mm, matched.in_force, zero)

    def at(self, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Array:
        """Returns it at places, (n,)."""
        off_mm, along_z = self._along(feature_index, arc_length_mm)
        if self.zero is None:
            return off_mm
        own_mm, own_z = self._along(np.array([self.zero[0]]), np.array([self.zero[1]]))
        return np.asarray(off_mm - along_z / own_z * own_mm)

    def taken_out(self, vectors: ErrorVectors) -> ErrorVectors:
        """Returns the errors had nothing been corrected."""
        return replace(
            vectors,
            error_mm=vectors.error_mm - self.at(vectors.feature_index, vectors.arc_length_mm),
            seen=tuple(
                observation.less(self.at(observation.feature_index, observation.arc_length_mm))
                for observation in vectors.seen
            ),
        )

    def _along(self, feature_index: NDArray[np.intp], arc_length_mm: Array) -> tuple[Array, Array]:
        places = list(zip(feature_index.tolist(), arc_length_mm.tolist(), strict=True))
        normal = np.array([self.profile.features[i].outward_normal(s) for i, s in places]).reshape(-1, 2)
        within = [float(self.contour[i].value_mm(s)) for i, s in places] if self.contour else [0.0] * len(places)
        return normal @ np.array(self.offset_mm) + np.array(within), normal[:, 1]


def _measured(profile: Profile, part: ErrorVectors) -> list[int]:
    """Returns the features of chains of which something was measured: others are estimated from these."""
    measured = {
        *part.feature_index.tolist(),
        *(i for observation in part.seen for i in observation.feature_index.tolist()),
    }
    return [i for chain in chains_of(profile) if measured.intersection(chain.features) for i in chain.features]


def _noted(inputs: Inputs, *notes: str) -> FromMemory:
    return FromMemory(edge_words(inputs.edge), inputs.memory.memory, applied=False, notes=notes)


def _arrived(inputs: Inputs, matched: Commanded, own: ProfileErrorModel) -> str:
    """Describes how much of the offset that is stated to be in force since the part before this one shows on it, where
    that is not all of it; "": it may be, a contour changed besides, or no part before it is known.
    """
    force, (earlier, _) = inputs.in_force, _earlier(inputs)
    then = GIVEN if force.record is None else force.record.cut_with or GIVEN
    if not earlier or force.program is not None or then.ran is Ran.CORRECTED:
        return ""
    in_force = _Moved.of(inputs, matched, own.vectors)
    today, before = in_force.taken_out(_used(own)), earlier[-1]
    features = sorted({*today.feature_index.tolist()} & {*before.feature_index.tolist()})
    off_mm, units = [], []
    for index in features:
        now, was = today.of_feature(index), before.of_feature(index)
        off_mm.append(np.mean(today.error_mm[now]) - np.mean(before.error_mm[was]))
        at = today.feature_index[now], today.arc_length_mm[now]
        units.append([np.mean(replace(in_force, offset_mm=unit).at(*at)) for unit in ((1.0, 0.0), (0.0, 1.0))])
    by_unit = np.array(units).reshape(-1, 2)
    axes = np.linalg.pinv(by_unit, rcond=SHOWN)
    added = np.array(force.cut_with.offset_mm) - np.array(then.offset_mm)
    shown = axes @ by_unit @ added
    size_mm, cuts = float(np.linalg.norm(shown)), inputs.options.between_cuts
    u_mm = np.hypot(cuts.common_difference_mm, cuts.scatter_difference_mm / np.sqrt(max(len(features), 1)))
    missing_mm = 0.0 if size_mm == 0.0 else float(axes @ np.array(off_mm) @ shown) / size_mm
    if abs(missing_mm) < IMPROBABLE * u_mm:
        return ""
    return wording(
        "Of the tool offset X {x} (radius), Z {z} that is stated to be in force since the part before this one, "
        "{share:.0f} % ± {u:.0f} % shows on it: was it entered, once, for this tool, with its sign?",
        x=Um(added[0]),
        z=Um(added[1]),
        share=100.0 * (1.0 + missing_mm / size_mm),
        u=200.0 * float(u_mm) / size_mm,
    )


def _earlier(inputs: Inputs) -> tuple[tuple[ErrorVectors, ...], str]:
    """Returns the finished parts behind the correction in force; or none, and in words why this part begins a new
    series: another edge or setting of it, part type, machine or drawing.

    Raises REC-KEY for parts that are not as a record holds them.
    """
    record = inputs.in_force.record
    if record is None or KEY not in record.model:
        return (), ""
    for before, now in _conditions(record, inputs):
        if before != now:
            return (), wording(
                "The finished parts before this one are of {before}, it is of {now}: it begins a new series.",
                before=before,
                now=now,
            )
    found = _recorded(record, inputs.profile)
    parts = tuple(one for one in found if one is not None)
    if len(parts) == len(found):
        return parts, ""
    return (), wording(
        "Finished parts before this one have features that its drawing does not have: it begins a new series."
    )


def _recorded(record: Record, profile: Profile) -> list[ErrorVectors | None]:
    """Returns the finished parts of a record; None for one with a feature that the profile does not have."""
    kept: Any = record.model[KEY]
    try:
        return [_part(one, profile) for one in kept]
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise Code.REC_KEY.refusal(
            f"'model.{KEY}' of correction {record.id} is not as trueloop wrote it: {type(error).__name__}: {error}",
            hint="restore its record as trueloop wrote it",
        ) from error


def _conditions(record: Record, inputs: Inputs) -> Iterator[tuple[str, str]]:
    """Yields in words, of the parts before and of this one, what parts of one series have in common."""
    if record.part_type is not None:
        yield name_of(record.part_type), name_of(inputs.part)
    machine = inputs.machine_tool if inputs.machine is None else inputs.machine.machine
    if record.machine is not None and machine is not None:
        yield " ".join(record.machine.identity).strip(), " ".join(machine.identity).strip()
    yield _set_words(record.edge, record.edge_set_at), _set_words(inputs.edge, inputs.edge_set_at)


def _set_words(edge: Edge | None, set_at: datetime | None) -> str:
    """Names an edge and, where it is stated, when it was set."""
    if edge is None:
        return wording("an edge that is not stated")
    words = edge_words(edge)
    return words if set_at is None else wording("{edge}, set at {when}", edge=words, when=set_at.isoformat())


def _used(model: ProfileErrorModel) -> ErrorVectors:
    """Returns the process errors that the fit uses, those of a feature with many touches averaged over stretches.

    An average has a smaller own uncertainty than its touches; that of the z reference they have in common stays.
    """
    vectors, features, own_u_mm = model.vectors, model.profile.features, model.vectors.own_u_mm
    used = (model.weight > 0.0) | vectors.at_reference
    left_out = {point for point, kept in zip(vectors.point, used.tolist(), strict=True) if not kept}
    groups: list[NDArray[np.intp]] = [np.array([k]) for k in np.flatnonzero(vectors.at_reference)]
    for index in np.unique(vectors.feature_index):
        rows = vectors.of_feature(int(index))
        rows = rows[used[rows] & ~vectors.at_reference[rows]]
        groups += [one for one in np.array_split(rows, min(len(rows), STRETCHES) or 1) if len(one)]
    first = vectors.chosen([int(rows[0]) for rows in groups])
    along_mm = np.array([float(np.mean(vectors.arc_length_mm[rows])) for rows in groups])
    places = [(features[i], s) for i, s in zip(first.feature_index.tolist(), along_mm.tolist(), strict=True)]
    averaged = replace(
        first,
        arc_length_mm=along_mm,
        error_mm=np.array([float(np.mean(vectors.error_mm[rows])) for rows in groups]),
        nominal_mm=np.array([feature.point_mm(s) for feature, s in places]).reshape(-1, 2),
        outward_normal=np.array([feature.outward_normal(s) for feature, s in places]).reshape(-1, 2),
        seen=tuple(observation for observation in vectors.seen if observation.name not in left_out),
    )
    own_mm = np.array([float(np.sqrt(np.sum(own_u_mm[rows] ** 2))) / len(rows) for rows in groups])
    at_zero_mm = float(np.max(vectors.standard_u_mm[vectors.at_reference][:1], initial=0.0))
    return replace(averaged, standard_u_mm=np.hypot(own_mm, averaged.z_share * at_zero_mm))


def _as_dict(part: ErrorVectors, profile: Profile) -> dict[str, object]:
    names = profile.names
    columns = zip(
        part.point,
        part.feature_index,
        part.arc_length_mm,
        part.error_mm,
        part.standard_u_mm,
        part.by_gauge,
        strict=True,
    )
    return {
        "points": [
            {
                "point": point,
                "feature": names[index],
                "along_mm": float(s),
                "error_mm": float(error),
                "standard_u_mm": float(u),
                "gauge": bool(gauge),
            }
            for point, index, s, error, u, gauge in columns
        ],
        "reference": [point for point, at in zip(part.point, part.at_reference, strict=True) if at],
        "readings": [
            {
                "name": observation.name,
                "features": [names[i] for i in observation.feature_index],
                "along_mm": observation.arc_length_mm.tolist(),
                "weight": observation.weight.tolist(),
                "value_mm": observation.value_mm,
                "standard_u_mm": observation.standard_u_mm,
            }
            for observation in part.seen
        ],
    }


def _part(kept: Mapping[str, Any], profile: Profile) -> ErrorVectors | None:
    """Returns one part as a record holds it; None where it has a feature that the profile does not have."""
    index = {name: k for k, name in enumerate(profile.names)}
    points, readings = kept["points"], kept["readings"]
    names = {point["feature"] for point in points}.union(*(reading["features"] for reading in readings))
    if not names <= index.keys():
        return None
    at = np.array([index[point["feature"]] for point in points], dtype=np.intp)
    s, error_mm, u_mm = (
        _numbers([point[key] for point in points]) for key in ("along_mm", "error_mm", "standard_u_mm")
    )
    places = [(profile.features[i], float(x)) for i, x in zip(at, s, strict=True)]
    return ErrorVectors(
        point=tuple(point["point"] for point in points),
        feature_index=at,
        arc_length_mm=s,
        error_mm=error_mm,
        standard_u_mm=u_mm,
        at_reference=np.array([point["point"] in kept["reference"] for point in points], dtype=np.bool_),
        nominal_mm=np.array([feature.point_mm(x) for feature, x in places]).reshape(-1, 2),
        outward_normal=np.array([feature.outward_normal(x) for feature, x in places]).reshape(-1, 2),
        gauged=tuple(point["point"] for point in points if point["gauge"]),
        seen=tuple(
            Seen(
                reading["name"],
                np.array([index[name] for name in reading["features"]], dtype=np.intp),
                _numbers(reading["along_mm"]),
                _numbers(reading["weight"]),
                *_numbers([reading["value_mm"], reading["standard_u_mm"]]).tolist(),
            )
            for reading in readings
        ),
    )


def _numbers(kept: Sequence[object]) -> NDArray[np.float64]:
    """Returns numbers of a record, (n,). Raises ValueError where any is not finite."""
    numbers = np.array(kept, dtype=np.float64)
    if not np.all(np.isfinite(numbers)):
        raise ValueError(f"{list(kept)!r:.60} are not all finite")
    return numbers
