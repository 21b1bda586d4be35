"""A control whose programs are files in a folder: a network share, a memory card, LinuxCNC's nc_files."""

import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from trueloop.controllers.links.link import LARGEST, NAME, PART, Busy, Listed, no_such_program, not_reached


@dataclass(frozen=True)
class Folder:
    """Programs in `folder`. `asked` says what the control is busy with, where anything does.

    `tell` makes a control load a file that was replaced, where it does not load it by itself. Links of the file
    system that lead elsewhere are neither listed nor read.
    """

    folder: Path
    asked: Callable[[], Busy | None] | None = None
    tell: Callable[[Path], None] | None = None

    @property
    def where(self) -> str:
        """Returns the folder."""
        return str(self.folder)

    @property
    def note(self) -> str:
        """Returns no note."""
        return ""

    def listed(self) -> list[Listed]:
        """Lists the files in the folder that can be a program."""
        try:
            every = sorted(self.folder.iterdir())
            return [_listed(one) for one in every if _is_program(one)]
        except OSError as error:
            raise not_reached(self.where, error) from error

    def read(self, name: str) -> bytes:
        """Returns the file's bytes."""
        path = self.folder / name
        if not _may_be_read(path):
            raise no_such_program(name, self.where, [one.name for one in self.listed()])
        try:
            with path.open("rb") as file:
                content = file.read(LARGEST + 1)
        except OSError as error:
            raise not_reached(self.where, error) from error
        if len(content) > LARGEST:
            raise not_reached(self.where, f"{name!r} has more than {LARGEST} bytes")
        return content

    def write_aside(self, name: str, content: bytes) -> str:
        """Writes and syncs a file that is there for this transfer alone."""
        path = self.folder / (name + PART)
        try:
            path.unlink(missing_ok=True)  # of a transfer that was cut off
            with path.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            self.remove_aside(path.name)
            raise not_reached(self.where, error) from error
        return path.name

    def put_in_place(self, aside: str, name: str) -> None:
        """Renames once: at every moment the old program is there whole, or the new one."""
        try:
            (self.folder / aside).replace(self.folder / name)
            _sync(self.folder)
        except OSError as error:
            raise not_reached(self.where, error) from error
        if self.tell is not None:
            self.tell(self.folder / name)

    def remove_aside(self, aside: str) -> None:
        """Removes it; what cannot be removed stays, under a name that no transfer takes for a program."""
        with suppress(OSError):
            (self.folder / aside).unlink(missing_ok=True)

    def busy(self) -> Busy | None:
        """Returns the answer of `asked`."""
        return None if self.asked is None else self.asked()


def named_in(file: Path) -> Callable[[], Busy | None]:
    """Reads the first line of a file in which the control writes what runs, empty while nothing does.

    A file that is not there or cannot be read gives None.
    """

    def busy() -> Busy | None:
        try:
            lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError:
            return None
        first = lines[0].strip() if lines else ""
        return Busy((first,) if first else ())

    return busy


def _may_be_read(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _is_program(path: Path) -> bool:
    return bool(NAME.fullmatch(path.name)) and not path.name.endswith(PART) and _may_be_read(path)


def _listed(path: Path) -> Listed:
    state = path.stat()
    return Listed(path.name, state.st_size, datetime.fromtimestamp(state.st_mtime, UTC))


def _sync(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
