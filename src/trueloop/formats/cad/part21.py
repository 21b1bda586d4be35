"""The records of a STEP file as it spells them (ISO 10303-21): numbers, types and parameters, not what they mean."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final, TypeAlias

Value: TypeAlias = "str | float | Ref | list[Value] | Typed | None"

FACES: Final = frozenset(("ADVANCED_FACE", "FACE_SURFACE"))
"""The types of records that are faces."""

TOKEN: Final = re.compile(
    r"\s+|/\*.*?\*/"
    r"|(?P<text>'(?:[^']|'')*')"
    r"|(?P<ref>#\d+)"
    r"|(?P<word>[A-Za-z_!][A-Za-z0-9_]*)"
    r"|(?P<number>[+-]?\d+\.?\d*(?:[Ee][+-]?\d+)?)"
    r"|(?P<enum>\.[A-Za-z0-9_]+\.)"
    r'|(?P<binary>"[^"]*")'
    r"|(?P<mark>[()=;,$*])",
    re.DOTALL,
)


@dataclass(frozen=True)
class Ref:
    """A reference to the record of a number."""

    number: int


@dataclass(frozen=True)
class Typed:
    """A value with its type: LENGTH_MEASURE(0.02)."""

    kind: str
    values: list[Value]


@dataclass(frozen=True)
class Record:
    """One record: its parameters by type; a complex one has several types."""

    number: int
    types: Mapping[str, list[Value]]

    def value(self, kind: str, place: int) -> Value:
        """Returns the parameter of a type at a place, from 0 or from the end; None where there is none."""
        values = self.types.get(kind, [])
        return values[place] if -len(values) <= place < len(values) else None

    def refs(self) -> Iterator[int]:
        """Yields the numbers of all records that it refers to."""
        for values in self.types.values():
            yield from _refs(values)


@dataclass(frozen=True)
class Records:
    """All records of a file, in its order."""

    of: Mapping[int, Record]

    @cached_property
    def numbers(self) -> tuple[int, ...]:
        """Returns the records' numbers, in the file's order."""
        return tuple(self.of)

    def typed(self, *kinds: str) -> Iterator[tuple[Record, list[Value]]]:
        """Yields the records of one of the types, with their parameters of it."""
        for record in self.of.values():
            for kind in kinds:
                if kind in record.types:
                    yield record, record.types[kind]

    def at(self, value: Value) -> Record | None:
        """Returns the record that a value refers to; None where it refers to none."""
        return self.of.get(value.number) if isinstance(value, Ref) else None


def read_records(text: str) -> Records:
    """Reads the records of the data sections. What cannot be read ends its record; nothing is raised."""
    found: dict[int, Record] = {}
    for start in re.finditer(r"(?<![A-Za-z0-9_])DATA\s*(?:\([^;]*\))?;", text):
        tokens = _tokens(text, start.end())
        for kind, token in tokens:
            if kind == "word" and token == "ENDSEC":
                break
            if kind == "ref" and next(tokens, ("", ""))[1] == "=":
                number = int(token[1:])
                found[number] = Record(number, dict(_types(tokens)))
    return Records(found)


def _tokens(text: str, at: int) -> Iterator[tuple[str, str]]:
    while (match := TOKEN.match(text, at)) is not None:
        at = match.end()
        if match.lastgroup is not None:
            yield match.lastgroup, match.group()


def _types(tokens: Iterator[tuple[str, str]]) -> Iterator[tuple[str, list[Value]]]:
    """Up to the record's semicolon: NAME(…), or (NAME(…) NAME(…))."""
    for kind, token in tokens:
        if token == ";" and kind == "mark":
            return
        if kind == "word" and next(tokens, ("", ""))[1] == "(":
            yield token.upper(), _values(tokens)


def _values(tokens: Iterator[tuple[str, str]]) -> list[Value]:
    """The values up to the closing bracket."""
    found: list[Value] = []
    for kind, token in tokens:
        match kind, token:
            case "mark", ")" | ";":
                break
            case "mark", "(":
                found.append(_values(tokens))
            case "mark", "$" | "*":
                found.append(None)
            case "text", _:
                found.append(token[1:-1].replace("''", "'"))
            case "ref", _:
                found.append(Ref(int(token[1:])))
            case "number", _:
                found.append(float(token))
            case "word", _:
                next(tokens, None)
                found.append(Typed(token.upper(), _values(tokens)))
            case "enum", _:
                found.append(token.strip("."))
    return found


def _refs(values: list[Value]) -> Iterator[int]:
    for value in values:
        if isinstance(value, Ref):
            yield value.number
        elif isinstance(value, list):
            yield from _refs(value)
        elif isinstance(value, Typed):
            yield from _refs(value.values)
