"""A control whose programs are files in a folder: a network share, a memory card, LinuxCNC's nc_files.

The operations of every link to a control, and the program names that it takes.

A LinuxCNC of this computer says by its own Python module what it is busy with, and reads its tool table.
"""

import os
import re
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final, Protocol

from trueloop.controllers.linuxcnc.cell.linuxcnc import Task
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.tool_tables.known import tool_table_of
from trueloop.wording import did_you_mean

PART: Final = ".part"
"""Ends the name of a program that is being sent; `checked_name` refuses it."""
NAME: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.,+-]{0,99}")
LARGEST: Final = 64_000_000
"""Bytes of a program; a control holds far less."""


@dataclass(frozen=True)
class ListedProgram:
    """A program at a control: its name there, its bytes, when it was changed; None: the control does not say."""

    name: str
    size_bytes: int | None = None
    changed_at: datetime | None = None


@dataclass(frozen=True)
class Busy:
    """Programs that a control executes, or has read and would cut so; names with their folders or without."""

    runs: tuple[str, ...] = ()
    loaded: tuple[str, ...] = ()


class Link(Protocol):
    """A control's programs. Names are checked (`checked_name`) before they reach it.

    Every method raises LNK-REACH where the control is not reached, refuses, or the line breaks; `read` LNK-NAME for a
    program that is not there.
    """

    @property
    def where(self) -> str:
        """Returns the control's address for people, without a password."""

    @property
    def note(self) -> str:
        """Returns what a user of this link has to know; empty: nothing."""

    def listed(self) -> list[ListedProgram]:
        """Lists the programs at the control, by name."""

    def read(self, name: str) -> bytes:
        """Reads a program, byte for byte."""

    def write_aside(self, name: str, content: bytes) -> str:
        """Sends a program under another name, which is returned: nothing is replaced yet."""

    def put_in_place(self, aside: str, name: str) -> None:
        """Gives what was sent aside its own name, in place of what has that name."""

    def remove_aside(self, aside: str) -> None:
        """Takes what was sent aside away again."""

    def busy(self) -> Busy | None:
        """Returns what runs and what is loaded; None: this link cannot know."""


def checked_name(name: str) -> str:
    """Returns the name. Raises LNK-NAME for one that could leave the control's folder, or stands for a transfer."""
    if NAME.fullmatch(name) and not name.endswith(PART) and ".." not in name:
        return name
    raise Code.LNK_NAME.refusal(
        f"{name!r} is not a valid program name",
        hint=f"up to 100 letters, digits and _ . , + -, beginning with a letter, a digit or _, not ending with {PART}",
        values={"name": name},
    )


def no_such_program(name: str, where: str, there: list[str]) -> TrueloopError:
    """Makes the error LNK-NAME, with the nearest name."""
    hint = did_you_mean(name, there) or f"{len(there)} programs are there: `trueloop link list`"
    return Code.LNK_NAME.refusal(f"no program {name!r} is stored at {where}", hint=hint, values={"name": name})


def not_reached(where: str, error: Exception | str) -> TrueloopError:
    """Returns the error LNK-REACH."""
    said = error if isinstance(error, str) else f"{type(error).__name__}: {error}"
    return Code.LNK_REACH.refusal(
        f"{where}: {said}",
        hint="see that the control is on and its address right; `trueloop link compare` shows which program it holds",
        values={"where": where},
    )


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

    def listed(self) -> list[ListedProgram]:
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
            raise no_such_program(name, self.where, [program.name for program in self.listed()])
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
            handle = os.open(self.folder, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
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
    """Reads the first line of the file that names what runs, "" while nothing does; None where it cannot be read."""

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


def _listed(path: Path) -> ListedProgram:
    state = path.stat()
    return ListedProgram(path.name, state.st_size, datetime.fromtimestamp(state.st_mtime, UTC))


BY_HAND: Final = "what is typed or done by hand"
TAKEN_S: Final = 5.0
"""How long LinuxCNC may take to read its tool table."""
_POLL_S: Final = 0.02
Offsets = dict[int, tuple[float, float]]
"""X and Z by tool, as the table counts them."""


def linuxcnc_busy(ini: Path, module: Callable[[], Any]) -> Callable[[], Busy | None]:
    """Asks the LinuxCNC of that configuration; `module` loads its `linuxcnc`. One that does not run does nothing.

    A program that is loaded and not begun counts: LinuxCNC has opened the file, and the next start cuts what it was
    then (LinuxCNC issue 2490). None: it comes up or goes just now, and does not say. The call raises CTL-LINUXCNC for a
    configuration that cannot be read.
    """

    def busy() -> Busy | None:
        nc = module()
        if not _runs(ini, nc):
            return Busy()
        try:
            status = nc.stat()
            status.poll()
        except (nc.error, SystemError):  # the second where HOME is another's than LinuxCNC's: its tools are there
            return None
        return _busy(status, nc)

    return busy


def _busy(status: Any, nc: Any) -> Busy:
    loaded = (status.file,) if status.file else ()
    idle = status.interp_state == nc.INTERP_IDLE and status.exec_state in (nc.EXEC_DONE, nc.EXEC_ERROR)
    if idle and status.inpos and not status.paused:
        return Busy(loaded=loaded)
    by_hand = () if status.task_mode == nc.MODE_AUTO else (BY_HAND,)
    return Busy(by_hand or loaded, loaded)


def linuxcnc_reads(ini: Path, module: Callable[[], Any], name: str) -> Callable[[Path], None]:
    """Makes the LinuxCNC of that configuration load its tool table of this name, and compares its X and Z offsets.

    Other files are not loaded. A LinuxCNC that does not run loads the table when it starts. An active offset does not
    change before the program calls G43 again. The call raises CTL-LINUXCNC for a file that is not this LinuxCNC's tool
    table, or whose offsets LinuxCNC does not have afterwards.
    """

    def read(table: Path) -> None:
        if table.name != name:
            return
        nc = module()
        runs, own = _runs(ini, nc), ini.parent / _stated(ini, nc, "EMCIO", "TOOL_TABLE")
        if own.resolve() != table.resolve():
            raise _failed(f"{table} is written, but the tool table of {ini} is {own}", "name that one as `tool_table`")
        if runs and (wrong := _not_taken(nc, _in_file(table))):
            tools = ", ".join(f"T{one}" for one in wrong)
            said = f"{table} is written, and LinuxCNC has not taken the offsets of {tools} within {TAKEN_S:g} s"
            raise _failed(said, "end LinuxCNC and start it again before anything is cut: it reads the table then")

    return read


def _not_taken(nc: Any, wanted: Offsets) -> list[int]:
    """Tools whose offsets in LinuxCNC, after it has read the table, are missing or differ from it."""
    command, status = nc.command(), nc.stat()
    command.load_tool_table()
    until = time.monotonic() + TAKEN_S
    while True:
        status.poll()
        held: Offsets = {one.id: (one.xoffset, one.zoffset) for one in status.tool_table if one.id > 0}
        wrong = sorted(tool for tool in wanted.keys() | held.keys() if wanted.get(tool) != held.get(tool))
        if not wrong or time.monotonic() > until:
            return wrong
        time.sleep(_POLL_S)


def _in_file(table: Path) -> Offsets:
    rows = tool_table_of(table, table.read_bytes()).rows
    return {
        row.tool: (0.0 if row.x is None else float(row.x.value), 0.0 if row.z is None else float(row.z.value))
        for row in rows
    }


def _runs(ini: Path, nc: Any) -> bool:
    return Task(ini, Path(_stated(ini, nc, "TASK", "TASK") or "milltask").name).pid() is not None


def _stated(ini: Path, nc: Any, section: str, name: str) -> str:
    try:
        return nc.ini(str(ini)).find(section, name) or ""
    except nc.error as error:
        said = f"LinuxCNC's configuration {str(ini)!r} cannot be read: {error}"
        raise _failed(said, "name it as `ini` in the link's table [linuxcnc.NAME]") from error


def _failed(message: str, hint: str) -> TrueloopError:
    return Code.CTL_LINUXCNC.refusal(message, hint=hint)
