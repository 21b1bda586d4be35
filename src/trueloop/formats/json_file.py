"""Files of trueloop's own in JSON, each with a line that says which format it is."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text

T = TypeVar("T")


def read_json(path: Path, name: str, made: Callable[[dict[str, Any]], T], *, hint: str) -> T:
    """What `made` makes of the file's content. Raises MCH-FILE where its "format" is not `name`, or `made` fails."""
    text = read_text(path, Code.MCH_FILE, hint=hint)
    try:
        with in_file(path):
            content = json.loads(text)
            if content["format"] != name:
                raise ValueError(f"format {content['format']!r} is not {name!r}")
            return made(content)
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        raise TrueloopError(
            Code.MCH_FILE,
            f"{path.name!r} is no {name}: {type(error).__name__}: {error}",
            hint=hint,
            place=Place(str(path)),
        ) from error
