"""The headings and keys of a TOML text with their places, and which two of them cannot stand beside each other.

Python's reader of TOML does not say where what it read stood, nor what a name collides with. Read line by line: a line
of a text over several lines that looks like a key is taken for one.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Literal

Location = tuple[int | str, ...]
"""Keys and places in arrays from the file down to one value."""

PART: Final = r"""(?:[\w-]+|"[^"]*"|'[^']*')"""
PATH: Final = rf"{PART}(?:\s*\.\s*{PART})*"
HEADING: Final = re.compile(rf"\s*(\[\[?)\s*({PATH})\s*\]\]?\s*(?:#|$)")
KEY: Final = re.compile(rf"\s*({PATH})\s*=")

KEEP_ONE: Final = "keep one of them"
ONE_VALUE: Final = "a name is either one value or a table: rename or remove one of them"
ONE_PLACE: Final = "keep the keys of a table in one place: under its heading, or dotted"


@dataclass(frozen=True)
class Statement:
    """A heading or key: where it begins, the location of the table above it and its own, and how it is written."""

    kind: Literal["table", "tables", "key"]
    line: int
    column: int
    table: Location
    location: Location
    written: str

    @property
    def name(self) -> str:
        """As a message names it."""
        heading = {"table": f"the table [{self.written}]", "tables": f"the table [[{self.written}]]"}
        return heading.get(self.kind, f"the key {self.written!r}")

    @property
    def defines(self) -> Location:
        """What it alone may define: of the first of several tables their array, else its location."""
        first = self.kind == "tables" and self.location[-1] == 0
        return self.location[:-1] if first else self.location


@dataclass(frozen=True)
class Collision:
    """A statement and one before it that define the same name."""

    later: Statement
    earlier: Statement

    @property
    def twice(self) -> bool:
        """Whether it is one key or one table, given twice."""
        return self.later.kind == self.earlier.kind and self.later.location == self.earlier.location

    @property
    def message(self) -> str:
        """Both lines, and the name that both define."""
        if self.twice:
            return (
                f"{self.later.name} is given twice: in line {self.later.line}, and in line {self.earlier.line} before"
            )
        shorter = min(self.later.defines, self.earlier.defines, key=len)
        both = ".".join(str(part) for part in shorter if isinstance(part, str))
        return f"{self.later.name} and {self.earlier.name} in line {self.earlier.line} both define {both!r}"

    @property
    def hint(self) -> str:
        """How to mend it."""
        if self.twice:
            return KEEP_ONE
        shorter = min(self.earlier, self.later, key=lambda statement: len(statement.defines))
        return ONE_VALUE if shorter.kind == "key" else ONE_PLACE


def statements(text: str) -> Iterator[Statement]:
    """Every heading and key in its order."""
    above: list[str] = []
    table: Location = ()
    counts: dict[str, int] = {}
    for line, written in enumerate(text.splitlines(), 1):
        if heading := HEADING.match(written):
            several, names = heading[1] == "[[", _parts(heading[2])
            if several:
                counts[".".join(names)] = counts.get(".".join(names), -1) + 1
            above, table = names, _with_counts(names, counts)
            kind: Literal["table", "tables"] = "tables" if several else "table"
            yield Statement(kind, line, heading.start(1) + 1, (), table, ".".join(names))
        elif key := KEY.match(written):
            names = _parts(key[1])
            location = _with_counts([*above, *names], counts)
            yield Statement("key", line, key.start(1) + 1, table, location, ".".join(names))


def collision(text: str, line: int) -> Collision | None:
    """What a reader of TOML complains of in a line, which may be the last of a value; None where nothing collides."""
    before = [statement for statement in statements(text) if statement.line <= line]
    for k in range(len(before) - 1, -1, -1):
        earlier = next((statement for statement in before[:k] if _collide(statement, before[k])), None)
        if earlier is not None:
            return Collision(before[k], earlier)
    return None


def _collide(earlier: Statement, later: Statement) -> bool:
    """Whether the later one defines what the earlier one has defined; a heading may open what keys do not fill."""
    old, new = earlier.location, later.defines
    shared = min(len(old), len(new))
    if old[:shared] != new[:shared]:
        return False
    if earlier.kind == "key" and len(old) <= len(new):
        return True
    if later.kind == "key":
        return shared > len(later.table) and (earlier.kind != "key" or len(earlier.table) < shared)
    if earlier.kind == "key":
        return len(earlier.table) < len(new)
    return len(old) == len(new) or (later.kind == "tables" and len(old) > len(new))


def _parts(path: str) -> list[str]:
    return [part.strip("\"'") for part in re.findall(PART, path)]


def _with_counts(names: list[str], counts: Mapping[str, int]) -> Location:
    """`term`, `signals` as `term`, 1, `signals` where the heading [[term]] was there twice so far."""
    location: Location = ()
    for k, name in enumerate(names, 1):
        path = ".".join(names[:k])
        location += (name, counts[path]) if path in counts else (name,)
    return location
