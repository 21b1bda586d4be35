"""Reads a TOML file of tables into pydantic models, and reports errors with line and column; writes keys and values.

Python's reader of TOML does not report where a key stands, nor with what a name collides: the text is read again line
by line. A line of a text over several lines that looks like a key is taken for one.
"""

import itertools
import json
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from datetime import datetime
from operator import attrgetter
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Final, Generic, Literal, TypeVar, get_args, get_origin

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, create_model
from pydantic_core import ErrorDetails

from trueloop.described import Described
from trueloop.domain.option import Choice, Option, choices_of, inside
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text
from trueloop.units import COARSEST_U_UM
from trueloop.wording import did_you_mean

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
        """The name that it alone may define: for the first of several tables their array, else its location."""
        first = self.kind == "tables" and self.location[-1] == 0
        return self.location[:-1] if first else self.location


@dataclass(frozen=True)
class Collision:
    """A statement and one before it that define the same name."""

    later: Statement
    earlier: Statement

    @property
    def twice(self) -> bool:
        """True if it is one key or one table, given twice."""
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
                path = ".".join(names)
                counts = {one: count for one, count in counts.items() if not one.startswith(f"{path}.")}
                counts[path] = counts.get(path, -1) + 1  # the arrays in a new table are counted from its first
            above, table = names, _with_counts(names, counts)
            kind: Literal["table", "tables"] = "tables" if several else "table"
            yield Statement(
                kind=kind, line=line, column=heading.start(1) + 1, table=(), location=table, written=".".join(names)
            )
        elif key := KEY.match(written):
            names = _parts(key[1])
            location = _with_counts([*above, *names], counts)
            yield Statement(
                kind="key", line=line, column=key.start(1) + 1, table=table, location=location, written=".".join(names)
            )


def collision(text: str, line: int) -> Collision | None:
    """Returns the collision that a TOML reader reports in a line, maybe the last of a value; None without one."""
    before = [statement for statement in statements(text) if statement.line <= line]
    for k in range(len(before) - 1, -1, -1):
        earlier = next((statement for statement in before[:k] if _collide(statement, before[k])), None)
        if earlier is not None:
            return Collision(before[k], earlier)
    return None


def _collide(earlier: Statement, later: Statement) -> bool:
    """Returns whether the later one defines what the earlier one has; a heading may open what keys do not fill."""
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


MOST: Final = 1e15
"""No length, time or temperature is as large; its square is still a number."""
MOST_COUNTED: Final = 1_000_000

Finite = Annotated[float, Field(ge=-MOST, le=MOST, allow_inf_nan=False, strict=True)]
Positive = Annotated[float, Field(gt=0, le=MOST, allow_inf_nan=False, strict=True)]
NotNegative = Annotated[float, Field(ge=0, le=MOST, allow_inf_nan=False, strict=True)]
MeasuringUm = Annotated[float, Field(gt=0, le=COARSEST_U_UM, allow_inf_nan=False, strict=True)]
Vector = tuple[Finite, Finite, Finite]
Count = Annotated[int, Field(ge=1, le=MOST_COUNTED, strict=True)]


def _zoned(moment: datetime) -> datetime:
    """A time without a zone is the clock on the wall here."""
    try:
        return moment.astimezone()
    except (OverflowError, ValueError, OSError) as error:
        raise ValueError(f"no time of day is known there: {error}") from error


def _unquoted(value: object) -> object:
    """Refuses a time in quotes, which TOML reads as text."""
    if isinstance(value, str):
        raise ValueError(f"a date with its time stands without quotes: {value}")
    return value


Moment = Annotated[datetime, Field(strict=True), AfterValidator(_zoned), BeforeValidator(_unquoted)]
"""A date with a time, in some zone."""

SYNTAX_HINT: Final = "text values stand in quotes, tables in [brackets]: see examples/modbas2/job.toml"
COLLIDES: Final = re.compile("overwrite a value|twice|redefine namespace|immutable namespace|Duplicate")
"""Pattern of the messages of Python's reader on two statements that define one name."""


@dataclass(frozen=True)
class In:
    """The unit of a key whose end names none, in words."""

    unit: str


class Table(Described):
    """A table whose unknown keys are refused: a mistyped option must not be an option ignored.

    What a key means is the text below it: the tables of the documentation and the JSON schema are made of that.

    Its numbers are of the types above, which take neither texts nor truth values for numbers.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=False, defer_build=True)


T = TypeVar("T", bound=Table)


@dataclass(frozen=True)
class Located(Generic[T]):
    """A file as a model, and where in the file what stands."""

    path: Path
    model: T
    text: str = field(repr=False)

    def at(self, *location: int | str) -> AbstractContextManager[None]:
        """Refusals from inside get the file and the line where that location of it stands."""
        return in_file(self.path, _line_of(self.text, location))


def read_tables(path: Path, model: type[T], code: Code, *, hint: str) -> T:
    """The model alone of `read_located`."""
    return read_located(path, model, code, hint=hint).model


def read_located(
    path: Path, model: type[T], code: Code, *, hint: str, missing: Code | None = None, syntax: Code | None = None
) -> Located[T]:
    """The file as a model. Raises `code`, with the line, for a key that is wrong; `missing` for a file that cannot be
    read and `syntax` for one that is not TOML, where they differ. `hint` says where the keys are listed.
    """
    text = read_text(path, missing or code, hint=hint)
    content = _parsed(text, path, syntax or code)
    try:
        return Located(path, model.model_validate(content), text)
    except ValidationError as error:
        first = _first(error)
        location = first["loc"]
        message, better_hint = _said(first, model)
        place = Place(str(path), _line_of(text, location))
        values = {"key": _key(location)} if "key" in code.values else {}
        raise code.refusal(message, hint=better_hint or hint, place=place, values=values) from error


def _parsed(text: str, path: Path, code: Code) -> dict[str, object]:
    """Raises `code` also for brackets without end and numbers of thousands of digits, which Python does not read."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise _syntax_error(text, path, code, error) from error


def _syntax_error(text: str, path: Path, code: Code, error: ValueError | RecursionError) -> TrueloopError:
    where = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
    line, column = (int(where[1]), int(where[2])) if where else (None, None)
    if line and COLLIDES.search(str(error)):
        found = collision(text, line)
        if found is None:
            message = "a key is given twice between the braces of one value"
            return code.refusal(message, hint=KEEP_ONE, place=Place(str(path), line, column))
        place = Place(str(path), found.later.line, found.later.column)
        return code.refusal(found.message, hint=found.hint, place=place)
    message = f"not a TOML file: {str(error).split(' (at ')[0]!r}"
    return code.refusal(message, hint=SYNTAX_HINT, place=Place(str(path), line, column))


ALTERNATIVE: Final = re.compile(r"[A-Z]\w*Table$|tuple\[|(constrained-)?int$")
"""A part of a mistake's location that names one of several forms of a value, and no key."""


def _first(error: ValidationError) -> ErrorDetails:
    """The first mistake; an unknown key before all others, because it is why another one is missing. Of a value that
    may have several forms the mistake that is farthest inside: the form that was meant.
    """
    mistakes = error.errors()
    first = next((mistake for mistake in mistakes if mistake["type"] == "extra_forbidden"), mistakes[0])
    above = tuple(itertools.takewhile(lambda part: not ALTERNATIVE.match(str(part)), first["loc"]))
    if len(above) < len(first["loc"]):
        of_value = [one for one in mistakes if one["loc"][: len(above)] == above]
        first = max(of_value, key=lambda one: (len(one["loc"]), one["type"] == "extra_forbidden"))
        first["loc"] = tuple(part for part in first["loc"] if not ALTERNATIVE.match(str(part)))
    return first


def _said(mistake: ErrorDetails, model: type[BaseModel]) -> tuple[str, str | None]:
    """Message, and a hint where there is a better one than the list of keys."""
    location = mistake["loc"]
    key = _key(location)
    if mistake["type"] == "extra_forbidden":
        return f"{key!r} is no key of this file", _hint_for_unknown(location, model)
    given = f", given {mistake['input']!r}" if not isinstance(mistake["input"], dict) else ""
    where = f"{key!r}: " if key else ""
    return f"{where}{mistake['msg'].removeprefix('Value error, ')}{given}", None


def _key(location: Location) -> str:
    return ".".join(map(str, location))


def _hint_for_unknown(location: Location, model: type[BaseModel]) -> str | None:
    """A table named in full under a heading, or a key that is nearly right; None where it is neither."""
    *above, name = (str(part) for part in location)
    if above and name in model.model_fields:
        written = f"leave '{name}.' out" if above == [name] else f"write it under [{name}]"
        return f"keys under [{'.'.join(above)}] count from there: {written}"
    return did_you_mean(name, _table_at(model, location).model_fields) or None


def _table_at(model: type[BaseModel], location: Location) -> type[BaseModel]:
    """The table that a key stands in."""
    for name in location[:-1]:
        if name in model.model_fields:  # others are places in arrays and names that the user gave to tables
            model = next(_models_in(model.model_fields[str(name)].annotation))
    return model


def _models_in(annotation: object) -> Iterator[type[BaseModel]]:
    """The table types that an annotation such as `tuple[ErrorTable, ...]` or `ProbeTable | None` names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _models_in(inner)


def _line_of(text: str, location: Location) -> int | None:
    """The line that agrees with most of a location, the first of several; None where none agrees with any of it."""
    agreed = [(_agreement(found.location, location), -found.line) for found in statements(text)]
    most, number = max(agreed, default=(0, 0))
    return -number if most else None


def _agreement(location: Location, other: Location) -> int:
    """How many parts they share from the start."""
    return next(
        (k for k, (a, b) in enumerate(zip(location, other, strict=False)) if a != b), min(len(location), len(other))
    )


D = TypeVar("D")


def with_options(table: str, *options: object) -> Callable[[type[T]], type[T]]:
    """Puts keys in front of those of a table's model: every option of these dataclasses that belongs to that table.

    A dataclass is given as its type, or as an instance where its defaults are others here.
    """
    choices = [choice for option in options for choice in choices_of(option).values()]
    keys: dict[str, Any] = {
        choice.option.key.removeprefix(f"{table}."): _field(choice)
        for choice in choices
        if choice.option.key.startswith(f"{table}.")
    }

    def model_with_keys(model: type[T]) -> type[T]:
        before = create_model(model.__name__, __base__=Table, **keys)
        bases: Any = (model, before)
        whole: type[T] = create_model(
            model.__name__, __base__=bases, __module__=model.__module__, __doc__=model.__doc__
        )
        return whole

    return model_with_keys


def options_from(kind: type[D], file: Table, **others: object) -> D:
    """Returns the dataclass of a file's options, in mm, radians and shares; `others` are set by no key alone."""
    keys = {name: choice.option.key for name, choice in choices_of(kind).items()}
    return kind(**{name: inside(key, attrgetter(key)(file)) for name, key in keys.items()}, **others)


def _field(choice: Choice) -> tuple[Any, Any]:
    described = Field(choice.default, description=choice.option.meaning)
    return Annotated[_checked(choice.kind, choice.option), In(choice.option.unit)], described


def _checked(kind: Any, option: Option) -> Any:
    """The type with the option's bounds at its numbers."""
    if kind is float:
        least = -MOST if option.least is None and option.above is None else option.least
        most = MOST if option.most is None and option.below is None else option.most
        bounds = Field(gt=option.above, ge=least, lt=option.below, le=most, allow_inf_nan=False, strict=True)
        return Annotated[float, bounds]
    if kind is int:
        return Annotated[int, Field(ge=option.least, le=option.most or MOST_COUNTED, strict=True)]
    if isinstance(kind, UnionType):
        first, *rest = (_checked(arg, option) for arg in get_args(kind))
        return first | rest[0]
    if get_origin(kind) is tuple:
        return tuple[tuple(_checked(arg, option) for arg in get_args(kind))]  # type: ignore[misc]
    return kind


def toml_keys(keys: Mapping[str, object]) -> list[str]:
    """Writes keys with their values, a line each; those without a value are left out."""
    return [f"{key} = {toml_value(value)}" for key, value in keys.items() if value is not None]


def toml_value(value: object) -> str:
    """Writes a text, a number, a time, a list or an inline table."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return f"{{ {', '.join(toml_keys({toml_value(key): one for key, one in value.items()}))} }}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, datetime):
        return value.isoformat()
    return str(value).lower()
