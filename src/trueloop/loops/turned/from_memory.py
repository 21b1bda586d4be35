"""The prediction of a part by memory before its finish cut, kept beside the correction so that it can be judged
afterwards.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, by_content
from trueloop.domain.option import MemoryUse
from trueloop.domain.tool import Edge
from trueloop.geometry.profile import Profile
from trueloop.memory.expected import Expected
from trueloop.statistics import rms
from trueloop.wording import wording


@by_content
@dataclass(frozen=True)
class FromMemory:
    """The prediction of one part by earlier parts of an edge, and its use.

    `edge` in words. `applied`: the correction of the features `features`, by index, is by memory and today's touches
    `points`; else it is by these touches alone. `keep` are the touches, by name, that are enough for the next part
    and for judging it. `expected` is the prediction, at its contact angles; None: none was made. `alarms` say how
    today's touches contradict earlier parts; then these are not used.
    """

    edge: str
    use: MemoryUse
    applied: bool
    features: tuple[int, ...] = ()
    points: tuple[str, ...] = ()
    keep: tuple[str, ...] = ()
    expected: Expected | None = None
    alarms: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def taken_off_mm(self, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Array:
        """Returns the share from memory of what a correction of weight 1 takes off at places, (n,): without a touch of
        today.

        Positive where material is taken off; zero where the correction is not by memory.
        """
        taken, known = np.zeros(len(feature_index)), self.expected
        if not self.applied or known is None:
            return taken
        for index in self.features:
            rows = feature_index == index
            taken[rows] = known.along(known.weight * known.memory_mm, index, arc_length_mm[rows])
        return taken

    def share(self, feature: int) -> float:
        """Returns the share of one feature's correction that is from memory, from 0 to 1: its RMS over both RMS."""
        if not self.applied or self.expected is None or feature not in self.features:
            return 0.0
        known, rows = self.expected, self.expected.rows(feature)
        memory, whole = known.memory_mm[rows], known.mean_mm[rows]
        from_memory, from_touches = rms(memory), rms(whole - memory)
        return from_memory / (from_memory + from_touches) if from_memory + from_touches > 0.0 else 0.0

    def words(self, profile: Profile) -> tuple[str, ...]:
        """Describes the shares of memory and of today's touches, how many of these suffice, and alarms."""
        if self.expected is None and not self.edge:
            return self.notes
        if self.expected is None:
            return tuple(wording("Memory of edge {edge}: {note}", edge=self.edge, note=note) for note in self.notes)
        head = wording("Memory of edge {edge}, inspected parts: {n}.", edge=self.edge, n=self.expected.parts)
        return (head, *self._shares(profile), *self._alarmed(), *self._enough(), *self.notes)

    def _shares(self, profile: Profile) -> tuple[str, ...]:
        if not self.applied:
            return ()
        touches = len(self.points)
        return tuple(
            wording(
                "{feature}: {memory:.0f} % of the correction is from memory, {touched:.0f} % from {n} touches.",
                feature=profile.names[i],
                memory=100.0 * (share := self.share(i)),
                touched=100.0 * (1.0 - share),
                n=touches,
            )
            for i in self.features
        )

    def _alarmed(self) -> tuple[str, ...]:
        if not self.alarms:
            if self.applied:
                return ()
            return (wording("The correction is by today's touches alone; memory gives its band."),)
        own = wording(
            "Today's touches contradict earlier parts: the correction is by today's {n} touches alone. Look "
            "what happened, and touch all points before cutting.",
            n=len(self.points),
        )
        return (own, *self.alarms)

    def _enough(self) -> tuple[str, ...]:
        if self.alarms or self.expected is None or not self.points:
            return ()
        enough = wording(
            "Touches that would have been enough: {enough} of {n}.",
            enough=self.expected.enough_touches,
            n=len(self.points),
        )
        if len(self.keep) == len(self.points):
            return (enough,)
        kept = wording("To touch on the next part, as a check too: {points}.", points=", ".join(self.keep))
        return (enough, kept)


def edge_words(edge: Edge | None) -> str:
    """Names an edge by its tool, insert and corner."""
    return "" if edge is None else " ".join(text for text in edge.identity if text)
