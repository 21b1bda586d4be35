"""What `compensate` and `demo` say in the end: before, predicted after, why, and where the files are."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trueloop.cli.terminal import wide_console
from trueloop.loops.correction import Correction
from trueloop.report.style import plain, signed
from trueloop.report.summary import kind_of_correction, worst_of
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class FeatureSummary:
    """One feature's errors in µm: measured before, predicted after; `nan` where nothing was touched.

    `predicted_expanded_u_um` is the largest expanded uncertainty of a prediction at the feature's touches.
    """

    feature: str
    touches: int
    correction: str
    before_rms_um: float
    before_worst_um: float
    predicted_rms_um: float
    predicted_worst_um: float
    predicted_expanded_u_um: float


def feature_summaries(correction: Correction) -> list[FeatureSummary]:
    """One for each feature of the profile, in its order."""
    return [_of_feature(correction, index, name) for index, name in enumerate(correction.profile.names)]


def _of_feature(correction: Correction, index: int, name: str) -> FeatureSummary:
    rows, prediction = correction.touches.of_feature(index), correction.prediction
    before, after, u = (
        values[rows] * UM_PER_MM for values in (prediction.before_mm, prediction.after_mm, prediction.expanded_u_mm)
    )
    return FeatureSummary(
        feature=name,
        touches=len(rows),
        correction=kind_of_correction(correction, index),
        before_rms_um=rms(before),
        before_worst_um=worst_of(before),
        predicted_rms_um=rms(after),
        predicted_worst_um=worst_of(after),
        predicted_expanded_u_um=float(np.max(u)) if len(u) else math.nan,
    )


def as_dict(correction: Correction, files: Sequence[Path]) -> dict[str, object]:
    """The summary as `--json` prints it; numbers that are not known are null."""
    k = correction.prediction.coverage_factor
    return {
        "part": correction.part,
        "record_id": correction.record.id,
        "program_to_run": correction.name_to_run,
        "features": [
            {key: _known(value) for key, value in vars(summary).items()} for summary in feature_summaries(correction)
        ],
        "predicted_is": f"a prediction, not a measurement; expanded uncertainty with k = {k:.2f} (95 %)",
        "decision": {"x": correction.decision.x.words, "z": correction.decision.z.words},
        "notes": list(correction.notes),
        "files": [str(path) for path in files],
    }


def _known(value: object) -> object:
    return None if isinstance(value, float) and math.isnan(value) else value


def print_summary(correction: Correction, files: Sequence[Path]) -> None:
    """The summary for people, on stdout."""
    from rich.table import Table

    console, k = wide_console(), correction.prediction.coverage_factor
    table = Table(box=None, pad_edge=False)
    table.add_column("feature", no_wrap=True)
    table.add_column("touches", justify="right")
    for heading in ("before\nRMS µm", "\nworst", "predicted\nRMS µm", "\nworst", f"\n±U (k = {k:.2f})"):
        table.add_column(heading, justify="right")
    table.add_column("correction")
    for line in feature_summaries(correction):
        before = plain(line.before_rms_um), signed(line.before_worst_um)
        after = plain(line.predicted_rms_um), signed(line.predicted_worst_um), plain(line.predicted_expanded_u_um)
        table.add_row(line.feature, str(line.touches), *before, *after, line.correction)
    console.print(f"[bold]{_escaped(correction.part)}[/], correction {correction.record.id}\n")
    console.print(table)
    console.print("\n+ is material left on. Predicted: if the finish cut errs as the semi-finish cut did.\n")
    for words in (correction.decision.x.words, correction.decision.z.words, *correction.notes):
        console.print(f"- {_escaped(words)}")
    console.print(f"\nRun [bold]{_escaped(correction.name_to_run)}[/]. Written:")
    for path in files:
        console.print(f"  {_escaped(str(path))}")


def _escaped(text: str) -> str:
    from rich.markup import escape

    return escape(text)
