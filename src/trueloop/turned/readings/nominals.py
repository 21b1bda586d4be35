"""Nominal values that a file states, beside those of the profile, from which a correction counts."""

from collections.abc import Sequence
from typing import Final

from trueloop.domain.inspection import Reading
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.observed import corrected, nominal_of

ROUNDED: Final = {"mm": 0.001, "deg": 0.01}
"""Nominal values differ by no more where one of them was rounded."""
SHOWN: Final = 4


def other_nominals(profile: Profile, readings: Sequence[MatchedReading]) -> tuple[Finding, ...]:
    """Returns a warning where the file's nominal values differ from the profile's: its deviations are others."""
    found: list[tuple[Reading, float, float]] = []
    for one in corrected(readings):
        stated, expected = one.reading.nominal, _nominal(profile, one)
        if stated is None or expected is None:
            continue
        if abs(stated - expected) > 1.000001 * ROUNDED[one.reading.quantity.unit]:
            found.append((one.reading, stated, expected))
    if not found:
        return ()
    shown = ", ".join(
        f"{reading.characteristic!r} {stated:.4f} and {expected:.4f} {reading.quantity.unit}"
        for reading, stated, expected in found[:SHOWN]
    )
    more = f", and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    first, stated, expected = found[0]
    finding = Finding(
        Severity.WARNING,
        Code.MSR_NOMINAL,
        f"{len(found)} readings have another nominal value in the file than on the part's contour: {shown}{more}; a "
        "correction counts from the contour's",
        "where the file's is the size to aim at, as the middle of limits: state it in the features of [part]",
        Place(line=first.line),
        values={"feature": first.feature, "actual": stated, "nominal": expected},
    )
    return (finding,)


def _nominal(profile: Profile, reading: MatchedReading) -> float | None:
    """Returns the profile's; None where the reading has none there, which is refused when it is to be used."""
    try:
        return nominal_of(profile, reading)
    except TrueloopError:
        return None
