"""Words and symbols of reports for what a characteristic is the size of, in English and German."""

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Final, Literal, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import Code, Place, TrueloopError

SLACK = 1e-9


def characteristics_of(readings: Sequence[Reading]) -> tuple[Characteristic, ...]:
    """Returns the file's characteristics, each once: those with a nominal value.

    Several diameters of one feature hold at the z where each was read; a single one holds along the whole feature.
    """
    found: dict[tuple[str, str, str], Characteristic] = {}
    places: dict[tuple[str, str, str], set[float | None]] = {}
    for reading in readings:
        key = reading.characteristic, reading.feature, reading.axis
        places.setdefault(key, set()).add(reading.place_mm[-1] if reading.place_mm else None)
        if reading.nominal is not None and key not in found:
            found[key] = reading.size(reading.nominal)
    diameters = [size.feature for size in found.values() if size.quantity is Quantity.DIAMETER]
    for each, size in found.items():
        several = size.quantity is Quantity.DIAMETER and diameters.count(size.feature) > 1
        if several and len(places[each]) == 1:
            found[each] = replace(size, at_z_mm=next(iter(places[each])))
    return tuple(found.values())


def require_order(reading: Reading, path: Path) -> None:
    """Raises MSR-EXCHANGED where the lower limit is above the upper one."""
    lower, upper = reading.lower_limit, reading.upper_limit
    if lower is not None and upper is not None and lower > upper + SLACK:
        raise limits_refusal(lower, upper, Place(str(path), reading.line))


def limits_refusal(lower: float, upper: float, place: Place) -> TrueloopError:
    """Returns the refusal MSR-EXCHANGED of limits in the wrong order, in mm or degrees."""
    return Code.MSR_EXCHANGED.refusal(
        f"the lower limit {lower:.6g} is above the upper one, {upper:.6g}",
        hint="are the two limits exchanged, or is a sign missing?",
        place=place,
        values={"lower": lower, "upper": upper},
    )


Deviation: TypeAlias = Literal["actual - nominal", "nominal - actual"]
LowerTolerance: TypeAlias = Literal["with its sign", "without its sign"]
MOST_OF: Final = 0.9
"""Share of the rows that must agree: a row that was typed wrongly does not change the sign of all others."""


def counted_from_nominal(nominal: Array, lower: Array, upper: Array, stated: bool) -> bool:
    """Returns whether limits (n,), nan where there is none, count from the nominal: as stated, unless no zone fits so.

    A zone fits where it holds its nominal value, which counted from itself is 0, and is nearer to that than to the
    other. The statement is overruled where zones fit the other way alone, and none fits its own way alone.
    """
    with np.errstate(invalid="ignore"):
        low, high = np.fmin(lower, upper), np.fmax(lower, upper)
        near_zero = np.fmax(np.abs(low), np.abs(high)) < np.fmin(np.abs(low - nominal), np.abs(high - nominal))
        near_nominal = np.fmax(np.abs(low - nominal), np.abs(high - nominal)) < np.fmin(np.abs(low), np.abs(high))
        relative = near_zero & ~(lower > 0) & ~(upper < 0) & ((lower > nominal) | (upper < nominal))
        absolute = near_nominal & ~(lower > nominal) & ~(upper < nominal) & ((lower > 0) | (upper < 0))
    if stated:
        return not np.any(absolute) or bool(np.any(relative))
    return bool(np.any(relative)) and not np.any(absolute)


def deviation_sign(actual: Array, nominal: Array, deviation: Array, rounding: Array | float) -> Deviation | None:
    """Returns the sign convention of deviations from rows that state all three, (n,) each, nan if not; None: unknown.

    Rows that agree with both signs, such as deviations of 0, do not count.
    """
    computed = actual - nominal
    same, opposite = np.abs(deviation - computed) <= rounding, np.abs(deviation + computed) <= rounding
    plus, minus = int(np.sum(same & ~opposite)), int(np.sum(opposite & ~same))
    if plus > MOST_OF * (plus + minus):
        return "actual - nominal"
    if minus > MOST_OF * (plus + minus):
        return "nominal - actual"
    return None


def lower_tolerance_sign(
    upper: Array, lower: Array, deviation: Array | None = None, good: Array | None = None
) -> LowerTolerance | None:
    """Returns whether lower tolerances are printed with their sign; all (n,), nan where not stated; None: unknown.

    Where one is negative, signs are printed. A zone has a width: of `0.05 0.05` the second is without its sign. Of
    `0.05 0.02`, which may be either, deviations of parts whose verdict `good` (1 or 0, nan where not stated) is known
    decide.
    """
    stated = ~(np.isnan(upper) | np.isnan(lower)) & (lower != 0)
    if not np.any(stated):
        return "with its sign"
    up, low = upper[stated], lower[stated]
    if np.any(low < 0):
        return "with its sign"
    signed, unsigned = bool(np.all(low < up)), bool(np.all(-low < up))
    if signed and unsigned and deviation is not None and good is not None:
        dev, verdict = deviation[stated], good[stated]
        known = ~(np.isnan(dev) | np.isnan(verdict))
        inside, inside_unsigned = (low <= dev) & (dev <= up), (-low <= dev) & (dev <= up)
        signed = bool(np.all((inside == (verdict > 0))[known]))
        unsigned = bool(np.all((inside_unsigned == (verdict > 0))[known]))
    if signed == unsigned:
        return None
    return "with its sign" if signed else "without its sign"


GEOMETRIC: Final = (
    "flat|eben|round(?:ness)?$|roundness|rundheit|circular(?:ity)?$|circularity|straight|gerad|cylindricity|zylind(?:er)?form|"
    "form|perp|rechtwinkl|parallel|angularity|neigung|konzent|concent|coax|koax|symm|true pos|positionstoleranz|gdt|"
    "profile|linienprofil|flaechenprofil|position polar|gdtpos"
)
WORDS: Final = (
    (Quantity.RUNOUT, re.compile("run ?out|rundlauf|planlauf|gesamtlauf|axiallauf|radiallauf|total lauf")),
    (Quantity.FORM, re.compile(GEOMETRIC)),
    (Quantity.ANGLE, re.compile("angle|winkel")),
    (Quantity.DIAMETER, re.compile(r"diam|durchmesser|\bdia\b|\bdurchm\b|[ø⌀∅φ]")),
    (Quantity.RADIUS, re.compile(r"radius")),
    (Quantity.LENGTH, re.compile("length|laenge|distan|abstand|width|breite|height|hoehe|depth|tiefe|thickness|dicke")),
)
"""Words of quantities in order of precedence: the roundness of a diameter is a form."""
SYMBOLS: Final = {
    **dict.fromkeys("⌀Øø∅φ", Quantity.DIAMETER),
    **dict.fromkeys("⏤⏥○⌭⌒⌓⟂⊥∥⫽⌖⌯◎", Quantity.FORM),
    **dict.fromkeys("↗⌰⌁", Quantity.RUNOUT),
}
LETTERS: Final = {
    "d": Quantity.DIAMETER,
    "dia": Quantity.DIAMETER,
    "dm": Quantity.DIAMETER,
    "r": Quantity.RADIUS,
    "l": Quantity.LENGTH,
    "a": Quantity.ANGLE,
    "position": Quantity.POSITION,
    "tp": Quantity.FORM,
}
FONT: Final = {
    **dict.fromkeys("abcdefgijkru", Quantity.FORM),
    **dict.fromkeys("ht", Quantity.RUNOUT),
    "n": Quantity.DIAMETER,
}
"""Letters that a GD&T font draws as symbols: n is ⌀, j position, c flatness, h runout (as such fonts are laid out)."""
ONLY_FONT: Final = frozenset("bcefghijknu")
"""Those that stand for nothing else in a column of quantities."""
Axis: TypeAlias = Literal["x", "y", "z"]
AXES: Final[dict[str, Axis]] = {"x": "x", "y": "y", "z": "z"}
_COORDINATE: Final = "pos|position|coord|coordinate|koord|koordinate|lage|location|centre|center|mitte|mittelpunkt"
COORDINATES: Final = (
    re.compile(rf"(?:(?:{_COORDINATE})[ .-]*)?([xyz])"),
    re.compile(rf"([xyz])[ .-]*(?:{_COORDINATE}|axis|achse|value|wert)"),
)
"""Words of a coordinate: its axis, alone or beside a word for a place."""


@lru_cache(maxsize=4096)
def quantity_of(text: str) -> Quantity | None:
    """Returns the quantity of a word, symbol or letter in a column of quantities; None where it is not known.

    >>> quantity_of("Durchmesser").value, quantity_of("⌀").value, quantity_of("Rundheit").value, quantity_of("X").value
    ('diameter', 'diameter', 'form', 'position')
    """
    name = _lower(text)
    if axis_of(text):
        return Quantity.POSITION
    if name in SYMBOLS or name in LETTERS:
        return SYMBOLS.get(name) or LETTERS[name]
    return quantity_in(text)


@lru_cache(maxsize=4096)
def axis_of(text: str) -> Axis | Literal[""]:
    """Returns the axis of a coordinate by its words in a column of quantities; empty of anything else.

    >>> axis_of("position X"), axis_of("Y-Koordinate"), axis_of("z"), axis_of("position")
    ('x', 'y', 'z', '')
    """
    found = next((match for words in COORDINATES if (match := words.fullmatch(_lower(text)))), None)
    return AXES[found[1]] if found else ""


@lru_cache(maxsize=4096)
def quantity_in(name: str) -> Quantity | None:
    """Returns the quantity in the name of a characteristic or feature: `Ø25 h6`, `Diameter 7`; None: without one."""
    lowered = _lower(name)
    return next((quantity for quantity, words in WORDS if words.search(lowered)), None)


def is_font(texts: frozenset[str]) -> bool:
    """Returns whether a column of quantities has letters that only a GD&T font explains."""
    letters = {text for text in texts if len(text) == 1 and text.isalpha() and text.isascii()}
    return bool(letters & ONLY_FONT) and all(letter in FONT for letter in letters)


def _lower(text: str) -> str:
    lowered = unicodedata.normalize("NFC", text).casefold().strip(" .:")
    for umlaut, letters in (("ä", "ae"), ("ö", "oe"), ("ü", "ue"), ("_", " ")):
        lowered = lowered.replace(umlaut, letters)
    return lowered
