"""Every figure of a report, as it is drawn for a screen and for a telephone."""

from collections.abc import Iterator

from trueloop.loops.turned.correction import Correction
from trueloop.report.style import Figure
from trueloop.report.turned.figures import whiskers
from trueloop.report.turned.figures.curves import error_curve
from trueloop.report.turned.page import WIDTHS
from trueloop.report.turned.sources import source_bars


def figures(correction: Correction) -> Iterator[Figure]:
    """Both views of the part, the sources of its errors, and a curve for each feature with two touches or more; each in
    two widths.
    """
    for width in WIDTHS.values():
        yield whiskers.before_and_after(correction, width)
        yield whiskers.after_enlarged(correction, width)
        yield source_bars(correction, width)
        for i in range(len(correction.profile.features)):
            if len(correction.touches.of_feature(i)) > 1:
                yield error_curve(correction, i, width)
