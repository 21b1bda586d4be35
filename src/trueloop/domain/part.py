"""Parts: what one drawing asks for, and the single pieces made to it.

Shares of a part: what each edge cuts of it, in one set-up or in several, is kept as a part of a type of its own. Its
name links it with the whole part: `shaft, second, T2` is what T2 cuts of a `shaft` in the set-up `second`.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal


@dataclass(frozen=True)
class PartType:
    """The type of all parts made to one drawing: its name or number, its revision, the material.

    `drawing` is the drawing's number where that is not the name. Empty text: not stated.
    """

    name: str
    revision: str = ""
    material: str = ""
    drawing: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns name and revision: errors learned of one revision need not hold for the next."""
        return self.name, self.revision


@dataclass(frozen=True)
class Part:
    """One piece of a part type. `serial` is empty where nobody stated it: then only its inspections identify it."""

    part_type: PartType
    serial: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the identity of the part type and the serial number."""
        return *self.part_type.identity, self.serial


EDGE: Final = re.compile(r"T\d+( D\d+)?( \((left|right|outer|inner) corner\))?")
SETUP: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")


def whole_of(names: Sequence[str]) -> str | None:
    """Returns the name of the part that types of these names are shares of; None: they are not shares of one part.

    >>> whole_of(["shaft, first, T1", "shaft, second, T2"]), whole_of(["shaft", "disc"])
    ('shaft', None)
    """
    split = [name.split(", ") for name in dict.fromkeys(names)]
    if not split or not all(len(words) > 1 and EDGE.fullmatch(words[-1]) for words in split):
        return None
    same = split[0][:-1]
    while same and not all(words[: len(same)] == same for words in split):
        same = same[:-1]
    rest = [words[len(same) : -1] for words in split]
    named = all(not words or (len(words) == 1 and SETUP.fullmatch(words[0])) for words in rest)
    return ", ".join(same) if same and named else None


@dataclass(frozen=True)
class WholePart:
    """A part by its serial number, with its shares; itself alone where it is kept whole."""

    part: Part
    shares: tuple[Part, ...]


def joined_shares(parts: Iterable[Part]) -> list[WholePart]:
    """Parts of one serial number: those that are shares of one part together, others by themselves."""
    every = list(parts)
    whole = whole_of([part.part_type.name for part in every]) if len(every) > 1 else None
    if whole is None:
        return [WholePart(part, (part,)) for part in every]
    first = every[0]
    return [WholePart(replace(first, part_type=replace(first.part_type, name=whole)), tuple(every))]
