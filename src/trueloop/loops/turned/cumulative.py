"""What a correction is in all, and how much of it was in force when the measured part was cut, in words."""

from collections.abc import Iterator

import numpy as np

from trueloop.domain.cut_with import CutWith
from trueloop.domain.life import Ran
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.shifts import Shifts, whole_mm
from trueloop.turned.compensation.decide import Decision
from trueloop.wording import Um, listed, wording


def cumulative_words(inputs: Inputs, matched: Commanded, decision: Decision, shifts: Shifts) -> Iterator[str]:
    """Of a part that was cut with a correction in force; nothing where none was."""
    cut = inputs.in_force.cut_with
    if not cut.corrected:
        return
    whole = _offset_words(cut, decision) if decision.by_offset else _contour_words(inputs, matched, decision, shifts)
    yield wording(
        "The measured part was cut with {what}; this correction takes its place and is the whole one: {whole}.",
        what=cut.words,
        whole=whole,
    )
    if cut.wear_mm != (0.0, 0.0):
        x, z = (Um(value, "+.1f") for value in cut.wear_mm)
        yield wording(
            "X {x} (radius), Z {z} stand in the control's wear table and stay there: what is written or to be entered "
            "comes on top of them.",
            x=x,
            z=z,
        )


def _offset_words(cut: CutWith, decision: Decision) -> str:
    whole = [Um(value, "+.1f") for value in decision.whole_offset_mm]
    before = [Um(value, "+.1f") for value in cut.offset_mm]
    of = wording("of which X {x}, Z {z} were in force", x=before[0], z=before[1])
    if cut.ran is Ran.CORRECTED:
        of = wording("in place of the contour that was in force")
    return wording("tool offset X {x} (radius), Z {z}, {of}", x=whole[0], z=whole[1], of=of)


def _contour_words(inputs: Inputs, matched: Commanded, decision: Decision, shifts: Shifts) -> str:
    """At the middle of every feature that was measured, along its normal."""
    kept = np.array(inputs.in_force.cut_with.offset_mm)
    offset = kept + np.array(whole_mm(decision))
    found = []
    for index in dict.fromkeys(inputs.touches.feature_index.tolist()):
        feature = inputs.profile.features[index]
        s = feature.length_mm / 2
        total = float(shifts.contour[index].value_mm(s) + feature.outward_normal(s) @ offset)
        before = float(feature.outward_normal(s) @ kept)
        before += float(matched.in_force[index].value_mm(s)) if matched.in_force else 0.0
        found.append(
            wording(
                "{feature} {total}, of which {before} were in force",
                feature=feature.name,
                total=Um(total, "+.1f"),
                before=Um(before, "+.1f"),
            )
        )
    return listed(found)
