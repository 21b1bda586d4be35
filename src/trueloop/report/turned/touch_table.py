"""The numbers: every touch with what was measured, fitted and predicted, as a table and as CSV.

The decisions of a correction in words.
"""

import csv
import io
import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Composed, Correction
from trueloop.report.markup import esc, items, section, table
from trueloop.report.shape import known
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.turned.shapes import TouchShape
from trueloop.turned.compensation.displaced import CentrePiece
from trueloop.turned.program.by_tool import ByTool, MovedFeature
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

SAMPLES = 101
RESOLVED_UM = 0.1


def decisions(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes offset or contour, the curves' models, what was commanded, weight, limits, and the loop's notes (HTML)."""
    program = (commanded_words(correction), weight_words(correction), limit_words(correction), *correction.notes)
    groups = {
        say("Offset or contour"): dict.fromkeys((*correction.decision.words, *correction.record.decision)),
        say("Error curves"): correction.model.notes,
        say("Program and limits"): program,
    }
    return "".join(
        f"<h3>{heading}</h3>{items(esc(say.note(word)) for word in words)}" for heading, words in groups.items()
    )


def commanded_words(correction: Correction) -> str:
    """Describes what of the measured errors was commanded, where the semi-finish program deviates from the nominal."""
    commanded_um = correction.commanded_mm * UM_PER_MM
    worst = int(np.argmax(np.abs(commanded_um)))
    if abs(commanded_um[worst]) < RESOLVED_UM:
        return wording("The programmed contour is the nominal one: all of the measured error is the process's.")
    return wording(
        "The program that cut the measured surface deviates from the nominal by up to {off} (point {point}). The "
        "touches contain that; error curves and predictions do not.",
        off=Um(float(correction.commanded_mm[worst]), "+.1f"),
        point=correction.touches.point[worst],
    )


def weight_words(correction: Correction) -> str:
    """Describes what share of the error is taken out."""
    weight = correction.options.weight
    some = wording("{percent:.0f} % of it, the rest stays for the next part", percent=100.0 * weight)
    return wording(
        "Weight {weight:g}: of the fitted process error the correction takes out {share}.",
        weight=float(weight),
        share=wording("all of it") if weight == 1 else some,
    )


def limit_words(correction: Correction) -> str:
    """Describes the limits, and how near the correction came to the one on size."""
    limits = correction.options.limits
    peak_um, feature = max(_peaks_um(correction.corrected), key=lambda peak: abs(peak[0]))
    return wording(
        "The contour moves by at most {peak} ({feature}); accepted are {most}, a slope of {slope:g} µm/mm and touches "
        "no older than {age:g} h. Curves are written within {chord}.",
        peak=Um(abs(peak_um) / UM_PER_MM),
        feature=feature,
        most=Um(limits.correction_mm, "g"),
        slope=float(limits.slope * UM_PER_MM),
        age=float(limits.age_hours),
        chord=Um(correction.options.chord_tolerance_mm, "g"),
    )


def _peaks_um(contour: tuple[CentrePiece, ...]) -> Iterator[tuple[float, str]]:
    for shifted in (piece.shifted for piece in contour):
        feature = shifted.feature
        values = shifted.off_nominal_mm(np.linspace(0.0, feature.length_mm, SAMPLES))
        yield float(values[np.argmax(np.abs(values))]) * UM_PER_MM, feature.name


def by_tool_lines(correction: Correction) -> list[str]:
    """The answer, what the contour would take out beyond it, and what the offset moves; [] where none comes first."""
    of = correction.by_tool
    return [of.words, of.beyond_words, of.moved_words] if of is not None and of.comes_first else []


def by_tool_block(correction: Correction, say: Texts = ENGLISH) -> str:
    """Returns the offsets by tool for the page (HTML); empty where no offset comes first."""
    lines = [say.note(line) for line in by_tool_lines(correction)]
    if not lines:
        return ""
    answer, *more = (esc(line) for line in lines)
    return f"<p id='by-tool'><strong>{answer}</strong><br>{'<br>'.join(more)}</p>"


def by_tool_as_dict(correction: Correction) -> dict[str, object] | None:
    """Converts the answer to a dict, whether it comes first or not; None where a machine model takes part."""
    of = correction.by_tool
    if of is None:
        return None
    return {
        "words": of.words,
        "comes_first": of.comes_first,
        "tools": [vars(tool) for tool in of.tools],
        "share": of.share,
        "beyond": _beyond(of),
        "features": [_feature(feature) for feature in of.features],
    }


def _beyond(of: ByTool) -> dict[str, object]:
    x, z = of.at_mm
    return {"um": of.beyond_mm * UM_PER_MM, "feature": of.beyond_on, "x_radius_mm": x, "z_mm": z}


def _feature(of: MovedFeature) -> dict[str, object]:
    return {
        "feature": of.feature,
        "moved_low_um": of.low_mm * UM_PER_MM,
        "moved_high_um": of.high_mm * UM_PER_MM,
        "own_correction_um": of.own_mm * UM_PER_MM,
        "moved_there_um": of.moved_mm * UM_PER_MM,
        "touched": of.touched,
        "against": of.against,
    }


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
