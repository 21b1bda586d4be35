"""The decisions of a correction in words."""

from collections.abc import Iterator

import numpy as np

from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc, items
from trueloop.report.style import plain, signed
from trueloop.turned.compensation.contour import CentrePiece
from trueloop.units import UM_PER_MM

SAMPLES = 101
RESOLVED_UM = 0.1


def decisions(correction: Correction) -> str:
    """Offset or contour, the curves' models, what was commanded, weight, limits, and the loop's own notes (HTML)."""
    axes = (correction.decision.x.words, correction.decision.z.words)
    program = (commanded_words(correction), weight_words(correction), limit_words(correction), *correction.notes)
    groups = {
        "Offset or contour": dict.fromkeys((*axes, *correction.record.decision)),
        "Error curves": correction.model.notes,
        "Program and limits": program,
    }
    return "".join(f"<h3>{heading}</h3>{items(map(esc, words))}" for heading, words in groups.items())


def commanded_words(correction: Correction) -> str:
    """What of the measured errors was commanded: where the semi-finish program itself deviates from the nominal."""
    commanded_um = correction.commanded_mm * UM_PER_MM
    worst = int(np.argmax(np.abs(commanded_um)))
    if abs(commanded_um[worst]) < RESOLVED_UM:
        return "The programmed contour is the nominal one: all of the measured error is the process's."
    return (
        "The program that cut the measured surface deviates from the nominal by up to "
        f"{signed(commanded_um[worst])} µm (point {correction.touches.point[worst]}). "
        "The touches contain that; error curves and predictions do not."
    )


def weight_words(correction: Correction) -> str:
    """What share of the error is taken out."""
    weight = correction.options.weight
    share = "all of it" if weight == 1 else f"{weight:.0%} of it, the rest stays for the next part"
    return f"Weight {weight:g}: of the fitted process error the correction takes out {share}."


def limit_words(correction: Correction) -> str:
    """The limits, and how near the correction came to the one on size."""
    limits = correction.options.limits
    peak_um, feature = _peak_um(correction.corrected)
    return (
        f"The contour moves by at most {plain(abs(peak_um))} µm ({feature}); accepted are "
        f"{limits.correction_mm * UM_PER_MM:g} µm, a slope of {limits.slope * UM_PER_MM:g} µm/mm and touches no older "
        f"than {limits.age_hours:g} h. Curves are written within "
        f"{correction.options.chord_tolerance_mm * UM_PER_MM:g} µm."
    )


def _peak_um(contour: tuple[CentrePiece, ...]) -> tuple[float, str]:
    """The shift of largest size with its sign, and the feature it is on."""
    return max(_peaks_um(contour), key=lambda peak: abs(peak[0]))


def _peaks_um(contour: tuple[CentrePiece, ...]) -> Iterator[tuple[float, str]]:
    for shifted in (piece.shifted for piece in contour):
        feature = shifted.feature
        values = shifted.off_nominal_mm(np.linspace(0.0, feature.length_mm, SAMPLES))
        yield float(values[np.argmax(np.abs(values))]) * UM_PER_MM, feature.name
