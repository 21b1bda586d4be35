"""Subprograms in files of their own: those that a program calls are read behind it, as a control's memory holds them.

The main program's lines stay where they are. A program of a Fanuc or Haas begins with its O number, one of a Sinumerik
with its name (`%_N_CONTOUR_SPF`), one of Klartext with `BEGIN PGM`; files are found by these: `O2000`, `2000.nc`,
`CONTOUR.SPF`, `L20.SPF`, `BORES.H`.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Finding, Place, TrueloopError
from trueloop.formats.input_file import read_input

_CALLS: Final = re.compile(rb"(?:M98|G65|G66)[^\n;(]*?P0*(\d+)|P0*(\d+)[^\n;(]*?(?:M98|G65|G66)", re.IGNORECASE)
_NAMES: Final = re.compile(rb"\b[A-Za-z_]\w+")
_FILES: Final = re.compile(
    rb"\bCALL PGM[ \t]+\"?(?:[^\";\r\n]*[\\/:])?([^\";\\/:\r\n]+?)\"?[ \t]*(?:;|\r?$)", re.I | re.M
)
_COMMENTS: Final = {"number": re.compile(rb"\([^)\n]*\)"), "name": re.compile(rb";[^\n]*")}
_MARK: Final = re.compile(rb"^[ \t]*%[ \t]*\r?$\n?", re.MULTILINE)
_NUMBERED: Final = re.compile(r"[Oo]?0*(\d+)")
_HEADER: Final = re.compile(rb"^[ \t]*(?:%_N_|;?\s*[O:]\d)", re.IGNORECASE)
_HEADS: Final = {
    "number": rb"^[ \t]*[O:]0*%b\b",
    "name": rb"^[ \t]*%%_N_%b_",
    "file": rb"^[ \t]*\d*[ \t]*BEGIN PGM[ \t]+%b[ \t]",
}
"""The line that begins a program."""
LARGEST_CALLER: Final = 1 << 20
"""So many bytes a program has at most that calls programs of its folder: those are held whole."""


@dataclass(frozen=True)
class WithCalled:
    """A program's text with those that it calls of its folder. `begins`: the line at which each begins, from 1."""

    file: Path
    text: bytes
    style: str = "number"
    called: tuple[Path, ...] = ()
    begins: tuple[int, ...] = ()
    behind: bytes = b""

    def _place(self, place: Place) -> Place:
        """Returns a place of the text in the file that it is of."""
        before = [index for index, first in enumerate(self.begins) if place.line is not None and place.line >= first]
        if place.line is None or not before:
            return place
        return replace(place, file=str(self.called[before[-1]]), line=place.line - self.begins[before[-1]] + 1)

    def placed(self, error: TrueloopError) -> TrueloopError:
        """Returns a refusal with the file and the line that it is of."""
        code, place = error.code, self._place(error.place)
        return TrueloopError(
            code, error.message, hint=error.hint, place=place, override=error.override, values=error.values
        )

    def findings(self, found: Sequence[Finding]) -> list[Finding]:
        """Returns findings with the files and the lines that they are of."""
        return [replace(finding, place=self._place(finding.place)) for finding in found]

    @contextmanager
    def placing(self) -> Iterator[None]:
        """Refusals from inside get the file and the line that they are of."""
        try:
            yield
        except TrueloopError as error:
            raise self.placed(error) from error

    def apart(self, written: bytes) -> list[bytes]:
        """Returns the program and those that it calls, of a text that was made of this one."""
        written = written.removesuffix(self.behind)
        parts: list[bytes] = []
        for file in reversed(self.called):
            *_, head = _heads(written, _name(file, self.style), self.style)
            part, written = written[head.start() :], written[: head.start()]
            head_is_new, is_marked = _as_read(file, self.style)
            mark = b"%\n" if is_marked else b""
            parts.append(mark + (part[part.index(b"\n") + 1 :] if head_is_new else part) + mark)
        return [written + self.behind, *reversed(parts)]


def of_folder(file: Path, dialect: str, source: bytes | None = None) -> WithCalled:
    """Returns a program with those that it calls of its own folder. Raises NC-FILE."""
    source = read_input(file, Code.NC_FILE, hint="name an NC program") if source is None else source
    style = _style(dialect)
    if style is None or len(source) > LARGEST_CALLER:
        return WithCalled(file, source)
    text, called = with_called(source, dialect, file.parent, lambda path: read_input(path, Code.NC_FILE, hint=""))
    if not called:
        return WithCalled(file, source)
    _, behind = _without_last_mark(source, style)
    files = tuple(file.parent / name for name, _ in called)
    begins = (line + _lines_before(path, style) for path, (_, line) in zip(files, called, strict=True))
    return WithCalled(file, text, style, called=files, begins=tuple(begins), behind=behind)


def _as_read(file: Path, style: str) -> tuple[bool, bool]:
    """Returns whether a file's program got a line with its number or name, and whether it begins with a tape mark."""
    original = file.read_bytes()
    is_marked = style == "number" and _MARK.match(original) is not None
    return style != "file" and _HEADER.match(_MARK.sub(b"", original)) is None, is_marked


def _lines_before(file: Path, style: str) -> int:
    head_is_new, is_marked = _as_read(file, style)
    return head_is_new - is_marked


def _style(dialect: str) -> str | None:
    """Returns how a control calls programs: by number, name or file; None where that is not looked for."""
    if dialect in ("siemens", "heidenhain"):
        return "name" if dialect == "siemens" else "file"
    return "number" if dialect.startswith(("fanuc", "haas")) else None


def _heads(text: bytes, name: str, style: str) -> list["re.Match[bytes]"]:
    """Returns the beginnings of programs of that name."""
    head = _HEADS[style] % re.escape(name.encode("latin-1", "replace"))
    return list(re.finditer(head, text, re.IGNORECASE | re.MULTILINE))


def with_called(
    source: bytes, dialect: str, folder: Path, read: Callable[[Path], bytes]
) -> tuple[bytes, tuple[tuple[str, int], ...]]:
    """Appends to the program all that it calls of a folder; returns of each also its file's name and first line.

    Raises NC-FILE where the folder cannot be read, NC-DIALECT for a control whose calls are not looked for.
    """
    style = _style(dialect)
    if style is None:
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
    known = {name: path for path in files if (name := _name(path, style))}
    whole, behind = _without_last_mark(source, style)
    taken: dict[str, int] = {}
    texts = [source]
    while texts:
        for name in _called(texts.pop(), style):
            if name not in known or name in taken or _heads(whole, name, style):
                continue
            text = read(known[name])
            if text == source or (style == "file" and not _heads(text, name, style)):
                continue  # itself, or one whose BEGIN PGM names another program
            taken[name] = whole.count(b"\n") + 1
            whole += _as_program(text, name, style)
            texts.append(text)
    return whole + behind, tuple((known[name].name, line) for name, line in taken.items())


def _name(path: Path, style: str) -> str:
    """By which a file's program is called: its number, its name in capitals; empty for none."""
    if style == "number":
        numbered = _NUMBERED.fullmatch(path.stem)
        return numbered.group(1) if numbered else ""
    return path.stem.upper() if path.suffix.upper() in ((".H",) if style == "file" else (".SPF", ".MPF")) else ""


def _called(source: bytes, style: str) -> Iterator[str]:
    """Names that may be called: of a Sinumerik all words."""
    if style == "file":
        yield from (name.decode("latin-1").upper().strip().removesuffix(".H") for name in _FILES.findall(source))
        return
    text = _COMMENTS[style].sub(b"", source)
    if style == "name":
        yield from (word.decode("latin-1").upper() for word in _NAMES.findall(text))
        return
    for before, after in _CALLS.findall(text):
        yield (before or after).decode()


def _without_last_mark(source: bytes, style: str) -> tuple[bytes, bytes]:
    """The program up to the tape mark at its end, and that: behind it a control reads nothing."""
    marks = list(_MARK.finditer(source)) if style == "number" else []
    if len(marks) < 2:
        return source if source.endswith(b"\n") else source + b"\n", b""
    return source[: marks[-1].start()], source[marks[-1].start() :]


def _as_program(text: bytes, name: str, style: str) -> bytes:
    """A file's text as one of several programs, with its number or name at its head."""
    if style == "number":
        text = _MARK.sub(b"", text)
    if style != "file" and not _HEADER.match(text):
        text = (f"%_N_{name}_SPF\n" if style == "name" else f"O{int(name):04d}\n").encode() + text
    return text if text.endswith(b"\n") else text + b"\n"
