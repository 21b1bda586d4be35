"""Content of the statements of a DMIS file, by run and part: nominals, actuals, tolerances, results."""

from collections import Counter
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Literal

from trueloop.domain.inspection import Vector
from trueloop.formats.inspections.dmis.features import Feature
from trueloop.formats.inspections.dmis.tolerances import Result, Tolerance
from trueloop.formats.inspections.dmis.words import key_of
from trueloop.formats.inspections.measured_file import Remark


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
