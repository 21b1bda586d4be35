"""The numbers: every touch with what was measured, fitted and predicted, as a table and as CSV."""

import csv
import io
import math
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Composed, Correction
from trueloop.report.markup import esc, section, table
from trueloop.report.shape import known
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.turned.shapes import TouchShape
from trueloop.units import UM_PER_MM

MM: Final = 4
UM: Final = 2


def touch_rows(correction: Correction) -> list[TouchShape]:
    """Returns one row a touch, along the profile; `commanded_um`: what the semi-finish program meant of the error."""
    touches, prediction = correction.touches, correction.prediction
    fitted = np.array(
        [
            correction.model.curves[i].value_mm(s)[0]
            for i, s in zip(touches.feature_index, touches.arc_length_mm, strict=True)
        ]
    )
    lengths = np.column_stack([touches.nominal_mm, touches.arc_length_mm])
    errors = UM_PER_MM * np.column_stack(
        [
            touches.error_mm, correction.commanded_mm, touches.standard_u_mm, fitted,
            prediction.after_mm, prediction.leave_one_out_mm, prediction.standard_u_mm,
        ]
    )  # fmt: skip
    names = correction.profile.names
    bad = np.full(len(touches.point), np.nan)
    for suspect in correction.model.suspects:
        bad[suspect.position] = round(suspect.probability, 4)
    weights = correction.model.weight
    numbers = np.column_stack([np.round(lengths, MM), np.round(errors, UM), weights, bad]) + 0.0  # no negative zeros
    return [
        TouchShape(**dict(zip(TouchShape.model_fields, (names[feature], point, *map(known, row)), strict=True)))
        for feature, point, row in zip(touches.feature_index, touches.point, numbers.tolist(), strict=True)
    ]


def touches_csv(correction: Correction) -> str:
    """Writes the rows with the column names as header; empty where nothing is known. CR LF as RFC 4180 wants it."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(TouchShape.model_fields)
    for row in touch_rows(correction):
        writer.writerow(value for _, value in row)
    return text.getvalue()


def touches_table(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the rows as HTML, errors to 0.1 µm."""
    headings = (
        say("feature"), say("point"), say("x, radius<br>{mm}"), say("z<br>{mm}"), say("arc length<br>{mm}"),
        say("before<br>{um}"), say("u gauging<br>{um}"), say("fitted<br>{um}"), say("after<br>{um}"),
        say("left out<br>{um}"), say("u after<br>{um}"), say("weight"),
    )  # fmt: skip
    from_here = f' <abbr title="{say("the part&#39;s z was taken from here")}">{say("z ref.")}</abbr>'
    rows = []
    for row, reference in zip(touch_rows(correction), correction.touches.at_reference, strict=True):
        mark = from_here if reference else ""
        lengths = (row.nominal_x_mm, row.nominal_z_mm, row.arc_length_mm)
        rows.append(
            [
                esc(row.feature),
                esc(row.point) + mark,
                *(say.mm(value) for value in lengths),
                say.error(row.error_before_um),
                say.size(row.gauging_standard_u_um, 2),
                say.error(row.fitted_um),
                say.error(row.predicted_after_um),
                say.error(math.nan if row.leave_one_out_um is None else row.leave_one_out_um),
                say.size(row.predicted_standard_u_um, 2),
                _weight(row, say),
            ]
        )
    return table(headings, rows, words=(0, 1), name="touches")


def _weight(row: TouchShape, say: Texts) -> str:
    """Weight in the fit, and how likely a touch is bad that the others contradict (HTML)."""
    if row.probability_bad is None:
        return say.number(row.weight, 0)
    bad = say("(bad: {percent:.1f} %)", percent=100.0 * row.probability_bad)
    return f"<strong>{say.number(row.weight, 0)}</strong> {bad}"


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
