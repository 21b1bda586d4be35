"""Subprograms in files of their own: those that a program calls are read behind it, as a control's memory holds them.

The main program's lines stay where they are. A program of a Fanuc or Haas begins with its O number, one of a Sinumerik
with its name (`%_N_CONTOUR_SPF`); files are found by these: `O2000`, `2000.nc`, `CONTOUR.SPF`, `L20.SPF`.
"""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place

_CALLS: Final = re.compile(rb"(?:M98|G65|G66)[^\n;(]*?P0*(\d+)|P0*(\d+)[^\n;(]*?(?:M98|G65|G66)", re.IGNORECASE)
_NAMES: Final = re.compile(rb"\b[A-Za-z_]\w+")
_COMMENTS: Final = {False: re.compile(rb"\([^)\n]*\)"), True: re.compile(rb";[^\n]*")}
_MARK: Final = re.compile(rb"^[ \t]*%[ \t]*\r?$\n?", re.MULTILINE)
_NUMBERED: Final = re.compile(r"[Oo]?0*(\d+)")
_HEADER: Final = re.compile(rb"^[ \t]*(?:%_N_|;?\s*[O:]\d)", re.IGNORECASE)


def with_called(
    source: bytes, dialect: str, folder: Path, read: Callable[[Path], bytes]
) -> tuple[bytes, tuple[tuple[str, int], ...]]:
    """Appends to the program all that it calls of a folder; returns of each also its file's name and first line.

    Raises NC-FILE where the folder cannot be read, NC-DIALECT for a control whose calls are not looked for.
    """
    by_name = dialect == "siemens"
    if not by_name and not dialect.startswith(("fanuc", "haas")):
        raise Code.NC_DIALECT.refusal(
            f"programs that one of {dialect} calls are not looked for in a folder",
            hint="write them into the program's own file, and leave out `programs.folder`",
        )
    try:
        files = sorted(path for path in folder.iterdir() if path.is_file())
    except OSError as error:
        raise Code.NC_FILE.refusal(
            f"the folder of programs cannot be read: {error.strerror}",
            hint="`programs.folder` names it, relative to the job file",
            place=Place(str(folder)),
        ) from error
    known = {name: path for path in files if (name := _name(path, by_name))}
    whole, behind = _without_last_mark(source, by_name)
    taken: dict[str, int] = {}
    texts = [source]
    while texts:
        for name in _called(texts.pop(), by_name):
            if name not in known or name in taken or _holds(whole, name, by_name):
                continue
            text = read(known[name])
            taken[name] = whole.count(b"\n") + 1
            whole += _as_program(text, name, by_name)
            texts.append(text)
    return whole + behind, tuple((known[name].name, line) for name, line in taken.items())


def _name(path: Path, by_name: bool) -> str:
    """By which a file's program is called: its number, its name in capitals; empty for none."""
    if by_name:
        return path.stem.upper() if path.suffix.upper() in (".SPF", ".MPF") else ""
    numbered = _NUMBERED.fullmatch(path.stem)
    return numbered.group(1) if numbered else ""


def _called(source: bytes, by_name: bool) -> Iterator[str]:
    """Names that may be called: of a Sinumerik all words."""
    text = _COMMENTS[by_name].sub(b"", source)
    if by_name:
        yield from (word.decode("latin-1").upper() for word in _NAMES.findall(text))
        return
    for before, after in _CALLS.findall(text):
        yield (before or after).decode()


def _holds(source: bytes, name: str, by_name: bool) -> bool:
    """Returns True where the text holds a program of that name already."""
    head = rf"^[ \t]*%_N_{name}_" if by_name else rf"^[ \t]*[O:]0*{name}\b"
    return re.search(head.encode(), source, re.IGNORECASE | re.MULTILINE) is not None


def _without_last_mark(source: bytes, by_name: bool) -> tuple[bytes, bytes]:
    """The program up to the tape mark at its end, and that: behind it a control reads nothing."""
    marks = [] if by_name else list(_MARK.finditer(source))
    if len(marks) < 2:
        return source if source.endswith(b"\n") else source + b"\n", b""
    return source[: marks[-1].start()], source[marks[-1].start() :]


def _as_program(text: bytes, name: str, by_name: bool) -> bytes:
    """A file's text as one of several programs, with its number or name at its head."""
    if not by_name:
        text = _MARK.sub(b"", text)
    if not _HEADER.match(text):
        text = (f"%_N_{name}_SPF\n" if by_name else f"O{int(name):04d}\n").encode() + text
    return text if text.endswith(b"\n") else text + b"\n"
