"""A DMIS statement taken apart: its label, its major word and what is said of it.

Beside it the settings in force at a statement: units, the plane of polar coordinates, the frame.
"""

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from trueloop.domain.inspection import Vector
from trueloop.errors import Code, Place
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.units import MM_PER_INCH

PARTS: Final = re.compile(
    r"(?:([A-Za-z]{1,3})\s*\((.*?)\)\s*=\s*)?([A-Za-z][A-Za-z0-9_]*|)\s*(?:[/=]\s*(.*)|('.*))?", re.S
)


@dataclass(frozen=True, slots=True)
class Words:
    """`FA(D1)=FEAT/CIRCLE,…`: `kind` FA, `label` D1, `word` FEAT, `fields` CIRCLE and so on, blanks taken off.

    `kind` and `label` are empty where a statement has none; `kind` and `word` are in capitals.
    """

    kind: str
    label: str
    word: str
    fields: tuple[str, ...]
    line: int


def words_of(text: str, line: int) -> Words | None:
    """Returns the parts of a statement's text; None where it is built otherwise."""
    head, slash, rest = text.partition("/")
    name, equals, word = head.rpartition("=")
    if slash and word.isalpha() and (not equals or (name.endswith(")") and name.count("(") == 1)):  # nearly all are
        kind, _, label = name[:-1].partition("(")
        if kind.isalpha() or not equals:
            return Words(kind.upper(), label.strip(), word.upper(), fields_of(rest), line)
    found = PARTS.fullmatch(text)
    if found is None:
        return None
    kind, label, word, rest, quoted = found.groups()
    if not word and not kind:
        return None
    fields = fields_of(rest if rest is not None else quoted or "")
    return Words((kind or "").upper(), (label or "").strip(), word.upper(), fields, line)


def fields_of(text: str) -> tuple[str, ...]:
    """Returns the fields between commas, outside of quoted texts."""
    if not text:
        return ()
    if "'" not in text:
        fields = text.split(",")
        return tuple([field.strip() for field in fields] if " " in text or "\t" in text else fields)
    return tuple(_quoted_fields(text))


def _quoted_fields(text: str) -> list[str]:
    fields, begin, quoted = [], 0, False
    for place, letter in enumerate(text):
        if letter == "'":
            quoted = not quoted
        elif letter == "," and not quoted:
            fields.append(text[begin:place].strip())
            begin = place + 1
    return [*fields, text[begin:].strip()]


def unquoted(field: str) -> str:
    """Returns a quoted text without its quotes; others as they are."""
    if len(field) > 1 and field[0] == field[-1] == "'":
        return field[1:-1].replace("''", "'").strip()
    return field


def label_in(field: str) -> tuple[str, str] | None:
    """Returns `FA(D1)` as ("FA", "D1"); None for anything that is not a label."""
    kind, opened, label = field.partition("(")
    if not opened or not label.endswith(")") or not kind.strip().isalpha():
        return None
    return kind.strip().upper(), label[:-1].strip()


def key_of(label: str) -> str:
    """Returns a label as it is compared: DMIS has no small letters, and a cut line may have lost a blank."""
    return label.upper() if label.isalnum() else "".join(label.split()).upper()


NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
SEXAGESIMAL: Final = re.compile(r"([+-]?)(\d+):(\d+)(?::(\d+\.?\d*))?")
FINEST: Final = 12
"""Decimals beyond which a number is exact in any sense that matters."""


LENGTHS_MM: Final = {"MM": 1.0, "CM": 10.0, "M": 1000.0, "INCH": MM_PER_INCH, "FEET": 12 * MM_PER_INCH}
ANGLES_DEG: Final = {"ANGDEC": 1.0, "ANGDMS": 1.0, "ANGRAD": 180.0 / math.pi}
PLANES: Final = {"XYPLAN": (0, 1, 2), "YZPLAN": (1, 2, 0), "ZXPLAN": (2, 0, 1)}
"""Axes of the plane in which polar coordinates turn, from the first to the second, and that of their height."""
Rotation = tuple[Vector, Vector, Vector]
UNTURNED: Final[Rotation] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Frame:
    """The coordinate system in force as seen from that of the first results: p = `rotation` · q + `shift_mm`."""

    rotation: Rotation = UNTURNED
    shift_mm: Vector = (0.0, 0.0, 0.0)

    def vector(self, q: Vector) -> Vector:
        """Returns a direction of this frame in the first one."""
        a, b, c = self.rotation
        return _dot(a, q), _dot(b, q), _dot(c, q)

    def point(self, q: Vector) -> Vector:
        """Returns a point of this frame in the first one."""
        if self is FIRST:
            return q
        (x, y, z), (dx, dy, dz) = self.vector(q), self.shift_mm
        return x + dx, y + dy, z + dz

    def shifted(self, shift_mm: Vector) -> "Frame":
        """Returns a frame whose origin lies there in this one."""
        return replace(self, shift_mm=self.point(shift_mm))

    def turned(self, axis: int, angle_deg: float) -> "Frame":
        """Returns a frame turned about an axis of this one, right-handed: from x to y about z."""
        cosine, sine = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
        first, second = (axis + 1) % 3, (axis + 2) % 3
        columns = [self.vector(unit) for unit in UNTURNED]
        new = list(columns)
        new[first] = _sum(cosine, columns[first], sine, columns[second])
        new[second] = _sum(-sine, columns[first], cosine, columns[second])
        rows = tuple(tuple(column[k] for column in new) for k in range(3))
        return replace(self, rotation=rows)  # type: ignore[arg-type]


FIRST: Final = Frame()


@dataclass(frozen=True)
class Settings:
    """Units as factors to mm and degrees; `mm` is None where the file has not stated one yet."""

    path: Path
    mm: float | None = None
    deg: float = 1.0
    sexagesimal: bool = False
    plane: str = "XYPLAN"
    frame: Frame = FIRST

    def length_factor(self, line: int) -> float:
        """Returns the factor to mm. Raises MSR-UNIT where neither file nor user has stated a unit."""
        if self.mm is None:
            raise Code.MSR_UNIT.refusal(
                f"{self.path.name!r} has lengths from line {line} on and no statement UNITS before them",
                hint="state the unit: --unit mm or --unit inch",
                place=Place(str(self.path), line),
            )
        return self.mm

    def place(self, polar: bool, q: Vector) -> Vector:
        """Returns Cartesian coordinates in the first frame; polar ones are radius, angle in degrees and height."""
        if polar:
            first, second, third = PLANES[self.plane]
            radius, angle_deg, height = q
            of = {first: radius * math.cos(math.radians(angle_deg)), second: radius * math.sin(math.radians(angle_deg))}
            q = tuple({**of, third: height}[axis] for axis in range(3))  # type: ignore[assignment]
        return self.frame.point(q)


def settings_from(path: Path, stated: StatedFacts) -> Settings:
    """Returns the settings at a file's beginning."""
    return Settings(path, None if stated.unit is None else LENGTHS_MM[stated.unit.upper()])


def with_units(settings: Settings, statement: Words) -> Settings:
    """Returns the settings after `UNITS/MM,ANGDEC`; words of other quantities (temperatures) change nothing."""
    for field in statement.fields:
        word = field.upper()
        if word in LENGTHS_MM:
            settings = replace(settings, mm=LENGTHS_MM[word])
        if word in ANGLES_DEG:
            settings = replace(settings, deg=ANGLES_DEG[word], sexagesimal=word == "ANGDMS")
    return settings


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _sum(a: float, u: Vector, b: float, v: Vector) -> Vector:
    return a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2]


def is_number(text: str) -> bool:
    """Returns whether it is a number or an angle in degrees, minutes and seconds."""
    return NUMBER.fullmatch(text) is not None or SEXAGESIMAL.fullmatch(text) is not None


def number_of(text: str, settings: Settings, line: int) -> float | None:
    """Its value in the file's unit; None for an empty field. Raises MSR-NUMBER for anything that is not a finite
    number.
    """
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if math.isfinite(value) and "_" not in text:  # Python takes 1_000
        return value
    raise Code.MSR_NUMBER.refusal(
        f"{text!r} stands where a number is expected",
        hint="write it with a decimal point; what was not measured is left empty",
        place=Place(str(settings.path), line),
        values={"text": text},
    )


def degrees_of(text: str, settings: Settings, line: int) -> float | None:
    """Returns an angle in degrees; of `12:30:00` where the file states ANGDMS."""
    found = SEXAGESIMAL.fullmatch(text) if settings.sexagesimal else None
    if found is None:
        value = number_of(text, settings, line)
        return None if value is None else value * settings.deg
    degrees = int(found[2]) + int(found[3]) / 60 + float(found[4] or 0) / 3600
    return -degrees if found[1] == "-" else degrees


def decimals_in(text: str) -> int:
    """Returns the number of decimals that a number is written with."""
    if "e" in text or "E" in text:
        mantissa, _, exponent = text.lower().partition("e")
        return min(max(decimals_in(mantissa) - int(exponent), 0), FINEST)
    point = text.find(".")
    return 0 if point < 0 else min(len(text) - point - 1, FINEST)
