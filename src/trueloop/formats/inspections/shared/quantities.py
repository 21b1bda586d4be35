"""Words and symbols of reports for what a characteristic is the size of, in English and German."""

import re
import unicodedata
from functools import lru_cache
from typing import Final, Literal

from trueloop.domain.characteristic import Quantity

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
    (
        Quantity.LENGTH,
        re.compile("length|laenge|distan|abstand|width|breite|height|hoehe|depth|tiefe|thickness|dicke"),
    ),
)
"""In this order: the roundness of a diameter is a form."""
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
    **dict.fromkeys("xyz", Quantity.POSITION),
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
AXES: Final[dict[str, Literal["x", "y", "z"]]] = {"x": "x", "y": "y", "z": "z"}


@lru_cache(maxsize=4096)
def quantity_of(text: str) -> Quantity | None:
    """What a word, symbol or letter in a column of quantities says; None where it is not known.

    >>> quantity_of("Durchmesser").value, quantity_of("⌀").value, quantity_of("Rundheit").value, quantity_of("X").value
    ('diameter', 'diameter', 'form', 'position')
    """
    name = _lower(text)
    if name in SYMBOLS or name in LETTERS:
        return SYMBOLS.get(name) or LETTERS[name]
    return quantity_in(text)


@lru_cache(maxsize=4096)
def quantity_in(name: str) -> Quantity | None:
    """What the name of a characteristic or feature says of its quantity: `Ø25 h6`, `Diameter 7`; None: nothing."""
    lowered = _lower(name)
    return next((quantity for quantity, words in WORDS if words.search(lowered)), None)


def is_font(texts: frozenset[str]) -> bool:
    """Whether a column of quantities holds letters that only a GD&T font explains."""
    letters = {text for text in texts if len(text) == 1 and text.isalpha() and text.isascii()}
    return bool(letters & ONLY_FONT) and all(letter in FONT for letter in letters)


def _lower(text: str) -> str:
    lowered = unicodedata.normalize("NFC", text).casefold().strip(" .:")
    for umlaut, letters in (("ä", "ae"), ("ö", "oe"), ("ü", "ue"), ("_", " ")):
        lowered = lowered.replace(umlaut, letters)
    return lowered
