"""The inputs of one edge of a set-up: its own contour in the frame of its program, what was measured of it,
and nothing of the others.

Fits, offsets, nose models and bands of two edges share nothing but the frame of the part. An error along the normal is
the same number in every frame: only places, normals and the order of the features change.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, Integers
from trueloop.domain.characteristic import Characteristic, Judged, Quantity
from trueloop.domain.inspection import Reading, Touch
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART, SetupFrame
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.nc.match.own_contour import OwnContour
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.options import Options
from trueloop.turned.readings.vectors import own_seen
from trueloop.turned.readings.vectors import shared_words as readings_words
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.wording import all_of, wording

T = TypeVar("T")


def own_inputs(inputs: Inputs, own: OwnContour | None) -> Inputs | None:
    """Returns the inputs of this edge's contour as `inputs_of_edge`; None where nothing of it was measured."""
    mine = inputs_of_edge(inputs, own)
    return mine if own is None or len(mine.touches.point) else None


def inputs_of_edge(inputs: Inputs, own: OwnContour | None) -> Inputs:
    """Returns the inputs of this edge's contour from those of the whole part, with this edge's tool.

    All of them for the only tool of a job (None), which cuts the whole profile. Of readings of features that several
    edges cut it has what they state of its own. Characteristics of these are left out, which a note says.
    """
    if own is None:
        return inputs
    touches = vectors_of_edge(inputs.touches, own, inputs.profile)
    finish = None if inputs.finish_touches is None else vectors_of_edge(inputs.finish_touches, own, inputs.profile)
    asked = tuple(characteristic for characteristic in inputs.characteristics if _is_own(characteristic, own, inputs))
    return replace(
        inputs,
        profile=own.profile,
        nose_radius_mm=own.edge.nose_radius_mm,
        touches=touches,
        options=_own_options(inputs.options, own, inputs),
        finish_touches=finish if finish is not None and len(finish.point) else None,
        characteristics=tuple(_renamed(characteristic, own, inputs) for characteristic in asked),
        called=own.edge,
    )


def shared_words(inputs: Inputs, contours: tuple[OwnContour, ...], judged: Collection[str] = ()) -> tuple[str, ...]:
    """Measurements and characteristics that no edge has for itself: what is left out, in words; `judged` are not."""
    owns = [set(_own_of(contour)) for contour in contours]
    measured = {int(i) for i in inputs.touches.feature_index}
    left = [name for i, name in enumerate(inputs.profile.names) if i in measured - set[int]().union(*owns)]
    shared = [
        characteristic.name
        for characteristic in inputs.characteristics
        if not any(_is_own(characteristic, own, inputs) for own in contours)
    ]
    asked = [name for name in shared if name not in judged]
    found: list[str] = []
    if left:
        found.append(
            wording("{names}: left alone, and what was measured of it is used for nothing.", names=all_of(left))
        )
    found.extend(readings_words(inputs.touches, owns, inputs.profile.names))
    of_no_place = [
        observation.name
        for observation in inputs.touches.seen
        if any(of.isdisjoint(measured) for of in owns if {*observation.feature_index.tolist()} <= of)
    ]
    if of_no_place:
        found.append(
            wording(
                "{names}: corrects nothing, as no diameter, length or touch states where the surface is that the "
                "edge cuts.",
                names=all_of(of_no_place),
            )
        )
    if asked:
        found.append(
            wording("{names}: sizes between features of several edges, which are not judged.", names=all_of(asked))
        )
    return tuple(found)


def _own_of(own: OwnContour) -> tuple[int, ...]:
    """Returns all features of the part that are the edge's, by index."""
    return tuple(index for parts in own.parts for index in parts)


def vectors_of_edge(vectors: ErrorVectors, own: OwnContour, profile: Profile) -> ErrorVectors:
    """Returns those on the edge's features, placed along its own contour; `profile` is the whole one, in its frame."""
    rows = np.flatnonzero(np.isin(vectors.feature_index, _own_of(own)))
    chosen = vectors.chosen(rows)
    index = np.array([own.index_of(int(i)) for i in chosen.feature_index], dtype=np.intp)
    features = own.profile.features
    along = [float(features[i].locate(point)[0]) for i, point in zip(index, chosen.nominal_mm, strict=True)]
    gauged = tuple(name for name in chosen.gauged if name in chosen.point)
    seen = tuple(_own_seen(observation, own, profile) for observation in own_seen(vectors, _own_of(own)))
    placed = replace(chosen, feature_index=index, arc_length_mm=np.array(along), gauged=gauged, seen=seen)
    return placed.chosen(np.lexsort((placed.arc_length_mm, placed.feature_index)))


def _own_seen(reading: Seen, own: OwnContour, profile: Profile) -> Seen:
    index = np.array([own.index_of(int(i)) for i in reading.feature_index], dtype=np.intp)
    pairs = zip(reading.feature_index.tolist(), reading.arc_length_mm, strict=True)
    points = [profile.features[i].point_mm(s) for i, s in pairs]
    along = [float(own.profile.features[i].locate(point)[0]) for i, point in zip(index, points, strict=True)]
    return replace(reading, feature_index=index, arc_length_mm=np.array(along))


def _own_options(options: Options, own: OwnContour, inputs: Inputs) -> Options:
    """Returns the options by a feature's name, by the names of its own contour."""
    knots, ends = _of_names(options.knot_every_on, own, inputs), _of_names(options.prescribed, own, inputs)
    return replace(options, knot_every_on=knots, prescribed=ends)


def _of_names(chosen: Mapping[str, T], own: OwnContour, inputs: Inputs) -> dict[str, T]:
    """Drops names of other edges' features; a name that is of no feature at all stays, to be refused as ever."""
    names, mine = inputs.profile.names, _own_of(own)
    kept: dict[str, T] = {}
    for name, value in chosen.items():
        if name not in names:
            kept[name] = value
        elif names.index(name) in mine:
            kept[_name(name, own, inputs)] = value
    return kept


def _name(name: str, own: OwnContour, inputs: Inputs) -> str:
    return own.profile.names[own.index_of(inputs.profile.names.index(name))] if name else ""


def _is_own(characteristic: Characteristic, own: OwnContour, inputs: Inputs) -> bool:
    names = [inputs.profile.names[index] for index in _own_of(own)]
    return characteristic.feature in names and (not characteristic.other or characteristic.other in names)


def _renamed(characteristic: Characteristic, own: OwnContour, inputs: Inputs) -> Characteristic:
    return replace(
        characteristic,
        feature=_name(characteristic.feature, own, inputs),
        other=_name(characteristic.other, own, inputs),
    )


def vectors_in(frame: SetupFrame, vectors: ErrorVectors, profile: Profile) -> ErrorVectors:
    """Returns part errors in the program's frame; `profile` is the part's."""
    index, along = _places(frame, vectors.feature_index, vectors.arc_length_mm, profile)
    placed = replace(
        vectors,
        feature_index=index,
        arc_length_mm=along,
        nominal_mm=frame.points(vectors.nominal_mm),
        outward_normal=frame.directions(vectors.outward_normal),
        seen=tuple(_seen_in(frame, observation, profile) for observation in vectors.seen),
    )
    return placed.chosen(np.lexsort((along, index)))


def _seen_in(frame: SetupFrame, reading: Seen, profile: Profile) -> Seen:
    index, along = _places(frame, reading.feature_index, reading.arc_length_mm, profile)
    return replace(reading, feature_index=index, arc_length_mm=along)


def seen_of_edge(seen: Sequence[Seen], frame: SetupFrame, own: OwnContour | None, profile: Profile) -> tuple[Seen, ...]:
    """Returns what is of this edge's features alone, along its own contour; all of it for a job's only tool."""
    placed = [_seen_in(frame, observation, profile) for observation in seen]
    if own is None:
        return tuple(placed)
    mine, in_frame = set(_own_of(own)), frame.profile(profile)
    return tuple(
        _own_seen(observation, own, in_frame)
        for observation in placed
        if mine.issuperset(observation.feature_index.tolist())
    )


def _places(frame: SetupFrame, index: Integers, along_mm: Array, profile: Profile) -> tuple[NDArray[np.intp], Array]:
    """Returns feature and arc length of places in the program's frame: from the other end where Z points backwards."""
    if not frame.backwards:
        return index.astype(np.intp), along_mm
    lengths_mm = np.array([feature.length_mm for feature in profile.features])
    return (len(lengths_mm) - 1 - index).astype(np.intp), lengths_mm[index] - along_mm


def index_in(frame: SetupFrame, index: int, features: int) -> int:
    """Returns the index of one of the part's features in the program's frame, of so many `features`."""
    return features - 1 - index if frame.backwards else index


def touch_in(frame: SetupFrame, touch: Touch) -> Touch:
    """Returns a touch where the program has it; its error along the normal is unchanged."""
    measured = None if touch.measured_mm is None else frame.point(touch.measured_mm)
    return replace(touch, nominal_mm=frame.point(touch.nominal_mm), measured_mm=measured)


def reading_in(frame: SetupFrame, reading: Reading, other: str) -> Reading | None:
    """Returns a reading of named features with its place as the program has it; `other` names the feature it counts
    from.

    None for a length that counts from the part's zero, where that is not the program's.
    """
    if reading.quantity is Quantity.LENGTH and not other and frame.zero_at_z_mm != 0.0:
        return None
    *across, along_mm = reading.place_mm or (0.0,)
    return replace(reading, place_mm=(*across, frame.z_mm(along_mm)) if reading.place_mm else ())


def ends_in(frame: SetupFrame, prescribed: Mapping[str, EndConditions]) -> dict[str, EndConditions]:
    """Returns the values prescribed at the ends of features, by name."""
    return {name: ends.reversed if frame.backwards else ends for name, ends in prescribed.items()}


def frame_of(correction: Correction) -> SetupFrame:
    """Returns the frame of the set-up in which a correction and its profile are."""
    stated = correction.record.options.get("setup")
    if not isinstance(stated, Mapping):
        return PART
    return SetupFrame(**{field.name: stated[field.name] for field in fields(SetupFrame)})


def characteristics_in(frame: SetupFrame, characteristics: Sequence[Characteristic]) -> tuple[Characteristic, ...]:
    """Characteristics with the place of a diameter as the program has it."""
    return tuple(
        characteristic
        if characteristic.at_z_mm is None
        else replace(characteristic, at_z_mm=frame.z_mm(characteristic.at_z_mm))
        for characteristic in characteristics
    )


def judged_on_part(correction: Correction, asked: Sequence[Characteristic]) -> Correction:
    """Returns the correction with its characteristics placed as the part has them; `asked` are those of the part."""
    places = {characteristic.name: characteristic.at_z_mm for characteristic in asked}

    def placed(judged: Judged) -> Judged:
        of = judged.characteristic
        return replace(judged, characteristic=replace(of, at_z_mm=places.get(of.name, of.at_z_mm)))

    judged = tuple(map(placed, correction.characteristics))
    return replace(correction, characteristics=judged, record=replace(correction.record, characteristics=judged))
