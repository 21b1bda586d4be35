"""The characteristics of a correction: in or out as measured, and as expected of the next cut; lengths between features
that two edges cut.

Each edge's correction says where its own face will be, and how surely. The two errors have nothing in common but the
frame of the part, so that their variances add. Along one face all places are taken to err together, which is on the
safe side. Each set-up corrects the error of its own faces, so that what its datum was off by goes with them. What a
length of two set-ups depends on besides is the face on which the part stands in a later set-up: where that face comes
out otherwise in the next cut than in the part that was measured, all that the later set-up cuts moves with it. It is
the face from which z counts.
"""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Judged, Judgement, Quantity
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART, SetupFrame
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.outcome import expected_mm
from trueloop.loops.turned.part_on_machine import InMachine, Surface, model_covariance
from trueloop.loops.turned.paths import Shifts
from trueloop.loops.turned.share import index_in
from trueloop.nc.match.own_contour import OwnContour
from trueloop.statistics import NORMAL_95
from trueloop.tolerances.conformance import judge
from trueloop.turned.characteristics.judging import Covariance, Places, judged, of_measured_part, of_next_cut
from trueloop.turned.characteristics.measurand import Measurand, diameters_at, measurand
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.readings.sizes import is_face
from trueloop.turned.readings.vectors import z_zero
from trueloop.turned.touches.error_vectors import ErrorVectors

TOUCHED_MM: Final = 0.05
"""A place this close to a touch is the touched one."""


@dataclass(frozen=True)
class Corrected:
    """One correction's knowledge of the errors of the touched part and of the next one: `own` is the fit to that part's
    measurements alone, `model` the one that corrects, which earlier parts may have told.
    """

    inputs: Inputs
    matched: Commanded
    surface: Surface
    own: ProfileErrorModel
    model: ProfileErrorModel
    decision: Decision
    shifts: Shifts
    machine: InMachine | None

    def characteristics(self) -> tuple[Judged, ...]:
        """Returns one characteristic for each that the inputs request, in their order. Raises TOL errors."""
        return tuple(self._judged(asked) for asked in self.inputs.characteristics)

    def _judged(self, characteristic: Characteristic) -> Judged:
        sizes = measurand(self.inputs.profile, characteristic, self._touches, self.inputs.part_zero_z_mm)
        places = Places(self.model, sizes.feature_index, sizes.arc_length_mm)
        after = judged(characteristic, sizes, self._expected_mm(places), self._next_cut(places))
        if not self.inputs.measured_finished:
            return Judged(characteristic, None, after)
        return Judged(characteristic, self._as_measured(characteristic, sizes), after)

    def _as_measured(self, characteristic: Characteristic, sizes: Measurand) -> Judgement:
        """Judges by a reading of the size itself or of a diameter without a place; else by this part's curve."""
        if (read := _read(characteristic, sizes, self.surface.touches)) is not None:
            return read
        touches, index = self.surface.touches, int(sizes.feature_index[0])
        touched = np.flatnonzero((touches.feature_index == index) & (self.own.weight > 0.0))
        if characteristic.quantity is Quantity.DIAMETER and characteristic.at_z_mm is None and len(touched):
            sizes = diameters_at(index, self.inputs.profile.features[index], touches.arc_length_mm[touched])
        places = Places(self.own, sizes.feature_index, sizes.arc_length_mm)
        return judged(characteristic, sizes, *self._measured(places))

    @property
    def _touches(self) -> NDArray[np.intp]:
        """Returns how many touches that count every feature has."""
        return np.bincount(self.model.vectors.feature_index[self.model.weight > 0.0], minlength=len(self.model.curves))

    def _expected_mm(self, places: Places) -> Array:
        """Errors that the next cut is expected to have: what is not taken out, and what of the program's stays."""
        curve, options, expected = places.curve_mm, self.inputs.options, places.expected_mm
        gain = places.each(lambda curve, s: np.full(len(s), curve.gain))
        by_offset = np.array(self.shifts.by_offset)[places.feature_index]
        offset = places.outward_normal @ np.array(self.decision.offset_mm)
        kept = places.shifted_mm(self.shifts.contour) - places.shifted_mm(self.shifts.correction)
        left = np.where(expected == curve, (1.0 - options.weight) * curve, expected - gain * options.weight * curve)
        return np.asarray(np.where(by_offset, expected + gain * offset, left) + kept)

    def _next_cut(self, places: Places) -> Covariance:
        covariance = of_next_cut(places, self.shifts.unasked)
        if self.machine is None:
            return covariance
        nominal, normal = places.nominal_mm, places.outward_normal
        return covariance.with_stated(model_covariance(self.machine, nominal, normal, self.inputs.nose_radius_mm))

    def _measured(self, places: Places) -> tuple[Array, Covariance]:
        """Errors of the part as it was touched: at touches their mean, else of process, program, machine."""
        error_mm = places.curve_mm + places.shifted_mm(self.matched.measured) + self._cut_in_mm(places)
        at, touch = self._touched(places)
        touches, here = self.surface.touches, np.unique(at)
        error_mm[here] = [np.mean(touches.error_mm[touch[at == k]]) for k in here]
        u_mm = np.array([np.max(touches.standard_u_mm[touch[at == k]]) for k in here])
        return error_mm, of_measured_part(places).with_measured(here, u_mm)

    def _touched(self, places: Places) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Returns the places that were touched, and the touches there; those left out as bad are not used."""
        touches = self.surface.touches
        same = np.equal.outer(places.feature_index, touches.feature_index) & (self.own.weight > 0.0)
        near = np.abs(np.subtract.outer(places.arc_length_mm, touches.arc_length_mm)) < TOUCHED_MM
        at, touch = np.nonzero(same & near)
        return at, touch

    def _cut_in_mm(self, places: Places) -> Array:
        """Returns the machine's errors in the touched surface, straight from touch to touch of a feature."""
        touches, found = self.surface.touches, np.zeros(len(places.feature_index))
        for i in np.unique(places.feature_index):
            rows, touched = places.feature_index == i, touches.of_feature(i)
            if len(touched):
                at, cut_in = touches.arc_length_mm[touched], self.surface.cut_in_mm[touched]
                found[rows] = np.interp(places.arc_length_mm[rows], at, cut_in)
        return found


@dataclass(frozen=True)
class Share:
    """The features that one edge cuts, and their correction; `frame` is that of the contour."""

    contour: OwnContour
    correction: Correction
    frame: SetupFrame = PART

    def cuts(self, profile: Profile, feature: int) -> bool:
        """Returns whether one of the part's features is cut by this edge."""
        placed = index_in(self.frame, feature, len(profile.features))
        return any(placed in parts for parts in self.contour.parts)

    def at(self, profile: Profile, feature: int, arc_length_mm: Array) -> tuple[Array, Array]:
        """Returns expected errors after the next cut and their standard uncertainties at places of one of the part's
        features.

        By an offset the program's own deviation stays; by the contour no more of it than the control resolves.
        """
        own, made = self.contour.index_of(index_in(self.frame, feature, len(profile.features))), self.correction
        points = self.frame.points(profile.features[feature].point_mm(arc_length_mm))
        s = np.array([float(self.contour.profile.features[own].locate(point)[0]) for point in points])
        kept = made.commanded[own].shifted.off_nominal_mm(s) if made.by_offset[own] else np.zeros(len(s))
        return expected_mm(made, own, s) + kept, made.next_cut(own, s).expanded_u_mm / NORMAL_95


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


def lengths(
    profile: Profile,
    characteristics: Sequence[Characteristic],
    vectors: ErrorVectors,
    setups: Sequence[Sequence[Share]],
    *,
    finished: bool,
) -> tuple[Judged, ...]:
    """Returns those characteristics that are lengths between faces of two edges of one set-up, where that is the only
    one, else of two set-ups. `setups`: the shares of each, in the order in which they are cut; `vectors` what was
    measured, in the frame of `profile`. A `finished` part is judged as measured as well.

    Left out are those with a face that was not measured, and of two set-ups all where z counts from no face, and those
    of a set-up before the one that cuts that face: on what the part stands there is not known. Raises TOL errors.
    """
    face = None if len(setups) == 1 else _face(profile, vectors, setups)
    if face is None and len(setups) > 1:
        return ()
    between = [
        characteristic
        for characteristic in characteristics
        if characteristic.quantity is Quantity.LENGTH and characteristic.other
    ]
    found = (_judged(profile, characteristic, vectors, setups, face) for characteristic in between)
    judged = [one for one in found if one is not None]
    if finished:
        judged = [replace(one, before=_as_measured(profile, one.characteristic, vectors)) for one in judged]
    return tuple(judged)


def _as_measured(profile: Profile, characteristic: Characteristic, vectors: ErrorVectors) -> Judgement | None:
    """Judges a length by its reading, else by what was measured of both its faces; None: of one of them nothing was."""
    count = np.bincount(vectors.feature_index, minlength=len(profile.features)).astype(np.intp)
    sizes = measurand(profile, characteristic, count)
    if (read := _read(characteristic, sizes, vectors)) is not None:
        return read
    value, variance = float(sizes.nominal[0]), 0.0
    for feature in np.unique(sizes.feature_index).tolist():
        rows = vectors.of_feature(feature)
        if not len(rows):
            return None
        gain = float(np.sum(sizes.gains[0, sizes.feature_index == feature]))
        value += gain * float(np.mean(vectors.error_mm[rows]))
        variance += (gain * float(np.max(vectors.standard_u_mm[rows]))) ** 2
    return judge(value, variance**0.5, None, characteristic.lower_limit, characteristic.upper_limit)


def _read(characteristic: Characteristic, sizes: Measurand, vectors: ErrorVectors) -> Judgement | None:
    """Judges a length, an angle or the radius of an arc by its latest reading; None: it was not read as such."""
    quantity, features = characteristic.quantity, {*sizes.feature_index.tolist()}
    unit, places = ("rad" if quantity is Quantity.ANGLE else "mm"), (1 if quantity is Quantity.LENGTH else 2)
    own = [
        observation
        for observation in vectors.seen
        if observation.standard_u_mm > 0.0 and observation.unit == unit and len(observation.weight) >= places
        if {*observation.feature_index.tolist()} == features
    ]
    if not own or quantity not in (Quantity.LENGTH, Quantity.ANGLE, Quantity.RADIUS):
        return None
    off, u = (math.degrees(each) if unit == "rad" else each for each in (own[-1].value_mm, own[-1].standard_u_mm))
    return judge(float(sizes.nominal[0]) + off, u, None, characteristic.lower_limit, characteristic.upper_limit)


def _face(profile: Profile, vectors: ErrorVectors, setups: Sequence[Sequence[Share]]) -> _Face | None:
    reference = z_zero(vectors)
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
    return _Face(
        feature=feature,
        setup=cut[0],
        faces_z=faces_z,
        grown_mm=grown_mm,
        next_u_mm=float(np.max(u_mm)),
        measured_u_mm=float(np.max(vectors.standard_u_mm[rows])),
    )


def _cut_by(profile: Profile, feature: int, setups: Sequence[Sequence[Share]]) -> tuple[int, Share] | None:
    """Returns the set-up, by its place, and the edge that cuts a feature; None: none, or it was not measured."""
    found = ((k, share) for k, shares in enumerate(setups) for share in shares if share.cuts(profile, feature))
    return next(found, None)


def _judged(
    profile: Profile,
    characteristic: Characteristic,
    vectors: ErrorVectors,
    setups: Sequence[Sequence[Share]],
    face: _Face | None,
) -> Judged | None:
    touched = np.bincount(vectors.feature_index, minlength=len(profile.features)).astype(np.intp)
    sizes = measurand(profile, characteristic, touched)
    cut = {int(feature): _cut_by(profile, int(feature), setups) for feature in np.unique(sizes.feature_index)}
    known = {feature: one for feature, one in cut.items() if one is not None}
    owners = {place if face is not None else id(share) for place, share in known.values()}
    if len(known) < len(cut) or len(owners) < len(known):  # of one edge or set-up, which judges it by itself
        return None
    if face is not None and min(place for place, _ in known.values()) < face.setup:
        return None
    value, variance = float(sizes.nominal[0]), 0.0
    along, u_mm = defaultdict[int, float](float), {} if face is None else {face.feature: face.next_u_mm}
    carried = 0.0
    for feature, (place, share) in known.items():
        gain, error_mm, u_mm[feature] = _of(profile, sizes, feature, share)
        value += gain * error_mm
        along[feature] += gain
        if face is not None and place > face.setup:
            carried += gain * float(profile.features[feature].outward_normal(0.0)[1]) * face.faces_z
    if face is not None:
        value += carried * face.grown_mm
        along[face.feature] += carried
        variance = (carried * face.measured_u_mm) ** 2
    variance += sum((along[feature] * u) ** 2 for feature, u in u_mm.items())
    return Judged(
        characteristic, None, judge(value, variance**0.5, None, characteristic.lower_limit, characteristic.upper_limit)
    )


def _of(profile: Profile, sizes: Measurand, feature: int, share: Share) -> tuple[float, float, float]:
    """Returns by how much a face's error adds to the length, that error after the next cut and its uncertainty."""
    rows = np.flatnonzero(sizes.feature_index == feature)
    error_mm, u_mm = share.at(profile, feature, sizes.arc_length_mm[rows])
    return float(np.sum(sizes.gains[0, rows])), float(np.mean(error_mm)), float(np.max(u_mm))
