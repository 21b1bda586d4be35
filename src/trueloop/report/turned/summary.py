"""The head of the report: the verdict in few sentences, and before and after of every feature."""

from collections.abc import Iterator

import numpy as np

from trueloop.domain.life import Ran
from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc, table
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.turned.features import TouchFigures, feature_summaries, touch_figures, worst_of
from trueloop.units import UM_PER_MM


def verdict(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes what to cut with and what to expect: at the touches, and of features without any (HTML)."""
    expected, point, feature = _worst_touch(correction, say)
    before_um = worst_of(correction.prediction.before_mm) * UM_PER_MM
    return say(
        "Finish with <code>{program}</code>: the worst error is expected to be <strong>{expected} {um}</strong> at "
        "point {point} on {feature} (worst measured before: {before} {um}).",
        program=esc(correction.name_to_run),
        expected=expected,
        point=esc(point),
        feature=esc(feature),
        before=say.error(before_um),
    ) + "".join(f" {esc(words)}" for words in _untouched_words(correction, say))


def headline(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes what to expect, as plain text: the worst touch, the widest uncertainty, features without a touch."""
    expected, point, feature = _worst_touch(correction, say)
    first = say(
        "Worst expected error at a touch: {expected} {um}, at point {point} on {feature}.",
        expected=expected,
        point=point,
        feature=feature,
    )
    return " ".join([first, *_untouched_words(correction, say)])


def _worst_touch(correction: Correction, say: Texts) -> tuple[str, str, str]:
    """The touch with the largest expected error: that with U, its point, its feature."""
    touches, prediction = correction.touches, correction.prediction
    k = int(np.argmax(np.abs(prediction.after_mm)))
    after, u = prediction.after_mm[k] * UM_PER_MM, prediction.expanded_u_mm[k] * UM_PER_MM
    return f"{say.error(after)} ± {say.size(u)}", touches.point[k], correction.profile.names[touches.feature_index[k]]


def _untouched_words(correction: Correction, say: Texts) -> Iterator[str]:
    """A sentence on the features without a touch: what is expected of each, and how sure that is."""
    summaries = feature_summaries(correction, say)
    untouched = [f"{one.feature} {one.expected}" for one in summaries if not one.figures.touches]
    if untouched:
        yield say("Without a touch: {features}.", features="; ".join(untouched))


def to_run(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes what to finish with, and what else may take its place: one of them (HTML)."""
    program, joint = esc(correction.name_to_run), bool(correction.joint_name)
    if correction.recommended is Ran.WEAR:
        return say("Enter the tool offset, and run <code>{program}</code> as it is.", program=program)
    if correction.recommended is Ran.OFFSETS:
        return say(
            "Run <code>{program}</code>; or enter the tool offset instead and run <code>{given}</code> as it is.",
            program=program,
            given=esc(correction.source_name),
        )
    if joint or correction.by_tool is None:
        return say("Run <code>{program}</code>, the tool offset as it is.", program=program)
    return say(
        "Run <code>{program}</code>, the tool offset as it is. The offset below is instead of it, not with it.",
        program=program,
    )


def offset_words(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes the tool offset as numbers to enter, what it stands for, and what it leaves."""
    left_um = correction.left_by_offset_mm * UM_PER_MM
    worst = int(np.argmax(np.abs(left_um)))
    if correction.runs_as_given:
        use = say("enter it at the control once, then run {program} as it is", program=correction.name_to_run)
    elif correction.joint_name and correction.by_tool is None:
        use = say("not to be entered: the decisions say why")
    elif correction.joint_name:
        use = say("not with {program}, which moves this edge's contour instead", program=correction.name_to_run)
    else:
        use = say("instead of {program}, not with it", program=correction.name_to_run)
    return say(
        "{wear} ({use}; leaves up to {left} {um}, on {feature})",
        wear=correction.wear.words,
        use=use,
        left=say.size(abs(left_um[worst])),
        feature=correction.profile.names[correction.touches.feature_index[worst]],
    )


def feature_table(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the table: a row a feature and one for all touches together."""
    headings = (
        say("feature"), say("touches"), say("before<br>RMS {um}"), say("before<br>worst {um}"),
        say("after<br>RMS {um}"), say("after<br>worst {um}"), say("left out<br>RMS {um}"),
        say("largest U<br>{um}"), say("correction"),
    )  # fmt: skip
    summaries = feature_summaries(correction, say)
    rows = [_row(one.feature, one.figures, one.expanded_u_um, one.correction, say) for one in summaries]
    every = touch_figures(correction, np.arange(len(correction.touches.point)))
    widest_um = float(np.max(correction.prediction.expanded_u_mm)) * UM_PER_MM
    last = _row(say("all touches"), every, widest_um, "", say)
    return table(headings, [*rows, last], words=(0, 8), name="features", stacks=True)


def _row(name: str, of: TouchFigures, u_um: float, kind: str, say: Texts) -> list[str]:
    return [
        esc(name), str(of.touches), say.size(of.before_rms_um), say.error(of.before_worst_um),
        say.size(of.predicted_rms_um), say.error(of.predicted_worst_um), say.size(of.left_out_rms_um), say.size(u_um),
        esc(kind),
    ]  # fmt: skip
