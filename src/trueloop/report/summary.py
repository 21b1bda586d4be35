"""The head of the report: the verdict in one sentence, and before and after of every feature."""

import numpy as np
from numpy.typing import NDArray

from trueloop.geometry.feature import Array
from trueloop.loops.correction import Correction
from trueloop.report.markup import esc, table
from trueloop.report.style import plain, signed
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

HEADINGS = (
    "feature", "touches", "before<br>RMS µm", "before<br>worst µm", "after<br>RMS µm", "after<br>worst µm",
    "left out<br>RMS µm", "correction",
)  # fmt: skip


def verdict(correction: Correction) -> str:
    """What to cut with and what to expect, in one sentence (HTML)."""
    touches, prediction = correction.touches, correction.prediction
    worst = int(np.argmax(np.abs(prediction.after_mm)))
    feature = correction.profile.names[touches.feature_index[worst]]
    after = signed(prediction.after_mm[worst] * UM_PER_MM)
    expanded = plain(prediction.expanded_u_mm[worst] * UM_PER_MM)
    return (
        f"Finish with <code>{esc(correction.name_to_run)}</code>: the worst error is expected to be "
        f"<strong>{after} ± {expanded} µm</strong> at point {esc(touches.point[worst])} on {esc(feature)} "
        f"(worst measured before: {signed(worst_of(prediction.before_mm) * UM_PER_MM)} µm)."
    )


def feature_table(correction: Correction) -> str:
    """A row a feature and one for all touches together."""
    names = correction.profile.names
    every = np.arange(len(correction.touches.point))
    rows = [_row(correction, name, correction.touches.of_feature(i), i) for i, name in enumerate(names)]
    return table(HEADINGS, [*rows, _row(correction, "all touches", every, None)], words=(0, 7), name="features")


def kind_of_correction(correction: Correction, index: int) -> str:
    """How a feature's error is described and corrected, in a few words."""
    curve = correction.model.curves[index]
    touches = len(correction.touches.of_feature(index))
    if correction.by_offset[index]:
        return "constant offset"
    if touches == 0:
        return "not touched: estimated"
    if curve.spline.degree == 0:
        return "one touch: constant" if touches == 1 else "constant"
    if curve.spline.degree == 1:
        return "straight line: size and taper"
    knots = len(curve.knots_mm)
    return f"{('', '', 'parabola', 'cubic spline')[curve.spline.degree]}, {knots} knot{'' if knots == 1 else 's'}"


def worst_of(values: Array) -> float:
    """The value of largest size, with its sign; nan of nothing."""
    return float(values[np.argmax(np.abs(values))]) if len(values) else float("nan")


def _row(correction: Correction, name: str, rows: NDArray[np.intp], index: int | None) -> list[str]:
    prediction = correction.prediction
    before, after, left_out = (
        values[rows] * UM_PER_MM for values in (prediction.before_mm, prediction.after_mm, prediction.leave_one_out_mm)
    )
    known = left_out[np.isfinite(left_out)]
    kind = "" if index is None else kind_of_correction(correction, index)
    return [
        esc(name), str(len(rows)), plain(rms(before)), signed(worst_of(before)),
        plain(rms(after)), signed(worst_of(after)), plain(rms(known)), kind,
    ]  # fmt: skip
