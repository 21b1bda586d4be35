"""Reading a user's file, and what is said when there is none: the nearest name there is."""

import difflib
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Final, TypeAlias

from trueloop.errors import Code, Place
from trueloop.nc.program import program as programs
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.guess import guess_dialect
from trueloop.nc.program.program import Program, Unit

FilePath: TypeAlias = str | PathLike[str]
"""A file by its path, as a person writes it."""

SAMPLE: Final = 512
UTF_16: Final = (
    "text in UTF-16",
    "save it as UTF-8, in Excel as 'CSV UTF-8', or convert it: iconv -f UTF-16 -t UTF-8 FILE > NEW",
)
WORKBOOK: Final = ("a workbook of a spreadsheet program", "save the sheet as CSV in UTF-8 and name that file")
ARCHIVE: Final = ("an archive or a workbook", "unpack it, or save the sheet as CSV in UTF-8, and name that file")
PDF: Final = ("a PDF document", "export its numbers as text and name that file")
OTHER_KINDS: Final = {
    **dict.fromkeys((".xlsx", ".xlsm", ".xlsb", ".xls", ".ods"), WORKBOOK),
    **dict.fromkeys((".zip", ".gz", ".7z"), ARCHIVE),
    ".pdf": PDF,
}
"""Files by their names that hold no plain text."""
SIGNATURES: Final = (
    (b"\xff\xfe", UTF_16),
    (b"\xfe\xff", UTF_16),
    (b"%PDF-", PDF),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", WORKBOOK),
    (b"PK\x03\x04", ARCHIVE),
    (b"\x1f\x8b", ARCHIVE),
    (b"7z\xbc\xaf", ARCHIVE),
)
"""Kinds of files by their first bytes."""


def read_input(path: Path, code: Code, *, hint: str) -> bytes:
    """Returns the file's bytes. Raises `code` if it cannot be read, with the nearest name in its folder or `hint`."""
    with readable(path, code, hint=hint):
        content = path.read_bytes()
    require_text(content, path, code)
    return content


def require_text(beginning: bytes, path: Path, code: Code) -> None:
    """Raises `code` for a file that by its first bytes or by its name is not plain text in UTF-8."""
    found = next((what for sign, what in SIGNATURES if beginning.startswith(sign)), None)
    found = found or OTHER_KINDS.get(path.suffix.lower()) or _utf_16(beginning)
    if found is not None:
        what, hint = found
        size = f"its first bytes are {beginning[:4].hex(' ')}" if beginning else "it is empty"
        raise code.refusal(f"{path.name!r} is {what}: {size}", hint=hint, place=Place(str(path)))


def _utf_16(beginning: bytes) -> tuple[str, str] | None:
    """Text without a byte order mark that has a zero beside every letter."""
    head = beginning[:SAMPLE]
    zeros = max(head[start::2].count(0) for start in (0, 1))
    return UTF_16 if zeros > len(head) / 4 else None


@contextmanager
def readable(path: Path, code: Code, *, hint: str) -> Iterator[None]:
    """Makes reading the file in its context raise `code` where that fails, as `read_input` does."""
    try:
        yield
    except FileNotFoundError as error:
        near = nearest_name(path)
        raise code.refusal(
            f"there is no file {str(path)!r}",
            hint=f"did you mean {str(path.with_name(near))!r}?" if near else hint,
            place=Place(str(path)),
        ) from error
    except OSError as error:
        raise code.refusal(
            f"{str(path)!r} cannot be read: {error.strerror or error}", hint=hint, place=Place(str(path))
        ) from error


def read_text(path: Path, code: Code, *, hint: str) -> str:
    """Reads a text file in UTF-8, with or without a byte order mark."""
    content = read_input(path, code, hint=hint)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise code.refusal(
            f"line {line} is not text in UTF-8: {error.reason}", hint=hint, place=Place(str(path), line)
        ) from error


def nearest_name(path: Path) -> str | None:
    """Returns the name in the path's folder most like its own; None where none is like it."""
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.exists()]  # no links that lead nowhere
    except OSError:
        return None
    found = difflib.get_close_matches(path.name.lower(), [name.lower() for name in names], n=1)
    return next((name for name in names if found and name.lower() == found[0]), None)


def read_program(path: FilePath, dialect: str | None = None, unit: Unit | None = None, decimals: int = 0) -> Program:
    """Reads the program of a file; its dialect is guessed where none is named, `unit` and `decimals` as for its bytes.

    Raises NC-FILE, NC-DIALECT and NC-LIMIT.

    >>> program = trueloop.read_program(trueloop.example("modbas2/finish.nc"), dialect="ge2000t")
    >>> program.block_count, program.parameters_used()
    (39, ('P42', 'P46', 'P47'))
    >>> path = program.run({"P42": 8.0, "P46": 3.52, "P47": 0.0})
    >>> len(path), path.end_mm[10].round(3).tolist()  # moves; X as a radius, Y, Z
    (16, [0.0, 0.0, 0.794])
    """
    file = Path(path)
    source, known = read_source(file, dialect)
    return programs.read_program(source, known, str(file), unit, decimals)


def read_source(path: Path, dialect: str | None) -> tuple[bytes, str]:
    """Returns the bytes of a program and its dialect, guessed where none is named. Raises NC-FILE and NC-DIALECT."""
    source = read_input(path, Code.NC_FILE, hint="name an NC program")
    return source, dialect_named(guess_dialect(source, str(path)) if dialect is None else dialect).name
