"""NIST's twenty covers replayed: the table of docs/series.md.

    python -m scripts.cover_series CORPUS

CORPUS holds data/public/qif/nist-cover-20-parts.QIF: twenty covers with 27 readings each, of one measuring machine. The
file states no unit of length; its values are millimetres.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Finding
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.loops.post_process.decide import usable
from trueloop.loops.post_process.series import PartSeen, series_of
from trueloop.loops.post_process.tracked import RULES, Replay, replay
from trueloop.units import UM_PER_MM

FILE: Final = Path("data/public/qif/nist-cover-20-parts.QIF")
PAGE: Final = Path(__file__).parents[1] / "docs" / "series.md"
BEGIN: Final = "<!-- written by scripts/cover_series.py -->\n"
END: Final = "<!-- end -->\n"
RULES_SHOWN: Final = ("measured", "memory", *RULES)


def replays_of(corpus: Path) -> tuple[list[Replay], tuple[Finding, ...]]:
    """The series of the covers replayed, and what is odd about the parts."""
    file = read_measured_file(corpus / FILE, StatedFacts("mm"))
    parts, findings = usable([PartSeen(one) for one in file.inspections], take_nominal=False)
    return [replay(one) for one in series_of(parts)], findings


def table(replays: Sequence[Replay]) -> str:
    """Root mean squares in µm over all parts but the first, and over those from the sixth on."""
    columns = ("characteristic", "as measured", "memory", "mean of all before", "0.75 of the one before")
    late = ("memory, from the 6th", "mean, from the 6th", "bands held")
    lines = [f"| {' | '.join([*columns, *late])} |\n", "|---|" + "---|" * 7 + "\n"]
    for one in replays:
        left = [f"{(one.rms_mm(rule) or 0.0) * UM_PER_MM:.1f}" for rule in RULES_SHOWN]
        later = [f"{_late_um(one, rule):.1f}" for rule in ("memory", next(iter(RULES)))]
        lines.append(f"| {one.series.name} | {' | '.join([*left, *later])} | {one.inside[0]} of {one.inside[1]} |\n")
    return "".join(lines)


def _late_um(one: Replay, rule: str) -> float:
    return float(np.sqrt(np.mean(np.square(one.left_mm(rule)[5:])))) * UM_PER_MM


def sentences(replays: Sequence[Replay]) -> str:
    """How often each rule leaves least, and how many bands held."""
    least = dict.fromkeys(RULES_SHOWN, 0)
    for one in replays:
        left = {rule: one.rms_mm(rule) or 0.0 for rule in RULES_SHOWN}
        least[min(left, key=lambda rule: left[rule])] += 1
    held, of = (sum(one.inside[k] for one in replays) for k in (0, 1))
    words = ", ".join(f"{rule} on {count}" for rule, count in least.items())
    worse = [one.series.name for one in replays if (one.rms_mm() or 0.0) >= (one.rms_mm("measured") or 0.0)]
    return (
        f"\nLeast is left by: {words}, of {len(replays)} characteristics. No better than doing nothing: "
        f"{', '.join(worse) or 'none'}. {held} of {of} bands held ({100 * held / of:.1f} %).\n"
    )


def main(corpus: Path) -> None:
    """Puts the table into the page."""
    replays, findings = replays_of(corpus)
    flagged = "".join(f"\n`{one.code}`: {one.message}.\n" for one in findings)
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    PAGE.write_text(before + BEGIN + table(replays) + sentences(replays) + flagged + END + after, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
