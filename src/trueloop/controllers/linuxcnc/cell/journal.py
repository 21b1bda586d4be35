"""A cell's facts, on disk before it acts on them: one line a fact, with a checksum, never changed."""

import json
import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, Final

from trueloop.domain.factory import FactKind
from trueloop.errors import Code, Place, TrueloopError


@dataclass(frozen=True)
class Entry:
    """One fact: its number from 1, what it is about, and its values."""

    no: int
    what: str
    values: Mapping[str, Any]

    def line(self) -> bytes:
        """Returns the entry as its line in the journal: checksum and JSON."""
        text = json.dumps([self.no, self.what, dict(self.values)], ensure_ascii=True, sort_keys=True)
        return f"{_sum(text)} {text}\n".encode()


class Journal:
    """The one writer of a journal. `entries` are all of them; `torn`: what a crash left of a last line."""

    def __init__(self, file: Path) -> None:
        """Opens or begins it. Raises CEL-JOURNAL: another client has it, a damaged line before the last, Windows."""
        if sys.platform == "win32":
            raise _refused(file, "a cell runs on Linux alone", "start it on the computer of the machine's LinuxCNC")
        import fcntl

        self.file = file
        try:
            self._fd = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            content = file.read_bytes()
            self.entries, self._end = read(content, file)
            self.torn = content[self._end :]
            os.ftruncate(self._fd, self._end)
            os.fsync(self._fd)
            fd = os.open(file.parent, os.O_RDONLY | os.O_DIRECTORY)
            try:
                os.fsync(fd)
            finally:
                os.close(fd)
        except BlockingIOError as error:
            raise _refused(file, "another client has it: 1 is the most", "end that one first") from error
        except OSError as error:
            raise _refused(file, f"error {error.errno}: {error.strerror}", "see that the disk has room") from error

    def add(self, what: str, /, **values: Any) -> Entry:
        """Adds one fact; it is on the disk when this returns. Raises CEL-JOURNAL, and then holds nothing of it."""
        entry = Entry(len(self.entries) + 1, what, values)
        line = entry.line()
        try:
            if os.pwrite(self._fd, line, self._end) != len(line):
                raise OSError(28, "no room for a whole line")
            os.fdatasync(self._fd)
        except OSError as error:
            os.ftruncate(self._fd, self._end)
            raise _refused(
                self.file, f"error {error.errno}: {error.strerror}", "make room; nothing is begun before"
            ) from error
        self._end += len(line)
        self.entries.append(entry)
        return entry

    def close(self) -> None:
        """Gives it free for another client."""
        os.close(self._fd)


def read(content: bytes, file: Path) -> tuple[list[Entry], int]:
    """Entries, and where they end: what follows is a last line that a crash tore. Raises CEL-JOURNAL.

    A crash leaves the beginning of a line, or a page of zeros; a last line that is whole and wrong is damage.
    """
    entries: list[Entry] = []
    end = 0
    for line in BytesIO(content):  # by line feeds alone: a damaged byte may read as another end of a line
        entry = _entry(line)
        if entry is None or entry.no != len(entries) + 1:
            if end + len(line) < len(content) or (line.endswith(b"\n") and b"\0\0" not in line):
                raise _refused(
                    file, f"line {len(entries) + 1} is damaged", "keep a copy and have a person look", len(entries) + 1
                )
            break
        entries.append(entry)
        end += len(line)
    return entries, end


def _entry(line: bytes) -> Entry | None:
    checksum, _, text = line.decode(errors="replace").partition(" ")
    if not text.endswith("\n") or _sum(text[:-1]) != checksum:
        return None
    return Entry(*json.loads(text))


def _sum(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:16]


def _refused(file: Path, why: str, hint: str, line: int | None = None) -> TrueloopError:
    return Code.CEL_JOURNAL.refusal(f"the journal: {why}", hint=hint, place=Place(str(file), line))


TOLD: Final = ("fact", "touches", "temperatures")
"""Kinds of entries that the service is to have."""


@dataclass(frozen=True)
class RunNow:
    """A run in hand. `touches`: the file that its program writes; `facts`: what is noted of it.

    `opened`: the control was given it; `begun`: the client was about to start it; `withdrawn`: the service no longer
    offers it; `differs`: what was read back is not what was sent.
    """

    key: str
    sent_sha256: str
    touches: str = ""
    facts: frozenset[FactKind] = frozenset()
    opened: bool = False
    begun: bool = False
    withdrawn: bool = False
    differs: bool = False
    gathered: bool = False

    @property
    def program(self) -> str:
        """Returns the name of its file at the control."""
        return f"{self.key}.ngc"


@dataclass(frozen=True)
class JournalState:
    """`run`: None where none is in hand; `over`: keys that never run again; `waiting`: entries for the service."""

    run: RunNow | None = None
    over: frozenset[str] = frozenset()
    waiting: tuple[Entry, ...] = ()
    refused: tuple[Any, ...] = field(default=())


def known(entries: Iterable[Entry]) -> JournalState:
    """Folds the entries of a journal into what is known."""
    now = JournalState()
    for entry in entries:
        now = with_entry(now, entry)
    return now


def with_entry(now: JournalState, entry: Entry) -> JournalState:
    """Returns the state after one more entry."""
    values = entry.values
    if entry.what in TOLD:
        now = replace(now, waiting=(*now.waiting, entry))
    if entry.what == "run":
        return replace(now, run=RunNow(values["key"], values["sent_sha256"], values["touches"]))
    if entry.what in ("acknowledged", "refused"):
        left = tuple(one for one in now.waiting if one.no not in values["entries"])
        refused = (*now.refused, dict(values)) if entry.what == "refused" else now.refused
        return replace(now, waiting=left, refused=refused)
    run = now.run
    if run is None or values.get("run") != run.key:
        return now
    if entry.what == "closed":
        return replace(now, run=None, over=now.over | {run.key})
    return replace(now, run=_with(run, entry))


def _with(run: RunNow, entry: Entry) -> RunNow:
    if entry.what == "fact":
        what = FactKind(entry.values["what"])
        read = entry.values["values"].get("read_back_sha256", run.sent_sha256)
        return replace(run, facts=run.facts | {what}, differs=run.differs or read != run.sent_sha256)
    if entry.what in ("touches", "no-touches"):
        return replace(run, gathered=True)
    return replace(
        run,
        opened=run.opened or entry.what == "opened",
        begun=run.begun or entry.what == "begun",
        withdrawn=run.withdrawn or entry.what == "withdrawn",
    )
