"""Lines of SHDR, in which an adapter speaks to an agent: `time|key|value|key|value`, a condition on its own."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

UNAVAILABLE: Final = "UNAVAILABLE"


@dataclass(frozen=True)
class Condition:
    """NORMAL, WARNING, FAULT or UNAVAILABLE; the control's own code and words for what is not normal."""

    level: str = "NORMAL"
    code: str = ""
    text: str = ""


Value = str | Condition
NONE: Final = Condition(UNAVAILABLE)


def lines(values: Mapping[str, Value], at: datetime) -> Iterator[str]:
    """All plain values in one line, then a line for each condition."""
    stamp = f"{at.astimezone(UTC):%Y-%m-%dT%H:%M:%S}.{at.microsecond:06d}Z"
    plain = [f"{key}|{escaped(value)}" for key, value in values.items() if isinstance(value, str)]
    if plain:
        yield f"{stamp}|{'|'.join(plain)}\n"
    for key, value in values.items():
        if isinstance(value, Condition):
            yield f"{stamp}|{key}|{value.level}|{escaped(value.code)}|||{escaped(value.text)}\n"


def escaped(text: str) -> str:
    """On one line, as one field: with a bar in it in quotes, the bar behind a backslash, as agents undo it."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    if "|" not in line:
        return line.lstrip('"')  # a quote at the beginning opens a field that nothing would close
    inner = line.replace('"', "'").replace("|", "\\|")
    return f'"{inner}"'


def number(value: float, decimals: int) -> str:
    """Without an exponent and without a minus before zero."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
