"""Sentences for people that keep what they are made of, so that a page can say them in another language and unit.

    wording("{feature}: no touch; standard uncertainty {u}.", feature=name, u=Um(u_mm))

The sentence is a text like any other, in English and micrometres. The template is a literal where it stands: a test
looks for all of them and for their translations.
"""

import difflib
import os
import re
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Final

from trueloop.units import UM_PER_MM

MINUS: Final = "\u2212"


def shell_word(word: str, *, windows: bool = os.name == "nt") -> str:
    """Returns the word as it is typed in a command: in quotes where the shell needs them, on Windows in double ones."""
    if not windows:
        return shlex.quote(word)
    return word if re.fullmatch(r"[\w@%+=:,./\\~-]+", word) else f'"{word}"'


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Returns the question whether the most alike of the known names is meant; "" where none is alike."""
    near = difflib.get_close_matches(name, list(known), n=1)
    return f"did you mean {near[0]!r}?" if near else ""


def first_of(names: Sequence[object], most: int) -> str:
    """Lists the first names, with a mark where there are more."""
    return ", ".join(map(str, names[:most])) + (", …" if len(names) > most else "")


@dataclass(frozen=True)
class Um:
    """A length in mm that is written in micrometres."""

    mm: float
    spec: str = ".1f"

    def __str__(self) -> str:
        return f"{self.mm * UM_PER_MM:{self.spec}}".replace("-", MINUS) + " µm"


@dataclass(frozen=True)
class Signed:
    """A number that is written with its sign, in the unit that it has."""

    value: float
    decimals: int

    def __str__(self) -> str:
        return f"{self.value:+.{self.decimals}f}".replace("-", MINUS)


class Wording(str):
    """A text of a `template` and its `values`: texts, numbers, lengths, wordings. Stored, it is a text alone."""

    template: str
    values: Mapping[str, object]


def wording(template: str, /, **values: object) -> Wording:
    """The text of a template.

    >>> from trueloop.wording import Um, wording
    >>> said = wording("{n} touches, {left} left", n=3, left=Um(0.0012))
    >>> said, said.values["n"]
    ('3 touches, 1.2 µm left', 3)
    """
    said = Wording(template.format_map(values))
    said.template, said.values = template, values
    return said


@dataclass(frozen=True)
class Worded:
    """A wording as a value that travels between processes."""

    template: str
    values: Mapping[str, object]

    @classmethod
    def of(cls, text: str) -> "str | Worded":
        """Makes it of a wording and of those among its values; other texts stay."""
        if not isinstance(text, Wording):
            return text
        return cls(
            text.template, {name: cls.of(one) if isinstance(one, str) else one for name, one in text.values.items()}
        )

    def text(self) -> Wording:
        """Returns the wording."""
        template = self.template
        return wording(
            template, **{name: one.text() if isinstance(one, Worded) else one for name, one in self.values.items()}
        )


def changed(text: str, change: Callable[[str], str]) -> str:
    """Returns a text with each of its texts changed; a wording stays one."""
    if not isinstance(text, Wording):
        return change(text)
    values = {name: changed(one, change) if isinstance(one, str) else one for name, one in text.values.items()}
    template = text.template
    return wording(template, **values)


def listed(texts: Sequence[str]) -> str:
    """Texts joined by semicolons, each of which can still be said otherwise."""
    return reduce(lambda first, more: wording("{first}; {more}", first=first, more=more), texts)


def all_of(names: Sequence[str]) -> str:
    """Names joined by "and"."""
    return reduce(lambda first, second: wording("{first} and {second}", first=first, second=second), names)
