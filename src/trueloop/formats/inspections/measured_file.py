"""The result of reading an inspection file: the inspections, and remarks about the file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, TypeAlias

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection, Reading

Unit: TypeAlias = Literal["mm", "inch"]


@dataclass(frozen=True)
class Remark:
    """Something about a file that its reader should know: not understood, contradictory, or assumed."""

    text: str
    line: int | None = None


@dataclass(frozen=True)
class MeasuredFile:
    """An inspection file as read: one inspection for each part in each run, in the file's order.

    `format` names it in words. `encoding` is the one its text was read in. `unit` is the file's own; all lengths here
    are in mm. `characteristics` are those the file asks for, with their limits, whether measured or not. `deviations`
    are those stated, as actual − nominal, of readings whose nominal value the file does not state, with what they may
    differ by from rounding, by line and characteristic.
    """

    path: Path
    format: str
    encoding: str
    unit: Unit | None
    inspections: tuple[Inspection, ...]
    characteristics: tuple[Characteristic, ...] = ()
    remarks: tuple[Remark, ...] = ()
    deviations: Mapping[tuple[int | None, str], tuple[float, float]] = field(default_factory=dict)

    def deviation_of(self, reading: Reading) -> tuple[float, float] | None:
        """Returns the deviation stated of a reading, and its rounding; None where the file has its nominal value."""
        return self.deviations.get((reading.line, reading.characteristic))

    def for_part(self, inspection: Inspection) -> Inspection:
        """Returns an inspection without nominal values that follow from deviations alone: on a part, its own count."""
        if not self.deviations:
            return inspection
        values = (
            replace(value, nominal=None)
            if isinstance(value, Reading) and self.deviation_of(value) is not None
            else value
            for value in inspection.values
        )
        return replace(inspection, values=tuple(values))


@dataclass(frozen=True)
class StatedFacts:
    """The user's statements about a file that it lacks. None: not stated.

    `unit` is that of its lengths, `mapping` the file with the meanings of its columns, `variables` those of a control's
    variables. `unit_key` is the job's key that states the unit; empty: the command's option does.
    """

    unit: Unit | None = None
    mapping: Path | None = None
    unit_key: str = ""


@dataclass(frozen=True)
class Format:
    """A kind of inspection file: how it is known by its path and its first bytes, and its reader.

    The reader raises MSR errors with line and column for what it cannot read.
    """

    name: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path, StatedFacts], MeasuredFile]
