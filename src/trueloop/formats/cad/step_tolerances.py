"""Characteristics of a profile from the tolerances of a STEP file: of which feature each is, and what it limits.

The records of a STEP file as it spells them (ISO 10303-21): numbers, types and parameters, not what they mean.

Dimensions and tolerances are those that the file attaches to its faces (AP242, ISO 10303-47), as they stand there.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, TypeAlias

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import TrueloopError
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.profile import Profile, kind_of
from trueloop.tolerances.text import limits_of
from trueloop.turned.characteristics.measurand import checked, edge_of, feature_index, with_nominal

Value: TypeAlias = "str | float | Ref | list[Value] | Typed | None"

FACES: Final = frozenset(("ADVANCED_FACE", "FACE_SURFACE"))
"""The types of records that are faces."""

TOKEN: Final = re.compile(
    r"\s+|/\*.*?\*/"
    r"|(?P<text>'(?:[^']|'')*')"
    r"|(?P<ref>#\d+)"
    r"|(?P<word>[A-Za-z_!][A-Za-z0-9_]*)"
    r"|(?P<number>[+-]?\d+\.?\d*(?:[Ee][+-]?\d+)?)"
    r"|(?P<enum>\.[A-Za-z0-9_]+\.)"
    r'|(?P<binary>"[^"]*")'
    r"|(?P<mark>[()=;,$*])",
    re.DOTALL,
)


@dataclass(frozen=True)
class Ref:
    """A reference to the record of a number."""

    number: int


@dataclass(frozen=True)
class Typed:
    """A value with its type: LENGTH_MEASURE(0.02)."""

    kind: str
    values: list[Value]


@dataclass(frozen=True)
class Record:
    """One record: its parameters by type; a complex one has several types."""

    number: int
    types: Mapping[str, list[Value]]

    def value(self, kind: str, place: int) -> Value:
        """Returns the parameter of a type at a place, from 0 or from the end; None where there is none."""
        values = self.types.get(kind, [])
        return values[place] if -len(values) <= place < len(values) else None

    def refs(self) -> Iterator[int]:
        """Yields the numbers of all records that it refers to."""
        for values in self.types.values():
            yield from _refs(values)


@dataclass(frozen=True)
class Records:
    """All records of a file, in its order."""

    of: Mapping[int, Record]

    @cached_property
    def numbers(self) -> tuple[int, ...]:
        """Returns the records' numbers, in the file's order."""
        return tuple(self.of)

    def typed(self, *kinds: str) -> Iterator[tuple[Record, list[Value]]]:
        """Yields the records of one of the types, with their parameters of it."""
        for record in self.of.values():
            for kind in kinds:
                if kind in record.types:
                    yield record, record.types[kind]

    def at(self, value: Value) -> Record | None:
        """Returns the record that a value refers to; None where it refers to none."""
        return self.of.get(value.number) if isinstance(value, Ref) else None


def read_records(text: str) -> Records:
    """Reads the records of the data sections. What cannot be read ends its record; nothing is raised."""
    found: dict[int, Record] = {}
    for start in re.finditer(r"(?<![A-Za-z0-9_])DATA\s*(?:\([^;]*\))?;", text):
        tokens = _tokens(text, start.end())
        for kind, token in tokens:
            if kind == "word" and token == "ENDSEC":
                break
            if kind == "ref" and next(tokens, ("", ""))[1] == "=":
                number = int(token[1:])
                found[number] = Record(number, dict(_types(tokens)))
    return Records(found)


def _tokens(text: str, at: int) -> Iterator[tuple[str, str]]:
    while (match := TOKEN.match(text, at)) is not None:
        at = match.end()
        if match.lastgroup is not None:
            yield match.lastgroup, match.group()


def _types(tokens: Iterator[tuple[str, str]]) -> Iterator[tuple[str, list[Value]]]:
    """Up to the record's semicolon: NAME(…), or (NAME(…) NAME(…))."""
    for kind, token in tokens:
        if token == ";" and kind == "mark":
            return
        if kind == "word" and next(tokens, ("", ""))[1] == "(":
            yield token.upper(), _values(tokens)


def _values(tokens: Iterator[tuple[str, str]]) -> list[Value]:
    """The values up to the closing bracket."""
    found: list[Value] = []
    for kind, token in tokens:
        match kind, token:
            case "mark", ")" | ";":
                break
            case "mark", "(":
                found.append(_values(tokens))
            case "mark", "$" | "*":
                found.append(None)
            case "text", _:
                found.append(token[1:-1].replace("''", "'"))
            case "ref", _:
                found.append(Ref(int(token[1:])))
            case "number", _:
                found.append(float(token))
            case "word", _:
                next(tokens, None)
                found.append(Typed(token.upper(), _values(tokens)))
            case "enum", _:
                found.append(token.strip("."))
    return found


def _refs(values: list[Value]) -> Iterator[int]:
    for value in values:
        if isinstance(value, Ref):
            yield value.number
        elif isinstance(value, list):
            yield from _refs(value)
        elif isinstance(value, Typed):
            yield from _refs(value.values)


SIZES: Final = ("DIMENSIONAL_SIZE", "ANGULAR_SIZE")
LOCATIONS: Final = ("DIMENSIONAL_LOCATION", "DIRECTED_DIMENSIONAL_LOCATION", "ANGULAR_LOCATION")
PREFIX: Final = {"MILLI": 1e-3, "CENTI": 1e-2, "DECI": 1e-1, "MICRO": 1e-6, "KILO": 1e3}
DEEPEST: Final = 4
"""A unit is stated in another one, that in a third; no further."""
FORM: Final = "_TOLERANCE"
NO_FORM: Final = ("PLUS_MINUS_TOLERANCE", "GEOMETRIC_TOLERANCE", "MODIFIED_GEOMETRIC_TOLERANCE")


@dataclass(frozen=True)
class StatedTolerance:
    """One dimension or tolerance: `kind` in the file's words ("diameter", "cylindricity"), lengths in mm, angles in
    degrees. Limits are absolute; `fit` such as "h6" stands instead of them. `faces`: for each of the one or two
    features it is of, the numbers of the faces' records.
    """

    kind: str
    faces: tuple[tuple[int, ...], ...]
    nominal: float | None = None
    lower: float | None = None
    upper: float | None = None
    fit: str = ""


def stated_in(records: Records) -> Iterator[StatedTolerance]:
    """Yields all of a file: dimensions with the limits that they have, then geometric tolerances."""
    pmi = _Pmi(records)
    for record, values in records.typed(*SIZES, *LOCATIONS):
        yield pmi.dimension(record, values)
    for record in records.of.values():
        if kinds := [kind for kind in record.types if kind.endswith(FORM) and kind not in NO_FORM]:
            yield pmi.geometric(record, kinds[0])


class _Pmi:
    """The records, and which of them say something of which."""

    def __init__(self, records: Records) -> None:
        self.records = records
        self.about: dict[int, list[Record]] = {}
        for record in records.of.values():
            for number in record.refs():
                self.about.setdefault(number, []).append(record)

    def dimension(self, record: Record, values: Sequence[Value]) -> StatedTolerance:
        """Its nominal, its limits as given, by deviations or by a fit."""
        values = values or record.types.get("SHAPE_ASPECT_RELATIONSHIP", [])
        location = any(kind in record.types for kind in LOCATIONS)
        name, of = ([*values, ""][0], values[2:4]) if location else ([*values, "", ""][1], values[:1])
        kind = "angle" if any(one.startswith("ANGULAR") for one in record.types) else str(name).lower()
        nominal, limits = self._nominal(record)
        fit = ""
        for about in self.about.get(record.number, ()):
            if "PLUS_MINUS_TOLERANCE" in about.types:
                zone = self.records.at(about.value("PLUS_MINUS_TOLERANCE", 0))
                fit, limits = _fit(zone) or fit, self._deviated(zone, nominal) or limits
        return StatedTolerance(kind, tuple(self.faces(one) for one in of), nominal, *limits, fit)

    def geometric(self, record: Record, kind: str) -> StatedTolerance:
        """Returns a geometric tolerance; the width of its zone is its upper limit."""
        values = record.types.get("GEOMETRIC_TOLERANCE") or record.types[kind]
        width = self.measure(self.records.at(values[2])) if len(values) > 2 else None
        words = kind.removesuffix(FORM).replace("_", " ").lower()
        return StatedTolerance(words, (self.faces(values[3]) if len(values) > 3 else (),), upper=width)

    def _nominal(self, dimension: Record) -> tuple[float | None, tuple[float | None, float | None]]:
        """The nominal of its representation, and the limits where it gives limits."""
        found: dict[str, float] = {}
        for about in self.about.get(dimension.number, ()):
            shape = self.records.at(about.value("DIMENSIONAL_CHARACTERISTIC_REPRESENTATION", 1))
            items = shape.value("SHAPE_DIMENSION_REPRESENTATION", 1) if shape else None
            for item in items if isinstance(items, list) else []:
                record = self.records.at(item)
                if record is not None and (size := self.measure(record)) is not None:
                    found[_item_name(record)] = size
        limits = found.pop("lower limit", None), found.pop("upper limit", None)
        return found.get("nominal value", next(iter(found.values()), None)), limits

    def _deviated(self, zone: Record | None, nominal: float | None) -> tuple[float, float] | None:
        if zone is None or nominal is None or "TOLERANCE_VALUE" not in zone.types:
            return None
        low, high = (self.measure(self.records.at(zone.value("TOLERANCE_VALUE", k))) for k in (0, 1))
        return None if low is None or high is None else (nominal + low, nominal + high)

    def measure(self, record: Record | None, deep: int = 0) -> float | None:
        """Returns a value with its unit, in mm or degrees; None of one whose unit rests on others without end."""
        for values in record.types.values() if record and deep < DEEPEST else ():
            if len(values) >= 2 and isinstance(values[-2], Typed | float):
                value = next(iter(values[-2].values), None) if isinstance(values[-2], Typed) else values[-2]
                scale = self._scale(values[-1], deep)
                return value * scale if isinstance(value, float) and scale is not None else None
        return None

    def _scale(self, unit: Value, deep: int) -> float | None:
        """Millimetres, or degrees, in the unit."""
        record = self.records.at(unit)
        if record is None:
            return None
        if "SI_UNIT" in record.types:
            prefix, name = record.value("SI_UNIT", -2), record.value("SI_UNIT", -1)
            factor = PREFIX.get(str(prefix), 1.0) if prefix else 1.0
            base = {"METRE": 1e3, "RADIAN": math.degrees(1)}.get(str(name))
            return None if base is None else factor * base
        if "CONVERSION_BASED_UNIT" in record.types:
            return self.measure(self.records.at(record.value("CONVERSION_BASED_UNIT", 1)), deep + 1)
        return None

    def faces(self, aspect: Value, numbers: frozenset[int] = frozenset()) -> tuple[int, ...]:
        """Returns the faces of a feature of the shape, also by way of the features that it is composed of."""
        record = self.records.at(aspect)
        if record is None or record.number in numbers:
            return ()
        found: list[int] = []
        for about in self.about.get(record.number, ()):
            if "GEOMETRIC_ITEM_SPECIFIC_USAGE" in about.types or "ITEM_IDENTIFIED_REPRESENTATION_USAGE" in about.types:
                found += [n for n in self._reached(about) if set(self.records.of[n].types) & FACES]
            for kind in about.types:
                values = about.types[kind]
                if kind.startswith("SHAPE_ASPECT") and len(values) >= 4 and self.records.at(values[2]) is record:
                    found += self.faces(values[3], numbers | {record.number})
        return tuple(dict.fromkeys(found))

    def _reached(self, usage: Record) -> Iterator[int]:
        """Returns the items that a usage identifies, through sets of them."""
        for number in usage.refs():
            record = self.records.of.get(number)
            if record is not None:
                yield number
                if "SET_REPRESENTATION_ITEM" in record.types or "COMPOUND_REPRESENTATION_ITEM" in record.types:
                    yield from (n for n in record.refs() if n in self.records.of)


def _item_name(record: Record) -> str:
    values = record.types.get("REPRESENTATION_ITEM") or next(iter(record.types.values()))
    return str(values[0]).lower() if values else ""


def _fit(zone: Record | None) -> str:
    """Returns the fit's class, such as "h6"."""
    if zone is None or "LIMITS_AND_FITS" not in zone.types:
        return ""
    form, grade = zone.value("LIMITS_AND_FITS", 0), zone.value("LIMITS_AND_FITS", 2)
    return f"{form}{str(grade).upper().removeprefix('IT')}"


RADII: Final = ("radius", "spherical radius", "toroidal minor radius")
SAME_DEG: Final = 1e-3
"""An angle that differs by less from the cone's own is the cone's."""


@dataclass(frozen=True)
class Proposals:
    """Characteristics of a profile, and a note of every tolerance of the file that is none, with the reason."""

    characteristics: tuple[Characteristic, ...] = ()
    notes: tuple[str, ...] = ()


def proposals(stated: Sequence[StatedTolerance], of_faces: Callable[[Sequence[int]], Sequence[Feature]]) -> Proposals:
    """Proposes characteristics. `of_faces`: the profile's features that faces leave, by their records' numbers."""
    found: list[Characteristic] = []
    notes: list[str] = []
    for tolerance in stated:
        on = [of_faces(faces) for faces in tolerance.faces]
        words = f"{tolerance.kind or 'a dimension'} {_limits(tolerance)}"
        if not on or not all(on):
            notes.append(f"Tolerance left out: {words}, not of this side's turned features.")
            continue
        made = list(_made(tolerance, on))
        if not made:
            names = ", ".join(feature.name for group in on for feature in group)
            notes.append(f"Tolerance left out: {words} of {names}, which a profile does not show.")
        found += [each for each in made if each.name not in {known.name for known in found}]
    return Proposals(tuple(found), tuple(notes))


def fitting(proposed: Sequence[Characteristic], profile: Profile) -> Proposals:
    """Returns the characteristics that a job with this profile accepts; of the others, why not."""
    found: list[Characteristic] = []
    notes: list[str] = []
    for characteristic in proposed:
        try:
            asked = with_nominal(characteristic, characteristic.nominal or None, profile)
            lower, upper = characteristic.lower_limit, characteristic.upper_limit
            if characteristic.tolerance:
                edge = edge_of(profile, feature_index(profile, asked))
                lower, upper = limits_of(characteristic.tolerance, asked.nominal, asked.quantity, edge, 1.0)
            checked(asked, lower, upper, characteristic.tolerance, profile)
            found.append(characteristic)
        except TrueloopError as refused:
            notes.append(f"Tolerance left out: {refused.message}.")
    return Proposals(tuple(found), tuple(notes))


def _made(tolerance: StatedTolerance, on: Sequence[Sequence[Feature]]) -> Iterator[Characteristic]:
    first, quantity = on[0][0], _quantity(tolerance, on)
    if quantity is None or (tolerance.lower is None and tolerance.upper is None and not tolerance.fit):
        return
    if quantity is Quantity.LENGTH:
        yield _limited(tolerance, f"{first.name} to {on[1][0].name}", quantity, first.name, other=on[1][0].name)
        return
    for feature in on[0]:
        stated = _to_the_axis(tolerance, feature) if quantity is Quantity.ANGLE else tolerance
        if stated is not None:
            yield _limited(stated, f"{feature.name} {quantity}", quantity, feature.name)


def _to_the_axis(tolerance: StatedTolerance, cone: Feature) -> StatedTolerance | None:
    """An angle of a cone counted to the axis: a file may say the cone's own, which is twice that."""
    along_x, along_z = (abs(float(part)) for part in cone.tangent(0.0))
    has = math.degrees(math.atan2(along_x, along_z))
    for factor in (1.0, 0.5):
        if tolerance.nominal is not None and abs(tolerance.nominal * factor - has) < SAME_DEG:
            low, high = (None if size is None else size * factor for size in (tolerance.lower, tolerance.upper))
            return replace(tolerance, nominal=tolerance.nominal * factor, lower=low, upper=high)
    return None


def _quantity(tolerance: StatedTolerance, on: Sequence[Sequence[Feature]]) -> Quantity | None:
    """Returns the quantity of a dimension on the profile; None if the profile does not show it."""
    kinds = {kind_of(feature) for group in on for feature in group}
    if tolerance.kind == "diameter" and kinds == {"cylinder"}:
        return Quantity.DIAMETER
    if tolerance.kind in RADII and kinds == {"arc"}:
        return Quantity.RADIUS
    if tolerance.kind == "angle" and kinds == {"cone"} and len(on) == 1:
        return Quantity.ANGLE
    if tolerance.kind == "linear distance" and kinds == {"face"} and len(on) == 2:
        return Quantity.LENGTH
    if tolerance.kind == "straightness" and all(not isinstance(feature, Arc) for feature in on[0]):
        return Quantity.FORM
    return None


def _limited(one: StatedTolerance, name: str, quantity: Quantity, feature: str, other: str = "") -> Characteristic:
    return Characteristic(
        name=name,
        quantity=quantity,
        feature=feature,
        nominal=one.nominal or 0.0,
        lower_limit=one.lower,
        upper_limit=one.upper,
        other=other,
        tolerance=one.fit,
    )


def _limits(tolerance: StatedTolerance) -> str:
    nominal = "" if tolerance.nominal is None else f"{tolerance.nominal:.4f} "
    limits = " to ".join("…" if value is None else f"{value:.4f}" for value in (tolerance.lower, tolerance.upper))
    return nominal + (tolerance.fit or (limits if limits != "… to …" else "without limits"))
