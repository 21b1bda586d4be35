"""Features of DMIS: `F(…)=FEAT/…` as the drawing has them, `FA(…)=FEAT/…` as they were measured."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, Literal

from trueloop.domain.inspection import Vector
from trueloop.formats.inspections.dmis.words import (
    FIRST,
    Settings,
    Words,
    decimals_in,
    degrees_of,
    is_number,
    number_of,
)

Side = Literal["", "inner", "outer"]
Some = tuple[float | None, float | None, float | None]
NOWHERE: Final[Some] = (None, None, None)

LAYOUTS: Final = {
    "POINT": ("xyz", "ijk"),
    "EDGEPT": ("xyz", "ijk"),
    "PLANE": ("xyz", "ijk"),
    "SYMPLN": ("xyz", "ijk"),
    "CIRCLE": ("xyz", "ijk", "DIAM"),
    "ARC": ("xyz", "ijk", "RAD", "from", "to"),
    "CYLNDR": ("xyz", "ijk", "DIAM", "LENGTH"),
    "CONE": ("xyz", "ijk", "cone"),
    "SPHERE": ("xyz", "DIAM", "ijk"),
    "CPARLN": ("xyz", "ijk", "pqr", "LENGTH", "WIDTH"),
    "SLOT": ("xyz", "ijk", "pqr", "LENGTH", "WIDTH"),
    "GCURVE": ("xyz", "ijk"),
    "GSURF": ("xyz", "ijk"),
    "LINE": ("xyz", "ijk", "pqr"),
}
"""Meanings of the numbers of a feature, in their order; `ijk` its direction or normal, `pqr` a second one."""
TRIPLES: Final = ("xyz", "ijk", "pqr", "end")
BOUNDED: Final = ("xyz", "end", "pqr")
"""A bounded line: its two ends, and the normal of its surface."""
ANGLES: Final = ("cone", "from", "to")
"""Not read further: sources at hand do not say whether a cone's angle is the included one or half of it."""
WORDS: Final = frozenset(("CART", "POL", "INNER", "OUTER", "IN", "OUT", "BND", "UNBND", "ROUND", "FLAT", "OPEN"))
"""Words allowed before the numbers of a feature; anything else there is no number."""
POINTS: Final = ("POINT", "EDGEPT")
NOTHING: Final = "0"
"""Some programs end the statement of a point with it. A decimal comma may make it too, where no number has a point."""
WITH_AXIS: Final = ("LINE", "CYLNDR", "CONE")
"""Along their direction the place that is stated means nothing."""
WITH_NORMAL: Final = ("PLANE", "SYMPLN")
"""Only along their normal it means something."""
ALONG: Final = 1.0 - 1e-6
"""Cosine from which a direction is taken as that of an axis: 0.08°."""


@dataclass(frozen=True, slots=True)
class Feature:
    """One feature, nominal or actual, in mm and degrees in the frame of the first results.

    `place_mm` has None where a coordinate is not stated. `sizes` by what DMIS calls their tolerances. `decimals_mm` is
    what one step of the last decimal is worth. `odd`: what is wrong with its fields, in words.
    """

    kind: str
    label: str
    line: int
    side: Side = ""
    place_mm: Some = NOWHERE
    direction: Vector | None = None
    sizes: dict[str, float] = field(default_factory=dict)
    decimals_mm: float = 0.0
    odd: str = ""

    @property
    def point_mm(self) -> Vector | None:
        """Its place where that is stated whole."""
        x, y, z = self.place_mm
        return None if x is None or y is None or z is None else (x, y, z)

    @property
    def known_axes(self) -> Iterator[int]:
        """Yields the axes along which its place is stated and means something."""
        for axis, value in enumerate(self.place_mm):
            along = 0.0 if self.direction is None else abs(self.direction[axis])
            if self.kind in WITH_AXIS and along > ALONG:
                continue
            if self.kind in WITH_NORMAL and self.direction is not None and along < ALONG:
                continue
            if value is not None:
                yield axis


@dataclass(frozen=True)
class Slots:
    """Positions of the numbers of a layout: a triple's first, or -1 where it has none."""

    place: int
    direction: int
    end: int
    sizes: tuple[tuple[str, int], ...]
    count: int

    @classmethod
    def of(cls, layout: tuple[str, ...]) -> "Slots":
        """Returns the slots of the names of a layout in their order."""
        begins, count = {}, 0
        for name in layout:
            begins[name] = count
            count += 3 if name in TRIPLES else 1
        sizes = tuple((name, begin) for name, begin in begins.items() if name not in TRIPLES)
        return cls(begins["xyz"], begins.get("ijk", -1), begins.get("end", -1), sizes, count)


SLOTS: Final = {kind: Slots.of(layout) for kind, layout in LAYOUTS.items()}
SLOTS_BOUNDED: Final = Slots.of(BOUNDED)


def feature_of(statement: Words, settings: Settings) -> Feature | str | None:
    """Returns the feature of a statement; the reason, in words, why it cannot be one; None for an unknown kind.

    Raises MSR-NUMBER for anything that is not a number, MSR-UNIT for lengths without a unit.
    """
    fields, line = statement.fields, statement.line
    kind = fields[0].upper() if fields else ""
    slots = SLOTS.get(kind)
    if slots is None:
        return None
    count = 1
    while count < len(fields) and fields[count].upper() in WORDS:
        count += 1
    words = [word.upper() for word in fields[1:count]]
    if kind == "LINE" and "BND" in words:
        slots = SLOTS_BOUNDED
    texts = fields[count : count + slots.count]
    behind = [text for text in fields[count + slots.count :] if is_number(text)]
    if kind in POINTS and behind == [NOTHING] and any("." in text for text in texts):
        fields, behind = fields[: count + slots.count], []
    if behind:  # which of the numbers is the size is not known
        return f"has {len(behind)} numbers more than a {kind} has, as decimal commas would make: it was left out"
    angular = {begin for name, begin in slots.sizes if name in ANGLES} | (
        {slots.place + 1} if "POL" in words else set()
    )
    numbers = [
        degrees_of(text, settings, line) if k in angular else number_of(text, settings, line)
        for k, text in enumerate(texts)
    ]
    numbers += [None] * (slots.count - len(numbers))
    mm = settings.length_factor(line)
    place = _place(numbers[slots.place : slots.place + 3], settings, mm, polar="POL" in words)
    if slots.end >= 0:
        direction = _between(place, _place(numbers[slots.end : slots.end + 3], settings, mm, polar="POL" in words))
    else:
        direction = _direction(numbers[slots.direction : slots.direction + 3], settings)
    sizes = {
        name: value if name in ANGLES else value * mm
        for name, begin in slots.sizes
        if (value := numbers[begin]) is not None
    }
    step = mm * 10.0 ** -_decimals(texts, slots)
    return Feature(
        kind=kind,
        label=statement.label,
        line=line,
        side=_side(words),
        place_mm=place,
        direction=direction,
        sizes=sizes,
        decimals_mm=step,
        odd=_odd(slots, fields[count:]),
    )


def _odd(slots: Slots, fields: tuple[str, ...]) -> str:
    """An empty field says that something was not measured; one that is not there may have been lost."""
    if len(fields) > slots.count:
        return f"has {len(fields) - slots.count} fields more than are known"
    size, begin = slots.sizes[0] if slots.sizes else ("place", slots.place + 2)
    return f"ends before its {size}" if len(fields) <= begin else ""


def _decimals(texts: tuple[str, ...], slots: Slots) -> int:
    """The most decimals that a place or a size is written with."""
    most = 0
    for k, text in enumerate(texts):
        if not slots.direction <= k < slots.direction + 3 or slots.direction < 0:
            most = max(most, decimals_in(text))
    return most


def _side(words: list[str]) -> Side:
    if not words:
        return ""
    return "inner" if "INNER" in words or "IN" in words else "outer" if "OUTER" in words or "OUT" in words else ""


def _place(numbers: list[float | None], settings: Settings, mm: float, *, polar: bool) -> Some:
    a, b, c = numbers
    if a is None or b is None or c is None:
        whole = polar or settings.frame is not FIRST  # one coordinate alone cannot be turned
        return NOWHERE if whole else (_times(a, mm), _times(b, mm), _times(c, mm))
    if not polar and settings.frame is FIRST:
        return a * mm, b * mm, c * mm
    return settings.place(polar, (a * mm, b if polar else b * mm, c * mm))


def _direction(numbers: list[float | None], settings: Settings) -> Vector | None:
    """A unit vector; None where it is not stated whole, or zero. Rounding alone is left as it is written."""
    if len(numbers) < 3:
        return None
    i, j, k = numbers
    if i is None or j is None or k is None:
        return None
    length = math.sqrt(i * i + j * j + k * k)
    if not 1e-9 < length < math.inf:
        return None
    if abs(length - 1.0) > 1e-4:
        i, j, k = i / length, j / length, k / length
    return (i, j, k) if settings.frame is FIRST else settings.frame.vector((i, j, k))


def _between(start: Some, end: Some) -> Vector | None:
    if None in start or None in end:
        return None
    along = [(b or 0.0) - (a or 0.0) for a, b in zip(start, end, strict=True)]
    length = math.sqrt(math.fsum(value * value for value in along))
    return None if length < 1e-9 else (along[0] / length, along[1] / length, along[2] / length)


def _times(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor
