"""Programs to and from a Fanuc control, over a connection that is there."""

import ctypes

from trueloop.controllers.links.focas.library import Connection
from trueloop.controllers.links.focas.numbers import named
from trueloop.controllers.links.line.framing import framed
from trueloop.controllers.links.link import LARGEST, Busy, Listed, not_reached

PIECE = 1024
ROWS = 10


class _Row(ctypes.Structure):
    """PRGDIR3."""

    _fields_ = (
        *(("number", ctypes.c_int32), ("length", ctypes.c_int32), ("page", ctypes.c_int32)),
        *(("comment", ctypes.c_char * 52), ("changed", ctypes.c_short * 6), ("made", ctypes.c_short * 6)),
    )


def directory(control: Connection) -> list[Listed]:
    """The programs of the folder that is chosen at the control, by number. Raises LNK-REACH."""
    found, top = list[Listed](), 0
    while True:
        first, count, rows = ctypes.c_int64(top), ctypes.c_short(ROWS), (_Row * ROWS)()
        control.call("cnc_rdprogdir3", ctypes.c_short(2), ctypes.byref(first), ctypes.byref(count), rows)
        page = [row for row in rows[: count.value] if row.number >= top]
        found += [Listed(named(row.number), row.length) for row in page]
        if count.value < ROWS or not page:
            return found
        top = page[-1].number + 1


def upload(control: Connection, number: int) -> bytes:
    """A program from the control, framed. Raises LNK-REACH."""
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
    """A framed program to the control, which takes its number from it. Raises LNK-REACH; half of it may be there then.

    Its errors come at the end: the control says there whether it has registered the program.
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
    """What runs, main program and subprogram; a program that is held or stopped within a block runs. Raises LNK-REACH.

    The states are those of Series 16i, 18i, 21i, 0i, 30i, 31i and 32i; of Series 15 they stand elsewhere.
    """
    state, programs = (ctypes.c_short * 32)(), (ctypes.c_short * 8)()
    control.call("cnc_statinfo", state)
    if state[3] == 0:  # neither stopped, held, started nor retracting: reset
        return Busy()
    control.call("cnc_rdprgnum", programs)
    return Busy(tuple(named(number) for number in dict.fromkeys(programs[2:4]) if number > 0) or ("a program",))
