"""Series: one characteristic over the parts of a type, in the order in which they were cut.

A series is one nominal size with its limits: where a drawing's revision changes them, another series begins, and
nothing learned of the earlier one holds. What a tool offset can change is corrected: sizes along the axes. Form, runout
and angles are kept with the inspections, and no offset is proposed for them.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from enum import IntEnum, StrEnum
from itertools import pairwise
from statistics import fmean
from typing import Annotated, Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.life import Identity
from trueloop.domain.option import Option
from trueloop.domain.part import PartType
from trueloop.domain.proposal import ProposalClass
from trueloop.errors import Code, Finding, Severity
from trueloop.memory.level.kalman import PartReading


class Parameter(StrEnum):
    """The five classes of parameters that may be adjusted [4773 §2]."""

    TOOL_OFFSET = "tool offset"
    NC_CODE = "NC code"
    REAL_TIME = "real-time compensation values"
    MODEL = "parameters of a model"
    WEIGHT = "weighting factors"


class Stage(IntEnum):
    """The stages, in the order in which a shop takes them up; the fifth goes along with all others [4773 §3.5]."""

    OFFSETS = 1  # tool offsets are adjusted
    PATHS = 2  # real-time compensation values or NC code are revised
    IDENTIFICATION = 3  # the error term that needs adjustment is named; a person adjusts it
    MODEL = 4  # the parameters of the model are adjusted
    WEIGHTS = 5  # the factors of stages 1, 2 and 4 are adjusted


ADJUSTS: Final[Mapping[Stage, frozenset[Parameter]]] = {
    Stage.OFFSETS: frozenset({Parameter.TOOL_OFFSET}),
    Stage.PATHS: frozenset({Parameter.NC_CODE, Parameter.REAL_TIME}),
    Stage.IDENTIFICATION: frozenset(),
    Stage.MODEL: frozenset({Parameter.MODEL}),
    Stage.WEIGHTS: frozenset({Parameter.WEIGHT}),
}
"""The automation of each stage, whichever loop it runs in."""

NOT_AFTER_THE_PROCESS: Final = frozenset({Parameter.NC_CODE, Parameter.REAL_TIME})
"""These "cannot be performed in the post-process loop" [4773 §5 (2)], against its §3.3, where they could."""

CLASSES: Final[Mapping[Parameter, ProposalClass]] = {
    Parameter.TOOL_OFFSET: ProposalClass.TOOL_OFFSET,
    Parameter.MODEL: ProposalClass.MEMORY,  # what is remembered is this loop's model
    Parameter.WEIGHT: ProposalClass.WEIGHT,
}
"""The class of the proposals that change a parameter."""


def may_change(stage: Stage) -> frozenset[ProposalClass]:
    """Returns the changes that a stage may make in the post-process loop: nothing at all in stages 2 and 3."""
    return frozenset(CLASSES[parameter] for parameter in ADJUSTS[stage] - NOT_AFTER_THE_PROCESS)


def stage_of(changes: ProposalClass) -> Stage:
    """Returns the stage that a proposal belongs to."""
    return next(stage for stage in Stage if changes in may_change(stage))


HINT = "state when the parts were cut or measured; a series in another order learns another drift"


@dataclass(frozen=True)
class When:
    """The facts on one part's place in the order: `kept` counts as the inspections were kept."""

    serial: str
    kept: int
    cut_order: int | None = None
    cut_at: datetime | None = None
    measured_at: datetime | None = None
    in_doubt: bool = False


def parts_in_order(parts: Sequence[When]) -> tuple[tuple[int, ...], tuple[Finding, ...]]:
    """Indices of the parts as they were cut, and what is in doubt (SER-ORDER).

    By the order of their cuts where all are counted, else by the time of the cuts, else by the time of inspection, else
    as they were kept. Serial numbers never decide, but contradict: NIST's 3811 was inspected before 3511 [6811 §4.3].
    """
    order = tuple(sorted(range(len(parts)), key=lambda k: (_key(parts, k), parts[k].kept)))
    sorted_parts = [parts[k] for k in order]
    findings = [_doubt(f"part {part.serial!r} is marked as cut in another order") for part in parts if part.in_doubt]
    return order, (*findings, *_clock_back(parts), *_against_serials(sorted_parts))


def _key(parts: Sequence[When], k: int) -> float:
    one = parts[k]
    if all(part.cut_order is not None for part in parts):
        return float(one.cut_order or 0)
    if all(part.cut_at is not None for part in parts):
        return _seconds(one.cut_at)
    if all(part.measured_at is not None for part in parts):
        return _seconds(one.measured_at)
    return 0.0


def _seconds(at: datetime | None) -> float:
    """Returns the time in seconds. A time without a zone is taken as UTC: within one file all are alike."""
    assert at is not None
    return (at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp()


def _clock_back(parts: Sequence[When]) -> tuple[Finding, ...]:
    """Reports each part kept later that was measured earlier: a clock set back, or files taken in another order."""
    timed = sorted((part for part in parts if part.measured_at is not None), key=lambda part: part.kept)
    return tuple(
        _doubt(
            f"part {after.serial!r} came after {before.serial!r} but was measured before it, at "
            f"{after.measured_at:%Y-%m-%d %H:%M} against {before.measured_at:%Y-%m-%d %H:%M}"
        )
        for before, after in pairwise(timed)
        if _seconds(after.measured_at) < _seconds(before.measured_at)
    )


def _against_serials(parts: Sequence[When]) -> tuple[Finding, ...]:
    """Reports the first place where serial numbers that count fall."""
    numbers = [re.search(r"(\d+)$", part.serial) for part in parts]
    if any(number is None for number in numbers):
        return ()
    counted = [(int(number[1]), part) for number, part in zip(numbers, parts, strict=True) if number is not None]
    for (low, before), (high, after) in pairwise(counted):
        if high < low:
            return (_doubt(f"part {after.serial!r} is taken as cut after {before.serial!r}"),)
    return ()


def _doubt(why: str) -> Finding:
    return Finding(Severity.WARNING, Code.SER_ORDER, f"the order of the parts is in doubt: {why}", HINT)


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
        """Returns the serial number of the part."""
        return self.inspection.part.serial


@dataclass(frozen=True)
class MadePart:
    """One characteristic of one part, as inspected: `error_mm` is actual less nominal, repeats averaged."""

    serial: str
    error_mm: float
    correction_mm: float
    set_before: bool
    counts: bool
    inspection: Identity

    @property
    def uncorrected_mm(self) -> float:
        """Returns the error had nothing been corrected, E = F + C."""
        return self.error_mm + self.correction_mm

    @property
    def reading(self) -> PartReading:
        """Returns the reading as memory takes it."""
        return PartReading(self.error_mm, self.correction_mm, set_before=self.set_before, counts=self.counts)


@dataclass(frozen=True)
class Series:
    """A characteristic over parts, in cutting order. `latest`: its nominal and limits are those of the last part."""

    part_type: PartType
    characteristic: Characteristic
    made: tuple[MadePart, ...]
    latest: bool = True

    @property
    def name(self) -> str:
        """Returns the name of the characteristic."""
        return self.characteristic.name

    @property
    def identity(self) -> Identity:
        """Returns part type, characteristic, nominal and limits."""
        return identity_of(self.part_type, self.characteristic)


def identity_of(part_type: PartType, characteristic: Characteristic) -> Identity:
    """Returns the key of a series; sizes to 0.1 nm, as files round them when they convert units."""
    sizes = (characteristic.nominal, characteristic.lower_limit, characteristic.upper_limit)
    return (
        *part_type.identity,
        characteristic.name,
        characteristic.quantity.value,
        *("" if size is None else f"{size:.7f}" for size in sizes),
    )


def characteristic_of(reading: Reading) -> Characteristic | None:
    """Returns the characteristic of a reading; None where no offset changes it, or its nominal is not stated."""
    if reading.nominal is None or reading.quantity not in BY_OFFSET or not reading.characteristic:
        return None
    return reading.size(reading.nominal)


def series_of(parts: Sequence[PartSeen]) -> tuple[Series, ...]:
    """Returns all series of parts in cutting order, the earlier revisions of a characteristic before its latest."""
    found: dict[Identity, tuple[PartType, Characteristic, list[MadePart]]] = {}
    last: dict[tuple[str, ...], Identity] = {}
    for part in parts:
        part_type = part.inspection.part.part_type
        for asked, error_mm in sizes_of(part.inspection):
            identity = identity_of(part_type, asked)
            made = MadePart(
                serial=part.serial,
                error_mm=error_mm,
                correction_mm=part.correction_mm.get(identity, 0.0),
                set_before=part.set_before or identity in part.begin_anew,
                counts=part.counts,
                inspection=part.inspection.identity,
            )
            found.setdefault(identity, (part_type, asked, []))[2].append(made)
            last[(*part_type.identity, asked.name)] = identity
    return tuple(
        Series(part_type, asked, tuple(made), last[(*part_type.identity, asked.name)] == identity)
        for identity, (part_type, asked, made) in found.items()
    )


def sizes_of(inspection: Inspection) -> Iterator[tuple[Characteristic, float]]:
    """Yields each characteristic of one part that an offset changes, with its error in mm: the mean of its repeats."""
    by_name: dict[str, list[tuple[Characteristic, float]]] = {}
    for reading in inspection.readings:
        asked = characteristic_of(reading)
        if asked is not None:
            by_name.setdefault(asked.name, []).append((asked, reading.actual))
    for repeats in by_name.values():
        asked = repeats[0][0]
        yield asked, fmean(actual - asked.nominal for _, actual in repeats)


@dataclass(frozen=True)
class SeriesOptions:
    """Lengths in mm, of sizes: a diameter's change is twice the radial one. `automatic`: what needs no decision."""

    largest_mm: Annotated[
        float, Option("series.max_um", "A proposal that changes a size by more is not accepted.", above=0)
    ] = 0.150
    least_mm: Annotated[float, Option("series.min_um", "A smaller change of a size is not proposed.", least=0)] = 0.0005
    age_hours: Annotated[
        float, Option("series.max_age_hours", "A proposal made longer ago is not accepted.", above=0)
    ] = 168.0
    take_nominal: Annotated[
        bool, Option("series.take_nominal", "Use parts whose values are exactly nominal, as if they were filled in.")
    ] = False
    automatic: frozenset[ProposalClass] = field(default_factory=frozenset)


LEAST_PARTS: Final = 3
"""With fewer parts a level is not yet one."""

NAMES: Final = {"offset": ProposalClass.TOOL_OFFSET, "memory": ProposalClass.MEMORY, "weight": ProposalClass.WEIGHT}
"""Classes as commands name them."""


def classes_named(names: Iterable[str]) -> frozenset[ProposalClass]:
    """Returns the classes of these names."""
    return frozenset(NAMES[name] for name in names)
