"""A part as a diagnosis of causes takes it: errors at its points by who saw them, and what it was made under."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum

from trueloop.diagnosis.features.feature_error import FeatureError, FeaturePlace
from trueloop.diagnosis.features.seen_points import SeenPoints


class SeenBy(StrEnum):
    """The device that measured an error.

    The machine's probe sees what the process did, corrected by the model of the machine; a measuring machine or a gauge
    sees what the machine did too.
    """

    MACHINE = "machine"
    CMM = "CMM"


@dataclass(frozen=True)
class SeenPart:
    """One part, `order` among the parts as they were cut.

    `points` and the `errors` of features from them, by who saw them. `setting` counts settings of each tool by its
    name: it rises where the tool was set anew. `minutes_in_cut` of each tool's edge, `depth_of_cut_mm` on the radius by
    feature; what is not known is missing. `temperatures` are those while it was cut. `correction_mm` is what
    corrections in force took off a feature's error, by (feature, kind), as recorded. `standard`: a calibrated part, on
    which nothing was cut; its errors are actual less calibrated.
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


@dataclass(frozen=True)
class SeenSeries:
    """Parts of one type in cutting order, and where their features are."""

    features: Mapping[str, FeaturePlace]
    parts: tuple[SeenPart, ...]
