"""Causes as data: how one shows on features, to whom, and from part to part; its remedy [4773 §4.2, Fig. 11]."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum

from trueloop.arrays import Array
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError, FeaturePlace, SeenPoints
from trueloop.errors import Finding


class SeenBy(StrEnum):
    """The device of an error: the machine's probe sees the process alone, a measuring machine all of it."""

    MACHINE = "machine"
    CMM = "CMM"


@dataclass(frozen=True)
class SeenPart:
    """One part, `order` among the parts as they were cut.

    `points` and the `errors` of features from them, by who saw them. `setting` counts settings of each tool by its
    name: it rises where the tool was set anew. `minutes_in_cut` of each tool's edge, `depth_of_cut_mm` on the radius by
    feature; what is not known is missing. `temperatures` are those while it was cut. `correction_mm` is what
    corrections of sizes took off a feature's error, by (feature, kind), as recorded; `taken_off_mm` what the program
    that ran took off at the points of each device, (n,), `carried_mm` the error of the machine that its model tells of
    the cut, which the surface carries there. `standard`: a calibrated part, on which nothing was cut; its errors are
    actual less calibrated.
    """

    serial: str
    order: int
    errors: Mapping[SeenBy, tuple[FeatureError, ...]]
    points: Mapping[SeenBy, SeenPoints] = field(default_factory=dict)
    at: datetime | None = None
    setting: Mapping[str, int] = field(default_factory=dict)
    minutes_in_cut: Mapping[str, float] = field(default_factory=dict)
    depth_of_cut_mm: Mapping[str, float] = field(default_factory=dict)
    temperatures: Mapping[str, float] = field(default_factory=dict)
    correction_mm: Mapping[tuple[str, str], float] = field(default_factory=dict)
    standard: bool = False
    taken_off_mm: Mapping[SeenBy, Array] = field(default_factory=dict)
    carried_mm: Mapping[SeenBy, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class SeenSeries:
    """Parts of one type in cutting order, and where their features are."""

    features: Mapping[str, FeaturePlace]
    parts: tuple[SeenPart, ...]


class Over(StrEnum):
    """How a cause goes over the parts of a series."""

    CONSTANT = "constant"  # the same on all parts
    SETTING = "setting"  # the same until the tool is set anew
    WEAR = "wear"  # grows with the minutes that the edge has cut
    TEMPERATURE = "temperature"  # follows a temperature
    DEPTH = "depth"  # in proportion to the depth of cut
    SCATTER = "scatter"  # another value on every part
    STEP = "step"  # another value from some part on, though nothing was set


@dataclass(frozen=True)
class Sign:
    """How a cause shows: on one kind of error, to whom, over the parts.

    `alike`: all features of a tool have one size, else each its own. `needed`: the cause always shows so, else it may.
    """

    kind: ErrorKind
    seen_by: tuple[SeenBy, ...]
    over: tuple[Over, ...]
    alike: bool = False
    needed: bool = True


@dataclass(frozen=True)
class Cause:
    """One cause. `key` is a name without spaces, `name` that for people; `prior` its share beforehand.

    `remedy` says what to do, `section` where the source says it, `decided_by` which measurement would tell it from
    others. `on_standard_part`: a calibrated part shows it too, on which nothing was cut. `of_tool`: it is one tool's,
    so that each tool is asked for.
    """

    key: str
    name: str
    signs: tuple[Sign, ...]
    prior: float
    remedy: str
    section: str
    decided_by: str
    on_standard_part: bool = False
    of_tool: bool = False


@dataclass(frozen=True)
class Candidate:
    """One cause on some features: `probability` that it acts, `size_mm` ± `standard_u_mm` if it does.

    `supports` and `contradicts` are evidence in words. `tool` is the one that it concerns, where it is one tool's. The
    size is what it leaves on the feature and the part that show it most, as an error there.
    """

    cause: Cause
    features: tuple[str, ...]
    probability: float
    size_mm: float
    standard_u_mm: float
    supports: tuple[str, ...] = ()
    contradicts: tuple[str, ...] = ()
    tool: str = ""


@dataclass(frozen=True)
class Diagnosis:
    """The causes of a series: candidates, likeliest first; `sound` is the probability that nothing acts.

    `hypotheses` are sets of causes by their keys with probabilities; () is none. `decide` says in words which
    measurement would tell apart what is left.
    """

    candidates: tuple[Candidate, ...]
    hypotheses: tuple[tuple[tuple[str, ...], float], ...]
    sound: float
    decide: tuple[str, ...] = ()
    gain: float = 1.0
    findings: tuple[Finding, ...] = ()
