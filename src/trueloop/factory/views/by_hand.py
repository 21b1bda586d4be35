"""A part that a person measures and corrects, without an order: what to measure of it, and what to cut it with."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from trueloop.factory.views.uploads import Remarked

Way = Literal["wear", "offsets", "corrected"]
"""How a correction is carried out: a wear number entered, a program that sets offsets, or the corrected program."""
About = Literal["dialect", "unit", "parameters", "lines", "outline", "accept_unknown_words"]
"""A missing statement, by the key of the request that gives it."""


@dataclass(frozen=True)
class SizeToMeasure:
    """A size of the measuring sheet by its number there; lengths in mm, an angle in degrees; z None: at no one place.

    `other` is the feature that a length counts from, "" for the part's zero. `tolerance_name`: a tolerance is stated
    under it for all sizes with this name; "" where the drawing has limits.
    """

    number: int
    name: str
    quantity: str
    feature: str
    other: str
    at_z_mm: float | None
    nominal: float
    lower_limit: float | None
    upper_limit: float | None
    tolerance_name: str


@dataclass(frozen=True)
class Unstated:
    """A statement that is needed to read the program; `choices` where there are some, or names of parameters."""

    about: About
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class MadeBefore:
    """A correction of the program that is in the store, and the ways in which it may have cut the part.

    `tool` is the edge that it is of, as programs call it; "" where neither job nor program states it.
    """

    id: str
    made_at: str
    serial: str
    ways: tuple[Way, ...]
    tool: str = ""


@dataclass(frozen=True)
class Picture:
    """A picture (SVG) for a wide screen and for a telephone; `said` is what it shows, in words."""

    wide: str
    narrow: str
    said: str


@dataclass(frozen=True)
class PartByHand:
    """The part that a program cuts. Where it cannot be read, `problem` says why, and `question` what helps.

    Values are typed in `unit`, the program's; `tools` are those that cut. `tolerances` are those of the last correction
    of the program, by `tolerance_name`.
    """

    name: str
    dialect: str = ""
    unit: Literal["mm", "inch"] = "mm"
    features: tuple[str, ...] = ()
    tools: tuple[str, ...] = ()
    sizes: tuple[SizeToMeasure, ...] = ()
    notes: tuple[str, ...] = ()
    picture: Picture | None = None
    question: Unstated | None = None
    problem: Remarked | None = None
    made_before: tuple[MadeBefore, ...] = ()
    tolerances: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class FileMade:
    """A file that was made, to be had at `uploads/{sha256}/file` for a day."""

    name: str
    sha256: str


@dataclass(frozen=True)
class WayToCut:
    """One way to carry out a correction, instead of the others. `enter`: at the control, "" for nothing.

    `blocks` enter it from a program; `program` is the one to run, by the name of a file; `given`: the one that was
    handed over, as it is. `leaves`: what this way leaves, in words, where that is not the prediction.
    """

    by: Way
    enter: str
    blocks: tuple[str, ...]
    program: str
    given: bool
    leaves: str


@dataclass(frozen=True)
class FeatureExpected:
    """A feature before and after: worst errors and expanded uncertainty (95 %), µm; None of what was not measured."""

    feature: str
    touches: int
    before_um: float | None
    expected_um: float
    expanded_u_um: float
    correction: str


@dataclass(frozen=True)
class CorrectedByHand:
    """A correction by a person's readings: one of `ways` is to be taken, the first is the recommended one.

    `kept`: whether the part is in the store, so that the next correction knows this one.
    """

    id: str
    kept: bool
    headline: str
    ways: tuple[WayToCut, ...]
    features: tuple[FeatureExpected, ...]
    notes: tuple[str, ...]
    remarks: tuple[Remarked, ...]
    picture: Picture
    files: tuple[FileMade, ...]
