"""Implausible readings: another part's, another unit, a radius for a diameter, two places of one name.

As of touches: what was given is compared with what one common blunder would have made of it.
"""

from collections.abc import Mapping, Sequence
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, Place, TrueloopError
from trueloop.turned.readings.matched import MatchedReading
from trueloop.turned.touches.plausibility import CREDIBLE_ERROR_MM
from trueloop.units import MM_PER_INCH

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
    for one in readings:
        other = first.setdefault(one.reading.characteristic, one)
        if _where(one) != _where(other):
            raise TrueloopError(
                Code.MSR_PLACES,
                f"{one.reading.characteristic!r} was read in 2 places: at {_shown(other)}, then at {_shown(one)}",
                hint="give each place a characteristic of its own; readings at one place are kept as repeats",
                place=Place(line=one.reading.line),
                values={"characteristic": one.reading.characteristic},
            )


def check_sizes(readings: Sequence[MatchedReading], nominal: Sequence[float], allowance_mm: float) -> None:
    """Refuses readings too far from the profile's nominal values, (n,), naming the blunder that would explain them.

    What the cut was to leave on may be on.
    """
    far = [k for k, one in enumerate(readings) if not _credible(one, one.reading.actual, nominal[k], allowance_mm)]
    if not far:
        return
    lengths = [k for k, one in enumerate(readings) if one.reading.quantity is not Quantity.ANGLE]
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


def _credible(one: MatchedReading, actual: float, nominal: float, allowance_mm: float = 0.0) -> bool:
    quantity = one.reading.quantity
    limit = {Quantity.ANGLE: CREDIBLE_DEG, Quantity.DIAMETER: 2 * CREDIBLE_ERROR_MM}.get(quantity, CREDIBLE_ERROR_MM)
    return abs(actual - nominal) <= 2.0 * abs(allowance_mm) + min(limit, SMALL * nominal if nominal > 0.0 else limit)


def _explains(one: MatchedReading, nominal: float, factor: float) -> bool:
    actual = one.reading.actual
    left = abs(factor * actual - nominal)
    return _credible(one, factor * actual, nominal) and left <= EXPLAINS * abs(actual - nominal)


def _blunder(
    code: Code, one: MatchedReading, nominal: float, factor: float, question: str, counts: Mapping[str, int]
) -> TrueloopError:
    reading = one.reading
    named: dict[str, float | str] = {"feature": reading.feature, "factor": factor, **counts}
    return TrueloopError(
        code,
        f"{reading.characteristic!r} is {reading.actual:.6g} {reading.quantity.unit}, nominal {nominal:.6g}: "
        f"{factor:.4g} times the reading fits" + "".join(f", {name} {count}" for name, count in counts.items()),
        hint=f"{question} The column names quantity and unit: diameter_mm, radius_mm, diameter_in, angle_deg",
        place=Place(line=reading.line),
        values={name: named[name] for name in code.values},
    )


def _far_off(one: MatchedReading, nominal: float, far: int, count: int) -> TrueloopError:
    reading = one.reading
    return TrueloopError(
        Code.MSR_NOMINAL,
        f"{reading.characteristic!r} is {reading.actual:.6g} {reading.quantity.unit}, nominal {nominal:.6g}: no error "
        f"of a cut is as large. {far} of {count} readings are as far off",
        hint="another part's readings, another feature, a length from another face, or an allowance left on?",
        place=Place(line=reading.line),
        values={"feature": reading.feature, "actual": reading.actual, "nominal": nominal},
    )


def _where(one: MatchedReading) -> tuple[object, ...]:
    return one.feature_index, one.other_index, one.reading.quantity, one.reading.place_mm


def _shown(one: MatchedReading) -> str:
    place = ", ".join(f"{number:g}" for number in one.reading.place_mm)
    return f"{one.reading.feature} ({place} mm)" if place else one.reading.feature
