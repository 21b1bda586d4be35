"""Parts cut before and after a correction side by side, in lines for people and as JSON."""

import json

from trueloop.loops.surface.compare import Comparison, PartFigures, Spread
from trueloop.report.surface.compare_page import rows_of
from trueloop.report.surface.summary import as_words
from trueloop.units import UM_PER_MM


def comparison_summary(found: Comparison) -> dict[str, object]:
    """Both groups in figures, and what was noticed in their parts."""
    groups = {"before": found.before, "after": found.after}
    return {
        which: {
            "name": group.name,
            "parts": [_part(part) for part in group.figures],
            "worst_part": group.figures[group.worst].name,
            **{name.replace(" ", "_"): _spread(spreads[side]) for name, *spreads in rows_of(found)},
        }
        for side, (which, group) in enumerate(groups.items())
    } | {"findings": as_words(found.findings)}


def comparison_json(found: Comparison) -> bytes:
    """The same as a file."""
    return (json.dumps(comparison_summary(found), indent=1, ensure_ascii=False) + "\n").encode()


def comparison_lines(found: Comparison) -> list[str]:
    """The same as a table."""
    groups = (found.before, found.after)
    counts = [f"{which}: {len(group.kept)} parts" for which, group in zip(("before", "after"), groups, strict=True)]
    lines = [_line("Deviation in µm", counts, "after ÷ before")]
    for name, before, after in rows_of(found):
        cells = [f"{s.rms_mm * UM_PER_MM:.2f} RMS" for s in (before, after)]
        lines.append(_line(name, cells, _share(before.rms_mm, after.rms_mm)))
        ranges = [f"{s.low_mm * UM_PER_MM:+.1f} to {s.high_mm * UM_PER_MM:+.1f}" for s in (before, after)]
        lines.append(_line("  range", ranges))
    worst = [group.figures[group.worst] for group in groups]
    cells = [f"{part.measured.worst_mm * UM_PER_MM:+.1f} ({part.name})" for part in worst]
    return [*lines, _line("worst (part)", cells, _share(*(part.measured.worst_mm for part in worst)))]


def _line(name: str, cells: list[str], share: str = "") -> str:
    return f"{name:<22}{cells[0]:>22}{cells[1]:>22}" + (f"{share:>16}" if share else "")


def _share(before_mm: float, after_mm: float) -> str:
    return f"{abs(after_mm / before_mm):.2f}" if before_mm else "–"


def _part(part: PartFigures) -> dict[str, object]:
    spreads = {name: _spread(getattr(part, name)) for name in ("measured", "deterministic", "random")}
    return {"name": part.name, **spreads}


def _spread(spread: Spread) -> dict[str, float]:
    names = {"rms_um": spread.rms_mm, "low_um": spread.low_mm, "high_um": spread.high_mm, "worst_um": spread.worst_mm}
    return {name: value * UM_PER_MM for name, value in names.items()}
