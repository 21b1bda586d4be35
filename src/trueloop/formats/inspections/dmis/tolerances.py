"""Tolerances of DMIS: `T(…)=TOL/…` as the drawing has them, `TA(…)=TOL/…` as they were found."""

from dataclasses import dataclass
from typing import Final, Literal

from trueloop.domain.characteristic import Quantity
from trueloop.formats.inspections.dmis.words import Settings, Words, decimals_in, is_number, number_of, unquoted

Verdict = Literal["", "in", "out"]

AXES: Final = {"XAXIS": 0, "YAXIS": 1, "ZAXIS": 2}
COORDINATES: Final = {**dict.fromkeys(AXES), "DIAMETER": "DIAM", "DIAM": "DIAM", "RADIUS": "RAD", "RAD": "RAD"}
"""Quantities of which `CORTOL` is the tolerance; sizes also have an equivalent tolerance of their own."""
QUANTITIES: Final = {
    "DIAM": Quantity.DIAMETER,
    "RAD": Quantity.RADIUS,
    "WIDTH": Quantity.LENGTH,
    "LENGTH": Quantity.LENGTH,
    "DISTB": Quantity.LENGTH,
    "DISTWRT": Quantity.LENGTH,
    **dict.fromkeys(AXES, Quantity.POSITION),
    **dict.fromkeys(("FLAT", "STRGHT", "CIRLTY", "CYLCTY"), Quantity.FORM),
    **dict.fromkeys(("CRNOUT", "TRNOUT"), Quantity.RUNOUT),
    **dict.fromkeys(("POS", "CONCEN", "COAX", "SYM", "PERP", "PARLEL", "ANGLR", "COMPOS"), Quantity.OTHER),
    **dict.fromkeys(("PROFP", "PROFS", "PROFL"), Quantity.OTHER),
}
"""Quantities by the word of the tolerance, of those that are read. A profile's deviations have a sign."""
PROFILES: Final = ("PROFP", "PROFS", "PROFL")
DISTANCES: Final = ("DISTB", "DISTWRT")
BETWEEN: Final = (*DISTANCES, "LENGTH")
"""Quantities between two features; a length is one that our own files state by `USETOL`."""
ZONES: Final = tuple(
    word
    for word, quantity in QUANTITIES.items()
    if quantity in (Quantity.FORM, Quantity.RUNOUT, Quantity.OTHER) and word not in PROFILES
)
"""Those with one limit, the width of a zone: what is found is never negative."""
STATED: Final = {quantity.name: quantity for quantity in Quantity}
"""Names after `USETOL` in our own files: the quantity, followed by the nominal value and the absolute limits."""
WORDS: Final = ("2D", "3D", "NOMINL", "LIMIT")
VERDICTS: Final[dict[str, Verdict]] = {"INTOL": "in", "OUTOL": "out", "OUTTOL": "out"}


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Limits in mm: relative to the nominal value, or absolute with `absolute`. None: none on that side.

    `nominal` where the tolerance states it itself: of distances.
    """

    what: str
    label: str
    line: int
    lower: float | None = None
    upper: float | None = None
    nominal: float | None = None
    absolute: bool = False

    def limits(self, nominal: float | None) -> tuple[float | None, float | None]:
        """Returns the absolute limits of a characteristic with that nominal value."""
        if self.absolute:
            return self.lower, self.upper
        if nominal is None:
            return None, None
        return tuple(None if one is None else nominal + one for one in (self.lower, self.upper))  # type: ignore[return-value]


@dataclass(frozen=True, slots=True)
class Result:
    """The result that a file states for a tolerance: values in mm, as deviations or as they are, and its verdict.

    `decimals_mm` is what one step of the last decimal is worth.
    """

    what: str
    label: str
    line: int
    values: tuple[float, ...]
    verdict: Verdict
    decimals_mm: float


def what_of(statement: Words) -> tuple[str, tuple[str, ...]] | None:
    """Returns the quantity of a tolerance, and the fields after it; None for words that are not read."""
    fields = statement.fields
    word = fields[0].upper() if fields else ""
    if word == "CORTOL" and len(fields) > 1:
        axis = fields[1].upper()
        return None if axis not in COORDINATES else (COORDINATES[axis] or axis, fields[2:])
    if word == "USETOL" and len(fields) > 1:
        what = unquoted(fields[1]).upper()
        return None if what not in STATED else (what, fields[2:])
    return None if word not in QUANTITIES else (word, fields[1:])


def tolerance_of(statement: Words, settings: Settings) -> Tolerance | str | None:
    """Returns the tolerance of a statement; words about what is wrong with it; None for one that is not read."""
    found = what_of(statement)
    if found is None:
        return None
    what, fields = found
    mm = settings.deg if what == Quantity.ANGLE.name else settings.length_factor(statement.line)
    word = fields[0].upper() if fields else ""
    own = statement.fields[0].upper() == "USETOL"
    if what in DISTANCES and word in ("NOMINL", "LIMIT"):
        fields = fields[1:]
    wanted = 1 if what in ZONES and not own else 3 if own or word == "NOMINL" else 2
    fields = _without_words(fields)
    if len(fields) < wanted:
        return f"has {len(fields)} of {wanted} limits"
    numbers = [
        None if (value := number_of(field, settings, statement.line)) is None else value * mm
        for field in fields[:wanted]
    ]
    if what in ZONES and not own:
        return Tolerance(
            what=what,
            label=statement.label,
            line=statement.line,
            lower=None,
            upper=numbers[0],
            nominal=0.0,
            absolute=True,
        )
    if len(fields) > wanted and is_number(fields[wanted]):
        return f"has more than {wanted} numbers"
    nominal = numbers[0] if wanted == 3 else 0.0 if what in PROFILES else None
    lower, upper = numbers[-2:]
    if lower is not None and upper is not None and lower > upper:
        return f"has a lower limit of {lower:.6g} mm above its upper one of {upper:.6g} mm"
    absolute = own or (what in DISTANCES and word == "LIMIT")
    return Tolerance(
        what=what,
        label=statement.label,
        line=statement.line,
        lower=lower,
        upper=upper,
        nominal=nominal,
        absolute=absolute,
    )


def result_of(statement: Words, settings: Settings) -> Result | str | None:
    """Returns the result of a statement; words about what is wrong with it; None for one that is not read.

    Raises MSR-NUMBER where text stands in place of the value.
    """
    found = what_of(statement)
    if found is None:
        return None
    what, fields = found
    mm = settings.deg if what == Quantity.ANGLE.name else settings.length_factor(statement.line)
    verdict: Verdict = next((VERDICTS[field.upper()] for field in fields if field.upper() in VERDICTS), "")
    texts: list[str] = []
    for field in _without_words(fields):
        if not is_number(field):
            break
        texts.append(field)
    if not texts:
        if fields and fields[0].upper() not in (*VERDICTS, *WORDS, ""):
            number_of(fields[0], settings, statement.line)
        return "has no value"
    if len(texts) > (2 if what in PROFILES else 1):
        return f"has {len(texts)} numbers in place of one, as decimal commas would make: it was left out"
    values = tuple(value * mm for text in texts if (value := number_of(text, settings, statement.line)) is not None)
    step = mm * 10.0 ** -max(decimals_in(text) for text in texts)
    return Result(
        what=what, label=statement.label, line=statement.line, values=values, verdict=verdict, decimals_mm=step
    )


def _without_words(fields: tuple[str, ...]) -> tuple[str, ...]:
    """The fields behind the words that may stand before a tolerance's numbers."""
    begin = 0
    while begin < len(fields) and fields[begin].upper() in WORDS:
        begin += 1
    return fields[begin:]
