"""A correction as JSON: what the command line prints and a service answers."""

import math

from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import between_cuts_words
from trueloop.report.turned.by_tool import by_tool_as_dict
from trueloop.report.turned.characteristics import characteristics_as_dicts
from trueloop.report.turned.features import FeatureSummary, feature_summaries, worst_of
from trueloop.report.turned.summary import headline
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM


def correction_as_dict(correction: Correction) -> dict[str, object]:
    """A correction; numbers that are not known are None.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> trueloop.correction_as_dict(trueloop.compensate(job.inputs))["program_to_run"]
    'corrected.nc'
    """
    return {
        "part": correction.part,
        "record_id": correction.record.id,
        "program_to_run": correction.name_to_run,
        "features": [_feature(summary) for summary in feature_summaries(correction)],
        "headline": headline(correction),
        "characteristics": characteristics_as_dicts(correction.characteristics),
        "predicted_is": "a prediction, not a measurement; expanded uncertainties hold 95 %",
        "between_cuts": between_cuts_words(correction.options.between_cuts),
        "components": [vars(one) for one in correction.record.components],
        "by_tool": by_tool_as_dict(correction),
        "tool_offset": {**correction.wear.as_dict(), "leaves": _left_by_offset(correction)},
        "decision": {"x": correction.decision.x.words, "z": correction.decision.z.words},
        "suspect_touches": [one.as_dict() for one in correction.model.suspects],
        "notes": list(correction.notes),
    }


def _feature(of: FeatureSummary) -> dict[str, object]:
    """`predicted_worst_um` and `predicted_expanded_u_um` are those along a feature without touches."""
    at_touches = of.figures
    return {
        "feature": of.feature,
        "touches": at_touches.touches,
        "correction": of.correction,
        "before_rms_um": _known(at_touches.before_rms_um),
        "before_worst_um": _known(at_touches.before_worst_um),
        "predicted_rms_um": _known(at_touches.predicted_rms_um),
        "predicted_worst_um": _known(of.expected_um),
        "predicted_expanded_u_um": _known(of.expanded_u_um),
        "expected": of.expected,
        "standard_u_um": of.standard_u_um,
    }


def _left_by_offset(correction: Correction) -> list[dict[str, object]]:
    """What the tool offset alone would leave at each feature's touches, µm."""
    left_um = correction.left_by_offset_mm * UM_PER_MM
    rows = [(name, left_um[correction.touches.of_feature(i)]) for i, name in enumerate(correction.profile.names)]
    return [{"feature": name, "rms_um": rms(left), "worst_um": worst_of(left)} for name, left in rows if len(left)]


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
