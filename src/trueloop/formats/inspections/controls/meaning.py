"""The mapping file of a control's output: what its variables hold, what the numbers of its lines are.

unit = "mm"

[variables.500]
feature = "journal"
quantity = "diameter"

[log]
x_is = "diameter"

[features]
"DIAMETER 7" = "journal"
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final, Literal, TypeAlias

from pydantic import Field, model_validator

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import StatedFacts, Unit
from trueloop.formats.inspections.shared.checks import numbered
from trueloop.formats.toml_tables import Count, Finite, NotNegative, Table, read_tables
from trueloop.units import MM_PER_INCH

HINT: Final = "docs/inspection-formats.md, “Dumps and print-outs of controls”, lists the keys of a mapping"
MM_PER: Final = {"mm": 1.0, "inch": MM_PER_INCH}
XIs: TypeAlias = Literal["radius", "diameter"]


class VariableTable(Table):
    """The meaning of one variable. Its numbers are in the file's unit, angles in degrees."""

    quantity: Quantity
    """`"diameter"`, `"radius"`, `"length"`, `"angle"`, `"runout"`, `"position"`, `"form"`."""
    feature: str = ""
    """The feature that it is a size of."""
    other: str = ""
    """With `quantity = "length"`: the feature from which it counts; left out, the part's zero."""
    point: str = ""
    """With `quantity = "position"`: the touch of which it is a coordinate. Coordinates of one point make one touch."""
    axis: Literal["", "x", "y", "z"] = ""
    """With `quantity = "position"`: which coordinate."""
    x_is: XIs | None = None
    """With `axis = "x"`: whether the variable holds a `"radius"` or a `"diameter"`."""
    holds: Literal["actual", "deviation"] = "actual"
    """`"deviation"`: the variable holds actual − nominal, and `nominal` or `nominal_in` is needed."""
    nominal: Finite | None = None
    """The nominal value."""
    nominal_in: str = ""
    """The variable that holds the nominal value."""
    lower_limit: Finite | None = None
    """The least value that is good."""
    upper_limit: Finite | None = None
    """The largest value that is good."""
    z: Finite | None = None
    """Where along the part it was measured."""

    @model_validator(mode="after")
    def _whole(self) -> "VariableTable":
        coordinate = self.quantity is Quantity.POSITION
        if coordinate != bool(self.axis):
            raise ValueError('`axis` belongs to `quantity = "position"`, and that needs it')
        if (self.axis == "x") != (self.x_is is not None):
            raise ValueError('`x_is` belongs to `axis = "x"`, and that needs it')
        if self.nominal is not None and self.nominal_in:
            raise ValueError("the nominal value is given twice: `nominal` and `nominal_in`")
        if self.holds == "deviation" and self.nominal is None and not self.nominal_in:
            raise ValueError("a deviation needs `nominal` or `nominal_in`")
        return self


class LogTable(Table):
    """The meaning of the numbers in a log of positions."""

    columns: tuple[Literal["x", "y", "z", "-"], ...] = ()
    """The meaning of each number in a line without letters; `"-"`: it is not read."""
    x_is: XIs | None = None
    """Meaning of an X: `"radius"` or `"diameter"`."""
    lines: tuple[Count, Count] | None = None
    """`[from, to]`: the lines that hold touches; left out, all do."""
    ball_radius: NotNegative = 0.0
    """Radius of the ball where positions are of its centre; 0 where they are of the surface."""

    @model_validator(mode="after")
    def _once(self) -> "LogTable":
        read = [name for name in self.columns if name != "-"]
        if len(set(read)) < len(read):
            raise ValueError("a coordinate stands in `columns` twice")
        return self


class Meaning(Table):
    """A whole mapping file of a control's output."""

    unit: Unit | None = None
    """Unit of the file's lengths; left out, `--unit` says it."""
    part: str = ""
    """The part's name."""
    serial: str = ""
    """Its serial number."""
    variables: dict[str, VariableTable] = Field(default_factory=dict)
    """Tables `[variables.500]`, one a variable: its number, or its name as in `"_OVR[4]"`."""
    log: LogTable | None = None
    """The meaning of the numbers in a log."""
    features: dict[str, str] = Field(default_factory=dict)
    """The part's names of features by those in the file, `"DIA 7" = "journal"`, `"LENGTH 2" = "shoulder from end"`."""


def meaning_of(stated: StatedFacts) -> Meaning:
    """The mapping that is stated; one without keys where none is. Raises MSR-MAPPING with the line of a wrong key."""
    if stated.mapping is None:
        return Meaning()
    return read_tables(stated.mapping, Meaning, Code.MSR_MAPPING, hint=HINT)


def reading_of(name: str, table: VariableTable, value: float, line: int, *, mm_per_unit: float) -> Reading:
    """Returns a value as the reading that its table states, a deviation with the table's nominal value on."""
    scale = (1.0 if table.quantity is Quantity.ANGLE else mm_per_unit) * (0.5 if table.x_is == "diameter" else 1.0)

    def scaled(number: float | None) -> float | None:
        return None if number is None else number * scale

    return Reading(
        characteristic=name,
        quantity=table.quantity,
        actual=(value + (table.nominal or 0.0) if table.holds == "deviation" else value) * scale,
        nominal=scaled(table.nominal),
        lower_limit=scaled(table.lower_limit),
        upper_limit=scaled(table.upper_limit),
        feature=table.feature,
        other=table.other,
        axis=table.axis,
        place_mm=() if table.z is None else (table.z * mm_per_unit,),
        line=line,
    )


def unit_of(stated: StatedFacts, meaning: Meaning, path: Path) -> Unit:
    """The unit of the file's lengths. Raises MSR-UNIT where it is not stated, or stated twice and differently."""
    units = {unit for unit in (stated.unit, meaning.unit) if unit is not None}
    if len(units) == 1:
        return units.pop()
    why = "--unit and the mapping's `unit` differ: mm and inch" if units else "the file does not say its unit"
    raise Code.MSR_UNIT.refusal(
        f"{path.name!r}: {why}",
        hint="state it once: --unit mm or --unit inch, or `unit` at the top of the mapping",
        place=Place(str(path)),
    )


def not_stated(path: Path, what: str, example: Sequence[str], line: int | None = None) -> TrueloopError:
    """The refusal of a file whose meaning is not stated, with a mapping that states it as an example."""
    shown = "".join(f"\n    {row}" for row in example)
    return Code.MSR_MEANING.refusal(
        f"{path.name!r}: {what}",
        hint=f"say so in a mapping, --mapping FILE.toml, for instance:{shown}",
        place=Place(str(path), line),
    )


DEVICE = "probe of the machine tool"


def inspection_of(
    path: Path,
    meaning: Meaning,
    readings: Iterable[Reading] = (),
    points: Iterable[CmmPoint] = (),
    *,
    ball_radius_mm: float = 0.0,
) -> Inspection:
    """Returns the values as an inspection; part and serial number as far as the mapping states them."""
    sizes, touched = numbered(readings), tuple(points)
    return Inspection(
        part=Part(PartType(meaning.part), meaning.serial),
        measured="CMM points" if not sizes else "readings and CMM points" if touched else "readings",
        sha256=sha256_of(path.read_bytes()),
        count=len(sizes) + len(touched),
        values=(*sizes, *touched),
        device=DEVICE,
        ball_radius_mm=ball_radius_mm if touched else 0.0,
    )
