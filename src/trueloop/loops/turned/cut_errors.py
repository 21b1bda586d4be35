"""Places of a profile as the state of an edge knows them: by contact angle, z, and share along a group of features."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.memory.made_part import CutErrors
from trueloop.turned.fit.prior.remembered_fit import angles_along
from trueloop.turned.touches.error_vectors import ErrorVectors


def cut_errors(profile: Profile, vectors: ErrorVectors) -> CutErrors:
    """Returns part errors at gauging points, without the point that the part's z was taken from: it is the reference of
    the others.

    Uncertainties are the touches' own; the reference has the one that all share.
    """
    at = _at(profile, vectors.feature_index, vectors.arc_length_mm, vectors.point)
    errors = CutErrors(
        feature=at.feature,
        point=at.point,
        contact_angle_rad=at.contact_angle_rad,
        error_mm=vectors.error_mm,
        standard_u_mm=vectors.own_u_mm,
        z_mm=at.z_mm,
        share=at.share,
        group=at.group,
    )
    reference = np.flatnonzero(vectors.at_reference)
    if not len(reference):
        return errors
    return _from(errors, vectors, errors.chosen(reference[:1])).chosen(np.flatnonzero(~vectors.at_reference))


def places_along(
    profile: Profile, features: Sequence[int], vectors: ErrorVectors
) -> tuple[NDArray[np.intp], Array, CutErrors]:
    """Places along features, their ends among them: feature index and arc length, (n,), and what the state knows them
    by. z counts from where that of the vectors does.
    """
    along = [angles_along(profile, i)[0] for i in features]
    index = np.repeat(np.array(features, dtype=np.intp), [len(s) for s in along])
    s = np.concatenate([*along, np.empty(0)])
    return index, s, places_at(profile, index, s, vectors)


def places_at(profile: Profile, index: NDArray[np.intp], arc_length_mm: Array, vectors: ErrorVectors) -> CutErrors:
    """Returns places (n,) of features as the state knows them. z counts from where that of the vectors does."""
    at = _at(profile, index, arc_length_mm, ("",) * len(arc_length_mm))
    reference = np.flatnonzero(vectors.at_reference)
    if not len(reference):
        return at
    touched = vectors.chosen(reference[:1])
    own = _at(profile, touched.feature_index, touched.arc_length_mm, touched.point)
    pairs = zip(index, arc_length_mm, strict=True)
    normals = np.array([profile.features[i].outward_normal(float(x))[1] for i, x in pairs])
    return CutErrors(
        feature=at.feature,
        point=at.point,
        contact_angle_rad=at.contact_angle_rad,
        error_mm=at.error_mm,
        standard_u_mm=at.standard_u_mm,
        z_mm=at.z_mm,
        share=at.share,
        group=at.group,
        z_share=normals / touched.outward_normal[0, 1],
        reference=own,
    )


def _from(errors: CutErrors, vectors: ErrorVectors, reference: CutErrors) -> CutErrors:
    return CutErrors(
        feature=errors.feature,
        point=errors.point,
        contact_angle_rad=errors.contact_angle_rad,
        error_mm=errors.error_mm,
        standard_u_mm=errors.standard_u_mm,
        z_mm=errors.z_mm,
        share=errors.share,
        group=errors.group,
        z_share=vectors.z_share,
        reference=reference,
    )


def _at(profile: Profile, feature_index: NDArray[np.intp], arc_length_mm: Array, points: tuple[str, ...]) -> CutErrors:
    places = list(zip(feature_index.tolist(), arc_length_mm.tolist(), strict=True))
    n = len(places)
    group, share = profile.in_groups(feature_index, arc_length_mm)
    return CutErrors(
        feature=tuple(profile.names[i] for i, _ in places),
        point=points,
        contact_angle_rad=profile.contact_angle_rad(feature_index, arc_length_mm) if n else np.empty(0),
        error_mm=np.zeros(n),
        standard_u_mm=np.zeros(n),
        z_mm=np.array([float(profile.features[i].point_mm(s)[1]) - profile.middle_z_mm for i, s in places]),
        share=share,
        group=tuple(profile.names[i] for i in group.tolist()),
    )
