"""The decisions of a correction in words."""

from collections.abc import Iterator

import numpy as np

from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc, items
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.turned.compensation.contour import CentrePiece
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
