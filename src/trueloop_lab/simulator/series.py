"""A simulated series: parts turned one after the other by an edge that wears on a machine that warms up.

It does not follow the model that `trueloop.memory` assumes: forms of the edge are those of worn tools (a flat, a
notch, a radius that is not the nominal one), with kinks; wear grows as tools wear, warming follows a time constant with
pauses, a probe reads in steps. Only in size is it like the turning of [6811] Tables 8–11.

    semi-finish error = edge + setting + warming + clamping + the part's own form + noise
    finish error      = that without its noise + what the finish cut does differently − gain · correction + noise
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content

FLAT_DEG, NOTCH_DEG, NOTCH_WIDTH_DEG = (15.0, 75.0), (5.0, 85.0), (8.0, 16.0)
"""Ranges, °, of the uniformly drawn angles of a flat and of a notch, and of a notch's width."""


def flat(angle_rad: Array, at_rad: float, depth_mm: float, nose_mm: float = 0.8) -> Array:
    """Returns the error of a flat worn into a nose, perpendicular to the normal at an angle: material is left on.

    Beside its middle the flat's corner cuts, at arccos(1 − depth/R) from it: a roof with its ridge at the middle.
    """
    corner = np.arccos(1 - depth_mm / nose_mm)
    return np.asarray(nose_mm * (1 - np.cos(np.maximum(corner - np.abs(angle_rad - at_rad), 0.0))))


def notch(angle_rad: Array, at_rad: float, depth_mm: float, width_rad: float) -> Array:
    """Returns the error of a notch at the depth of cut: a groove with straight flanks."""
    return np.asarray(depth_mm * np.maximum(1 - np.abs(angle_rad - at_rad) / width_rad, 0.0))


def other_radius(angle_rad: Array, smaller_mm: float) -> Array:
    """Returns the error of a nose radius below the nominal one, touched off along X and Z: it cuts too deep between.

    The centre lies nearer to the work by the difference in both directions, the nose less far before it.
    """
    return np.asarray(smaller_mm * (1 - np.sin(angle_rad) - np.cos(angle_rad)))


def drawn_place(rng: np.random.Generator) -> tuple[float, float, float]:
    """Draws the angles of a flat and of a notch, and the notch's width, rad."""
    flat_deg, notch_deg, width_deg = (rng.uniform(*span) for span in (FLAT_DEG, NOTCH_DEG, NOTCH_WIDTH_DEG))
    return float(np.radians(flat_deg)), float(np.radians(notch_deg)), float(np.radians(width_deg))


def other_form(angle_rad: Array, rng: np.random.Generator, size_mm: float) -> Array:
    """Draws another edge's difference: flats and notches of either sign and another radius, RMS `size_mm`, (n,)."""
    drawn = other_radius(angle_rad, rng.normal())
    for _ in range(2):
        at, notched, width = drawn_place(rng)
        drawn = drawn + rng.normal() * flat(angle_rad, at, 0.03) / 0.03
        drawn = drawn + rng.normal() * notch(angle_rad, notched, 1.0, 2 * width)
    return np.asarray(size_mm * drawn / np.sqrt(np.mean(drawn**2)))


ANGLES: Final = np.radians(np.linspace(4.0, 88.0, 20))
"""Contact angles of twenty touches on an arc, as on NIST's parts."""


class What(StrEnum):
    """Kinds of events in a series."""

    EDGE = "edge"  # another edge from here on, with another form; `size_mm` is the RMS by which it differs
    OFFSET = "offset"  # both cuts of this part and all later ones moved along X
    FINISH = "finish"  # the finish cut of this part alone moved along X
    CORRECTION = "correction"  # of this part `size_mm` times the correction arrives: 0 not run, 2 twice


@dataclass(frozen=True)
class Event:
    """Something that happens before part `part`, counted from 0; size in mm, of a correction as a factor."""

    what: What
    part: int
    size_mm: float


@dataclass(frozen=True)
class Shop:
    """Parameters of the series of a shop; lengths in mm, times in minutes.

    `flat_mm`, `notch_mm` and `radius_mm` are standard deviations of the edge's form when the series begins. Wear adds
    to flat, notch and setting: by `break_in_mm` with `break_in_min`, then by `wear_mm` per hour, and faster towards
    the end of the edge's `life_min`. Warming moves X by `warming_mm` with `warming_min`, from cold at every
    `shift_parts`. The finish cut deflects less than the semi-finish cut by `push_off_mm`.
    """

    setting_mm: float = 0.020
    flat_mm: float = 0.020
    notch_mm: float = 0.012
    radius_mm: float = 0.020
    break_in_mm: float = 0.003
    break_in_min: float = 15.0
    wear_mm: float = 0.006
    life_min: float = 240.0
    minutes: float = 6.0
    warming_mm: float = 0.006
    warming_min: float = 40.0
    shift_parts: int = 15
    push_off_mm: float = 0.005
    clamping_mm: float = 0.002
    own_form_mm: float = 0.0015
    finish_scatter_mm: float = 0.0015
    noise_mm: float = 0.0015
    resolution_mm: float = 0.0001
    heavy_tails: bool = False
    """Noise of Student's t with four degrees of freedom, of the same standard deviation."""
    gross_share: float = 0.0
    gross_mm: float = 0.020
    gain: float = 1.0
    parts: int = 30
    changed_at: int | None = None
    """Another edge is set from this part on, as everybody knows."""
    stands_from: int | None = None
    """From this part on the edge wears no more and the machine keeps its warmth: each might be it."""
    angle_rad: Array = field(default_factory=ANGLES.copy)


@by_content
@dataclass(frozen=True)
class Series:
    """One drawn series of K parts at n contact angles, mm, positive = material left on.

    `semifinish_mm` (K, n) are the touches; `uncorrected_mm` (K, n) is the finish error had nothing been corrected,
    exactly; `noise_mm` (K, n) that of the finish inspection; `gain` (K,) the share of a correction that arrives;
    `minutes_in_cut` (K,) the age of the edge, `edge` (K,) its number as it is known to the shop.
    """

    angle_rad: Array
    semifinish_mm: Array
    uncorrected_mm: Array
    noise_mm: Array
    gain: Array
    minutes_in_cut: Array
    edge: Array

    def left_mm(self, part: int, correction_mm: Array | float) -> Array:
        """Returns the true finish error of a part that was cut with that correction, (n,)."""
        return np.asarray(self.uncorrected_mm[part] - self.gain[part] * correction_mm)

    def inspected_mm(self, part: int, correction_mm: Array | float) -> Array:
        """Returns the finish error as an inspection measures it, (n,)."""
        return np.asarray(self.left_mm(part, correction_mm) + self.noise_mm[part])


def draw(shop: Shop, rng: np.random.Generator, events: Sequence[Event] = ()) -> Series:
    """Draws one series of a shop, with its events."""
    angle, k = shop.angle_rad, np.arange(shop.parts)
    k = k if shop.stands_from is None else np.minimum(k, shop.stands_from)
    edges = np.zeros(shop.parts, int) if shop.changed_at is None else (k >= shop.changed_at).astype(int)
    since = np.where(edges == 1, k - (shop.changed_at or 0), k)
    minutes = shop.minutes * (since + 1.0)
    both = np.concatenate([_edge(shop, rng, minutes[edges == edge]) for edge in np.unique(edges)])
    both = both + warming(shop, np.asarray(k, np.float64))[:, None] * np.sin(angle)
    both = both + _clamping(shop, rng) + _own_forms(shop, rng, shop.own_form_mm)
    finish = both + _push_off(shop, rng) + _own_forms(shop, rng, shop.finish_scatter_mm)
    touched, inspected, gain = _noise(shop, rng), _noise(shop, rng), np.full(shop.parts, shop.gain)
    for event in events:
        moved = _moved(event, shop, rng)
        finish = finish + moved
        both = both + (0.0 if event.what is What.FINISH else moved)
        if event.what is What.CORRECTION:
            gain[event.part] = event.size_mm * shop.gain
    return Series(angle, _read(shop, both + touched), finish, inspected, gain, minutes, edges)


def wear(shop: Shop, minutes: Array) -> Array:
    """Returns the wear grown over minutes in cut: breaking in, evenly, and faster as the edge's life ends, mm."""
    broken_in = shop.break_in_mm * (1 - np.exp(-minutes / shop.break_in_min))
    even = shop.wear_mm * minutes / 60
    return np.asarray(broken_in + even + shop.wear_mm * (minutes / shop.life_min) ** 4)


def warming(shop: Shop, part: Array) -> Array:
    """Returns the displacement along X of a machine that is cold when a shift begins, mm."""
    minutes = shop.minutes * (part % shop.shift_parts)
    return np.asarray(-shop.warming_mm * (1 - np.exp(-minutes / shop.warming_min)))


def _edge(shop: Shop, rng: np.random.Generator, minutes: Array) -> Array:
    """Form and setting of one edge as it wears, (parts, n)."""
    angle, grown = shop.angle_rad, wear(shop, minutes)
    at, notched, width = drawn_place(rng)
    flat_mm, notch_mm = np.abs(rng.normal(size=2)) * (shop.flat_mm, shop.notch_mm)
    x, z = rng.normal(size=2) * shop.setting_mm
    still = other_radius(angle, rng.normal() * shop.radius_mm) + x * np.sin(angle) + z * np.cos(angle)
    worn = [flat(angle, at, flat_mm + g) + notch(angle, notched, notch_mm + g / 2, width) for g in grown]
    return np.asarray(still + np.array(worn) + 0.5 * grown[:, None] * np.sin(angle))


def _clamping(shop: Shop, rng: np.random.Generator) -> Array:
    along = np.stack([np.sin(shop.angle_rad), np.cos(shop.angle_rad)])
    return np.asarray(shop.clamping_mm * rng.normal(size=(shop.parts, 2)) @ along)


def _push_off(shop: Shop, rng: np.random.Generator) -> Array:
    """The nose is pushed off by its normal force, and less so where the chip is thin, towards the face."""
    size, thin = rng.normal(size=2) * shop.push_off_mm
    return np.asarray(size * np.sin(shop.angle_rad) + thin * np.cos(shop.angle_rad) ** 2)


def _own_forms(shop: Shop, rng: np.random.Generator, size_mm: float) -> Array:
    """Of each part: three waves of random height over the arc, of that standard deviation at a place; (K, n)."""
    share = (shop.angle_rad - shop.angle_rad[0]) / (np.ptp(shop.angle_rad) or 1.0)
    waves = np.stack([np.cos(np.pi * m * share) for m in (1, 2, 3)])
    waves /= np.sqrt(np.mean(np.sum(waves**2, axis=0)))
    return np.asarray(size_mm * rng.normal(size=(shop.parts, 3)) @ waves)


def _noise(shop: Shop, rng: np.random.Generator) -> Array:
    size = (shop.parts, len(shop.angle_rad))
    drawn = rng.standard_t(4, size) / np.sqrt(2) if shop.heavy_tails else rng.normal(size=size)
    gross = (rng.random(size) < shop.gross_share) * rng.normal(size=size) * shop.gross_mm
    return np.asarray(shop.noise_mm * drawn + gross)


def _read(shop: Shop, error_mm: Array) -> Array:
    """As a probe reads it, in steps."""
    return np.asarray(np.round(error_mm / shop.resolution_mm) * shop.resolution_mm)


def _moved(event: Event, shop: Shop, rng: np.random.Generator) -> Array:
    """The addition of an event to a cut, (K, n)."""
    k, angle = np.arange(shop.parts)[:, None], shop.angle_rad
    if event.what is What.EDGE:
        return np.asarray((k >= event.part) * other_form(angle, rng, event.size_mm))
    if event.what is What.CORRECTION:
        return np.zeros((shop.parts, len(angle)))
    parts = k == event.part if event.what is What.FINISH else k >= event.part
    return np.asarray(parts * event.size_mm * np.sin(angle))
