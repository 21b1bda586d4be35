"""What was measured in the part's frame, as the frame of one of its set-ups has it, and back.

An error along the normal is the same number in every frame: only places, normals and the order of the features change.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, Integers
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Reading, Touch
from trueloop.domain.judged import Judged
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.loops.turned.correction import Correction
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.seen import Seen


def vectors_in(frame: SetupFrame, vectors: ErrorVectors, profile: Profile) -> ErrorVectors:
    """Part errors in the program's frame; `profile` is the part's."""
    index, along = _places(frame, vectors.feature_index, vectors.arc_length_mm, profile)
    placed = replace(
        vectors,
        feature_index=index,
        arc_length_mm=along,
        nominal_mm=frame.points(vectors.nominal_mm),
        outward_normal=frame.directions(vectors.outward_normal),
        seen=tuple(_seen_in(frame, one, profile) for one in vectors.seen),
    )
    return placed.chosen(np.lexsort((along, index)))


def _seen_in(frame: SetupFrame, seen: Seen, profile: Profile) -> Seen:
    index, along = _places(frame, seen.feature_index, seen.arc_length_mm, profile)
    return replace(seen, feature_index=index, arc_length_mm=along)


def _places(frame: SetupFrame, index: Integers, along_mm: Array, profile: Profile) -> tuple[NDArray[np.intp], Array]:
    """Feature and arc length of places in the program's frame: counted from the other end where Z points backwards."""
    if not frame.backwards:
        return index.astype(np.intp), along_mm
    lengths_mm = np.array([feature.length_mm for feature in profile.features])
    return (len(lengths_mm) - 1 - index).astype(np.intp), lengths_mm[index] - along_mm


def index_in(frame: SetupFrame, index: int, features: int) -> int:
    """Where one of the part's features stands in the program's frame, of so many `features`."""
    return features - 1 - index if frame.backwards else index


def touch_in(frame: SetupFrame, touch: Touch) -> Touch:
    """A touch where the program has it; its error along the normal is the same."""
    measured = None if touch.measured_mm is None else frame.point(touch.measured_mm)
    return replace(touch, nominal_mm=frame.point(touch.nominal_mm), measured_mm=measured)


def reading_in(frame: SetupFrame, reading: Reading, other: str) -> Reading | None:
    """A reading of named features with its place as the program has it; `other` names the feature it counts from.

    None for a length that counts from the part's zero, where that is not the program's.
    """
    if reading.quantity is Quantity.LENGTH and not other and frame.zero_at_z_mm != 0.0:
        return None
    *across, along_mm = reading.place_mm or (0.0,)
    return replace(reading, place_mm=(*across, frame.z_mm(along_mm)) if reading.place_mm else ())


def ends_in(frame: SetupFrame, prescribed: Mapping[str, EndConditions]) -> dict[str, EndConditions]:
    """What is prescribed at the ends of features, by name."""
    return {name: ends.reversed if frame.backwards else ends for name, ends in prescribed.items()}


def characteristics_in(frame: SetupFrame, asked: Sequence[Characteristic]) -> tuple[Characteristic, ...]:
    """Characteristics with the place of a diameter as the program has it."""
    return tuple(one if one.at_z_mm is None else replace(one, at_z_mm=frame.z_mm(one.at_z_mm)) for one in asked)


def judged_on_part(correction: Correction, asked: Sequence[Characteristic]) -> Correction:
    """The correction with its characteristics placed as the part has them; `asked` are those of the part."""
    places = {one.name: one.at_z_mm for one in asked}

    def placed(one: Judged) -> Judged:
        of = one.characteristic
        return replace(one, characteristic=replace(of, at_z_mm=places.get(of.name, of.at_z_mm)))

    judged = tuple(map(placed, correction.characteristics))
    return replace(correction, characteristics=judged, record=replace(correction.record, characteristics=judged))
