"""What memory would have made of the ten worn-nose parts of [6811], in the order of their numbers.

`python -m studies.nist_memory` writes `replay.csv`, `as-first.csv` and `replay.html` to out/memory. NIST's correction C
is rebuilt as [6811 §3.2] says and added to the error of its finish cut: E = F + C, had nothing been corrected.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Final

import numpy as np

from scripts.nist_bands import PUBLISHED
from scripts.nist_parts import NistPart, parts
from scripts.nist_table import corrected
from studies.replay.replay import Predicted, Replayed, replay
from trueloop.arrays import Flags
from trueloop.loops.turned.deviations import cut_errors
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.memory.made_part import MadePart
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.touches.touches import Gauging, error_vectors

ARCS: Final = ("dome", "knob")
THREE: Final = (2, 9, 16)
"""The 3rd, 10th and 17th of the twenty touches of an arc; all others with them."""

FOLDER: Final = Path(__file__).parents[1] / "out" / "memory"


@cache
def worn_nose_parts() -> tuple[NistPart, ...]:
    """MODBAS2 first, then PIECS11."""
    return tuple(part for part in parts() if part.family.name in {"MODBAS2", "PIECS11"})


@cache
def made_parts() -> tuple[MadePart, ...]:
    """All ten."""
    return tuple(made_part(part, float(k)) for k, part in enumerate(worn_nose_parts()))


def made_part(part: NistPart, order: float) -> MadePart:
    """All touches, and NIST's correction as [6811 §3.2] made it: lines and splines, positive where taken off."""
    touches = error_vectors(part.profile, part.semifinish, Gauging())
    published = touches.error_mm - fit_profile(part.profile, touches, PUBLISHED).residual_mm
    finish = np.array([touch.error_mm for touch in part.finish], dtype=np.float64)

    places = cut_errors(part.profile, touches)
    return MadePart(
        part.family.name, part.number, "as reported", order, places, replace(places, error_mm=finish), published
    )


def on_arc(part: NistPart) -> Flags:
    """Which of a part's points lie on its dome or knob."""
    return np.array([touch.feature in ARCS for touch in part.semifinish])


@cache
def fitted(serial: str) -> Predicted:
    """What today's fit of the part's own twenty touches says: the correction without memory, and its band."""
    part = next(part for part in worn_nose_parts() if part.number == serial)
    found, chosen = corrected(part).prediction, on_arc(part)
    return Predicted((found.before_mm - found.after_mm)[chosen], found.budget.expanded_u_mm[chosen])


def own_fit(part: MadePart) -> Predicted:
    """Today's fit of a part."""
    return fitted(part.serial)


@cache
def replayed(touches: Sequence[int] | None = None) -> tuple[Replayed, ...]:
    """The ten parts in order, on their arcs; `touches` of the arc, None: all."""
    return replayed_parts(made_parts(), touches)


def replayed_parts(parts: Sequence[MadePart], touches: Sequence[int] | None = None) -> tuple[Replayed, ...]:
    """The same of any parts."""
    some = None if touches is None else partial(some_of_arc, touches=touches)
    return on_arcs(replay(parts, own_fit, MemoryOptions(), some))


@cache
def arcs() -> tuple[MadePart, ...]:
    """The ten parts as their arcs alone."""
    return tuple(map(_arc_of, made_parts()))


def some_of_arc(part: MadePart, touches: Sequence[int]) -> Sequence[int]:
    """Some touches of a part's arc, and all others, by position."""
    arc = np.isin(part.semifinish.feature, ARCS)
    chosen = np.flatnonzero(arc)[[k for k in touches if k < np.count_nonzero(arc)]]
    return [int(k) for k in np.sort(np.append(np.flatnonzero(~arc), chosen))]


def on_arcs(replays: Sequence[Replayed]) -> tuple[Replayed, ...]:
    """What was predicted of parts, on their arcs alone; the numbers of touches are those of the arcs."""
    return tuple(map(_on_arc, replays))


def _on_arc(one: Replayed) -> Replayed:
    made, finish = _arc_of(one.part), one.part.finish
    assert finish is not None
    touches = one.touches - len(one.part.semifinish) + len(made.semifinish)
    rows = np.flatnonzero(np.isin(finish.feature, ARCS))
    if one.own_fit:  # which is of the arc alone
        return Replayed(made, touches, one.predicted, True)
    predicted = Predicted(one.predicted.error_mm[rows], one.predicted.half_band_mm[rows])
    return Replayed(made, touches, predicted, False)


def _arc_of(part: MadePart) -> MadePart:
    assert part.finish is not None and part.correction_mm is not None
    touched, found = (np.flatnonzero(np.isin(of.feature, ARCS)) for of in (part.semifinish, part.finish))
    semifinish, finish = part.semifinish.chosen(touched), part.finish.chosen(found)
    return replace(part, semifinish=semifinish, finish=finish, correction_mm=part.correction_mm[found])


@cache
def as_first() -> tuple[Replayed, ...]:
    """Each PIECS11 part as if it had been the first of its type, after the four MODBAS2, at the angles seen by then."""
    modbas2, piecs11 = made_parts()[:4], made_parts()[4:]
    seen = max(np.max(part.semifinish.contact_angle_rad) for part in modbas2)
    each = (_up_to_angle(replace(part, order=float(len(modbas2))), seen + SEEN_RAD) for part in piecs11)
    return on_arcs([replay([*modbas2, part], own_fit, MemoryOptions())[-1] for part in each])


SEEN_RAD: Final = np.radians(2.2)
"""An angle beyond the outermost touch by half of what touches are apart still counts as seen."""


def _up_to_angle(part: MadePart, angle_rad: float) -> MadePart:
    assert part.finish is not None and part.correction_mm is not None
    seen = part.finish.contact_angle_rad <= angle_rad
    return replace(
        part,
        semifinish=part.semifinish.chosen(np.flatnonzero(part.semifinish.contact_angle_rad <= angle_rad)),
        finish=part.finish.chosen(np.flatnonzero(seen)),
        correction_mm=part.correction_mm[seen],
    )


def main() -> None:
    """Writes the replay and says what it would have left."""
    from studies.replay.files import write_replay

    fits = tuple(Replayed(part, len(part.semifinish), own_fit(part), True) for part in arcs())
    memory = {"20 touches": replayed(), "3 touches": replayed(THREE)}
    written = write_replay(FOLDER, "Ten parts of one worn edge", SOURCE, fits, memory, as_first())
    print("\n".join(f"written: {path}" for path in written))


SOURCE: Final = (
    "NISTIR 6811, Tables 8 to 11: four MODBAS2 and six PIECS11 parts, touched after the semi-finish cut and again "
    "after a finish cut that NIST had corrected. NIST's correction is rebuilt as the report describes it and added to "
    "what its finish cut left; less the prediction, that is what the prediction would have left in that metal."
)

if __name__ == "__main__":
    main()
