"""The deviations of a program's contour from the nominal, feature by feature.

A curved feature may be cut by many short lines. Their ends are what was meant, and what is corrected; between them the
part has facets, which are on it when it is measured.

The conditions of the semi-finish and of the finish cut: touched errors repeat at equal ones alone [6811 §2.0].
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.geometry.feature import Line, is_curved
from trueloop.geometry.profile import Profile
from trueloop.memory.made_part import CutErrors
from trueloop.nc.match.matching import ContourMatch, FeatureMatch
from trueloop.nc.program.along import FeedMove
from trueloop.nc.program.tool_path import ToolPath
from trueloop.statistics import rms
from trueloop.turned.compensation.shift import ZERO, Shift, sampled
from trueloop.turned.fit.prior.remembered_fit import angles_along
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import wording


def cut_errors(profile: Profile, vectors: ErrorVectors) -> CutErrors:
    """Returns part errors at gauging points, without the point that the part's z was taken from: it is the reference of
    the others.

    Uncertainties are the touches' own; the reference has the one that all share.
    """
    at = _at(profile, vectors.feature_index, vectors.arc_length_mm, vectors.point)
    errors = replace(at, error_mm=vectors.error_mm, standard_u_mm=vectors.own_u_mm)
    reference = np.flatnonzero(vectors.at_reference)
    if not len(reference):
        return errors
    return _from(errors, vectors, errors.chosen(reference[:1])).chosen(np.flatnonzero(~vectors.at_reference))


def places_along(
    profile: Profile, features: Sequence[int], vectors: ErrorVectors
) -> tuple[NDArray[np.intp], Array, CutErrors]:
    """Places along features, ends included: feature and arc length, (n,), as the state knows them."""
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
    return replace(at, z_share=normals / touched.outward_normal[0, 1], reference=own)


def _from(errors: CutErrors, vectors: ErrorVectors, reference: CutErrors) -> CutErrors:
    return replace(errors, z_share=vectors.z_share, reference=reference)


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


SAMPLES: Final = 257

FEWEST_CHORDS: Final = 4
FACETS_MM: Final = 0.005
"""Lines that leave deeper facets are not chords of a curve."""

STRETCHES: Final = 32
"""Ends of chords, each rounded by the programmer, deviate by the mean over each of so many stretches."""

OF_ROUNDING: Final = 0.2
"""The rms of what is left of a curve whose ends are rounded on both axes, of the control's resolution: 1/√12 on an axis
at the ends, less between them."""

DEGREES: Final = range(3, 10)
"""Degrees of the polynomials between the ends; a curve that needs more is taken as it is written."""

OF_RESOLUTION: Final = 1.5
"""Ends that deviate by no more than so much of the control's resolution are rounded on both axes."""


def of_contour(match: FeatureMatch, resolution_mm: float) -> Shift:
    """Returns deviations of the intended contour: sampled, exact on lines, and good to the square of the spacing on
    arcs.

    Of chords the ends count; where these are only rounded, there is none.
    """
    if not is_chords(match):
        return _of_all(match)
    s, off = _at_ends(match)
    if np.max(np.abs(off)) <= OF_RESOLUTION * resolution_mm:
        return ZERO
    groups = np.array_split(np.arange(len(s)), min(STRETCHES, len(s)))
    return sampled(*(np.array([np.mean(of[group]) for group in groups]) for of in (s, off)))


def of_surface(match: FeatureMatch) -> Shift:
    """Returns deviations of the surface that is cut, facets and all."""
    if not is_chords(match):
        return _of_all(match)
    ends = _at_ends(match)[0]
    s = np.unique(np.concatenate([ends, *(ends[:-1] + share * np.diff(ends) for share in (0.25, 0.5, 0.75))]))
    return sampled(s, match.deviation_mm(s))


def of_written(match: FeatureMatch, resolution_mm: float) -> Shift:
    """Returns deviations of a contour that a correction wrote. On a curve of several moves each end was rounded to the
    control's resolution: the smoothest polynomial that leaves no more than that is what was meant; it ends where the
    curve does.
    """
    whole = of_surface(match)
    if not is_curved(match.feature) or len(match.moves) == 1:
        return whole
    s, along = np.linspace(0.0, match.feature.length_mm, SAMPLES), np.linspace(-1.0, 1.0, SAMPLES)
    off_mm = whole.value_mm(s)
    ends_mm = np.interp(along, [-1.0, 1.0], off_mm[[0, -1]])
    for degree in DEGREES:
        inner = (1.0 - along**2)[:, None] * chebvander(along, degree)
        fitted_mm = ends_mm + inner @ np.linalg.lstsq(inner, off_mm - ends_mm, rcond=None)[0]
        if rms(off_mm - fitted_mm) <= OF_ROUNDING * resolution_mm:
            return sampled(s, fitted_mm)
    return whole


def unevenness_mm(match: FeatureMatch, contour: Shift) -> float:
    """Returns by how much chords, with their facets and the rounding of their ends, deviate from the intended contour.

    0 of other moves; never more than `FACETS_MM`, which is what chords are allowed.
    """
    if not is_chords(match):
        return 0.0
    surface = of_surface(match)
    off = surface.value_mm(surface.breaks_mm) - contour.value_mm(surface.breaks_mm)
    return min(float(np.max(np.abs(off))), FACETS_MM)


def is_chords(match: FeatureMatch) -> bool:
    """Returns whether a curved feature is cut by short lines from point to point of it."""
    lines = all(isinstance(matched.move.path, Line) for matched in match.moves)
    many = is_curved(match.feature) and len(match.moves) >= FEWEST_CHORDS
    return many and lines and _facets_mm(match) <= FACETS_MM


def _facets_mm(match: FeatureMatch) -> float:
    ends, off = _at_ends(match)
    middle = (off[:-1] + off[1:]) / 2
    return float(np.max(np.abs(match.deviation_mm((ends[:-1] + ends[1:]) / 2) - middle), initial=0.0))


def _at_ends(match: FeatureMatch) -> tuple[Array, Array]:
    """Returns arc lengths of the ends of moves on the feature, ascending, and the deviation of each."""
    both = np.unique(np.round([[m.start_mm, m.end_mm] for m in match.moves], 9))
    s = both[(both >= 0.0) & (both <= match.feature.length_mm)]
    return s, match.deviation_mm(s)


def _of_all(match: FeatureMatch) -> Shift:
    s = np.linspace(0.0, match.feature.length_mm, SAMPLES)
    return sampled(s, match.deviation_mm(s))


SAME_SHARE: Final = 0.02
"""Feeds and speeds that differ by no more than this share are the same."""
SAME_DEPTH: Final = 0.25
"""Depths of cut that differ by no more than this share of the larger are alike: the force is about in proportion."""
_LEAST_MM: Final = 0.01
"""A finish cut that is programmed less deep takes its depth from an offset, which the programs do not show."""
_ALONG: Final = 0.9
"""Least cosine of the angles between a feature and a pass that goes along it, and between a turned feature and Z."""
_SAMPLES: Final = 17


def conditions_words(path: ToolPath, match: ContourMatch, before: ToolPath, other: ContourMatch) -> Iterator[str]:
    """Describes feed and speed of the two cuts on the feature where they differ most."""
    for what, name, mode in (
        (wording("feed"), "feed", "feed_mode"),
        (wording("spindle speed"), "spindle_speed", "spindle_mode"),
    ):
        unlike = []
        for own, theirs in zip(match.features, other.features, strict=True):
            semifinish, finish = _usual(before, theirs, name, mode), _usual(path, own, name, mode)
            if semifinish is None or finish is None:
                continue
            (was, its), (now, new) = semifinish, finish
            if its != new or abs(was - now) > SAME_SHARE * abs(now):
                share = float("inf") if its != new else abs(np.log(was / now))
                units = (f" G{its}", f" G{new}") if its != new else ("", "")
                unlike.append((share, f"{was:g}{units[0]}", f"{now:g}{units[1]}", own.feature.name))
        if unlike:
            _, before_it, now_it, feature = max(unlike, key=lambda one: one[0])
            yield wording(
                "The semi-finish cut has another {what} than the finish cut, {was} for {now} on {feature}: what was "
                "measured repeats in the finish cut only under the same conditions.",
                what=what,
                was=before_it,
                now=now_it,
                feature=feature,
            )


def _usual(path: ToolPath, match: FeatureMatch, name: str, mode: str) -> tuple[float, int] | None:
    """Returns the median over the moves along a feature, and its mode; None where the program states none."""
    moves = [matched.move.index for matched in match.moves]
    values = np.asarray(getattr(path, name))[moves]
    known = values[np.isfinite(values) & (values > 0.0)]
    return (float(np.median(known)), int(np.median(getattr(path, mode)[moves]))) if len(known) else None


def depth_words(match: ContourMatch, before: ContourMatch, roughed: Sequence[FeedMove]) -> Iterator[str]:
    """Describes the depths of the two cuts on the feature where they differ most, if markedly.

    `roughed` are the feed moves of the semi-finish program with its roughing. Where no pass of it goes along a feature
    before the semi-finish pass, with the same point of the tool, the depth of that is not known; nor is it on faces,
    along which the tool is withdrawn as well.
    """
    depths = [
        (finish.feature.name, semifinish_mm, finish_mm)
        for finish, own in zip(match.features, before.features, strict=True)
        if match.on_contour == before.on_contour
        if (finish_mm := _apart_mm(finish, own)) >= _LEAST_MM
        if (semifinish_mm := _depth_mm(own, roughed)) is not None
    ]
    unlike = [depth for depth in depths if abs(depth[1] - depth[2]) > SAME_DEPTH * max(depth[1:])]
    if unlike:
        name, was, now = max(unlike, key=lambda one: abs(np.log(one[1] / one[2])))
        yield wording(
            "The semi-finish cut is {was:.3g} mm deep on {feature}, the finish cut {now:.3g} mm: what was measured "
            "repeats in the finish cut only under the same conditions.",
            was=was,
            feature=name,
            now=now,
        )


def _apart_mm(finish: FeatureMatch, semifinish: FeatureMatch) -> float:
    """Returns how far the semi-finish pass lies outside the finish pass, in the middle of the feature."""
    middle = np.array([finish.feature.length_mm / 2])
    outside = semifinish.offset_mm + semifinish.deviation_mm(middle)
    return float((outside - finish.offset_mm - finish.deviation_mm(middle))[0])


def _depth_mm(own: FeatureMatch, roughed: Sequence[FeedMove]) -> float | None:
    """Returns how far the nearest earlier pass along the feature lies outside the semi-finish pass, in its middle."""
    middle = own.feature.length_mm / 2
    normal = own.feature.outward_normal(middle)
    if abs(normal[0]) < _ALONG:
        return None
    place = own.feature.point_mm(middle) + (own.offset_mm + own.deviation_mm([middle])[0]) * normal
    first = min((matched.move for matched in own.moves), key=lambda move: move.index)
    at = next((k for k, move in enumerate(roughed) if (move.line, move.path) == (first.line, first.path)), 0)
    alike = [move for move in roughed[:at] if move.on_contour == first.on_contour]
    crossings = [mm for move in alike for mm in _crossings_mm(move, place, normal) if mm > _LEAST_MM]
    return min(crossings, default=None)


def _crossings_mm(move: FeedMove, place: Array, normal: Array) -> Iterator[float]:
    """Yields where a ray crosses a move that goes across it: distances from `place` (2,) along `normal` (2,)."""
    points = move.path.point_mm(np.linspace(0.0, move.path.length_mm, _SAMPLES))
    along = np.array([-normal[1], normal[0]])
    off, up = (points - place) @ along, (points - place) @ normal
    for k in np.flatnonzero((off[:-1] < 0.0) != (off[1:] < 0.0)):
        step = points[k + 1] - points[k]
        if abs(step @ along) >= _ALONG * np.hypot(*step):
            yield float(up[k] - off[k] * (up[k + 1] - up[k]) / (off[k + 1] - off[k]))
