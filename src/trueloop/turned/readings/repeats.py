"""Readings of one place that contradict each other: further apart than their stated uncertainty allows."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.special import chdtrc

from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.option import Limits, allowed_by
from trueloop.errors import Code, Place
from trueloop.geometry.profile import Profile
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.observed import arc_length_of, corrected, in_one_place, stated_u
from trueloop.turned.touches.touches import Gauging
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

IMPROBABLE: Final = 1e-4
"""Readings that are so far apart less often than this, by their own uncertainty, contradict each other."""


def check_repeats(
    profile: Profile, readings: Sequence[MatchedReading], gauging: Gauging, limits: Limits
) -> tuple[str, ...]:
    """Returns notes on readings of one place that contradict each other; ±U holds their spread.

    Raises CMP-SCATTER where they scatter by more than the limit besides, along the normal.
    """
    notes = []
    for group in in_one_place(corrected(readings)):
        actual = np.array([one.reading.actual for one in group])
        u = stated_u(group, gauging.readings_u_mm)
        spread = float(np.std(actual, ddof=1)) if len(group) > 1 else 0.0
        if not spread or chdtrc(len(group) - 1, (len(group) - 1) * (spread / u) ** 2) > IMPROBABLE:
            continue
        said, first = _words(group, actual, u), group[0]
        scatter_mm = spread * _along_normal(profile, first)
        if scatter_mm > limits.scatter_mm:
            raise Code.CMP_SCATTER.refusal(
                f"{said}: {scatter_mm * UM_PER_MM:.1f} µm along the normal (one standard deviation); the limit is "
                f"{limits.scatter_mm * UM_PER_MM:.1f} µm",
                hint="read that place again and leave the wrong value out, or give each place its own z_mm",
                override=allowed_by("scatter_mm"),
                place=Place(line=group[int(np.argmax(np.abs(actual - np.median(actual))))].reading.line),
                values={"scatter_um": scatter_mm * UM_PER_MM, "limit_um": limits.scatter_mm * UM_PER_MM},
            )
        notes.append(wording("{said}: their mean is taken, and their spread is part of each ±U.", said=said))
    return tuple(notes)


def _words(group: Sequence[MatchedReading], actual: Array, u: float) -> str:
    reading = group[0].reading
    size = f"{u * UM_PER_MM:.1f} µm" if reading.quantity.unit == "mm" else f"{u:.4f}°"
    unit = "mm" if reading.quantity.unit == "mm" else "°"
    return wording(
        "{n} readings of one place, {name}, from {least:.4f} to {most:.4f} {unit}, are further apart than their "
        "standard uncertainty of {u} allows",
        n=len(group),
        name=repr(reading.characteristic),
        least=float(actual.min()),
        most=float(actual.max()),
        unit=unit,
        u=size,
    )


def _along_normal(profile: Profile, reading: MatchedReading) -> float:
    """Returns the displacement of the surface per unit of a reading, mm; of an angle at the ends of its line."""
    feature, quantity = profile.features[reading.feature_index], reading.reading.quantity
    if quantity is Quantity.ANGLE:
        return math.radians(feature.length_mm / 2.0)
    if quantity is not Quantity.DIAMETER:
        return 1.0
    return abs(float(feature.outward_normal(arc_length_of(feature, reading.reading))[0])) / 2.0
