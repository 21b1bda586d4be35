"""How memory does in a simulated shop, beside simple rules: writes the tables of docs/memory-study.md.

`python -m studies.memory_study` prints them (some minutes on one core), `--write` puts them into the page;
`--only levels` makes one of them, `--share 0.1` a tenth of the series.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Final

from studies import memory_level_study, memory_notice_study, memory_profile_study

PAGE: Final = Path(__file__).parents[1] / "docs" / "memory-study.md"
END: Final = "<!-- end of what is written -->\n"
TABLES: Final[dict[str, tuple[Callable[[int], str], int]]] = {
    "levels": (memory_level_study.local_levels, memory_level_study.SERIES),
    "shops": (memory_level_study.shops, memory_level_study.SERIES),
    "profiles": (memory_profile_study.profiles, memory_profile_study.SERIES),
    "events": (memory_notice_study.events, memory_notice_study.HISTORIES),
    "quiet events": (memory_notice_study.quiet_events, memory_notice_study.HISTORIES // 2),
    "false alarms": (memory_notice_study.false_alarms, memory_notice_study.LIKE_IT),
}
"""By name: what makes the table, and of how many series."""


def main() -> None:
    """Prints the tables, or writes them into the page."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--only", choices=tuple(TABLES), help="this table alone")
    options.add_argument("--share", type=float, default=1.0, help="of the series")
    options.add_argument("--write", action="store_true", help="into docs/memory-study.md")
    given = options.parse_args()
    for name, (make, series) in TABLES.items():
        if given.only in (None, name):
            text = make(max(2, round(given.share * series)))
            if given.write:
                _write(name, text)
            else:
                print(f"{name}\n\n{text}", flush=True)


def _write(name: str, text: str) -> None:
    begin = f"<!-- written by studies/memory_study.py: {name} -->\n"
    before, rest = PAGE.read_text().split(begin)
    PAGE.write_text(f"{before}{begin}{text}{END}{rest.split(END, 1)[1]}")


if __name__ == "__main__":
    main()
