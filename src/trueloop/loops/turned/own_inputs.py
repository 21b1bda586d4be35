"""What one of several edges is corrected from: its own contour, what was measured of it, and nothing of the others.

Fits, offsets, nose models and bands of two edges share nothing but the frame of the part.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TypeVar

import numpy as np

from trueloop.domain.characteristic import Characteristic
from trueloop.loops.turned.correction import Inputs
from trueloop.nc.match.own_contour import OwnContour
from trueloop.turned.options import Options
from trueloop.turned.readings.shared import own_seen
from trueloop.turned.readings.shared import shared_words as readings_words
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.seen import Seen
from trueloop.wording import all_of, wording

T = TypeVar("T")


def own_inputs(inputs: Inputs, own: OwnContour) -> Inputs | None:
    """Of inputs of the whole part, with this edge's tool, those of its contour; None where nothing of it was measured.

    Of readings of features that several edges cut it has what they state of its own. Characteristics of these are left
    out, which a note says.
    """
    touches = _own_vectors(inputs.touches, own, inputs)
    if not len(touches.point):
        return None
    finish = None if inputs.finish_touches is None else _own_vectors(inputs.finish_touches, own, inputs)
    asked = tuple(one for one in inputs.characteristics if _is_own(one, own, inputs))
    return replace(
        inputs,
        profile=own.profile,
        nose_radius_mm=own.edge.nose_radius_mm,
        touches=touches,
        options=_own_options(inputs.options, own, inputs),
        finish_touches=finish if finish is not None and len(finish.point) else None,
        characteristics=tuple(_renamed(one, own, inputs) for one in asked),
        called=own.edge,
    )


def shared_words(inputs: Inputs, contours: tuple[OwnContour, ...], judged: Collection[str] = ()) -> tuple[str, ...]:
    """Measurements and characteristics that no edge has for itself: what is left out, in words; `judged` are not."""
    owns = [set(_own_of(one)) for one in contours]
    measured = {int(i) for i in inputs.touches.feature_index}
    left = [name for i, name in enumerate(inputs.profile.names) if i in measured - set[int]().union(*owns)]
    shared = [one.name for one in inputs.characteristics if not any(_is_own(one, own, inputs) for own in contours)]
    asked = [name for name in shared if name not in judged]
    found: list[str] = []
    if left:
        found.append(
            wording("{names}: left alone, and what was measured of it is used for nothing.", names=all_of(left))
        )
    found.extend(readings_words(inputs.touches.seen, owns, inputs.profile.names))
    if asked:
        found.append(
            wording("{names}: sizes between features of several edges, which are not judged.", names=all_of(asked))
        )
    return tuple(found)


def _own_of(own: OwnContour) -> tuple[int, ...]:
    """All features of the part that are the edge's, by index."""
    return tuple(index for parts in own.parts for index in parts)


def _own_vectors(vectors: ErrorVectors, own: OwnContour, inputs: Inputs) -> ErrorVectors:
    """Those on the edge's features, placed along its own contour."""
    rows = np.flatnonzero(np.isin(vectors.feature_index, _own_of(own)))
    chosen = vectors.chosen(rows)
    index = np.array([own.index_of(int(i)) for i in chosen.feature_index], dtype=np.intp)
    features = own.profile.features
    along = [float(features[i].locate(point)[0]) for i, point in zip(index, chosen.nominal_mm, strict=True)]
    gauged = tuple(name for name in chosen.gauged if name in chosen.point)
    seen = tuple(_own_seen(one, own, inputs) for one in own_seen(chosen.seen, _own_of(own)))
    placed = replace(chosen, feature_index=index, arc_length_mm=np.array(along), gauged=gauged, seen=seen)
    return placed.chosen(np.lexsort((placed.arc_length_mm, placed.feature_index)))


def _own_seen(seen: Seen, own: OwnContour, inputs: Inputs) -> Seen:
    index = np.array([own.index_of(int(i)) for i in seen.feature_index], dtype=np.intp)
    pairs = zip(seen.feature_index.tolist(), seen.arc_length_mm, strict=True)
    points = [inputs.profile.features[i].point_mm(s) for i, s in pairs]
    along = [float(own.profile.features[i].locate(point)[0]) for i, point in zip(index, points, strict=True)]
    return replace(seen, feature_index=index, arc_length_mm=np.array(along))


def _own_options(options: Options, own: OwnContour, inputs: Inputs) -> Options:
    """What is chosen by a feature's name, by the names of its own contour."""
    knots, ends = _of_names(options.knot_every_on, own, inputs), _of_names(options.prescribed, own, inputs)
    return replace(options, knot_every_on=knots, prescribed=ends)


def _of_names(chosen: Mapping[str, T], own: OwnContour, inputs: Inputs) -> dict[str, T]:
    """Without those of other edges' features; a name that is of no feature at all stays, to be refused as ever."""
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


def _is_own(asked: Characteristic, own: OwnContour, inputs: Inputs) -> bool:
    names = [inputs.profile.names[index] for index in _own_of(own)]
    return asked.feature in names and (not asked.other or asked.other in names)


def _renamed(asked: Characteristic, own: OwnContour, inputs: Inputs) -> Characteristic:
    return replace(asked, feature=_name(asked.feature, own, inputs), other=_name(asked.other, own, inputs))
