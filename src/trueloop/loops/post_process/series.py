"""Series: one characteristic over the parts of a type, in the order in which they were cut.

A series is one nominal size with its limits: where a drawing's revision changes them, another series begins, and
nothing learned of the earlier one holds. What a tool offset can change is corrected: sizes along the axes. Form, runout
and angles are kept with the inspections, and no offset is proposed for them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.life import Identity
from trueloop.domain.part import PartType
from trueloop.memory.level.step import PartReading

BY_OFFSET: Final = frozenset({Quantity.DIAMETER, Quantity.RADIUS, Quantity.LENGTH, Quantity.POSITION})
"""Sizes that a tool offset changes."""


@dataclass(frozen=True)
class PartSeen:
    """One inspected part. `correction_mm`: what the proposals in force when it was cut took off, by series.

    `set_before`: the tool was set or changed since the part before; `begin_anew` are the series of which memory was
    begun anew with this part. `counts` False: nothing is learned from it.
    """

    inspection: Inspection
    correction_mm: Mapping[Identity, float] = field(default_factory=dict)
    set_before: bool = False
    counts: bool = True
    begin_anew: frozenset[Identity] = frozenset()

    @property
    def serial(self) -> str:
        """Of the part."""
        return self.inspection.part.serial


@dataclass(frozen=True)
class Made:
    """One characteristic of one part, as inspected: `error_mm` is actual less nominal, repeats averaged."""

    serial: str
    error_mm: float
    correction_mm: float
    set_before: bool
    counts: bool
    inspection: Identity

    @property
    def uncorrected_mm(self) -> float:
        """The error had nothing been corrected, E = F + C."""
        return self.error_mm + self.correction_mm

    @property
    def reading(self) -> PartReading:
        """As memory takes it."""
        return PartReading(self.error_mm, self.correction_mm, set_before=self.set_before, counts=self.counts)


@dataclass(frozen=True)
class Series:
    """A characteristic over parts, in cutting order. `latest`: its nominal and limits are those of the last part."""

    part_type: PartType
    characteristic: Characteristic
    made: tuple[Made, ...]
    latest: bool = True

    @property
    def name(self) -> str:
        """Of the characteristic."""
        return self.characteristic.name

    @property
    def identity(self) -> Identity:
        """Part type, characteristic, nominal and limits."""
        return identity_of(self.part_type, self.characteristic)


def identity_of(part_type: PartType, asked: Characteristic) -> Identity:
    """By which a series is known; sizes to 0.1 nm, as files round them when they convert units."""
    sizes = (asked.nominal, asked.lower_limit, asked.upper_limit)
    return (
        *part_type.identity,
        asked.name,
        asked.quantity.value,
        *("" if one is None else f"{one:.7f}" for one in sizes),
    )


def characteristic_of(reading: Reading) -> Characteristic | None:
    """What a reading is a value of; None where no offset changes it, or its nominal is not stated."""
    if reading.nominal is None or reading.quantity not in BY_OFFSET or not reading.characteristic:
        return None
    return Characteristic(
        reading.characteristic,
        reading.quantity,
        reading.feature,
        reading.nominal,
        reading.lower_limit,
        reading.upper_limit,
        other=reading.other,
    )


def series_of(seen: Sequence[PartSeen]) -> tuple[Series, ...]:
    """All series of parts in cutting order, the earlier revisions of a characteristic before its latest."""
    found: dict[Identity, tuple[PartType, Characteristic, list[Made]]] = {}
    last: dict[tuple[str, ...], Identity] = {}
    for part in seen:
        part_type = part.inspection.part.part_type
        for asked, error_mm in sizes_of(part.inspection):
            identity = identity_of(part_type, asked)
            made = Made(
                *(part.serial, error_mm, part.correction_mm.get(identity, 0.0)),
                *(part.set_before or identity in part.begin_anew, part.counts, part.inspection.identity),
            )
            found.setdefault(identity, (part_type, asked, []))[2].append(made)
            last[(*part_type.identity, asked.name)] = identity
    return tuple(
        Series(part_type, asked, tuple(made), last[(*part_type.identity, asked.name)] == identity)
        for identity, (part_type, asked, made) in found.items()
    )


def sizes_of(inspection: Inspection) -> Iterator[tuple[Characteristic, float]]:
    """Each characteristic of one part that an offset changes, with its error in mm: the mean of its repeats."""
    by_name: dict[str, list[tuple[Characteristic, float]]] = {}
    for reading in inspection.readings:
        asked = characteristic_of(reading)
        if asked is not None:
            by_name.setdefault(asked.name, []).append((asked, reading.actual))
    for repeats in by_name.values():
        asked = repeats[0][0]
        yield asked, fmean(actual - asked.nominal for _, actual in repeats)
