"""Errors of features of the parts of [6811] Tables 4 and 7 to 11 after either cut, as the diagnosis finds them.

[6811] NISTIR 6811, Process-Intermittent Error Compensation, 2002.
"""

import textwrap
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Final, Literal

import numpy as np

from scripts.nist_parts import NistPart, parts
from trueloop.diagnosis.features.errors_of import errors_of
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError, FeaturePlace, SeenPoints
from trueloop.domain.inspection import Touch
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.profile import Profile

U_MM: Final = 0.0005
"""Standard uncertainty of one touch: 0.43 µm of a diameter [6811 §5.1], and 0.3 µm of the tables' whole micrometres."""
STRAIGHT_MM: Final = 1e-6
TOOL: Final = "T01"
Cut = Literal["semifinish", "finish"]


def places_of(profile: Profile) -> dict[str, FeaturePlace]:
    """Where each feature of a profile lies; one tool cut all of them."""
    return {one.name: _place(one) for one in profile.features}


def _place(one: Feature) -> FeaturePlace:
    (x0, z0), (x1, z1) = one.start_mm, one.end_mm
    kind = "cone"
    if isinstance(one, Arc):
        kind = "arc"
    elif abs(x1 - x0) < STRAIGHT_MM:
        kind = "shaft"
    elif abs(z1 - z0) < STRAIGHT_MM:
        kind = "face"
    return FeaturePlace(one.name, kind, (min(x0, x1), max(x0, x1)), (min(z0, z1), max(z0, z1)), TOOL)


def seen_points(part: NistPart, cut: Cut) -> SeenPoints:
    """The touches of one part after one cut."""
    touches: Sequence[Touch] = part.semifinish if cut == "semifinish" else part.finish
    nominal = np.array([one.nominal_mm for one in touches])
    at = part.profile.locate(nominal)
    features = [part.profile.features[int(index)] for index in at.feature_index]
    normal = [one.outward_normal(float(s)) for one, s in zip(features, at.arc_length_mm, strict=True)]
    n = len(touches)
    return SeenPoints(
        tuple(str(one.feature) for one in touches),
        nominal,
        np.array(normal),
        np.array([one.error_mm or 0.0 for one in touches]),
        np.full(n, U_MM),
        np.full(n, np.nan),
        np.ones(n, dtype=np.intp),
    )


@cache
def all_parts() -> tuple[NistPart, ...]:
    """The fourteen."""
    return tuple(parts())


def of_family(name: str) -> list[NistPart]:
    """Parts of one design, in the tables' order."""
    return [one for one in all_parts() if one.family.name == name]


def errors(part: NistPart, cut: Cut) -> dict[tuple[str, ErrorKind], FeatureError]:
    """Errors of its features after one cut, by feature and kind."""
    found = errors_of(seen_points(part, cut), places_of(part.profile))
    return {(one.feature, one.kind): one for one in found}


def table(head: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> str:
    """A table in Markdown; all but the first `words` columns are numbers."""
    rule = ["---"] * words + ["--:"] * (len(head) - words)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, rule, *rows))


def wrapped(text: str, indent: str = "") -> str:
    """A paragraph of lines of 120 characters."""
    return textwrap.fill(text, 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
