"""The head of the report: the verdict in few sentences, and before and after of every feature."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import Outcome, outcomes
from trueloop.report.markup import esc, table
from trueloop.report.style import plain, signed
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

HEADINGS = (
    "feature", "touches", "before<br>RMS µm", "before<br>worst µm", "after<br>RMS µm", "after<br>worst µm",
    "left out<br>RMS µm", "largest U<br>µm", "correction",
)  # fmt: skip


STAYS_MM = 5e-5
"""A cut that moves by less stays where it is."""


def verdict(correction: Correction) -> str:
    """What to cut with and what to expect: at the touches, and of features without any (HTML)."""
    touches, prediction = correction.touches, correction.prediction
    worst = int(np.argmax(np.abs(prediction.after_mm)))
    feature = correction.profile.names[touches.feature_index[worst]]
    after = signed(prediction.after_mm[worst] * UM_PER_MM)
    expanded = plain(prediction.expanded_u_mm[worst] * UM_PER_MM)
    return (
        f"Finish with <code>{esc(correction.name_to_run)}</code>: the worst error is expected to be "
        f"<strong>{after} ± {expanded} µm</strong> at point {esc(touches.point[worst])} on {esc(feature)} "
        f"(worst measured before: {signed(worst_of(prediction.before_mm) * UM_PER_MM)} µm)."
        + "".join(f" {esc(words)}" for words in untouched_words(correction))
    )


def headline(correction: Correction) -> str:
    """What to expect, as plain text: the worst touch, the widest uncertainty, and features without a touch."""
    touches, prediction = correction.touches, correction.prediction
    worst = int(np.argmax(np.abs(prediction.after_mm)))
    expected = (
        f"{signed(prediction.after_mm[worst] * UM_PER_MM)} ± {plain(prediction.expanded_u_mm[worst] * UM_PER_MM)}"
    )
    feature = correction.profile.names[touches.feature_index[worst]]
    first = f"Worst expected error at a touch: {expected} µm, at point {touches.point[worst]} on {feature}."
    return " ".join([first, *untouched_words(correction)])


def untouched_words(correction: Correction) -> Iterator[str]:
    """A sentence on the features without a touch: what is expected of each, and how sure that is."""
    told = [
        f"{_name(correction, one)} {expected_words(correction, one)}" for one in outcomes(correction) if not one.touched
    ]
    if told:
        yield f"Without a touch: {'; '.join(told)}."


def expected_words(correction: Correction, outcome: Outcome) -> str:
    """Expected error and its expanded uncertainty in µm; a feature that is left as programmed is called so."""
    u = plain(outcome.expanded_u_mm * UM_PER_MM)
    if is_left(correction, outcome.index):
        return f"left as programmed ± {u} µm"
    return f"{signed(outcome.expected_mm * UM_PER_MM)} ± {u} µm"


def is_left(correction: Correction, index: int) -> bool:
    """Whether a feature's cut stays as programmed because nothing is known of its error: no offset moves it either."""
    feature = correction.profile.features[index]
    normals = feature.outward_normal(np.linspace(0.0, feature.length_mm, 17))
    moved = normals @ np.array(correction.decision.offset_mm) * correction.by_offset[index]
    return correction.model.curves[index].unsupported and bool(np.max(np.abs(moved)) < STAYS_MM)


def _name(correction: Correction, outcome: Outcome) -> str:
    return correction.profile.names[outcome.index]


def offset_words(correction: Correction) -> str:
    """The tool offset as numbers to enter, what it stands for, and what it leaves."""
    left_um = correction.left_by_offset_mm * UM_PER_MM
    worst = int(np.argmax(np.abs(left_um)))
    feature = correction.profile.names[correction.touches.feature_index[worst]]
    use = (
        f"enter it at the control once, then run {correction.source_name} as it is"
        if correction.runs_as_given
        else f"instead of {correction.name_to_run}, not with it"
    )
    return f"{correction.wear.words} ({use}; leaves up to {plain(abs(left_um[worst]))} µm, on {feature})"


def feature_table(correction: Correction) -> str:
    """A row a feature and one for all touches together."""
    names = correction.profile.names
    every = np.arange(len(correction.touches.point))
    u = [one.expanded_u_mm for one in outcomes(correction)]
    rows = [_row(correction, name, correction.touches.of_feature(i), i, u[i]) for i, name in enumerate(names)]
    widest = float(np.max(correction.prediction.expanded_u_mm))
    rows.append(_row(correction, "all touches", every, None, widest))
    return table(HEADINGS, rows, words=(0, 8), name="features")


def kind_of_correction(correction: Correction, index: int) -> str:
    """How a feature's error is described and corrected, in a few words."""
    curve = correction.model.curves[index]
    touches = len(correction.touches.of_feature(index))
    if is_left(correction, index):
        return "not touched: left as programmed"
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


def _row(correction: Correction, name: str, rows: NDArray[np.intp], index: int | None, u_mm: float) -> list[str]:
    prediction = correction.prediction
    before, after, left_out = (
        values[rows] * UM_PER_MM for values in (prediction.before_mm, prediction.after_mm, prediction.leave_one_out_mm)
    )
    known = left_out[np.isfinite(left_out)]
    kind = "" if index is None else kind_of_correction(correction, index)
    return [
        esc(name), str(len(rows)), plain(rms(before)), signed(worst_of(before)),
        plain(rms(after)), signed(worst_of(after)), plain(rms(known)),
        plain(u_mm * UM_PER_MM), kind,
    ]  # fmt: skip
