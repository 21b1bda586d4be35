"""What of a composed correction is the machine's and what the process's, touch by touch."""

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Composed, Correction
from trueloop.report.markup import esc, section, table
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.units import UM_PER_MM


def composed_words(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes the ranges of both components at the touches, as plain text; empty where there is only COMP_PROC."""
    of = correction.composed
    if of is None:
        return ""
    mtg, proc = of.comp_mtg_mm, of.comp_proc_mm
    return say(
        "At the touches, {um}: COMP_MTG {mtg}; COMP_PROC {proc}; composed {both}.",
        mtg=_range(mtg, say),
        proc=_range(proc, say),
        both=_range(mtg + proc, say),
    )


def composed_section(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the section of the report, with a row a touch; empty where there is only COMP_PROC."""
    of = correction.composed
    if of is None:
        return ""
    return section(
        "composed",
        say("Machine and process"),
        f"<p>{esc(composed_words(correction, say))} ",
        say(
            "COMP_MTG is the machine's, −E at the finish cut's temperatures; COMP_PROC the process's. Along the "
            "outward normal, + is away from the material."
        ),
        "</p>",
        table(_headings(say), _rows(correction, of, say), words=(0, 1), name="components", stacks=True),
    )


def _headings(say: Texts) -> tuple[str, ...]:
    return (
        say("feature"), say("point"), say("reported<br>{um}"), say("part error<br>{um}"),
        say("of it E of<br>the cut before {um}"), say("COMP_MTG<br>{um}"), say("COMP_PROC<br>{um}"),
        say("composed<br>{um}"),
    )  # fmt: skip


def _rows(correction: Correction, of: Composed, say: Texts) -> list[list[str]]:
    touches, names = correction.touches, correction.profile.names
    numbers = UM_PER_MM * np.column_stack(
        [
            of.reported_mm, touches.error_mm, of.cut_in_mm, of.comp_mtg_mm, of.comp_proc_mm,
            of.comp_mtg_mm + of.comp_proc_mm,
        ]
    )  # fmt: skip
    return [
        [esc(names[feature]), esc(point), *map(say.error, row)]
        for feature, point, row in zip(touches.feature_index, touches.point, numbers.tolist(), strict=True)
    ]


def _range(values_mm: Array, say: Texts) -> str:
    low, high = (say.error(float(end) * UM_PER_MM) for end in (values_mm.min(), values_mm.max()))
    return say("{low} to {high}", low=low, high=high)
