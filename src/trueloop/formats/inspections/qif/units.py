"""The units of a QIF document, and its numbers in millimetres and degrees.

Where a document states none the standard has metres and radians; real files without them hold millimetres and degrees.
Neither is taken: the user is asked.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import StatedFacts, Unit
from trueloop.formats.inspections.qif.elements import Element
from trueloop.formats.inspections.shared.text import number_in

MM: Final = {
    **dict.fromkeys(("mm", "millimeter", "millimetre", "millimeters", "millimetres"), 1.0),
    **dict.fromkeys(("in", "inch", "inches"), 25.4),
    **dict.fromkeys(("m", "meter", "metre", "meters", "metres"), 1000.0),
    **dict.fromkeys(("cm", "centimeter", "centimetre"), 10.0),
    **dict.fromkeys(("um", "µm", "micrometer", "micrometre", "micron"), 0.001),
}
"""Millimetres in the units of length that have one meaning."""
DEGREES: Final = {
    **dict.fromkeys(("deg", "degree", "degrees"), 1.0),
    **dict.fromkeys(("rad", "radian", "radians"), math.degrees(1.0)),
}
SLACK: Final = 1e-6
"""Factors are written with few digits: 0.017453292519943 rad in a degree."""
HINT: Final = "state the unit: `--unit mm` or `--unit inch`"


@dataclass(frozen=True)
class Units:
    """Factors to mm and to degrees: the document's own, None where it states none, and all units by name."""

    path: Path
    mm: float | None
    degrees: float | None
    lengths: Mapping[str, float]
    angles: Mapping[str, float]

    @property
    def unit(self) -> Unit | None:
        """Returns the document's unit of length where it is mm or inch."""
        return "mm" if self.mm == MM["mm"] else "inch" if self.mm == MM["inch"] else None

    def factor(self, element: Element, quantity: Quantity) -> float | None:
        """Returns the factor of a value; None for an angle whose unit is not stated. Raises MSR-UNIT for a length."""
        angle = quantity is Quantity.ANGLE
        name = element.attributes.get("angularUnit" if angle else "linearUnit")
        known, own = (self.angles, self.degrees) if angle else (self.lengths, self.mm)
        found = own if name is None else known.get(name, known.get(name.lower()))
        if found is None and (name is not None or not angle):
            what = "it states no unit of length" if name is None else f"its unit {name!r} is not defined"
            raise _wrong(self.path, what, element.line)
        return found

    def value(self, element: Element | None, quantity: Quantity) -> float | None:
        """Returns an element's number in mm or degrees; None where there is none, or its unit is not known."""
        if element is None or not element.text:
            return None
        factor = self.factor(element, quantity)
        return None if factor is None else factor * number_in(element.text, self.path, element.line)

    def place(self, element: Element | None) -> tuple[float, float, float] | None:
        """Returns three coordinates in mm; None where there are not three."""
        if element is None or len(words := element.text.split()) != 3:
            return None
        factor = self.factor(element, Quantity.POSITION) or 1.0
        x, y, z = (factor * number_in(word, self.path, element.line) for word in words)
        return x, y, z


def units_of(element: Element | None, path: Path, stated: StatedFacts) -> Units:
    """Returns the units that `FileUnits` (None: missing) states, else the user's. Raises MSR-UNIT where both differ."""
    lengths, angles = dict(MM), dict(DEGREES)
    own_mm = own_degrees = None
    for part in () if element is None else (*element.every("LinearUnit"), *element.every("AngularUnit")):
        known, per_si = (lengths, 1000.0) if part.name == "LinearUnit" else (angles, math.degrees(1.0))
        known[part.words("UnitName")] = _factor(part, known, per_si, path)
    primary = None if element is None else element.first("PrimaryUnits")
    if primary is not None:
        own_mm = lengths.get(primary.words("LinearUnit", "UnitName"))
        pmi = primary.first("PMIAngularUnit")
        if pmi is not None:
            angles[pmi.words("UnitName")] = _factor(pmi, angles, math.degrees(1.0), path)
        own_degrees = angles.get((pmi or primary).words(*(() if pmi else ("AngularUnit",)), "UnitName"))
    said = None if stated.unit is None else MM[stated.unit]
    if said is not None and own_mm is not None and said != own_mm:
        raise _wrong(path, f"it states {own_mm:g} mm as its unit of length, `--unit` {said:g} mm", None)
    return Units(path, own_mm if own_mm is not None else said, own_degrees, lengths, angles)


def _factor(unit: Element, factors: Mapping[str, float], per_si: float, path: Path) -> float:
    """Of one definition: that of its conversion to metres or radians, exact where its name has one meaning."""
    name, factor = unit.words("UnitName"), unit.first("UnitConversion", "Factor")
    usual = factors.get(name.lower())
    if factor is None:
        if usual is None and name != unit.words("SIUnitName"):
            raise _wrong(path, f"its unit {name!r} is defined without a factor", unit.line)
        return per_si if usual is None else usual
    found = per_si * number_in(factor.text, path, factor.line)
    if number_in(unit.words("UnitConversion", "Offset") or "0", path, unit.line) or found <= 0.0:
        raise _wrong(path, f"its unit {name!r} counts from another zero, or backwards", unit.line)
    if usual is not None and abs(found / usual - 1.0) > SLACK:
        raise _wrong(path, f"its unit {name!r} is defined as {found:g} instead of {usual:g} mm or degrees", unit.line)
    return found if usual is None else usual


def _wrong(path: Path, what: str, line: int | None) -> TrueloopError:
    return Code.MSR_UNIT.refusal(
        f"the lengths of {path.name!r} cannot be read: {what}", hint=HINT, place=Place(str(path), line)
    )
