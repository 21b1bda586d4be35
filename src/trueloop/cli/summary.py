"""What `compensate` and `demo` say in the end: before, predicted after, why, and where the files are."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from trueloop.cli.terminal import wide_console
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import Outcome, between_cuts_words, causes_um, outcomes
from trueloop.report.style import plain, signed
from trueloop.report.turned.composed import composed_words
from trueloop.report.turned.summary import expected_words, headline, kind_of_correction, offset_words, worst_of
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class FeatureSummary:
    """One feature's errors in µm: measured before, predicted after; `nan` where nothing was touched.

    `predicted_expanded_u_um` is the largest expanded uncertainty at the feature's touches or, without any, along it;
    `standard_u_um` what makes it up, by cause. `expected` says both in words.
    """

    feature: str
    touches: int
    correction: str
    before_rms_um: float
    before_worst_um: float
    predicted_rms_um: float
    predicted_worst_um: float
    predicted_expanded_u_um: float
    expected: str
    standard_u_um: dict[str, float]


def feature_summaries(correction: Correction) -> list[FeatureSummary]:
    """One for each feature of the profile, in its order."""
    return [_of_feature(correction, outcome) for outcome in outcomes(correction)]


def _of_feature(correction: Correction, outcome: Outcome) -> FeatureSummary:
    index, prediction = outcome.index, correction.prediction
    rows = correction.touches.of_feature(index)
    before, after = (values[rows] * UM_PER_MM for values in (prediction.before_mm, prediction.after_mm))
    return FeatureSummary(
        feature=correction.profile.names[index],
        touches=len(rows),
        correction=kind_of_correction(correction, index),
        before_rms_um=rms(before),
        before_worst_um=worst_of(before),
        predicted_rms_um=rms(after),
        predicted_worst_um=outcome.expected_mm * UM_PER_MM,
        predicted_expanded_u_um=outcome.expanded_u_mm * UM_PER_MM,
        expected=expected_words(correction, outcome),
        standard_u_um=causes_um(outcome.budget),
    )


def as_dict(correction: Correction, files: Sequence[Path]) -> dict[str, object]:
    """The summary as `--json` prints it; numbers that are not known are null."""
    return {
        "part": correction.part,
        "record_id": correction.record.id,
        "program_to_run": correction.name_to_run,
        "features": [
            {key: _known(value) for key, value in vars(summary).items()} for summary in feature_summaries(correction)
        ],
        "headline": headline(correction),
        "predicted_is": "a prediction, not a measurement; expanded uncertainties hold 95 %",
        "between_cuts": between_cuts_words(correction.options.between_cuts),
        "components": [vars(one) for one in correction.record.components],
        "tool_offset": {**correction.wear.as_dict(), "leaves": _left_by_offset(correction)},
        "decision": {"x": correction.decision.x.words, "z": correction.decision.z.words},
        "suspect_touches": [one.as_dict() for one in correction.model.suspects],
        "notes": list(correction.notes),
        "files": [str(path) for path in files],
    }


def _left_by_offset(correction: Correction) -> list[dict[str, object]]:
    """What the tool offset alone would leave at each feature's touches, µm."""
    left_um = correction.left_by_offset_mm * UM_PER_MM
    rows = [(name, left_um[correction.touches.of_feature(i)]) for i, name in enumerate(correction.profile.names)]
    return [{"feature": name, "rms_um": rms(left), "worst_um": worst_of(left)} for name, left in rows if len(left)]


def _known(value: object) -> object:
    return None if isinstance(value, float) and math.isnan(value) else value


def print_summary(correction: Correction, files: Sequence[Path]) -> None:
    """The summary for people, on stdout."""
    from rich.table import Table

    console = wide_console()
    table = Table(box=None, pad_edge=False)
    table.add_column("feature", no_wrap=True)
    table.add_column("touches", justify="right")
    for heading in ("before\nRMS µm", "\nworst", "predicted\nRMS µm", "\nworst", "\n±U (95 %)"):
        table.add_column(heading, justify="right")
    table.add_column("correction")
    for line in feature_summaries(correction):
        before = plain(line.before_rms_um), signed(line.before_worst_um)
        after = plain(line.predicted_rms_um), signed(line.predicted_worst_um), plain(line.predicted_expanded_u_um)
        table.add_row(line.feature, str(line.touches), *before, *after, line.correction)
    console.print(f"[bold]{_escaped(correction.part)}[/], correction {correction.record.id}\n")
    console.print(table)
    console.print(
        "\n+ is material left on. Predicted: what repeats is taken out; ±U holds what the finish cut may differ by."
    )
    console.print(f"[bold]{_escaped(headline(correction))}[/]\n")
    for words in (_budget_words(correction), between_cuts_words(correction.options.between_cuts)):
        console.print(f"- {_escaped(words)}")
    for words in (correction.decision.x.words, correction.decision.z.words, *correction.notes):
        console.print(f"- {_escaped(words)}")
    if correction.composed is not None:
        console.print(f"- {_escaped(composed_words(correction))}")
    console.print(f"\nTool offset: {_escaped(offset_words(correction))}")
    for block in correction.wear.blocks:
        console.print(f"  {_escaped(block)}")
    console.print(f"\nRun [bold]{_escaped(correction.name_to_run)}[/]. Written:")
    for path in files:
        console.print(f"  {_escaped(str(path))}")


def _budget_words(correction: Correction) -> str:
    """The largest of each cause over all features."""
    causes = [causes_um(outcome.budget) for outcome in outcomes(correction)]
    largest = {cause: max(one[cause] for one in causes) for cause in causes[0]}
    told = ", ".join(f"{cause} {plain(um)}" for cause, um in largest.items())
    return f"Uncertainty budget, largest standard uncertainties in µm: {told}."


def _escaped(text: str) -> str:
    from rich.markup import escape

    return escape(text)
