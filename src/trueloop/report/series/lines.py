"""Series and proposals as lines for a terminal."""

import csv
import io
from collections.abc import Iterator
from typing import Final

from trueloop.domain.proposal import Proposal, ProposalClass, ProposalDecision
from trueloop.loops.post_process.series import stage_of
from trueloop.report.series.values import CharacteristicSeriesShape, SeriesShape
from trueloop.report.style import plain, signed
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM

COLUMNS: Final = (
    "part_type", "characteristic", "part", "measured_um", "correction_um", "left_um", "predicted_um", "band_um",
    "inside", "weight", "drift_um", "alarm", "tool_set",
)  # fmt: skip


def series_csv(series: SeriesShape) -> str:
    """Errors before (`measured_um`) and after correction (`left_um`), with what was predicted from earlier parts."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for of_it in series.characteristics:
        for part in of_it.parts:
            sizes = (part.before_um, part.correction_um, part.after_um, part.expected_um, part.band_um)
            writer.writerow([
                *(series.part_type, of_it.characteristic, part.serial),
                *("" if size is None else f"{size:.3f}" for size in sizes),
                *("" if part.inside is None else int(part.inside), f"{part.weight:.4f}"),
                *("" if part.drift_um is None else f"{part.drift_um:.3f}", int(part.alarm), int(part.tool_set)),
            ])  # fmt: skip
    return text.getvalue()


HEAD = (
    "characteristic",
    "parts",
    "last µm",
    "level µm",
    "± µm",
    "weight",
    "drift µm",
    "alarm",
    "next µm",
    "P in",
    "Ppk",
)


def status_rows(series: SeriesShape) -> Iterator[tuple[str, ...]]:
    """Cells of a table, one row a characteristic."""
    for characteristic in series.characteristics:
        yield _row(characteristic)


def _row(series: CharacteristicSeriesShape) -> tuple[str, ...]:
    last, ahead = series.parts[-1], series.next
    share = None if ahead is None else ahead.probability_after
    return (
        series.characteristic if series.latest else f"{series.characteristic} (earlier)",
        str(len(series.parts)),
        signed(last.after_um),
        "" if series.level_um is None else signed(series.level_um),
        "" if series.level_band_um is None else plain(series.level_band_um),
        plain(last.weight, 2),
        "" if last.drift_um is None else plain(last.drift_um, 2),
        "" if series.open_alarm is None else f"part {series.open_alarm}",
        "" if ahead is None else signed(ahead.size_change_um),
        "" if share is None else f"{100 * share:.1f} %",
        "" if series.capability is None else f"{series.capability.ppk:.2f} ≥ {series.capability.lower:.2f}",
    )


def replay_rows(series: SeriesShape) -> Iterator[tuple[str, ...]]:
    """Yields the head, then one row a characteristic: what each rule would have left, and how many bands held."""
    rules = tuple(series.characteristics[0].left_rms_um) if series.characteristics else ()
    yield ("characteristic", "parts", *rules, "inside bands", "alarms")
    for characteristic in series.characteristics:
        later = characteristic.parts[1:]
        inside = f"{sum(bool(part.inside) for part in later)} of {len(later)}"
        alarms = ", ".join(part.serial for part in characteristic.parts if part.alarm)
        yield (
            characteristic.characteristic,
            str(len(characteristic.parts)),
            *(plain(characteristic.left_rms_um[r], 2) for r in rules),
            inside,
            alarms,
        )


def proposal_lines(proposal: Proposal, decision: ProposalDecision | None) -> Iterator[str]:
    """Yields the lines of a proposal: id, class and stage, its effect on each characteristic, and the decision."""
    verdict = "waits for a decision" if decision is None else f"{decision.verdict} by {decision.who}"
    yield f"{proposal.id}  {proposal.changes}, stage {stage_of(proposal.changes)}: {verdict}"
    if proposal.changes is ProposalClass.MEMORY:
        yield f"  learn anew from part {proposal.from_serial}"
    if proposal.weight is not None:
        yield f"  weight factor {proposal.weight:.2f}"
    for effect in proposal.effects:
        change, before, after = (
            signed(mm * UM_PER_MM) for mm in (effect.size_change_mm, effect.error_before_mm, effect.error_after_mm)
        )
        band = plain(NORMAL_95 * effect.standard_u_mm * UM_PER_MM)
        share = ""
        if effect.probability_in_before is not None and effect.probability_in_after is not None:
            share = (
                f", in tolerance {100 * effect.probability_in_before:.1f} → {100 * effect.probability_in_after:.1f} %"
            )
        yield f"  {effect.characteristic}: size {change} µm; error {before} → {after} ± {band} µm{share}"
    for alarm in proposal.alarms:
        yield f"  alarm: {alarm}"
    yield f"  {proposal.why}"


def proposal_as_dict(proposal: Proposal, decision: ProposalDecision | None) -> dict[str, object]:
    """Returns a proposal and its decision as JSON-ready values."""
    offset = proposal.tool_offset
    return {
        "id": proposal.id,
        "class": proposal.changes.value,
        "stage": int(stage_of(proposal.changes)),
        "part_type": proposal.part_type.name,
        "after_part": proposal.last_serial,
        "made_at": proposal.made_at.isoformat(),
        "made_by": proposal.made_by,
        "effects": [
            {
                "characteristic": effect.characteristic,
                "parts": effect.parts,
                "size_change_um": round(effect.size_change_mm * UM_PER_MM, 4),
                "error_before_um": round(effect.error_before_mm * UM_PER_MM, 4),
                "error_after_um": round(effect.error_after_mm * UM_PER_MM, 4),
                "standard_u_um": round(effect.standard_u_mm * UM_PER_MM, 4),
                "probability_in_before": effect.probability_in_before,
                "probability_in_after": effect.probability_in_after,
                "weight": effect.weight,
            }
            for effect in proposal.effects
        ],
        "tool_offset": None
        if offset is None
        else {"tool": offset.tool, "x_radius_mm": offset.x_radius_mm, "z_mm": offset.z_mm, "x_is": offset.x_is},
        "weight": proposal.weight,
        "from_part": proposal.from_serial or None,
        "alarms": list(proposal.alarms),
        "why": proposal.why,
        "decision": None if decision is None else decision_as_dict(decision),
    }


def decision_as_dict(decision: ProposalDecision) -> dict[str, object]:
    """Returns a decision as JSON-ready values."""
    return {
        "proposal": decision.proposal,
        "verdict": decision.verdict,
        "who": decision.who,
        "at": decision.at.isoformat(),
        "why": decision.why,
        "automatic": decision.automatic,
        "overrides": list(decision.overrides),
    }
