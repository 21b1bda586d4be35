"""Reading a user's file, and what is said when there is none: the nearest name there is."""

import difflib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from trueloop.errors import Code, Place, TrueloopError


def read_input(path: Path, code: Code, *, hint: str) -> bytes:
    """The file's bytes. Raises `code` when it cannot be read, with the nearest name in its folder, else with `hint`."""
    with readable(path, code, hint=hint):
        return path.read_bytes()


@contextmanager
def readable(path: Path, code: Code, *, hint: str) -> Iterator[None]:
    """What is read of the file in here raises `code` where it cannot be, as `read_input` does."""
    try:
        yield
    except FileNotFoundError as error:
        near = nearest_name(path)
        raise TrueloopError(
            code,
            f"there is no file {str(path)!r}",
            hint=f"did you mean {str(path.with_name(near))!r}?" if near else hint,
            place=Place(str(path)),
        ) from error
    except OSError as error:
        raise TrueloopError(
            code, f"{str(path)!r} cannot be read: {error.strerror or error}", hint=hint, place=Place(str(path))
        ) from error


def read_text(path: Path, code: Code, *, hint: str) -> str:
    """The same as text in UTF-8, with or without a byte order mark."""
    content = read_input(path, code, hint=hint)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise TrueloopError(
            code, f"line {line} is no text in UTF-8: {error.reason}", hint=hint, place=Place(str(path), line)
        ) from error


def nearest_name(path: Path) -> str | None:
    """The name in the path's folder most like the one asked for; None where none is like it."""
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.exists()]  # no links that lead nowhere
    except OSError:
        return None
    found = difflib.get_close_matches(path.name.lower(), [name.lower() for name in names], n=1)
    return next((name for name in names if found and name.lower() == found[0]), None)
