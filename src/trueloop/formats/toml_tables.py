"""Reading a TOML file of tables into pydantic models: one way to say what is wrong in it."""

import difflib
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Annotated, Final, Generic, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text

MOST: Final = 1e15
"""No length, time or temperature is as large; its square is still a number."""

Finite = Annotated[float, Field(ge=-MOST, le=MOST, allow_inf_nan=False, strict=True)]
Positive = Annotated[float, Field(gt=0, le=MOST, allow_inf_nan=False, strict=True)]
NotNegative = Annotated[float, Field(ge=0, le=MOST, allow_inf_nan=False, strict=True)]
Share = Annotated[float, Field(gt=0, le=1, strict=True)]
Count = Annotated[int, Field(ge=1, le=1_000_000, strict=True)]


def _zoned(moment: datetime) -> datetime:
    """A time without a zone is the clock on the wall here."""
    try:
        return moment.astimezone()
    except (OverflowError, ValueError, OSError) as error:
        raise ValueError(f"no time of day is known there: {error}") from error


Moment = Annotated[datetime, Field(strict=True), AfterValidator(_zoned)]
"""A date with a time, in some zone."""

Location = tuple[int | str, ...]
"""Keys and places in arrays from the file down to one value."""

SYNTAX_HINT: Final = "text values stand in quotes, tables in [brackets]: see examples/modbas2/job.toml"

HEADING: Final = re.compile(r"\s*(\[\[?)\s*([^\]]+?)\s*\]")
KEY_PART: Final = r"""[\w-]+|"[^"]*"|'[^']*'"""
DOTTED_KEY: Final = re.compile(rf"\s*((?:{KEY_PART})(?:\s*\.\s*(?:{KEY_PART}))*)\s*=")
GIVEN_TWICE: Final = re.compile("overwrite a value|twice")
KEY: Final = re.compile(r"\s*[\"']?([\w-]+)[\"']?\s*[=.]")


class Table(BaseModel):
    """A table whose unknown keys are refused: a mistyped option must not be an option ignored.

    Its numbers are of the types above, which take neither texts nor truth values for numbers.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)


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


def read_tables(
    path: Path, model: type[T], code: Code, *, hint: str, missing: Code | None = None, syntax: Code | None = None
) -> T:
    """The model alone of `read_located`."""
    return read_located(path, model, code, hint=hint, missing=missing, syntax=syntax).model


def read_located(
    path: Path, model: type[T], code: Code, *, hint: str, missing: Code | None = None, syntax: Code | None = None
) -> Located[T]:
    """The file as a model. Raises `code`, with the line, for a key that is wrong; `missing` for a file that cannot be
    read and `syntax` for one that is no TOML, where they differ. `hint` says where the keys are listed.
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
        raise TrueloopError(code, message, hint=better_hint or hint, place=place) from error


def _parsed(text: str, path: Path, code: Code) -> dict[str, object]:
    """Raises `code` also for brackets without end and numbers of thousands of digits, which Python does not read."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise _syntax_error(text, path, code, error) from error


def _syntax_error(text: str, path: Path, code: Code, error: ValueError | RecursionError) -> TrueloopError:
    where = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
    line, column = (int(where[1]), int(where[2])) if where else (None, None)
    if GIVEN_TWICE.search(str(error)) and (twice := [found for found in _repeated(text) if found[0] <= (line or 0)]):
        second, first, name = twice[-1]  # a value of several lines is complained of in its last
        message = f"{name} is given twice: in line {second}, and in line {first} before"
        return TrueloopError(code, message, hint="keep one of them", place=Place(str(path), second))
    message = f"not a TOML file: {str(error).split(' (at ')[0]!r}"
    return TrueloopError(code, message, hint=SYNTAX_HINT, place=Place(str(path), line, column))


def _first(error: ValidationError) -> ErrorDetails:
    """The first mistake; an unknown key before all others, because it is why another one is missing."""
    mistakes = error.errors()
    return next((mistake for mistake in mistakes if mistake["type"] == "extra_forbidden"), mistakes[0])


def _said(mistake: ErrorDetails, model: type[BaseModel]) -> tuple[str, str | None]:
    """Message, and a hint where there is a better one than the list of keys."""
    location = mistake["loc"]
    key = ".".join(str(part) for part in location)
    if mistake["type"] == "extra_forbidden":
        near = difflib.get_close_matches(str(location[-1]), _table_at(model, location).model_fields, n=1)
        return f"{key!r} is no key of this file", f"did you mean {near[0]!r}?" if near else None
    given = f", given {mistake['input']!r}" if not isinstance(mistake["input"], dict) else ""
    where = f"{key!r}: " if key else ""
    return f"{where}{mistake['msg'].removeprefix('Value error, ')}{given}", None


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
    agreed = [(_agreement(where, location), -number) for number, where in _locations(text)]
    most, number = max(agreed, default=(0, 0))
    return -number if most else None


def _agreement(one: Location, other: Location) -> int:
    """How many parts they share from the start."""
    return next((k for k, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))


def _locations(text: str) -> Iterator[tuple[int, Location]]:
    """Line number and location of every heading and key."""
    table: Location = ()
    counts: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        if heading := HEADING.match(line):
            names = [name.strip(" \"'") for name in heading[2].split(".")]
            path = ".".join(names)
            if heading[1] == "[[":
                counts[path] = counts.get(path, -1) + 1
            table = _with_counts(names, counts)
            yield number, table
        elif key := KEY.match(line):
            yield number, (*table, key[1])


def _repeated(text: str) -> Iterator[tuple[int, int, str]]:
    """Line of every key and table that was there before, line of the first, and its name as it is written."""
    first: dict[Location, int] = {}
    table: Location = ()
    for number, (line, location) in enumerate(zip(text.splitlines(), _by_line(text), strict=True), 1):
        key, heading = DOTTED_KEY.match(line), HEADING.match(line)
        if heading and location:
            table, name = location, f"the table [{heading[2]}]"
            whole = location if heading[1] == "[" else (*location, number)
        elif key:
            parts = [part.strip("\"'") for part in re.findall(KEY_PART, key[1])]
            whole, name = (*table, *parts), f"the key {'.'.join(parts)!r}"
        else:
            continue
        if whole in first:
            yield number, first[whole], name
        first.setdefault(whole, number)


def _by_line(text: str) -> list[Location]:
    """The location that begins in each line, () where none does."""
    begins = dict(_locations(text))
    return [begins.get(number, ()) for number, _ in enumerate(text.splitlines(), 1)]


def _with_counts(names: list[str], counts: Mapping[str, int]) -> Location:
    """`term`, `signals` as `term`, 1, `signals` where the heading [[term]] was there twice so far."""
    location: Location = ()
    for k, name in enumerate(names, 1):
        path = ".".join(names[:k])
        location += (name, counts[path]) if path in counts else (name,)
    return location
