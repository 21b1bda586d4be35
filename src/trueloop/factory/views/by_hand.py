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
    """A statement needed to read a program, `choices` or names of parameters; `program` is its set-up, from 0."""

    about: About
    choices: tuple[str, ...] = ()
    program: int = 0


@dataclass(frozen=True)
class MadeBefore:
    """A correction of the program that is in the store, and the ways in which it may have cut the part.

    `tool` is the edge that it is of, as programs call it; "" where neither job nor program states it. Of several tools
    or set-ups it stands for the corrections of all that were made from one measurement, carried out as they state: it
    has no ways, and the id of the first.
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
class ProgramToRun:
    """The tools and the program of a part that several tools cut, by set-up: `entered` at the control, in words, with
    `blocks` that enter it from a program; the program to be run then, `given` where it is the one handed over.
    """

    setup: str
    entered: tuple[str, ...]
    blocks: tuple[str, ...]
    program: str
    given: bool


@dataclass(frozen=True)
class FeatureExpected:
    """A feature before and after: worst errors and U (95 %), µm; None: not measured. `cut_by`: its tool and set-up."""

    feature: str
    touches: int
    before_um: float | None
    expected_um: float
    expanded_u_um: float
    correction: str
    cut_by: str = ""


@dataclass(frozen=True)
class CorrectedByHand:
    """A correction by a person's readings: one of `ways` is to be taken, the first is the recommended one. Of several
    tools or set-ups it has none, and all of `to_run` is to be done.

    `kept`: whether the part is in the store, so that the next correction knows this one.
    """

    id: str
    kept: bool
    headline: str
    ways: tuple[WayToCut, ...]
    features: tuple[FeatureExpected, ...]
    notes: tuple[str, ...]
    remarks: tuple[Remarked, ...]
    pictures: tuple[Picture, ...]
    files: tuple[FileMade, ...]
    to_run: tuple[ProgramToRun, ...] = ()


@dataclass(frozen=True)
class MilledFeatureShown:
    """A feature that a program mills, as the program has it, mm, with what cuts it.

    `radius_at_control`: the radius of its tool stands at the control; else in the path.
    """

    name: str
    kind: str
    at_mm: tuple[float, float, float]
    size_mm: float
    tool: str
    work_offset: str
    side: str
    radius_at_control: bool


@dataclass(frozen=True)
class MilledSize:
    """A size or coordinate that a feature shows: its `quantity` is diameter, width, x, y or z."""

    number: int
    name: str
    feature: str
    quantity: str
    nominal_mm: float


@dataclass(frozen=True)
class MilledPart:
    """Features that a program mills, in its `unit`; `problem`: why it cannot be read, `question`: the remedy."""

    name: str
    dialect: str = ""
    unit: Literal["mm", "inch"] = "mm"
    features: tuple[MilledFeatureShown, ...] = ()
    sizes: tuple[MilledSize, ...] = ()
    notes: tuple[str, ...] = ()
    question: Unstated | None = None
    problem: Remarked | None = None


@dataclass(frozen=True)
class Expectation:
    """Deviation of a size or coordinate from its nominal value, µm: on the last part, None where it was not measured,
    and expected of the next one unchanged and with the numbers entered, ± at 95 %.
    """

    name: str
    measured_um: float | None
    unchanged_um: float
    entered_um: float
    expanded_u_um: float
    probability_in: float | None


@dataclass(frozen=True)
class MilledEntries:
    """The numbers to enter at the control before the next part, in words; `anything`: there are some. `kept`: whether
    the part is in the store with what was measured of it.
    """

    entries: tuple[str, ...]
    rms: str
    expected: tuple[Expectation, ...]
    notes: tuple[str, ...]
    anything: bool
    files: tuple[FileMade, ...] = ()
    kept: bool = False
