"""Every figure of a report, as it is drawn at its widest."""

from collections.abc import Iterator

from trueloop.loops.turned.correction import Correction
from trueloop.report.style import Figure
from trueloop.report.turned import whiskers
from trueloop.report.turned.curves import error_curve


def figures(correction: Correction) -> Iterator[Figure]:
    """Both views of the part, and a curve for each feature with two touches or more."""
    yield whiskers.before_and_after(correction)
    yield whiskers.after_enlarged(correction)
    for i in range(len(correction.profile.features)):
        if len(correction.touches.of_feature(i)) > 1:
            yield error_curve(correction, i)
