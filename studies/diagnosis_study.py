"""How well diagnoses name what is wrong, where the truth is known: prints tables.

`python -m studies.diagnosis_study` prints them, some minutes on one core;
`--only terms` makes one of them, `--share 0.1` a tenth of the trials, `--share 10` ten times as many.
"""

import argparse
from collections.abc import Callable
from typing import Final

from studies import diagnosis_causes_study as causes
from studies import diagnosis_terms_study as terms

TABLES: Final[dict[str, tuple[Callable[[int], str], int]]] = {
    "single causes": (causes.single, 5),
    "other causes": (causes.others, 2),
    "two causes": (causes.two, 2),
    "sound series": (causes.sound, 2),
    "gains": (causes.gains, 3),
    "terms": (terms.terms, 27),
    "sound models": (terms.sound, 18),
    "bad inputs": (terms.bad_inputs, 9),
}
"""By name: what makes the table, and of how many trials; the page says of how many its figures are."""


def main() -> None:
    """Prints the tables, or writes them into the page."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--only", choices=tuple(TABLES), help="this table alone")
    options.add_argument("--share", type=float, default=1.0, help="of the trials")
    given = options.parse_args()
    for name, (make, trials) in TABLES.items():
        if given.only in (None, name):
            text = make(max(2, round(given.share * trials)))
            print(f"{name}\n\n{text}", flush=True)


if __name__ == "__main__":
    main()
