"""Makes docs/performance.md from the ratios that `make bench KEEP=1` keeps."""

from itertools import groupby
from typing import Final

from benches.ratio import kept

HEAD: Final = """# Performance

How many times as long as trueloop the tool takes that a user would pick instead. Both are timed in turn in one run
(`make bench`), each ratio is the median over rounds; below 1 the other one is faster. `make bench KEEP=1` keeps the
ratios of a version, and a later run names those that fell by a third. Absolute times depend on the computer: a run
prints them.
"""


def page() -> str:
    """Returns the page: a table for each comparison, with a column for each version."""
    ratios = sorted(kept(), key=lambda one: (one.title, one.ours))
    versions = list(dict.fromkeys(one.version for one in kept()))
    parts = [HEAD]
    for (title, ours), of_table in groupby(ratios, lambda one: (one.title, one.ours)):
        rows: dict[str, dict[str, float]] = {}
        for one in of_table:
            rows.setdefault(one.rival, {})[one.version] = one.ratio
        parts.append(f"\n## {title[0].upper()}{title[1:]}\n\n| beside {ours} | {' | '.join(versions)} |\n")
        parts.append(f"|---|{'---:|' * len(versions)}\n")
        for rival, ratio in rows.items():
            parts.append(f"| {rival} | {' | '.join(_cell(ratio, version) for version in versions)} |\n")
    return "".join(parts)


def _cell(ratios: dict[str, float], version: str) -> str:
    if version not in ratios:
        return "–"
    return f"{ratios[version]:,.0f} ×" if ratios[version] >= 100 else f"{ratios[version]:.3g} ×"
