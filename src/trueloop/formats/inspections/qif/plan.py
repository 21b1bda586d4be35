"""The plan of a QIF document: its items, with nominal and limits from the elements that each refers to."""

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Vector
from trueloop.formats.inspections.measured_file import Remark
from trueloop.formats.inspections.qif.elements import Element, kept_in
from trueloop.formats.inspections.qif.units import Units
from trueloop.formats.inspections.shared.quantities import counted_from_nominal
from trueloop.formats.inspections.shared.text import NUMBER

NAMES: Final = {
    Quantity.DIAMETER: "Diameter SphericalDiameter",
    Quantity.RADIUS: "Radius SphericalRadius",
    Quantity.LENGTH: "Length Width Height Depth Thickness DistanceBetween DistanceFrom Distance CurveLength Chord "
    "Square",
    Quantity.ANGLE: "Angle AngleBetween AngleFrom AngularCoordinate UserDefinedAngular",
    Quantity.RUNOUT: "CircularRunout TotalRunout Runout",
    Quantity.POSITION: "LinearCoordinate",
    Quantity.FORM: "Straightness Flatness Circularity Cylindricity Conicity Ellipticity Sphericity Toroidicity "
    "OtherForm LineProfile SurfaceProfile SurfaceProfileNonUniform",
    Quantity.OTHER: "Perpendicularity Parallelism Angularity Position Concentricity Coaxiality Symmetry PointProfile "
    "UserDefinedLinear",
}
KINDS: Final = {name: quantity for quantity, names in NAMES.items() for name in names.split()}
"""Kinds of characteristic whose values are lengths or angles."""
KIND: Final = re.compile(r"(\w+?)Characteristic(?:Definition|Nominal|Item|Actual|Measurement)")
POINTS: Final = ("PointFeature", "EdgePointFeature")
"""Beginnings of the names of features that are single points."""
AXES: Final[Mapping[str, Literal["x", "y", "z"]]] = {
    "XAXIS": "x",
    "YAXIS": "y",
    "ZAXIS": "z",
    "x": "x",
    "y": "y",
    "z": "z",
}
ABSOLUTE: Final = {"true": True, "1": True, "false": False, "0": False}
"""`DefinedAsLimit`: whether limits are absolute."""
NUMBERING: Final = re.compile(
    r"(part|piece|component|serial|specimen)[-_ ]*(number|no\.?|nr\.?|#|id)|s/n|(teile?|serien)[- ]?(nummer|nr\.?)",
    re.IGNORECASE,
)
"""Names of characteristics that number the parts."""


@dataclass(frozen=True, slots=True)
class Item:
    """A characteristic as results refer to it; `numbers`: the parts, `set_only`: reported as its nominal value."""

    name: str
    quantity: Quantity
    nominal: float | None = None
    lower_limit: float | None = None
    upper_limit: float | None = None
    tolerance: str = ""
    axis: Literal["", "x", "y", "z"] = ""
    features: tuple[str, ...] = ()
    devices: tuple[str, ...] = ()
    kept: Mapping[str, str] = field(default_factory=dict)
    numbers: bool = False
    set_only: bool = False

    def features_in(self, plan: "Plan", measured: tuple[str, ...] = ()) -> tuple[str, str]:
        """Returns the names of its feature and of the one it counts from: kept, of its features, or measured ones."""
        features = self.features or measured
        feature, other = plan.feature(features[:1]), plan.feature(features[1:])
        return self.kept.get("feature", feature), self.kept.get("other", other)

    def characteristic(self, feature: str, other: str) -> Characteristic | None:
        """Returns the drawing's characteristic; None where a size has no nominal. That of a form or a zone is 0."""
        zone = self.quantity in {Quantity.FORM, Quantity.RUNOUT, Quantity.OTHER}
        nominal = 0.0 if self.nominal is None and zone else self.nominal
        if nominal is None or self.numbers:
            return None
        return Characteristic(
            name=self.name,
            quantity=self.quantity,
            feature=feature,
            nominal=nominal,
            lower_limit=self.lower_limit,
            upper_limit=self.upper_limit,
            other=other,
            tolerance=self.tolerance,
        )


@dataclass
class Parts:
    """The members of a document's lists, by identifier."""

    lists: dict[str, dict[str, Element]] = field(default_factory=dict)

    def add(self, around: str, element: Element) -> None:
        """Adds a member to the list of that name."""
        self.lists.setdefault(around, {})[element.attributes.get("id", "")] = element

    def of(self, around: str, reference: Element | None) -> Element | None:
        """Returns the member that an element refers to; None: it is missing, or in another document."""
        if reference is None or "xId" in reference.attributes:
            return None
        return self.lists.get(around, {}).get(reference.text)


@dataclass(frozen=True)
class Plan:
    """Items and features by identifier, and what had to be said of them."""

    items: Mapping[str, Item]
    feature_names: Mapping[str, str]
    places: Mapping[str, Vector]
    nominal_points: Mapping[str, tuple[Vector, Vector | None]]
    remarks: tuple[Remark, ...]

    def feature(self, identifiers: tuple[str, ...]) -> str:
        """Returns the names of features, joined."""
        return " - ".join(name for identifier in identifiers if (name := self.feature_names.get(identifier, "")))


def plan_of(parts: Parts, units: Units) -> Plan:
    """Items with their nominals and limits. Raises MSR-NUMBER and MSR-UNIT with the line."""
    items, remarks = {}, Counter[str]()
    for identifier, element in parts.lists.get("CharacteristicItems", {}).items():
        if kind_of(element) in KINDS:
            items[identifier] = _item(element, parts, units, remarks)
    names: dict[str, str] = {}
    places: dict[str, Vector] = {}
    points: dict[str, tuple[Vector, Vector | None]] = {}
    for identifier, element in parts.lists.get("FeatureItems", {}).items():
        names[identifier] = element.words("FeatureName") or element.words("Name")
        nominal = parts.of("FeatureNominals", element.first("FeatureNominalId"))
        if nominal is not None and (
            location := units.place(nominal.first("Location") or nominal.first("Axis", "AxisPoint"))
        ):
            places[identifier] = location
            if nominal.name.startswith(POINTS):
                points[identifier] = location, _normal(nominal)
    said = tuple(Remark(f"{text} ({count} characteristics)") for text, count in remarks.items())
    return Plan(items, names, places, points, said)


def kind_of(element: Element) -> str:
    """Returns the kind of a characteristic: `Diameter` of `DiameterCharacteristicItem`."""
    found = KIND.fullmatch(element.name)
    return found[1] if found else ""


def _normal(nominal: Element) -> Vector | None:
    words = nominal.words("Normal").split()
    numbers = [float(word) for word in words if NUMBER.fullmatch(word) and "," not in word]
    return (numbers[0], numbers[1], numbers[2]) if len(numbers) == len(words) == len("xyz") else None


def _item(element: Element, parts: Parts, units: Units, remarks: Counter[str]) -> Item:
    nominal = parts.of("CharacteristicNominals", element.first("CharacteristicNominalId"))
    reference = None if nominal is None else nominal.first("CharacteristicDefinitionId")
    definition = parts.of("CharacteristicDefinitions", reference)
    if nominal is None:
        remarks["the nominal that an item refers to is not in this file: no nominal value, no limits"] += 1
    elif definition is None:
        remarks["the definition that a nominal refers to is not in this file: no limits"] += 1
    quantity = _quantity(element, definition)
    target = None if nominal is None else units.value(nominal.first("TargetValue"), quantity)
    lower, upper, tolerance = _limits(definition, target, quantity, parts, units, remarks)
    name = next(filter(None, (one.words("Name") for one in (element, nominal, definition) if one is not None)), "")
    name = name or element.words("CharacteristicDesignator", "Designator")
    axis = "" if nominal is None else nominal.words("Direction")
    return Item(
        name=name or f"{kind_of(element)} {element.attributes.get('id', '')}",
        quantity=quantity,
        nominal=target,
        lower_limit=lower,
        upper_limit=upper,
        tolerance=tolerance,
        axis=AXES.get(axis, AXES.get(kept_in(element).get("axis", ""), "")),
        features=tuple(part.text for ids in element.every("FeatureItemIds") for part in ids.parts),
        devices=tuple(part.text for ids in element.every("MeasurementDeviceIds") for part in ids.parts),
        kept=kept_in(element),
        numbers=_numbers(element, name, definition),
        set_only=definition is not None and definition.words("NonTolerance") == "SET",
    )


def _quantity(item: Element, definition: Element | None) -> Quantity:
    """By the kind, or in words where the kind is the user's own."""
    said = "" if definition is None else definition.words("WhatToMeasure")
    return Quantity(said) if said in set(Quantity) else KINDS[kind_of(item)]


def _numbers(item: Element, name: str, definition: Element | None) -> bool:
    """Returns whether a characteristic numbers the parts: by its name, unless what it measures is one of our words."""
    said = "" if definition is None else definition.words("WhatToMeasure")
    return kind_of(item).startswith("UserDefined") and said not in set(Quantity) and bool(NUMBERING.search(name))


def _limits(
    definition: Element | None,
    target: float | None,
    quantity: Quantity,
    parts: Parts,
    units: Units,
    remarks: Counter[str],
) -> tuple[float | None, float | None, str]:
    """Absolute limits, and a tolerance whose limits are not in the file, in words."""
    if definition is None:
        return None, None, ""
    fit = definition.first("LimitsAndFitsSpecification")
    if fit is not None:
        return None, None, fit.words("FormVariance") + fit.words("Grade")
    zone = units.value(definition.first("ToleranceValue"), quantity)
    if zone is not None:
        return _zone(definition, zone, quantity, units)
    tolerance = definition.first("Tolerance")
    if tolerance is not None and tolerance.first("DefinitionId") is not None:
        tolerance = parts.of("ToleranceDefinitions", tolerance.first("DefinitionId"))
    if tolerance is None:
        return None, None, ""
    lower, upper = (units.value(next(tolerance.every(name), None), quantity) for name in ("MinValue", "MaxValue"))
    absolute = ABSOLUTE.get(next((one.text for one in tolerance.every("DefinedAsLimit")), ""))
    if absolute is None or (not absolute and target is None):
        remarks["limits that do not say whether they are absolute, or are relative to no nominal, are left out"] += 1
        return None, None, ""
    offset = 0.0 if absolute or target is None else target
    if not absolute and target is not None and lower is not None and upper is not None:
        zone_of = [np.array([value]) for value in (target, lower, upper)]
        if not counted_from_nominal(zone_of[0], zone_of[1], zone_of[2], stated=True):
            remarks["limits exclude the nominal value as DefinedAsLimit has them: they are taken as absolute"] += 1
            offset = 0.0
    return None if lower is None else lower + offset, None if upper is None else upper + offset, ""


def _zone(
    definition: Element, width: float, quantity: Quantity, units: Units
) -> tuple[float | None, float | None, str]:
    """Of a zone: its width is the limit, of a signed profile of a point half of it on each side unless disposed."""
    if kind_of(definition) == "PointProfile":
        outer = units.value(definition.first("OuterDisposition"), quantity)
        upper = width / 2.0 if outer is None else outer
        return upper - width, upper, ""
    condition = definition.words("MaterialCondition")
    if condition in {"MAXIMUM", "LEAST"}:  # the size of the feature widens the zone
        return None, None, f"{width:g} mm at {condition.lower()} material condition"
    return None, width, ""
