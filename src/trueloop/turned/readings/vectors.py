"""Readings beside touches as error vectors: what the fit sees of them, and points to show and to decide by."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.turned.readings.matched import MatchedReading
from trueloop.turned.readings.nominal import FACES_Z
from trueloop.turned.readings.observed import Repeated, corrected, datum_of, repeated, seen_by
from trueloop.turned.readings.shared import determined
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.plausibility import SAME_POINT_MM
from trueloop.turned.touches.seen import Seen
from trueloop.turned.touches.touches import Gauging
from trueloop.units import UM_PER_MM
from trueloop.wording import wording


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

    A reading where a touch was taken is seen by the fit and is no point of its own. `gauging` says what the cut was to
    leave on, and the uncertainty of readings that state none. Raises MSR errors; MSR-NONE where no error of the profile
    follows.
    """
    used = repeated(profile, corrected(readings), gauging)
    if not used:
        kinds = ", ".join(sorted({str(one.reading.quantity) for one in readings})) or "none at all"
        raise TrueloopError(
            Code.MSR_NONE,
            f"of {len(readings)} readings ({kinds}) none says where the part's surface is",
            hint="read at least one diameter, radius or length of a feature of the part",
        )
    datum = None if touches is not None and _knows_z(touches) else datum_of(profile, [one.first for one in used])
    whole = tuple(seen_by(profile, one, datum) for one in used)
    seen = tuple(one.less(np.full(len(one.weight), gauging.allowance_mm)) for one in whole)
    if datum is not None:
        name, middle = profile.names[datum], 0.5 * profile.features[datum].length_mm
        seen = (*seen, Seen.at(f"{name} (datum)", ((datum, middle, 1.0),), 0.0, 0.0))
    rows = [*_single(used, seen), *_faces(profile, used, seen, datum)]
    joined = _joined(profile, rows, touches)
    return replace(joined, seen=seen), tuple(_notes(profile, readings, used, datum))


def _knows_z(touches: ErrorVectors) -> bool:
    """Returns whether touches determine the zero of z: some are on faces."""
    return bool(np.any(np.abs(touches.outward_normal[:, 1]) > FACES_Z))


def _single(used: Sequence[Repeated], seen: Sequence[Seen]) -> Iterator[_Row]:
    """Diameters and radii: one reading is the error at one place."""
    for one, sees in zip(used, seen, strict=False):
        if one.first.reading.quantity is not Quantity.LENGTH and len(sees.weight) == 1:
            yield _Row(
                sees.name, int(sees.feature_index[0]), float(sees.arc_length_mm[0]), sees.value_mm, sees.standard_u_mm
            )


def _faces(profile: Profile, used: Sequence[Repeated], seen: Sequence[Seen], datum: int | None) -> Iterator[_Row]:
    """Faces that lengths tie to the datum, or to the part's zero: their errors by weighted least squares."""
    lengths = [s for one, s in zip(used, seen, strict=False) if one.first.reading.quantity is Quantity.LENGTH]
    by_definition = () if datum is None or not lengths else seen[len(used) :]
    for (index, along_mm), (error_mm, u_mm) in determined((*by_definition, *lengths)).items():
        kind = "datum" if index == datum else "lengths"
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
    profile: Profile, readings: Sequence[MatchedReading], used: Sequence[Repeated], datum: int | None
) -> Iterator[str]:
    kept = len(readings) - len(corrected(readings))
    if kept:
        kinds = sorted({str(one.reading.quantity) for one in set(readings) - set(corrected(readings))})
        yield f"{kept} readings ({', '.join(kinds)}) are kept: no error of the profile follows from them."
    if datum is not None:
        yield (
            f"Lengths say nothing of where z is counted from: {profile.names[datum]} is the datum, its error is zero "
            "by definition."
        )
    if any(one.count > 1 for one in used):
        spread = max(one.count for one in used)
        yield f"Up to {spread} readings of one place: their spread is the gauge's repeatability, part of each ±U."


def nominal_words(vectors: ErrorVectors) -> tuple[str, ...]:
    """Returns a remark where every reading is exactly nominal: gauges do not measure so, a sheet that is filled in
    does.
    """
    read = [one.value_mm for one in vectors.seen if one.standard_u_mm > 0.0]
    if len(read) < FEW_NOMINAL or any(abs(value) > NOMINAL_MM for value in read):
        return ()
    return (wording("All {n} readings are exactly nominal: were they measured, or filled in?", n=len(read)),)


def assumed_words(readings: Sequence[MatchedReading], assumed_u_mm: float) -> tuple[str, ...]:
    """Describes the uncertainty assumed of readings that state none."""
    count = sum(one.reading.standard_u is None for one in corrected(readings))
    if not count:
        return ()
    return (
        f"{count} readings state no uncertainty: a standard uncertainty of {assumed_u_mm * UM_PER_MM:g} µm is "
        "assumed, `gauging.readings_u_um` sets it.",
    )
