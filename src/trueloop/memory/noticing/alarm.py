"""The changes noticed of one part, with their probabilities and possible causes."""

from dataclasses import dataclass
from enum import StrEnum


class What(StrEnum):
    """The property of a part that differs from the prediction of earlier parts."""

    LEVEL = "level"  # the whole part moved by (dX, dZ)
    SHAPE = "shape"  # what is left of it
    DRIFT = "drift"  # it changes from part to part
    GAIN = "gain"  # the share of the correction that arrived
    MEMORY_GAIN = "memory gain"  # of that part of the correction that came from memory


@dataclass(frozen=True)
class LeftOut:
    """A touch that all others contradict: its place in the order given, its name, and by how many standard
    deviations it differs from what the others say of it, positive = more material.
    """

    index: int
    point: str
    deviations: float


@dataclass(frozen=True)
class Alarm:
    """One test that failed. `probability` is that of such a result by chance, `says` states what may have happened."""

    what: What
    probability: float
    says: str


@dataclass(frozen=True)
class PartChanges:
    """The changes noticed of one part. `alarms` has the likeliest first; it is empty where nothing is unusual.

    `level_mm` is (dX, dZ) by which the part's error lies beside the prediction, X a radius; `gain` the share of the
    correction that arrived, with its standard uncertainty, None without a correction. `quarantine`: nothing may be
    learned from this record until a person has looked, because what was corrected is not what was recorded.
    """

    alarms: tuple[Alarm, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    level_mm: tuple[float, float] | None = None
    gain: float | None = None
    gain_u: float | None = None
    memory_gain: float | None = None
    quarantine: bool = False
    notes: tuple[str, ...] = ()

    @property
    def own_fit(self) -> bool:
        """Returns whether today's part is to be corrected by its own touches alone."""
        return bool(self.alarms)
