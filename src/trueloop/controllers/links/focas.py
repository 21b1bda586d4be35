"""Fanuc controls, by the FOCAS library that the user has of Fanuc."""

import ctypes
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any, Final

from trueloop.controllers.links.folder import LARGEST, PART, Busy, ListedProgram, no_such_program, not_reached
from trueloop.controllers.links.line import framed, require_no_end_within
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.tool_tables.known import tool_table_of
from trueloop.formats.tables.tool_tables.tool_table import ToolRow, Unit

OK: Final = 0
BUSY: Final = -1
BUFFER: Final = 10
"""The control's buffer is full, or empty: the same call again."""
POLL_S: Final = 0.005
ANSWERS: Final = {
    -17: "protocol error", -16: "no connection to its address", -15: "the library for this series is missing",
    -11: "bus error", -10: "system error", -9: "HSSB error", -8: "the connection is lost",
    -7: "library and control differ", -6: "unexpected error", -5: "system error",
    -2: "reset or stopped at the control", -1: "busy", 1: "not prepared, or not known to this control",
    2: "wrong length of data", 3: "no such number", 4: "no such kind of data",
    5: "data refused: no such program, one that is there already, or text that it does not take",
    6: "the control has not this option", 7: "protected against writing", 8: "its memory is full",
    9: "a parameter of it is wrong", 10: "buffer full or empty", 11: "wrong path",
    12: "another mode has to be chosen at the control", 13: "refused now", 14: "data server error",
    15: "an alarm is on", 16: "it is stopped", 17: "protected data",
}  # fmt: skip
"""Meanings of EW codes, in short."""


def load(path: Path) -> ctypes.CDLL:
    """Loads the FOCAS library. Raises LNK-LIBRARY where it cannot be loaded."""
    kind: Callable[[str], ctypes.CDLL] = getattr(ctypes, "WinDLL") if sys.platform == "win32" else ctypes.CDLL  # noqa: B009
    try:
        return kind(str(path))
    except OSError as error:
        raise Code.LNK_LIBRARY.refusal(
            f"the FOCAS library {str(path)!r} cannot be loaded: {error}",
            hint="it is Fanuc's, and not part of this: name yours as `library` in the link's table [focas.NAME] "
            "(libfwlib32.so, Fwlib32.dll, Fwlib64.dll), of as many bits as this Python",
            values={"where": str(path)},
        ) from error


@dataclass(frozen=True)
class Connection:
    """A control by its handle. Raises LNK-REACH, with what the library answered, for all but OK."""

    library: ctypes.CDLL
    handle: int
    where: str
    timeout_s: float

    def call(self, name: str, *given: Any) -> None:
        """Calls a function that has to succeed; while the control is busy the call is repeated, up to `timeout_s`."""
        until = time.monotonic() + self.timeout_s
        while (answer := self.answer(name, *given)) == BUSY and time.monotonic() < until:
            time.sleep(POLL_S)
        if answer != OK:
            raise self.refused(name, answer)

    def answer(self, name: str, *given: Any) -> int:
        """Calls a function of the library and returns its code."""
        return _function(self.library, name, self.where)(ctypes.c_ushort(self.handle), *given)

    def refused(self, name: str, answer: int) -> TrueloopError:
        """Returns the error LNK-REACH."""
        return not_reached(self.where, f"{name} answered {answer}: {ANSWERS.get(answer, 'an unknown code')}")

    def moved(self, name: str, room: ctypes.c_int64, data: Any) -> int:
        """Bytes that a transfer's call carried: `room` before and after. Waits up to `timeout_s` without a byte."""
        until, there = time.monotonic() + self.timeout_s, room.value
        while True:
            room.value = there
            answer = self.answer(name, ctypes.byref(room), data)
            carried = room.value & 0xFFFFFFFF
            if answer not in (OK, BUFFER):
                raise self.refused(name, answer)
            if answer == OK and 0 < carried <= there:
                return carried
            if time.monotonic() > until:
                raise not_reached(self.where, f"{name} carried nothing for {self.timeout_s:g} s")
            time.sleep(POLL_S)


@contextmanager
def connected(library: Path, host: str, port: int, timeout_s: float) -> Iterator[Connection]:
    """Opens a connection for one piece of work and frees it afterwards. Raises LNK-LIBRARY, LNK-REACH."""
    focas, where, handle = load(library), f"focas://{host}:{port}", ctypes.c_ushort()
    _started(focas, where)
    open_ = _function(focas, "cnc_allclibhndl3", where)
    answer = open_(host.encode(), ctypes.c_ushort(port), ctypes.c_int32(max(1, round(timeout_s))), ctypes.byref(handle))
    connection = Connection(focas, handle.value, where, timeout_s)
    if answer != OK:
        raise connection.refused("cnc_allclibhndl3", answer)
    try:
        yield connection
    finally:
        connection.answer("cnc_freelibhndl")


def _started(focas: ctypes.CDLL, where: str) -> None:
    """The library for Linux wants a file for its log before anything else."""
    if hasattr(focas, "cnc_startupprocess"):
        log = str(Path(tempfile.gettempdir()) / "focas.log").encode()
        answer = _function(focas, "cnc_startupprocess", where)(ctypes.c_int32(0), log)
        if answer != OK:
            raise not_reached(where, f"cnc_startupprocess answered {answer}")


def _function(library: ctypes.CDLL, name: str, where: str) -> Callable[..., int]:
    try:
        found = getattr(library, name)
    except AttributeError as error:
        raise Code.LNK_LIBRARY.refusal(
            f"the library has no function {name}",
            hint="name Fanuc's FOCAS library as `library` in the link's table [focas.NAME]",
            values={"where": where},
        ) from error
    found.restype = ctypes.c_short
    return found  # type: ignore[no-any-return]


NAME: Final = re.compile(r"O(\d{4})")
HEAD: Final = re.compile(rb"\A%\s*O(\d{4})(?!\d)")


def named(number: int) -> str:
    """Returns the name of a program number: `O0012`."""
    return f"O{number:04d}"


def number_of(name: str) -> int:
    """Returns the number of a program's name. Raises LNK-NAME for another name than `O0012`."""
    found = NAME.fullmatch(name)
    if found is None or int(found[1]) == 0:
        raise _wrong(f"{name!r} is no program's name at a control that counts programs", name)
    return int(found[1])


def checked_text(content: bytes, name: str) -> bytes:
    """Frames a program. Raises LNK-NAME where its own O number is another, LNK-CODE for a `%` within it."""
    text = framed(content)
    require_no_end_within(text)
    found = HEAD.match(text)
    if found is None or int(found[1]) != number_of(name):
        own = "begins with no O number of four digits" if found is None else f"calls itself {named(int(found[1]))}"
        raise _wrong(f"the program {own}, and is to be {name}: the control goes by the program", name)
    return text


def renumbered(text: bytes, number: int) -> bytes:
    """Gives a framed program another number. A program without one stays as it is."""
    return HEAD.sub(lambda found: found[0][:-4] + f"{number:04d}".encode(), text)


def _wrong(message: str, name: str) -> TrueloopError:
    hint = "name it by its O number, with four digits: `--name O0012`"
    return Code.LNK_NAME.refusal(message, hint=hint, values={"name": name})


LETTERS: Final = "XZRQ"
GEOMETRY_FROM: Final = 10_000
LENGTH: Final = 8
"""Bytes of ODBTOFS."""


class _Offset(ctypes.Structure):
    """The structure ODBTOFS of FOCAS: a tool offset."""

    _fields_ = (("number", ctypes.c_short), ("kind", ctypes.c_short), ("data", ctypes.c_int32))


def offsets_text(control: Connection, increment: Decimal, unit: Unit) -> bytes:
    """Returns all offsets in force, wear and geometry, as G10 blocks. Raises LNK-REACH, also for what is no lathe."""
    system, info = ctypes.create_string_buffer(64), (ctypes.c_short * 8)()
    control.call("cnc_sysinfo", system)
    if b"T" not in system.raw[6:8]:
        kind = system.raw[6:8].decode("latin-1").strip()
        raise not_reached(control.where, f"it says that it is {kind!r}: offsets are read of lathes alone (T)")
    control.call("cnc_rdtofsinfo", info)
    rows = [
        f"G10 P{number + geometry * GEOMETRY_FROM} {_words(control, number, geometry, increment)}"
        for geometry in (0, 1)
        for number in range(1, info[1] + 1)
    ]
    return "\n".join(["%", "G21" if unit == "mm" else "G20", *rows, "%", ""]).encode()


def write_offsets(control: Connection, before: bytes, after: bytes, increment: Decimal, unit: Unit) -> None:
    """Writes what differs. Raises OFS errors before the first one, LNK-REACH after putting back what was written."""
    old, new = (_counts(text, increment, unit) for text in (before, after))
    if old.keys() != new.keys():
        lost = sorted(old.keys() ^ new.keys())[0]
        raise Code.OFS_ROW.refusal(
            f"the table and the control do not have the same offsets: {lost[0]} of kind {lost[1]}",
            hint="fetch the table, and change numbers in it alone",
        )
    written = list[tuple[int, int]]()
    try:
        for key in sorted(key for key in new if new[key] != old[key]):
            written.append(key)
            _write(control, key, new[key])
    except BaseException:
        for key in reversed(written):
            with suppress(TrueloopError):
                _write(control, key, old[key])
        raise


def _words(control: Connection, number: int, geometry: int, increment: Decimal) -> str:
    words = []
    for k, letter in enumerate(LETTERS):
        offset, kind = _Offset(), ctypes.c_short(2 * k + geometry)
        control.call("cnc_rdtofs", ctypes.c_short(number), kind, ctypes.c_short(LENGTH), ctypes.byref(offset))
        words.append(f"{letter}{offset.data}" if letter == "Q" else f"{letter}{offset.data * increment:f}")
    return " ".join(words)


def _write(control: Connection, key: tuple[int, int], count: int) -> None:
    number, kind = map(ctypes.c_short, key)
    control.call("cnc_wrtofs", number, kind, ctypes.c_short(LENGTH), ctypes.c_int32(count))


def _counts(text: bytes, increment: Decimal, unit: Unit) -> dict[tuple[int, int], int]:
    """The control's offsets, by number and kind."""
    table = tool_table_of(Path("OFFSETS"), text, unit)
    return {key: count for row in table.rows for key, count in _row_counts(row, increment)}


def _row_counts(row: ToolRow, increment: Decimal) -> Iterator[tuple[tuple[int, int], int]]:
    geometry = int(row.kind == "geometry")
    for k, number in enumerate((row.x, row.z, row.nose)):
        if number is not None:
            count = number.value / increment
            if count != int(count):
                raise Code.OFS_NUMBER.refusal(
                    f"{number.value} of offset {row.tool} is no whole number of the control's increment {increment}",
                    hint="state the increment that the control shows offsets with, or round the number",
                    values={"text": str(number.value)},
                )
            yield (row.tool, 2 * k + geometry), int(count)
    if row.tip is not None:
        yield (row.tool, 6 + geometry), row.tip


PIECE = 1024
ROWS = 10


class _Row(ctypes.Structure):
    """The structure PRGDIR3 of FOCAS: a row of the directory."""

    _fields_ = (
        *(("number", ctypes.c_int32), ("length", ctypes.c_int32), ("page", ctypes.c_int32)),
        *(("comment", ctypes.c_char * 52), ("changed", ctypes.c_short * 6), ("made", ctypes.c_short * 6)),
    )


def directory(control: Connection) -> list[ListedProgram]:
    """Lists the programs of the folder that is chosen at the control, by number. Raises LNK-REACH."""
    found, top = list[ListedProgram](), 0
    while True:
        first, count, rows = ctypes.c_int64(top), ctypes.c_short(ROWS), (_Row * ROWS)()
        control.call("cnc_rdprogdir3", ctypes.c_short(2), ctypes.byref(first), ctypes.byref(count), rows)
        page = [row for row in rows[: count.value] if row.number >= top]
        found += [ListedProgram(named(row.number), row.length) for row in page]
        if count.value < ROWS or not page:
            return found
        top = page[-1].number + 1


def upload(control: Connection, number: int) -> bytes:
    """Reads a program from the control, framed. Raises LNK-REACH."""
    control.call("cnc_upstart4", ctypes.c_short(0), named(number).encode())
    text = bytearray()
    try:
        while not text.rstrip().endswith(b"\n%"):
            buffer = ctypes.create_string_buffer(PIECE + 1)
            carried = control.moved("cnc_upload4", ctypes.c_int64(PIECE), buffer)
            text += buffer.raw[:carried]
            if len(text) > LARGEST:
                raise not_reached(control.where, f"{named(number)} has more than {LARGEST} bytes")
    finally:
        control.answer("cnc_upend4")
    return framed(bytes(text))


def download(control: Connection, text: bytes) -> None:
    """Sends a framed program, whose number the control takes. Raises LNK-REACH; half of it may be there then.

    Its errors come at the end: the control reports there whether it has registered the program.
    """
    left = text.removeprefix(b"%").rstrip(b"\n")
    control.call("cnc_dwnstart4", ctypes.c_short(0), b"")
    try:
        while left:
            piece = left[:PIECE]
            left = left[control.moved("cnc_download4", ctypes.c_int64(len(piece)), piece) :]
    except BaseException:
        control.answer("cnc_dwnend4")
        raise
    control.call("cnc_dwnend4")


def delete(control: Connection, number: int) -> None:
    """Deletes a program. Raises LNK-REACH: the control refuses for one that runs."""
    control.call("cnc_delete", ctypes.c_short(number))


def busy(control: Connection) -> Busy:
    """Returns the running main program and subprogram; one held or stopped within a block runs. Raises LNK-REACH.

    The states are those of Series 16i, 18i, 21i, 0i, 30i, 31i and 32i; of Series 15 they stand elsewhere.
    """
    state, programs = (ctypes.c_short * 32)(), (ctypes.c_short * 8)()
    control.call("cnc_statinfo", state)
    if state[3] == 0:  # neither stopped, held, started nor retracting: reset
        return Busy()
    control.call("cnc_rdprgnum", programs)
    return Busy(tuple(named(number) for number in dict.fromkeys(programs[2:4]) if number > 0) or ("a program",))


TABLE: Final = "OFFSETS"
"""The name of the control's offsets among its programs."""


@dataclass(frozen=True)
class Focas:
    """Programs in the folder that is chosen at the control. Each call connects anew.

    `aside`: the number of a program that is there for transfers alone. `increment`: what offsets are counted in, in
    `unit`. Raises LNK-LIBRARY where the library cannot be loaded.
    """

    host: str
    library: Path
    aside: int
    port: int = 8193
    timeout_s: float = 10.0
    increment: Decimal | None = None
    unit: Unit | None = None

    @property
    def where(self) -> str:
        """Returns the address."""
        return f"focas://{self.host}:{self.port}"

    @property
    def note(self) -> str:
        """States that the protocol has no password."""
        return f"{self.host}: FOCAS knows no password, anybody on this network can do the same"

    def listed(self) -> list[ListedProgram]:
        """Lists the programs, without the one of transfers."""
        with self._connected() as control:
            return [program for program in directory(control) if number_of(program.name) != self.aside]

    def read(self, name: str) -> bytes:
        """Reads a program, framed; one sent aside with the number that it is to have. `TABLE`: the offsets."""
        with self._connected() as control:
            if name == TABLE:
                return offsets_text(control, *self._counted())
            if name.endswith(PART):
                return renumbered(upload(control, self.aside), number_of(name.removesuffix(PART)))
            number, there = number_of(name), [program.name for program in directory(control)]
            if name not in there:
                raise no_such_program(name, self.where, there)
            return upload(control, number)

    def write_aside(self, name: str, content: bytes) -> str:
        """Sends it under the number of transfers, by which the control shows that it accepts it and has room."""
        text = renumbered(checked_text(content, name), self.aside)
        with self._connected() as control:
            self._removed(control)
            download(control, text)
        return name + PART

    def put_in_place(self, aside: str, name: str) -> None:
        """Deletes the program of that name, and sends the one that was sent aside under it; else that one again."""
        number, text = number_of(name), self.read(aside)
        with self._connected() as control:
            if any(program.name == name for program in directory(control)):
                before = upload(control, number)
                delete(control, number)
                try:
                    download(control, text)
                except BaseException:
                    with suppress(TrueloopError):
                        download(control, before)
                    raise
            else:
                download(control, text)
            self._removed(control)

    def remove_aside(self, aside: str) -> None:
        """Removes it; what cannot be removed stays under the number of transfers, in whose place the next one comes."""
        with suppress(TrueloopError), self._connected() as control:
            self._removed(control)

    def busy(self) -> Busy | None:
        """Returns the program that runs."""
        with self._connected() as control:
            return busy(control)

    def write_table(self, content: bytes) -> None:
        """Writes the offsets that differ from those in force; after an error those that were written are put back."""
        increment, unit = self._counted()
        with self._connected() as control:
            write_offsets(control, offsets_text(control, increment, unit), content, increment, unit)

    def _removed(self, control: Connection) -> None:
        if any(number_of(program.name) == self.aside for program in directory(control)):
            delete(control, self.aside)

    def _counted(self) -> tuple[Decimal, Unit]:
        if self.increment is None or self.unit is None:
            raise Code.OFS_UNIT.refusal(
                f"{self.where} counts offsets, and nothing says in what: a tenth or ten times as much would be read",
                hint="state `table_unit`, and `increment` (0.001 where the control shows three decimals), "
                "in the link's table [focas.NAME]",
            )
        return self.increment, self.unit

    def _connected(self) -> AbstractContextManager[Connection]:
        return connected(self.library, self.host, self.port, self.timeout_s)
