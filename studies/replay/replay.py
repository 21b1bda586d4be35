"""What memory would have predicted of parts that are made already: each from those before it and its own touches."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.errors import Code, TrueloopError
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.memory.edge.predict import expect
from trueloop.memory.made_part import MadePart

HALF_WIDTH: Final = 1.96
"""Of the band that holds 95 %, in standard deviations."""


class Predicted(NamedTuple):
    """The finish error had nothing been corrected, and the half width of its 95 % band: (n,) each, mm."""

    error_mm: Array
    half_band_mm: Array


@by_content
@dataclass(frozen=True)
class Replayed:
    """One part, as it was made, with what was predicted of it from `touches` of its touches.

    `predicted` is at the places of the part's finish inspection; `own_fit`: by the part's own touches, not by memory.
    """

    part: MadePart
    touches: int
    predicted: Predicted
    own_fit: bool

    @property
    def left_mm(self) -> Array:
        """What the prediction would have left had it been the correction: E = F + C less the prediction, (n,)."""
        uncorrected = self.part.uncorrected_mm
        assert uncorrected is not None
        return uncorrected - self.predicted.error_mm

    @property
    def inside(self) -> float:
        """Share of places where that is inside the band."""
        return float(np.mean(np.abs(self.left_mm) <= self.predicted.half_band_mm))


def replay(
    parts: Sequence[MadePart],
    own_fit: Callable[[MadePart], Predicted],
    options: MemoryOptions,
    touches: Callable[[MadePart], Sequence[int]] | None = None,
) -> tuple[Replayed, ...]:
    """Inspected parts in cutting order, each predicted before it is learned from.

    `touches` gives the places, among a part's touches, of those that are used; None: all. All are used where memory
    refuses to predict from fewer: of the first part of the edge, and where contact angles are new. `own_fit` gives what
    is predicted where memory says so. A part without a finish inspection or without a known correction is learned from,
    but not predicted.
    """
    learned: list[MadePart] = []
    done = []
    for part in parts:
        taken = part
        if touches is not None and learned:
            taken = replace(part, semifinish=part.semifinish.chosen(touches(part)))
        if part.uncorrected_mm is not None:
            one = _replayed(learned, part, taken, own_fit, options)
            taken = part if one.touches == len(part.semifinish.error_mm) else taken
            done.append(one)
        learned.append(taken)
    return tuple(done)


def _replayed(
    learned: Sequence[MadePart],
    part: MadePart,
    taken: MadePart,
    own_fit: Callable[[MadePart], Predicted],
    options: MemoryOptions,
) -> Replayed:
    assert part.finish is not None
    try:
        found = expect(learned, _unfinished(taken), part.finish, options)
    except TrueloopError as refused:
        if refused.code not in {Code.MEM_UNSEEN, Code.MEM_SETTING, Code.MEM_TYPE} or taken is part:
            raise
        return _replayed(learned, part, part, own_fit, options)
    used = len(taken.semifinish.error_mm)
    if found.own_fit:
        return Replayed(part, used, own_fit(part), True)
    half_band = HALF_WIDTH * np.sqrt(np.diag(found.covariance_mm2))
    return Replayed(part, used, Predicted(found.mean_mm, half_band), False)


def _unfinished(part: MadePart) -> MadePart:
    return replace(part, finish=None, correction_mm=None, from_memory_mm=None)
