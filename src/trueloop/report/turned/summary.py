"""The head of the report: the verdict in few sentences, and before and after of every feature."""

from collections.abc import Iterator

import numpy as np

from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc, table
from trueloop.report.style import plain, signed
from trueloop.report.turned.features import TouchFigures, feature_summaries, touch_figures, worst_of
from trueloop.units import UM_PER_MM

HEADINGS = (
    "feature", "touches", "before<br>RMS µm", "before<br>worst µm", "after<br>RMS µm", "after<br>worst µm",
    "left out<br>RMS µm", "largest U<br>µm", "correction",
)  # fmt: skip


def verdict(correction: Correction) -> str:
    """What to cut with and what to expect: at the touches, and of features without any (HTML)."""
    expected, point, feature = _worst_touch(correction)
    return (
        f"Finish with <code>{esc(correction.name_to_run)}</code>: the worst error is expected to be "
        f"<strong>{expected} µm</strong> at point {esc(point)} on {esc(feature)} "
        f"(worst measured before: {signed(worst_of(correction.prediction.before_mm) * UM_PER_MM)} µm)."
        + "".join(f" {esc(words)}" for words in _untouched_words(correction))
    )


def headline(correction: Correction) -> str:
    """What to expect, as plain text: the worst touch, the widest uncertainty, and features without a touch."""
    expected, point, feature = _worst_touch(correction)
    first = f"Worst expected error at a touch: {expected} µm, at point {point} on {feature}."
    return " ".join([first, *_untouched_words(correction)])


def _worst_touch(correction: Correction) -> tuple[str, str, str]:
    """The touch with the largest expected error: that with U in µm, its point, its feature."""
    touches, prediction = correction.touches, correction.prediction
    k = int(np.argmax(np.abs(prediction.after_mm)))
    after, u = prediction.after_mm[k] * UM_PER_MM, prediction.expanded_u_mm[k] * UM_PER_MM
    return f"{signed(after)} ± {plain(u)}", touches.point[k], correction.profile.names[touches.feature_index[k]]


def _untouched_words(correction: Correction) -> Iterator[str]:
    """A sentence on the features without a touch: what is expected of each, and how sure that is."""
    untouched = [f"{one.feature} {one.expected}" for one in feature_summaries(correction) if not one.figures.touches]
    if untouched:
        yield f"Without a touch: {'; '.join(untouched)}."


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
    rows = [_row(one.feature, one.figures, one.expanded_u_um, one.correction) for one in feature_summaries(correction)]
    every = touch_figures(correction, np.arange(len(correction.touches.point)))
    widest_um = float(np.max(correction.prediction.expanded_u_mm)) * UM_PER_MM
    return table(HEADINGS, [*rows, _row("all touches", every, widest_um, "")], words=(0, 8), name="features")


def _row(name: str, of: TouchFigures, u_um: float, kind: str) -> list[str]:
    return [
        esc(name), str(of.touches), plain(of.before_rms_um), signed(of.before_worst_um), plain(of.predicted_rms_um),
        signed(of.predicted_worst_um), plain(of.left_out_rms_um), plain(u_um), kind,
    ]  # fmt: skip
