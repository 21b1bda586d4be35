"""Reading a TOML file of tables into pydantic models: one way to say what is wrong in it."""

import re
import tomllib
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text


class Table(BaseModel):
    """A table whose unknown keys are refused: a mistyped option must not be an option ignored."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)


T = TypeVar("T", bound=Table)


def read_tables(path: Path, model: type[T], code: Code, *, hint: str) -> T:
    """The file as a model; raises `code` with the line of what is wrong."""
    text = read_text(path, code, hint=hint)
    try:
        return model.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        where = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(where[1]), int(where[2])) if where else (None, None)
        raise TrueloopError(
            code, f"not a TOML file: {str(error)!r}", hint=hint, place=Place(str(path), line, column)
        ) from error
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        given = f", given {first['input']!r}" if not isinstance(first["input"], dict) else ""
        message = f"{key!r}: {first['msg'].removeprefix('Value error, ')}{given}"
        line = _line_of(text, [str(part) for part in first["loc"]])
        raise TrueloopError(code, message, hint=hint, place=Place(str(path), line)) from error


def _line_of(text: str, names: list[str]) -> int | None:
    """The line of the last name, searched from its table's heading on."""
    lines = text.splitlines()
    heading = re.compile(rf"\s*\[+{re.escape(names[0])}\b")
    start = next((k for k, line in enumerate(lines) if heading.match(line)), None)
    if start is None:
        return None
    key = re.compile(rf'\s*"?{re.escape(names[-1])}"?\s*=')
    return next((k + 1 for k in range(start, len(lines)) if key.match(lines[k])), start + 1)
