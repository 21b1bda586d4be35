"""How well diagnoses name what is wrong, where the truth is known: writes the tables of docs/diagnosis-study.md.

`python -m scripts.diagnosis_study` prints them (some minutes on one core), `--write` puts them into the page;
`--only terms` makes one of them, `--share 0.1` a tenth of the trials, `--share 10` ten times as many.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Final

from scripts import diagnosis_causes_study as causes
from scripts import diagnosis_terms_study as terms

PAGE: Final = Path(__file__).parents[1] / "docs" / "diagnosis-study.md"
END: Final = "<!-- end of what is written -->\n"
TABLES: Final[dict[str, tuple[Callable[[int], str], int]]] = {
    "single causes": (causes.single, 60),
    "other causes": (causes.others, 40),
    "two causes": (causes.two, 30),
    "sound series": (causes.sound, 30),
    "gains": (causes.gains, 40),
    "terms": (terms.terms, 180),
    "sound models": (terms.sound, 90),
    "bad inputs": (terms.bad_inputs, 27),
}
"""By name: what makes the table, and of how many trials."""


def main() -> None:
    """Prints the tables, or writes them into the page."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--only", choices=tuple(TABLES), help="this table alone")
    options.add_argument("--share", type=float, default=1.0, help="of the trials")
    options.add_argument("--write", action="store_true", help="into docs/diagnosis-study.md")
    given = options.parse_args()
    for name, (make, trials) in TABLES.items():
        if given.only in (None, name):
            text = make(max(2, round(given.share * trials)))
            if given.write:
                _write(name, text)
            else:
                print(f"{name}\n\n{text}", flush=True)


def _write(name: str, text: str) -> None:
    begin = f"<!-- written by scripts/diagnosis_study.py: {name} -->\n"
    before, rest = PAGE.read_text().split(begin)
    PAGE.write_text(f"{before}{begin}{text}{END}{rest.split(END, 1)[1]}")


if __name__ == "__main__":
    main()
