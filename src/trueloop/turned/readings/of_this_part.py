"""Implausible inspections: another part, another unit, limits that exclude, one name in two places.

Implausible readings: another part's, another unit, a radius for a diameter, two places of one name.

As of touches: what was given is compared with what one common blunder would have made of it.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch, Values, Vector
from trueloop.domain.option import Limits, allowed_by
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.estimate.catalogue import PRIORS
from trueloop.geometry.feature import Line, Point
from trueloop.geometry.profile import FACES_Z, Profile
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import Axis, MatchedReading, Matches
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import CREDIBLE_ERROR_MM
from trueloop.units import MM_PER_INCH, UM_PER_MM
from trueloop.wording import Um, wording

OF_PART: Final = 0.5
"""An inspection of which less is matched is of another part."""
EXPLAINED: Final = 0.5
"""A factor explains an inspection where it makes this share of what fits nothing fit something."""
FEW: Final = 200
"""The largest number of values that are tried with a factor."""
SAME: Final = 1e-6
BLUNDERS: Final[tuple[tuple[float, str], ...]] = (
    (MM_PER_INCH, "inches taken for millimetres?"),
    (1.0 / MM_PER_INCH, "millimetres taken for inches?"),
)

LARGEST: Final = 1.96
"""Standard deviations of a size's logarithm: a prior leaves 2.5 % of sizes above."""
UNUSUAL: Final = 1.5
"""Those by which errors of two places of one line are as far apart on 5 to 6 % of lines, by the priors."""
REPEATS_TO: Final = 4.0
"""Standard uncertainties of the difference of two readings, by which they may be further apart."""


def check_matches(
    profile: Profile, inspection: Inspection, matches: Matches, names: Mapping[str, str], axis: Axis | None
) -> tuple[Finding, ...]:
    """Returns findings on an inspection of a profile: errors where it must not be used, warnings else."""
    return (
        *_part(profile, inspection, matches, names, axis),
        *_limits(inspection.readings),
        *_two_places(inspection.readings),
    )


def _part(
    profile: Profile, inspection: Inspection, matches: Matches, names: Mapping[str, str], axis: Axis | None
) -> Iterator[Finding]:
    """MSR-SCALE where a factor explains why too little fits, else MSR-PART."""
    values = matches.count + len(matches.unmatched)
    if not matches.unmatched or matches.count >= OF_PART * values:
        return
    tried = replace(inspection, values=tuple(left.value for left in matches.unmatched[:FEW]))
    for factor, question in BLUNDERS:
        scaled = match_inspection(profile, _times(tried, factor), names, axis)
        fitting = scaled.count + sum(bool(left.candidates) for left in scaled.left)
        if fitting >= EXPLAINED * len(tried.values):
            yield Finding(
                Severity.ERROR,
                Code.MSR_SCALE,
                f"{fitting} of {len(tried.values)} values that fit nothing fit when multiplied by {factor:.5f}",
                f"{question} State the file's unit: --unit mm or --unit inch",
                values={"factor": factor, "fitting": fitting, "values": len(tried.values)},
            )
            return
    yield Finding(
        Severity.ERROR,
        Code.MSR_PART,
        f"{matches.count} of {values} values are of this part, by name or by size; the first that is not: "
        f"{matches.unmatched[0].reason}",
        "is it of another part, or in another frame? A mapping's [features] lists names that differ",
        values={"matched": matches.count, "values": values},
    )


def _times(inspection: Inspection, factor: float) -> Inspection:
    """Returns the inspection with all lengths multiplied."""

    def vector(at: Vector) -> Vector:
        return at[0] * factor, at[1] * factor, at[2] * factor

    def place(at: Point) -> Point:
        return at[0] * factor, at[1] * factor

    def value(reading: Reading | Touch | CmmPoint) -> Reading | Touch | CmmPoint:
        if isinstance(reading, CmmPoint):
            nominal = None if reading.nominal_mm is None else vector(reading.nominal_mm)
            return replace(reading, measured_mm=vector(reading.measured_mm), nominal_mm=nominal)
        if isinstance(reading, Touch):
            measured = None if reading.measured_mm is None else place(reading.measured_mm)
            return replace(reading, nominal_mm=place(reading.nominal_mm), measured_mm=measured)
        scale = 1.0 if reading.quantity is Quantity.ANGLE else factor
        size = None if reading.nominal is None else reading.nominal * scale
        at = tuple(each * factor for each in reading.place_mm)
        return replace(reading, actual=reading.actual * scale, nominal=size, place_mm=at)

    values: Values = tuple(value(one) for one in inspection.values)
    return replace(inspection, values=values, ball_radius_mm=inspection.ball_radius_mm * factor)


def _limits(readings: tuple[Reading, ...]) -> Iterator[Finding]:
    """Each characteristic once: the wrong way round is an error, the nominal value outside a warning (a fit may)."""
    for reading in {(one.characteristic, one.feature): one for one in reversed(readings)}.values():
        lower, upper, nominal = reading.lower_limit, reading.upper_limit, reading.nominal
        if lower is not None and upper is not None and lower > upper:
            why, severity = f"the lower limit {lower:.4f} is above the upper {upper:.4f}", Severity.ERROR
        elif nominal is not None and (_outside(nominal, lower, min) or _outside(nominal, upper, max)):
            low, high = ("none" if limit is None else f"{limit:.4f}" for limit in (lower, upper))
            why, severity = f"limits {low} and {high} exclude the nominal {nominal:.4f}", Severity.WARNING
        else:
            continue
        yield Finding(
            severity,
            Code.MSR_EXCLUDED,
            f"{reading.characteristic!r}: {why} {reading.quantity.unit}",
            "a fit such as f7 excludes its nominal size; else look at the limits' signs, and whether they are relative",
            Place(line=reading.line),
            values={"characteristic": reading.characteristic},
        )


def _outside(nominal: float, limit: float | None, end: Callable[[float, float], float]) -> bool:
    return limit is not None and abs(nominal - limit) > SAME and end(nominal, limit) == nominal


def _two_places(readings: tuple[Reading, ...]) -> Iterator[Finding]:
    first: dict[tuple[str, str, str], Reading] = {}
    said: set[str] = set()
    for reading in readings:
        one = first.setdefault((reading.characteristic, reading.feature, reading.axis), reading)
        both = [(one.nominal, reading.nominal), *zip(one.place_mm, reading.place_mm, strict=False)]
        apart = [(a, b) for a, b in both if a is not None and b is not None and abs(a - b) > SAME]
        if not apart or reading.characteristic in said:
            continue
        said.add(reading.characteristic)
        what = "nominal values" if apart[0] == (one.nominal, reading.nominal) else "places, at"
        yield Finding(
            Severity.WARNING,
            Code.MSR_PLACES,
            f"{reading.characteristic!r} has two {what} {apart[0][0]:.4f} and {apart[0][1]:.4f}",
            "name them differently in the file, or give each its feature",
            Place(line=reading.line),
            values={"characteristic": reading.characteristic},
        )


CREDIBLE_DEG: Final = 1.0
"""A cone that is this much off is another cone: 1.7 mm in 100 mm of length."""
SMALL: Final = 0.2
"""Of a small size, so large a share of it is not credible either."""
EXPLAINS: Final = 0.1
"""A blunder explains a reading where undoing it leaves less than this share of the deviation."""
ASKS: Final = {
    (Quantity.DIAMETER, 2.0): "a radius in a column of diameters?",
    (Quantity.DIAMETER, 0.5): "twice a diameter: was a diameter taken for a radius?",
    (Quantity.RADIUS, 0.5): "a diameter in a column of radii?",
    (Quantity.RADIUS, 2.0): "half a radius: was a radius taken for a diameter?",
    (Quantity.ANGLE, 0.5): "the included angle of a cone? An angle is counted between surface and axis",
    (Quantity.ANGLE, 2.0): "half of an angle? An angle is counted between surface and axis",
}


def check_places(readings: Sequence[MatchedReading]) -> None:
    """Refuses one characteristic at two places of one part: which of them is meant is not known."""
    first: dict[str, MatchedReading] = {}
    for reading in readings:
        other = first.setdefault(reading.reading.characteristic, reading)
        if _where(reading) != _where(other):
            raise Code.MSR_PLACES.refusal(
                f"{reading.reading.characteristic!r} was read in 2 places: at {_shown(other)}, then at "
                f"{_shown(reading)}",
                hint="give each place a characteristic of its own; readings at one place are kept as repeats",
                place=Place(line=reading.reading.line),
                values={"characteristic": reading.reading.characteristic},
            )


def check_sizes(readings: Sequence[MatchedReading], nominal: Sequence[float], allowance_mm: float) -> None:
    """Refuses readings too far from nominal, (n,), naming a blunder; what the cut should leave on may be on."""
    far = [
        k
        for k, reading in enumerate(readings)
        if not _credible(reading, reading.reading.actual, nominal[k], allowance_mm)
    ]
    if not far:
        return
    lengths = [k for k, reading in enumerate(readings) if reading.reading.quantity is not Quantity.ANGLE]
    for factor, question in (
        (MM_PER_INCH, "inches in a column named mm?"),
        (1 / MM_PER_INCH, "millimetres in a column named in?"),
    ):
        undone = [k for k in lengths if _explains(readings[k], nominal[k], factor)]
        if undone and len(undone) >= 0.9 * len(lengths):
            one, counts = readings[undone[0]], {"fitting": len(undone), "values": len(lengths)}
            raise _blunder(Code.MSR_SCALE, one, nominal[undone[0]], factor, question, counts)
    for k in far:
        for factor in (2.0, 0.5):
            question = ASKS.get((readings[k].reading.quantity, factor), "")
            if question and _explains(readings[k], nominal[k], factor):
                raise _blunder(Code.MSR_TWICE, readings[k], nominal[k], factor, question, {})
    raise _far_off(readings[far[0]], nominal[far[0]], len(far), len(readings))


def _credible(reading: MatchedReading, actual: float, nominal: float, allowance_mm: float = 0.0) -> bool:
    quantity = reading.reading.quantity
    limit = {Quantity.ANGLE: CREDIBLE_DEG, Quantity.DIAMETER: 2 * CREDIBLE_ERROR_MM}.get(quantity, CREDIBLE_ERROR_MM)
    return abs(actual - nominal) <= 2.0 * abs(allowance_mm) + min(limit, SMALL * nominal if nominal > 0.0 else limit)


def _explains(reading: MatchedReading, nominal: float, factor: float) -> bool:
    actual = reading.reading.actual
    left = abs(factor * actual - nominal)
    return _credible(reading, factor * actual, nominal) and left <= EXPLAINS * abs(actual - nominal)


def _blunder(
    code: Code, match: MatchedReading, nominal: float, factor: float, question: str, counts: Mapping[str, int]
) -> TrueloopError:
    reading = match.reading
    named: dict[str, float | str] = {"feature": reading.feature, "factor": factor, **counts}
    return code.refusal(
        f"{reading.characteristic!r} is {reading.actual:.6g} {reading.quantity.unit}, nominal {nominal:.6g}: "
        f"{factor:.4g} times the reading fits" + "".join(f", {name} {count}" for name, count in counts.items()),
        hint=f"{question} The column names quantity and unit: diameter_mm, radius_mm, diameter_in, angle_deg",
        place=Place(line=reading.line),
        values={name: named[name] for name in code.values},
    )


def _far_off(match: MatchedReading, nominal: float, far: int, count: int) -> TrueloopError:
    reading = match.reading
    return Code.MSR_NOMINAL.refusal(
        wording(
            "{characteristic!r} is {actual:.6g} {unit}, nominal {nominal:.6g}: no error of a cut is as large. "
            "{far} of {count} readings are as far off",
            characteristic=reading.characteristic,
            actual=reading.actual,
            unit=reading.quantity.unit,
            nominal=nominal,
            far=far,
            count=count,
        ),
        hint=wording("another part's readings, another feature, a length from another face, or an allowance left on?"),
        place=Place(line=reading.line),
        values={"feature": reading.feature, "actual": reading.actual, "nominal": nominal},
    )


def _where(reading: MatchedReading) -> tuple[object, ...]:
    return reading.feature_index, reading.other_index, reading.reading.quantity, reading.reading.place_mm


def _shown(reading: MatchedReading) -> str:
    place = ", ".join(f"{number:g}" for number in reading.reading.place_mm)
    return f"{reading.reading.feature} ({place} mm)" if place else reading.reading.feature


def check_neighbours(profile: Profile, vectors: ErrorVectors, readings: Sequence[Reading], limits: Limits) -> None:
    """Raises CMP-SCATTER where one reading of a line stands further apart from those beside it than the priors let
    its form and its taper be: a digit typed wrong would become a curve of the contour.

    `readings` are those that the errors are from. Several such readings in a row are a step, which no slip explains.
    """
    for pair in _slips(profile, vectors, limits, LARGEST):
        raise _stands_apart(vectors, pair, readings, limits)


def neighbour_words(
    profile: Profile, vectors: ErrorVectors, readings: Sequence[Reading], limits: Limits
) -> tuple[str, ...]:
    """Returns a note for each line of which a reading stands further apart than is usual: it may be typed wrong."""
    return tuple(
        wording(
            "{reading} stands {apart} µm along the normal from {beside}, on the same line: form and taper of one line "
            "in twenty are as large. It becomes a taper or a bow of the correction; read both again if a digit may be "
            "typed wrong.",
            reading=_said(vectors, slip, readings),
            beside=_said(vectors, beside, readings),
            apart=f"{abs(float(vectors.error_mm[slip] - vectors.error_mm[beside])) * UM_PER_MM:.1f}",
        )
        for slip, beside in _slips(profile, vectors, limits, UNUSUAL)
    )


def _slips(profile: Profile, vectors: ErrorVectors, limits: Limits, largest: float) -> Iterator[tuple[int, int]]:
    """Yields the reading of a line that alone stands apart, in `largest` standard deviations, and its neighbour."""
    for index in range(len(profile.features)):
        rows = vectors.of_feature(index)
        if not isinstance(profile.features[index], Line) or not (apart := _apart(vectors, rows, limits, largest)):
            continue
        alone = [k for k in rows if vectors.by_gauge[k] and not _apart(vectors, rows[rows != k], limits, largest)]
        if not alone:
            continue
        others = np.setdiff1d(np.flatnonzero(np.abs(vectors.outward_normal[:, 1]) < FACES_Z), alone)
        expected = float(np.median(vectors.error_mm[others if len(others) else alone]))
        slip = max(alone, key=lambda k: abs(float(vectors.error_mm[k]) - expected))
        yield slip, next(a + b - slip for a, b in apart if slip in (a, b))


def _apart(vectors: ErrorVectors, rows: NDArray[np.intp], limits: Limits, largest: float) -> list[tuple[int, int]]:
    """Returns neighbours among a feature's rows, one a reading, that are further apart than a line's errors."""
    pairs = zip(rows[:-1].tolist(), rows[1:].tolist(), strict=True)
    read = [(a, b) for a, b in pairs if vectors.by_gauge[a] or vectors.by_gauge[b]]
    return [(a, b) for a, b in read if _scatter_mm(vectors, a, b) > _form_mm(vectors, a, b, limits, largest)]


def _scatter_mm(vectors: ErrorVectors, a: int, b: int) -> float:
    return abs(float(vectors.error_mm[a] - vectors.error_mm[b])) / math.sqrt(2.0)


def _form_mm(vectors: ErrorVectors, a: int, b: int, limits: Limits, largest: float) -> float:
    """Returns the largest standard deviation of two errors of one line; what else is accepted has the limit's."""
    form, taper = (PRIORS[name].median * math.exp(largest * PRIORS[name].log_sd) for name in ("along", "taper"))
    over_mm = abs(float(vectors.arc_length_mm[a] - vectors.arc_length_mm[b]))
    u_mm = math.hypot(*vectors.standard_u_mm[[a, b]])
    return max(math.hypot(form, taper * over_mm, REPEATS_TO * u_mm) / math.sqrt(2.0), limits.scatter_mm)


def _stands_apart(
    vectors: ErrorVectors, pair: tuple[int, int], readings: Sequence[Reading], limits: Limits
) -> TrueloopError:
    said = [f"{_said(vectors, k, readings)}, an error of {vectors.error_mm[k] * UM_PER_MM:+.1f} µm" for k in pair]
    slip = next((reading for reading in readings if reading.characteristic == vectors.point[pair[0]]), None)
    own_file = bool(np.all(vectors.by_gauge))  # beside touches the file is theirs
    scatter_mm, form_mm = _scatter_mm(vectors, *pair), _form_mm(vectors, *pair, limits, LARGEST)
    return Code.CMP_SCATTER.refusal(
        wording(
            "{said}, stands apart from {other}, on the same line: they scatter by {scatter} along the normal (one "
            "standard deviation), and its form and taper make at most {form}",
            said=said[0],
            other=said[1],
            scatter=Um(scatter_mm),
            form=Um(form_mm),
        ),
        hint=wording("read both again: is a digit typed wrong?"),
        override=f"{allowed_by('scatter_mm')}, for a part that is tapered or bent so much",
        place=Place(line=slip.line if slip and own_file else None),
        values={"scatter_um": scatter_mm * UM_PER_MM, "limit_um": form_mm * UM_PER_MM},
    )


def _said(vectors: ErrorVectors, k: int, readings: Sequence[Reading]) -> str:
    """A reading by its name and value, a touch by its name."""
    value = next((f" {one.actual:.4f} mm" for one in readings if one.characteristic == vectors.point[k]), "")
    return f"{vectors.point[k]!r}{value}"
