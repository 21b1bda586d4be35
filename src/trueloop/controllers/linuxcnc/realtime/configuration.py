"""A configuration of LinuxCNC as its files say it: the INI file, and the lines of HAL that it names, in their order."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place
from trueloop.formats.input_file import read_input

LIBRARY: Final = Path("/usr/share/linuxcnc/hallib")
MOST_FILES: Final = 50
"""Of HAL: a file that sources itself would have no end."""


@dataclass(frozen=True)
class Entry:
    """A key of the INI file, in its section and line."""

    section: str
    key: str
    value: str
    place: Place


@dataclass(frozen=True)
class HalLine:
    """A line of HAL as it stands, and the words that halcmd sees of it."""

    place: Place
    text: str
    words: tuple[str, ...]


@dataclass(frozen=True)
class Configuration:
    """The files that LinuxCNC is started with."""

    ini: Path
    entries: tuple[Entry, ...]
    hal: tuple[HalLine, ...]

    def all(self, section: str, key: str) -> tuple[Entry, ...]:
        """Returns every entry of this name."""
        return tuple(e for e in self.entries if (e.section, e.key) == (section, key))

    def value(self, section: str, key: str, otherwise: str = "") -> str:
        """Returns the first entry's value, else `otherwise`."""
        return next((entry.value for entry in self.all(section, key)), otherwise)

    def commands(self, verb: str) -> tuple[HalLine, ...]:
        """Returns the lines of HAL with this command."""
        return tuple(line for line in self.hal if line.words and line.words[0] == verb)

    def using(self, pin: str) -> tuple[HalLine, ...]:
        """Returns the lines of HAL that name a pin."""
        return tuple(line for line in self.hal if pin in line.words[1:])

    def signal_of(self, pin: str) -> str | None:
        """Returns the signal that a pin is netted to; None: none."""
        return next((line.words[1] for line in self.using(pin) if line.words[0] == "net"), None)


def read_configuration(ini: Path) -> Configuration:
    """Reads the files. Raises RTC-HAL for one that cannot be read, and for anything that is not plain HAL."""
    entries = tuple(_entries(ini))
    named = Configuration(ini, entries, ())
    lines: list[HalLine] = []
    named_files = (*named.all("HAL", "HALFILE"), *named.all("HAL", "POSTGUI_HALFILE"))
    for entry in (entry for entry in named_files if entry.value):
        lines += _hal(_hal_file(entry, ini.parent), named, 0)
    return Configuration(ini, entries, tuple(lines))


def _entries(ini: Path) -> Iterator[Entry]:
    section = ""
    for number, line in enumerate(_text(ini).splitlines(), 1):
        text = line.strip()
        if text.startswith("#INCLUDE "):
            yield from _entries(ini.parent / text.split(None, 1)[1].strip())
        elif text.startswith("["):
            section = text[1:].partition("]")[0].strip()
        elif "=" in text and text[0] not in "#;":
            key, _, value = text.partition("=")
            yield Entry(section, key.strip(), value.partition("#")[0].strip(), Place(str(ini), number))


def _hal_file(entry: Entry, folder: Path) -> Path:
    name = entry.value.split()[0]
    if name.endswith(".tcl"):
        raise Code.RTC_HAL.refusal(
            f"{entry.key} = {entry.value} is a script: what it nets is not known before it runs",
            hint="let LinuxCNC run, save what was made with `halcmd save all FILE.hal`, and name that file instead",
            place=entry.place,
        )
    return LIBRARY / name.removeprefix("LIB:") if name.startswith("LIB:") else _found(folder / Path(name).expanduser())


def _found(path: Path) -> Path:
    """The file, or that of this name in LinuxCNC's library."""
    in_library = LIBRARY / path.name
    return in_library if in_library.exists() and not path.exists() else path


def _hal(path: Path, named: Configuration, depth: int) -> Iterator[HalLine]:
    """A file's lines, with those that it sources in their place; a continued line is one, where it begins."""
    if depth > MOST_FILES:
        raise Code.RTC_HAL.refusal(
            f"{path.name} is sourced {depth} levels deep",
            hint="a file that sources itself has no end",
            place=Place(str(path)),
        )
    open_text, first = "", 0
    for number, line in enumerate(_text(path).splitlines(), 1):
        first = first if open_text else number
        open_text += line
        if line.endswith("\\"):
            open_text += "\n"
            continue
        words = tuple(_substituted(open_text.replace("\\\n", " "), named).split())
        yield HalLine(Place(str(path), first), open_text, words)
        if words[:1] == ("source",):
            yield from _hal(_found(named.ini.parent / words[1]), named, depth + 1)
        open_text = ""


def _substituted(text: str, named: Configuration) -> str:
    """Without comments, arrows and quotes; [SECTION]KEY and [SECTION](KEY) as the INI file has them."""
    text = re.sub(r"<=>|=>|<=|\"", " ", text.partition("#")[0])

    def told(match: re.Match[str]) -> str:
        return named.value(match[1], match[2] or match[3], match[0])

    return re.sub(r"\[(\w+)\](?:\((\w+)\)|(\w+))", told, text)


def _text(path: Path) -> str:
    return read_input(path, Code.RTC_HAL, hint="name the INI file that LinuxCNC is started with").decode(
        "utf-8", "replace"
    )
