"""Content of the statements of a DMIS file, by run and part: nominals, actuals, tolerances, results."""

from collections import Counter
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Final, Literal

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Vector
from trueloop.formats.inspections.dmis.features import Feature
from trueloop.formats.inspections.dmis.words import Settings, Words, decimals_in, is_number, key_of, number_of, unquoted
from trueloop.formats.inspections.measured_file import Remark

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
    for word in _without_words(fields):
        if not is_number(word):
            break
        texts.append(word)
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


@dataclass(frozen=True)
class Heading:
    """Statements of a file about a run before its results; empty: not stated."""

    file: str = ""
    part: str = ""
    serial: str = ""
    revision: str = ""
    device: str = ""
    operator: str = ""
    date: tuple[int, int, int] | None = None
    time: tuple[int, int, int] = (0, 0, 0)

    @property
    def moment(self) -> datetime | None:
        """Returns date and time as the measuring machine's clock showed them; their zone is not stated."""
        return None if self.date is None else datetime(*self.date, *self.time)

    def named(self, what: str, text: str) -> "Heading":
        """Returns the heading with a text for one of its names."""
        return Heading(**{**vars(self), what: text})


@dataclass(frozen=True, slots=True)
class Actual:
    """A measured feature, the nominal one and the tolerances in force at its statement, and when it was reported."""

    feature: Feature
    nominal: Feature | None
    limits: dict[str, Tolerance]
    moment: datetime | None


@dataclass(frozen=True, slots=True)
class RunResult:
    """A result, the keys of the features that it is about (of a distance two), and the tolerance of its label."""

    result: Result
    features: tuple[str, ...]
    moment: datetime | None
    labelled: Tolerance | None


@dataclass
class Run:
    """One run of one part, while it is read."""

    heading: Heading
    frame: Literal["part", "device"] = "part"
    nominals: dict[str, Feature] = field(default_factory=dict)
    actuals: list[Actual] = field(default_factory=list)
    tolerances: dict[str, dict[str, Tolerance]] = field(default_factory=dict)
    by_label: dict[str, Tolerance] = field(default_factory=dict)
    found: list[RunResult] = field(default_factory=list)
    loose: list[tuple[str, Vector, Vector | None]] = field(default_factory=list)
    stated: set[str] = field(default_factory=set)

    @property
    def measured(self) -> bool:
        """Returns whether anything was measured in it."""
        return bool(self.actuals or self.found or self.loose)

    def next(self, heading: Heading) -> "Run":
        """Returns a new run in which the nominals and tolerances stated so far remain in force."""
        return Run(
            heading=heading,
            frame=self.frame,
            nominals=dict(self.nominals),
            actuals=[],
            tolerances=_copied(self.tolerances),
            by_label=dict(self.by_label),
        )

    def joined(self, other: "Run") -> "Run":
        """Returns the run with what a later run adds to it."""
        return Run(
            heading=self.heading,
            frame=self.frame,
            nominals={**self.nominals, **other.nominals},
            actuals=[*self.actuals, *other.actuals],
            tolerances=_copied({**self.tolerances, **other.tolerances}),
            by_label={**self.by_label, **other.by_label},
            found=[*self.found, *other.found],
            loose=[*self.loose, *other.loose],
            stated=self.stated | other.stated,
        )


@dataclass
class Notes:
    """Remarks about a file: some with their line, others counted by kind, with the first line of each."""

    remarks: list[Remark] = field(default_factory=list)
    counted: Counter[str] = field(default_factory=Counter)
    first: dict[str, int] = field(default_factory=dict)

    def say(self, text: str, line: int) -> None:
        """Adds a remark on a line."""
        self.remarks.append(Remark(text, line))

    def count(self, kind: str, line: int) -> None:
        """Counts one more of a kind, in words that a number can follow."""
        self.counted[kind] += 1
        self.first.setdefault(kind, line)

    def all(self) -> tuple[Remark, ...]:
        """Returns all remarks in the order of their lines."""
        counted = [
            Remark(kind if number == 1 else f"{kind}: {number} times, first here", self.first[kind])
            for kind, number in self.counted.items()
        ]
        return tuple(sorted([*self.remarks, *counted], key=lambda remark: remark.line or 0))


def shared(limits: Tolerance, features: tuple[str, ...], run: Run) -> None:
    """Puts a tolerance where results of these features, or of its own label, find it."""
    run.by_label[key_of(limits.label)] = limits
    for feature in features:
        run.tolerances.setdefault(feature, {})[limits.what] = limits


def _copied(tolerances: dict[str, dict[str, Tolerance]]) -> dict[str, dict[str, Tolerance]]:
    return {feature: dict(each) for feature, each in tolerances.items()}


def with_time(heading: Heading, numbers: tuple[int, ...]) -> Heading:
    """Returns the heading at another time of its day. Raises ValueError for anything that is not a time."""
    hour, minute, second = (*numbers, 0)[:3]
    datetime(2000, 1, 1, hour, minute, second)
    return replace(heading, time=(hour, minute, second))


def with_date(heading: Heading, year: int, month: int, day: int) -> Heading:
    """Returns the heading on another day, whose time is not known yet. Raises ValueError for anything that is not a
    date.
    """
    datetime(year, month, day)
    return replace(heading, date=(year, month, day), time=(0, 0, 0))
