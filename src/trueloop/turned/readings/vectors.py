"""Readings beside touches as error vectors: what the fit sees of them, and points to show and to decide by."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code
from trueloop.geometry.profile import FACES_Z, Profile
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.observed import CORRECTED, RepeatedReading, corrected, datum_of, repeated, seen_by
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.turned.touches.touches import SAME_POINT_MM, Gauging
from trueloop.wording import Um, all_of, wording


@dataclass(frozen=True)
class _Row:
    """An error at one place of the profile, from one reading or from the lengths between faces."""

    name: str
    feature_index: int
    arc_length_mm: float
    error_mm: float
    standard_u_mm: float


def with_readings(
    profile: Profile, readings: Sequence[MatchedReading], touches: ErrorVectors | None, gauging: Gauging
) -> tuple[ErrorVectors, tuple[str, ...]]:
    """Orders touches (None: there are none) and readings together along the profile, and returns notes in words.

    A reading where a touch was taken is seen by the fit and is not a point of its own. `gauging` says what the cut was
    to leave on, and the uncertainty of readings that state none. Raises MSR errors.
    """
    used = repeated(profile, corrected(readings), gauging)
    datum = (
        None if touches is not None and _knows_z(touches) else datum_of(profile, [reading.first for reading in used])
    )
    whole = tuple(seen_by(profile, reading, datum) for reading in used)
    seen = tuple(observation.less(np.full(len(observation.weight), gauging.allowance_mm)) for observation in whole)
    if datum is not None:
        name, middle = profile.names[datum], 0.5 * profile.features[datum].length_mm
        seen = (*seen, Seen.at(f"{name} (datum)", ((datum, middle, 1.0),), 0.0, 0.0))
    rows = [*_single(used, seen), *_faces(profile, used, seen, datum, touches)]
    joined = _joined(profile, rows, touches)
    return replace(joined, seen=seen), tuple(_notes(profile, readings, used, datum))


def require_places(readings: Sequence[MatchedReading], vectors: ErrorVectors) -> None:
    """Raises MSR-NONE where no error at a place follows: an angle turns about any, an arc's radius has any centre."""
    if len(vectors.point):
        return
    kinds = ", ".join(sorted({str(reading.reading.quantity) for reading in readings}))
    raise Code.MSR_NONE.refusal(
        wording("of {n} readings ({kinds}) none states where the part's surface is", n=len(readings), kinds=kinds),
        hint=wording("read at least one diameter or length of a feature besides"),
    )


def _knows_z(touches: ErrorVectors) -> bool:
    """Returns whether touches determine the zero of z: some are on faces."""
    return bool(np.any(np.abs(touches.outward_normal[:, 1]) > FACES_Z))


def z_zero(vectors: ErrorVectors) -> NDArray[np.intp]:
    """Returns the positions of places on the face from which z counts, a touch or the lengths' datum; or none."""
    datum = [name in vectors.gauged and name.endswith(f"({DATUM})") for name in vectors.point]
    return np.flatnonzero(vectors.at_reference | np.array(datum, dtype=np.bool_))


def _single(used: Sequence[RepeatedReading], readings: Sequence[Seen]) -> Iterator[_Row]:
    """Diameters and radii: one reading is the error at one place."""
    for reading, sees in zip(used, readings, strict=False):
        if reading.first.reading.quantity is not Quantity.LENGTH and len(sees.weight) == 1:
            yield _Row(
                sees.name, int(sees.feature_index[0]), float(sees.arc_length_mm[0]), sees.value_mm, sees.standard_u_mm
            )


def _faces(
    profile: Profile,
    used: Sequence[RepeatedReading],
    readings: Sequence[Seen],
    datum: int | None,
    touches: ErrorVectors | None,
) -> Iterator[_Row]:
    """Faces that lengths tie to the datum, a touched face, or the part's zero: errors by weighted least squares."""
    lengths = [
        s for reading, s in zip(used, readings, strict=False) if reading.first.reading.quantity is Quantity.LENGTH
    ]
    by_definition = () if datum is None or not lengths else readings[len(used) :]
    touched = () if touches is None else _touched_faces(replace(touches, seen=tuple(lengths)))
    of_touches = {index for observation in touched for index in observation.feature_index.tolist()}
    for (index, along_mm), (error_mm, u_mm) in determined((*by_definition, *touched, *lengths)).items():
        if index in of_touches:
            continue
        kind = DATUM if index == datum else "lengths"
        yield _Row(f"{profile.names[index]} ({kind})", index, along_mm, error_mm, u_mm)


def _joined(profile: Profile, rows: Sequence[_Row], touches: ErrorVectors | None) -> ErrorVectors:
    """Both in order along the profile; of points in one place the touch, else the first."""
    taken = [] if touches is None else list(zip(touches.feature_index.tolist(), touches.arc_length_mm, strict=True))
    kept: list[_Row] = []
    for row in rows:
        if not any(i == row.feature_index and abs(s - row.arc_length_mm) < SAME_POINT_MM for i, s in taken):
            taken.append((row.feature_index, row.arc_length_mm))
            kept.append(row)
    gauged = _vectors(profile, kept, () if touches is None else touches.point)
    if touches is None:
        both = gauged
    elif not kept:
        return touches
    else:
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(one, name) for one in (touches, gauged)]) for name in ARRAYS
        }
        both = replace(touches, point=(*touches.point, *gauged.point), gauged=gauged.gauged, **arrays)
    return both.chosen(np.lexsort((both.arc_length_mm, both.feature_index)))


DATUM: Final = "datum"
FEW_NOMINAL: Final = 3
"""So many readings are not exactly nominal by chance."""
NOMINAL_MM: Final = 1e-9

ARRAYS: Final = (
    "feature_index",
    "arc_length_mm",
    "error_mm",
    "standard_u_mm",
    "at_reference",
    "nominal_mm",
    "outward_normal",
)


def _vectors(profile: Profile, rows: Sequence[_Row], taken: Sequence[str]) -> ErrorVectors:
    """Returns the rows as points, by names that no touch has."""
    places = [(profile.features[row.feature_index], row.arc_length_mm) for row in rows]
    names = tuple(f"{row.name} (gauge)" if row.name in taken else row.name for row in rows)
    return ErrorVectors(
        point=names,
        feature_index=np.array([row.feature_index for row in rows], dtype=np.intp),
        arc_length_mm=np.array([row.arc_length_mm for row in rows]),
        error_mm=np.array([row.error_mm for row in rows]),
        standard_u_mm=np.array([row.standard_u_mm for row in rows]),
        at_reference=np.zeros(len(rows), dtype=np.bool_),
        nominal_mm=np.array([feature.point_mm(s) for feature, s in places]).reshape(-1, 2),
        outward_normal=np.array([feature.outward_normal(s) for feature, s in places]).reshape(-1, 2),
        gauged=names,
    )


def _notes(
    profile: Profile, readings: Sequence[MatchedReading], used: Sequence[RepeatedReading], datum: int | None
) -> Iterator[str]:
    kept = [reading for reading in readings if reading.reading.quantity not in CORRECTED]
    if kept:
        kinds = sorted({str(reading.reading.quantity) for reading in kept})
        yield wording(
            "{n} readings ({kinds}) are kept: no error of the profile follows from them.",
            n=len(kept),
            kinds=", ".join(kinds),
        )
    if datum is not None:
        yield wording(
            "Lengths say nothing of where z is counted from: {face} is the datum, its error is zero by definition.",
            face=profile.names[datum],
        )
    if (most := max((reading.count for reading in used), default=1)) > 1:
        yield wording(
            "Up to {n} readings of one place: their spread is the gauge's repeatability, part of each ±U.", n=most
        )


def nominal_words(vectors: ErrorVectors) -> tuple[str, ...]:
    """Returns a remark where all readings or touches are exactly nominal: a sheet filled in, not measured."""
    read = [observation.value_mm for observation in vectors.seen if observation.standard_u_mm > 0.0]
    touched = vectors.error_mm[~vectors.by_gauge & ~vectors.at_reference].tolist()
    words = []
    if _all_nominal(read):
        words.append(wording("All {n} readings are exactly nominal: were they measured, or filled in?", n=len(read)))
    if _all_nominal(touched):
        words.append(
            wording("All {n} touches have an error of exactly 0: were they measured, or filled in?", n=len(touched))
        )
    return tuple(words)


def _all_nominal(deviations_mm: Sequence[float]) -> bool:
    return len(deviations_mm) >= FEW_NOMINAL and all(abs(value) <= NOMINAL_MM for value in deviations_mm)


def assumed_words(readings: Sequence[MatchedReading], assumed_u_mm: float) -> tuple[str, ...]:
    """Describes the uncertainty assumed of readings that state none."""
    count = sum(reading.reading.standard_u is None for reading in corrected(readings))
    if not count:
        return ()
    return (
        wording(
            "{n} readings state no uncertainty: a standard uncertainty of {u} is assumed, `gauging.readings_u_um` sets "
            "it.",
            n=count,
            u=Um(assumed_u_mm, "g"),
        ),
    )


STEEL_PER_K: Final = 11.5e-6
"""Thermal expansion of unalloyed steel near 20 °C, 1/K; that of aluminium is about 23e-6."""
NEAR_K: Final = 1.0
"""Readings this near to 20 °C are taken to be at it."""


def warm_words(readings: Sequence[MatchedReading]) -> tuple[str, ...]:
    """Describes what the stated temperature of a part makes of its sizes: nothing here takes that out."""

    def off_k(reading: MatchedReading) -> float:
        return 0.0 if reading.reading.temperature_c is None else reading.reading.temperature_c - 20.0

    def grown_mm(reading: MatchedReading) -> float:
        return STEEL_PER_K * off_k(reading) * reading.reading.actual

    warm = [one for one in corrected(readings) if abs(off_k(one)) > NEAR_K and one.reading.quantity.unit == "mm"]
    if not warm:
        return ()
    most = max(warm, key=lambda one: abs(grown_mm(one)))
    return (
        wording(
            "{n} readings were taken at up to {c:.1f} °C: {name} of a steel part changes by {grown} from 20 °C "
            "(11.5 µm/m/K; aluminium twice that). It is neither taken out nor part of ±U: enter sizes at 20 °C",
            n=len(warm),
            c=most.reading.temperature_c,
            name=most.reading.characteristic,
            grown=Um(grown_mm(most), "+.1f"),
        ),
    )


SOLVED: Final = 1.0 - 1e-6
"""A place that readings determine: less is one whose error another one's may take."""
Place = tuple[int, float]
"""Feature and arc length, mm."""


def determined(readings: Sequence[Seen]) -> dict[Place, tuple[float, float]]:
    """Returns the errors at places that readings determine, (error, u) in mm, by weighted least squares."""
    exact = {
        _places(reading)[0]: reading.value_mm / float(reading.weight[0])
        for reading in readings
        if reading.standard_u_mm == 0.0
    }
    rows = [reading for reading in readings if reading.standard_u_mm > 0.0]
    free = sorted({place for observation in rows for place in _places(observation)} - exact.keys())
    terms, values = np.zeros((len(rows), len(free))), np.zeros(len(rows))
    for row, observation in enumerate(rows):
        values[row] = observation.value_mm / observation.standard_u_mm
        for place, weight in zip(
            _places(observation), (observation.weight / observation.standard_u_mm).tolist(), strict=True
        ):
            if place in exact:
                values[row] -= weight * exact[place]
            else:
                terms[row, free.index(place)] += weight
    inverse = np.linalg.pinv(terms, rcond=1e-9)
    error, solved, u = inverse @ values, np.diag(inverse @ terms), np.linalg.norm(inverse, axis=1)
    by_rows = {p: (float(error[k]), float(u[k])) for k, p in enumerate(free) if solved[k] >= SOLVED}
    return {place: (error_mm, 0.0) for place, error_mm in exact.items()} | by_rows


def _touched_faces(vectors: ErrorVectors) -> tuple[Seen, ...]:
    """Returns the errors of touched faces at the places from which lengths count."""
    lengths = [observation for observation in vectors.seen if len({*observation.feature_index.tolist()}) > 1]
    touched = np.flatnonzero(~vectors.by_gauge)
    rows = {
        place: touched[vectors.feature_index[touched] == place[0]]
        for place in dict.fromkeys(place for length in lengths for place in _places(length))
    }
    return tuple(
        Seen.at("", ((*place, 1.0),), float(np.median(vectors.error_mm[of])), float(np.mean(vectors.standard_u_mm[of])))
        for place, of in rows.items()
        if len(of)
    )


def own_seen(vectors: ErrorVectors, own: Collection[int]) -> tuple[Seen, ...]:
    """Returns what readings state of the features `own` alone: those that see no others, and shared ones in which
    touches or the remaining readings determine the errors of all others: these are taken out, their variance is added.
    """
    return tuple(alone for observation in vectors.seen if (alone := _own_part(observation, vectors, own)) is not None)


def _own_part(reading: Seen, vectors: ErrorVectors, own: Collection[int]) -> Seen | None:
    """Returns what a reading states of the features `own` alone; None: nothing, or errors of others stay in it."""
    mine = np.isin(reading.feature_index, list(own))
    if mine.all() or not mine.any():
        return reading if mine.all() else None
    others = [k for k, is_mine in enumerate(mine.tolist()) if not is_mine]
    beside = [other for other in vectors.seen if other is not reading]
    known, places = determined([*_touched_faces(vectors), *beside]), _places(reading)
    if any(places[k] not in known for k in others):
        return None
    weights = reading.weight[others]
    errors_mm, u_mm = np.array([known[places[k]] for k in others]).T
    return replace(
        reading,
        feature_index=reading.feature_index[mine],
        arc_length_mm=reading.arc_length_mm[mine],
        weight=reading.weight[mine],
        value_mm=reading.value_mm - float(weights @ errors_mm),
        standard_u_mm=float(np.linalg.norm([reading.standard_u_mm, *(weights * u_mm)])),
    )


def _places(reading: Seen) -> list[Place]:
    return list(zip(reading.feature_index.tolist(), reading.arc_length_mm.tolist(), strict=True))


def shared_words(vectors: ErrorVectors, owns: Sequence[Collection[int]], names: Sequence[str]) -> list[str]:
    """Words what readings of several owners' features correct; `owns`: features of each, `names`: of all."""
    found: list[str] = []
    unused: list[str] = []
    for observation in vectors.seen:
        of = {*observation.feature_index.tolist()}
        if any(of <= {*own} for own in owns):
            continue
        corrected = [of & {*own} for own in owns if _own_part(observation, vectors, own) is not None]
        found.extend(
            wording(
                "{name}: taken as the error of {feature}, counted from {other}.",
                name=observation.name,
                feature=all_of([names[index] for index in sorted(mine)]),
                other=all_of([names[index] for index in sorted(of - mine)]),
            )
            for mine in corrected
        )
        unused.extend([] if corrected else [observation.name])
    if unused:
        found.append(
            wording(
                "{names}: between features that are not cut together, and corrects none of them: no other reading or "
                "touch states where one of them is.",
                names=all_of(unused),
            )
        )
    return found
