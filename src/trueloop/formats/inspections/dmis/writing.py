"""DMIS statements as text: labels that every reader takes, numbers, texts, lines of a length that all take."""

import re
from collections.abc import Iterable
from typing import Final

WIDTH: Final = 78
"""Characters of a line; the standard allows 80 of one, from memory."""


def statements_text(statements: Iterable[str]) -> str:
    """Statements as lines, long ones continued by `$` behind a comma."""
    return "\n".join(line for statement in statements for line in _lines(statement)) + "\n"


def comment(text: str) -> str:
    """Returns a comment line; what would continue it or end it is left out."""
    return "$$ " + " ".join(text.replace("$", " ").split())


def quoted(text: str) -> str:
    """Returns a text in quotes, on one line."""
    return "'" + " ".join(text.splitlines()).replace("'", "''") + "'"


def number(value: float, decimals: int = 4) -> str:
    """Returns a number with at most so many decimals, never `-0`."""
    text = f"{round(value, decimals) + 0.0:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def numbers(values: Iterable[float], decimals: int = 4) -> str:
    """Returns numbers joined by commas."""
    return ",".join(number(value, decimals) for value in values)


class Labels:
    """Labels for names: letters, digits, `_` and `-`, beginning with a letter, no two alike in capitals."""

    def __init__(self) -> None:
        self._taken: dict[str, int] = {}

    def new(self, name: str, prefix: str = "P") -> str:
        """Returns an unused label like the name."""
        label = re.sub(r"[^A-Za-z0-9_-]", "_", name) or prefix
        label = label if label[0].isalpha() else prefix + label
        count = self._taken[label.upper()] = self._taken.get(label.upper(), 0) + 1
        return label if count == 1 else self.new(f"{label}_{count}", prefix)


def _lines(statement: str) -> Iterable[str]:
    while len(statement) > WIDTH and not statement.startswith("$$"):
        cut = statement.rfind(",", 0, WIDTH - 1) + 1 or WIDTH - 1
        yield statement[:cut] + "$"
        statement = statement[cut:]
    yield statement
