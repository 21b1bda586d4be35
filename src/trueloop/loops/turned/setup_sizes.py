"""Lengths between faces that two set-ups cut, judged as expected after the next cut.

Each set-up corrects the error of its own faces, so that what its datum was off by goes with them. What a length hangs
on besides is the face on which the part stands in a later set-up: where that face comes out otherwise in the next cut
than in the part that was measured, all that the later set-up cuts moves with it. It is the face from which z counts.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.judged import Judged
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.shared_sizes import Share
from trueloop.tolerances.conformance import judge
from trueloop.turned.characteristics.measurand import Measurand, measurand
from trueloop.turned.readings.sizes import is_face
from trueloop.turned.touches.error_vectors import ErrorVectors


@dataclass(frozen=True)
class _Face:
    """The face on which the part stands in every set-up after the one that cuts it, by its index; −1: none does.

    `grown_mm`: by how much more material the next cut leaves on it than was measured; `u_mm` of the next cut, and of
    what was measured.
    """

    feature: int
    setup: int
    faces_z: float
    grown_mm: float = 0.0
    next_u_mm: float = 0.0
    measured_u_mm: float = 0.0


def setup_sizes(
    profile: Profile, asked: Sequence[Characteristic], vectors: ErrorVectors, setups: Sequence[Sequence[Share]]
) -> tuple[Judged, ...]:
    """Those characteristics that are lengths between two set-ups' faces; `setups`: the shares of each, in the order in
    which they are cut, `vectors` what was measured, in the part's frame.

    Left out are those with a face that was not measured, all where z counts from no face, and those of a set-up before
    the one that cuts that face: on what the part stands there is not known. Raises TOL errors.
    """
    face = _face(profile, vectors, setups)
    if face is None:
        return ()
    lengths = [one for one in asked if one.quantity is Quantity.LENGTH and one.other]
    found = (_judged(profile, one, vectors, setups, face) for one in lengths)
    return tuple(one for one in found if one is not None)


def _face(profile: Profile, vectors: ErrorVectors, setups: Sequence[Sequence[Share]]) -> _Face | None:
    reference = np.flatnonzero(vectors.at_reference)
    if not len(reference):
        return None
    feature = int(vectors.feature_index[reference[0]])
    if not is_face(profile.features[feature]):
        return None
    faces_z = float(vectors.outward_normal[reference[0], 1])
    cut = _cut_by(profile, feature, setups)
    if cut is None:
        return _Face(feature, -1, faces_z)
    rows = vectors.of_feature(feature)
    error_mm, u_mm = cut[1].at(profile, feature, vectors.arc_length_mm[rows])
    grown_mm = float(np.mean(error_mm - vectors.error_mm[rows]))
    return _Face(feature, cut[0], faces_z, grown_mm, float(np.max(u_mm)), float(np.max(vectors.standard_u_mm[rows])))


def _cut_by(profile: Profile, feature: int, setups: Sequence[Sequence[Share]]) -> tuple[int, Share] | None:
    """The set-up, by its place, and the edge that cuts a feature; None: none, or it was not measured."""
    found = ((k, one) for k, shares in enumerate(setups) for one in shares if one.cuts(profile, feature))
    return next(found, None)


def _judged(
    profile: Profile, asked: Characteristic, vectors: ErrorVectors, setups: Sequence[Sequence[Share]], face: _Face
) -> Judged | None:
    touched = np.bincount(vectors.feature_index, minlength=len(profile.features)).astype(np.intp)
    sizes = measurand(profile, asked, touched)
    cut = {int(feature): _cut_by(profile, int(feature), setups) for feature in np.unique(sizes.feature_index)}
    places = [one[0] for one in cut.values() if one is not None]
    if len(places) < len(cut) or len(set(places)) < len(places) or min(places) < face.setup:
        return None
    value = float(sizes.nominal[0])
    along, u_mm = defaultdict[int, float](float), {face.feature: face.next_u_mm}
    carried = 0.0
    for feature, one in cut.items():
        assert one is not None
        gain, error_mm, u_mm[feature] = _of(profile, sizes, feature, one[1])
        value += gain * error_mm
        along[feature] += gain
        if one[0] > face.setup:
            carried += gain * _faces_z(profile, feature) * face.faces_z
    value += carried * face.grown_mm
    along[face.feature] += carried
    variance = sum((along[feature] * u) ** 2 for feature, u in u_mm.items()) + (carried * face.measured_u_mm) ** 2
    return Judged(asked, None, judge(value, variance**0.5, None, asked.lower_limit, asked.upper_limit))


def _of(profile: Profile, sizes: Measurand, feature: int, share: Share) -> tuple[float, float, float]:
    """Of a face: by how much the length grows with its error, that error after the next cut and its uncertainty."""
    rows = np.flatnonzero(sizes.feature_index == feature)
    error_mm, u_mm = share.at(profile, feature, sizes.arc_length_mm[rows])
    return float(np.sum(sizes.gains[0, rows])), float(np.mean(error_mm)), float(np.max(u_mm))


def _faces_z(profile: Profile, feature: int) -> float:
    return float(profile.features[feature].outward_normal(0.0)[1])
