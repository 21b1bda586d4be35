"""How often clean touches are suspected, and what a bad touch does to the curves: simulated parts of known error.

    python -m studies.bad_touch_study 700     # parts of each family without a bad touch, then with one and two

The errors of a part are those of a nose (three shapes of its error over contact angle), a taper of each straight
feature (standard deviation 5 µm from end to end) and a normal scatter of 1.2 µm.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Arc, contact_angle_rad
from trueloop.geometry.profile import Profile
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.options import BadTouches, FitOptions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM

SCATTER_MM = 0.0012
TAPER_MM = 0.005
KEEP = FitOptions(bad_touches=BadTouches.KEEP)


@dataclass(frozen=True)
class Family:
    """A profile and how many touches each feature has."""

    profile: Profile
    counts: tuple[int, ...]


@dataclass(frozen=True)
class DrawnPart:
    """One part's touches as measured, and their true errors, (n,)."""

    touches: ErrorVectors
    true_mm: Array


def families() -> Mapping[str, Family]:
    """Those of [6811], by their drawn dimensions; "49" is MODBAS2 with 49 touches."""
    from tests.support.profiles import facetst, modbas2, piecs11

    return MappingProxyType(
        {
            "MODBAS2": Family(modbas2(), (0, 0, 5, 5, 1, 1, 20)),
            "49": Family(modbas2(), (0, 0, 10, 10, 4, 4, 21)),
            "PIECS11": Family(piecs11(), (1, 0, 4, 20)),
            "FACETST": Family(facetst(), (4, 4, 4, 3)),
        }
    )


def nose_error_mm(angle_rad: Array, shape: int) -> Array:
    """Error of a nose over contact angle: set off, worn on its flank, or lobed."""
    if shape == 0:
        return np.asarray(0.01 * np.sin(angle_rad) + 0.02 * np.cos(angle_rad))
    if shape == 1:
        return np.asarray(0.04 * np.sin(angle_rad) ** 2 + 0.03 * np.exp(-(((angle_rad - 0.6) / 0.35) ** 2)))
    return np.asarray(0.02 * np.sin(3 * angle_rad + 1) + 0.03 * np.cos(angle_rad))


def draw(family: Family, rng: np.random.Generator) -> DrawnPart:
    """A part without a bad touch."""
    from tests.support.touched import touched

    shape = int(rng.integers(3))
    bare = touched(family.profile, family.counts, lambda _, n: nose_error_mm(contact_angle_rad(n), shape), 0.0004)
    lengths = np.array([f.length_mm for f in family.profile.features])[bare.feature_index]
    straight = np.array([not isinstance(f, Arc) for f in family.profile.features])[bare.feature_index]
    taper = rng.normal(0.0, TAPER_MM, len(family.counts))[bare.feature_index]
    true = bare.error_mm + straight * taper * (bare.arc_length_mm / lengths - 0.5)
    return DrawnPart(replace(bare, error_mm=true + SCATTER_MM * rng.standard_normal(len(true))), true)


def spoiled(part: DrawnPart, size_mm: float, how_many: int, rng: np.random.Generator) -> tuple[ErrorVectors, set[int]]:
    """Touches of which some are bad by ± this much, and which those are."""
    bad = rng.choice(len(part.true_mm), how_many, replace=False)
    error = part.touches.error_mm.copy()
    error[bad] += size_mm * rng.choice([-1.0, 1.0], how_many)
    return replace(part.touches, error_mm=error), {int(k) for k in bad}


def worst_um(profile: Profile, touches: ErrorVectors, true_mm: Array, options: FitOptions) -> float:
    """The largest error of the fitted curves, and so of a full correction, at the touches' places."""
    curves = fit_profile(profile, touches, options).curves
    at = zip(touches.feature_index, touches.arc_length_mm, strict=True)
    return float(np.max(np.abs([curves[i].value_mm(s)[0] for i, s in at] - true_mm))) * UM_PER_MM


def suspected(family: Family, parts: int, rng: np.random.Generator) -> tuple[int, int]:
    """Of clean parts: in how many a touch is suspected, and in how many one is left out."""
    found = [fit_profile(family.profile, draw(family, rng).touches).suspects for _ in range(parts)]
    return sum(bool(one) for one in found), sum(any(touch.left_out for touch in one) for one in found)


def main(parts: int) -> None:
    """Prints both tables."""
    for name, family in families().items():
        print(name, parts, "clean parts: suspected, left out", *suspected(family, parts, np.random.default_rng(1)))
    for name in ("49", "MODBAS2"):
        family = families()[name]
        for size_um, how_many in ((20, 1), (30, 1), (40, 1), (30, 2)):
            rng, rows, found = np.random.default_rng(2), [], 0
            for _ in range(max(parts // 15, 1)):
                part = draw(family, rng)
                touches, bad = spoiled(part, size_um / UM_PER_MM, how_many, rng)
                suspects = fit_profile(family.profile, touches).suspects
                found += {one.position for one in suspects if one.left_out} == bad
                rows.append([worst_um(family.profile, touches, part.true_mm, o) for o in (KEEP, FitOptions())])
            median, most = np.median(rows, axis=0), np.percentile(rows, 95, axis=0)
            print(f"{name}: {how_many} of {size_um} µm: left out {found} of {len(rows)}; worst error kept/left out:")
            print(f"   median {median[0]:.1f} / {median[1]:.1f} µm, 95 % {most[0]:.1f} / {most[1]:.1f} µm")


if __name__ == "__main__":
    main(int(sys.argv[1]))
