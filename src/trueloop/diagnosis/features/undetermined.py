"""What points of features do not determine, by name: DIA-POINTS."""

from collections.abc import Iterator, Mapping

import numpy as np

from trueloop.diagnosis.features.averaged import Averaged, averaged
from trueloop.diagnosis.features.feature_error import ErrorKind, FeaturePlace
from trueloop.diagnosis.features.form import SMOOTH_PLACES, SPAN, STRAIGHT, WAVES, Form, form_of
from trueloop.diagnosis.features.seen_points import SeenPoints
from trueloop.errors import Code, Finding, Severity
from trueloop.wording import wording

EDGES = wording(
    "Edges are not judged: what servo lag rounds off is tenths of a millimetre wide, and a ball does not see it."
)
"""[4773 §4.2 e]: 0.0005 mm/(mm/min) · 0.08 mm/rev · 4000 rev/min = 0.16 mm."""


def undetermined(points: SeenPoints, places: Mapping[str, FeaturePlace]) -> tuple[Finding, ...]:
    """Feature by feature which errors cannot be had from the points, why, and how many points could."""
    found: list[Finding] = []
    for name, place in places.items():
        of_it = points.of(name)
        if not len(of_it.feature):
            why = wording("'{feature}': it was not measured", feature=name)
            found.append(_note(name, why, wording("measure at least one point of it")))
            continue
        once = averaged(of_it)
        found += _of_straight(form_of(once, place), place) if place.kind in STRAIGHT else ()
        found += _around(once, form_of(once, place), name)
    return tuple(found)


def _of_straight(form: Form, place: FeaturePlace) -> Iterator[Finding]:
    along = "radius" if place.kind == "face" else "z"
    count = len(np.unique(np.round(form.along_mm, 6)))
    spans, whole = form.ends_mm[1] - form.ends_mm[0], form.whole_mm[1] - form.whole_mm[0]
    if not form.degree:
        kind = ErrorKind.FACE_TAPER if place.kind == "face" else ErrorKind.SHAFT_TAPER
        why = wording(
            "'{feature}': no {kind}; {count} places in {along}, which span {spans:.3g} of {whole:.3g} mm",
            feature=place.name,
            kind=str(kind),
            count=count,
            along=along,
            spans=spans,
            whole=whole,
        )
        hint = wording("measure two places at least, which span {share:.0%} of the feature", share=SPAN)
        yield _note(place.name, why, hint)
    elif form.smooth is None:
        why = wording(
            "'{feature}': no straightness; {count} places in {along}", feature=place.name, count=count, along=along
        )
        hint = wording("measure {count} places: up to three waves along the feature", count=SMOOTH_PLACES)
        yield _note(place.name, why, hint)


def _around(points: Averaged, form: Form, name: str) -> Iterator[Finding]:
    """Angles that are known, more than one, and too few or too uneven for waves around the turn."""
    angles = np.mod(points.spindle_rad[~np.isnan(points.spindle_rad)], 2.0 * np.pi)
    different = len(np.unique(np.round(angles, 6)))
    lacking = [(n, needed) for n, needed in WAVES if n not in form.waves]
    if different > 1 and lacking:
        wave, needed = lacking[0]
        kind = ErrorKind.ECCENTRICITY if wave == 1 else ErrorKind.LOBING
        why = wording(
            "'{feature}': no {kind}; {count} angles of the part", feature=name, kind=str(kind), count=different
        )
        hint = wording("measure at {count} angles, evenly around the turn, in each place", count=needed)
        yield _note(name, why, hint)


def _note(feature: str, why: str, hint: str) -> Finding:
    return Finding(Severity.NOTE, Code.DIA_POINTS, why, hint, values={"feature": feature})
