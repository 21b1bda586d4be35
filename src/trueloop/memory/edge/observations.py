"""The touches of several parts as one vector: which cut of which part each belongs to, and at which contact angle."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, Flags, Integers, by_content
from trueloop.memory.made_part import ArcErrors, MadePart


@by_content
@dataclass(frozen=True)
class Cuts:
    """The cuts that errors belong to, each (m,): what the model's terms ask of them.

    `part`, `part_type` and `setting` are numbers that are equal where these are. `finish` is 1 for a finish cut, 0 for
    a semi-finish cut. `since_setting` counts parts since the first of the same setting, `in_cut` the edge's age in
    parts of mean duration: by minutes in cut where every part states them, else by the order of the parts.
    """

    part: Integers
    part_type: Integers
    setting: Integers
    finish: Array
    since_setting: Array
    in_cut: Array


@by_content
@dataclass(frozen=True)
class Observations:
    """n errors of m cuts, sorted by cut; (n,) each, mm.

    `cut` is the place in `cuts`; the errors are S, and E = F + C. `correction_mm` is C, zero before the finish cut;
    `standard_u_mm` that of the measurement.
    """

    cuts: Cuts
    cut: Integers
    contact_angle_rad: Array
    error_mm: Array
    correction_mm: Array
    standard_u_mm: Array

    def at(self, chosen: Flags) -> "Observations":
        """Some of the errors; all cuts stay."""
        columns = (self.contact_angle_rad, self.error_mm, self.correction_mm, self.standard_u_mm)
        return Observations(self.cuts, self.cut[chosen], *(column[chosen] for column in columns))

    def __hash__(self) -> int:
        """By content, so that what was fitted to the same errors is known again."""
        return hash((self.cut.tobytes(), self.contact_angle_rad.tobytes(), self.error_mm.tobytes()))


def observations(parts: Sequence[MadePart]) -> Observations:
    """All errors of parts in cutting order: cut 2k is the semi-finish cut of part k, 2k + 1 its finish cut.

    An inspected part whose correction is unknown counts by its semi-finish cut alone: E = F + C is not known.
    """
    seen = [errors for part in parts for errors in ((part.semifinish, None), _uncorrected(part))]
    errors = [one for one, _ in seen]
    lengths = [len(one.error_mm) for one in errors]
    taken = [np.zeros(len(one.error_mm)) if c is None else c for one, c in seen]
    return Observations(
        cuts_of(parts),
        np.repeat(np.arange(len(errors)), lengths),
        np.concatenate([one.contact_angle_rad for one in errors]),
        np.concatenate([one.error_mm + c for one, c in zip(errors, taken, strict=True)]),
        np.concatenate(taken),
        np.concatenate([one.standard_u_mm for one in errors]),
    )


def cuts_of(parts: Sequence[MadePart]) -> Cuts:
    """Both cuts of every part."""
    order = np.array([part.order for part in parts], dtype=np.float64)
    settings = _numbers([part.setting for part in parts])
    first = np.array([order[settings == setting].min() for setting in settings])
    twice = (
        np.arange(len(parts)),
        _numbers([part.part_type for part in parts]),
        settings,
        order - first,
        _age(parts, order),
    )
    part, part_type, setting, since_setting, in_cut = (np.repeat(column, 2) for column in twice)
    return Cuts(part, part_type, setting, np.tile([0.0, 1.0], len(parts)), since_setting, in_cut)


def _uncorrected(part: MadePart) -> tuple[ArcErrors, Array | None]:
    known = part.finish if part.finish is not None and part.correction_mm is not None else ArcErrors.none()
    return known, part.correction_mm if part.finish is not None else None


def _numbers(names: Sequence[str]) -> Integers:
    return np.unique(names, return_inverse=True)[1]


def _age(parts: Sequence[MadePart], order: Array) -> Array:
    """The edge's age in parts of mean duration, counted from the first of these parts."""
    minutes = np.array([np.nan if part.minutes_in_cut is None else part.minutes_in_cut for part in parts])
    span = np.ptp(minutes) if np.all(np.isfinite(minutes)) else 0.0
    if span <= 0:
        return np.asarray(order - order.min())
    return np.asarray((minutes - minutes.min()) * (np.ptp(order) / span))
