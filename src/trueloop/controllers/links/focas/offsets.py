"""Offsets of a Fanuc lathe: read as a table of G10, and the numbers that differ written one by one.

Kinds of offset (T series): wear of X 0, Z 2, nose radius 4, tip 6; geometry of X 1, Z 3, nose radius 5, tip 7.
"""

import ctypes
from collections.abc import Iterator
from contextlib import suppress
from decimal import Decimal
from pathlib import Path
from typing import Final

from trueloop.controllers.links.focas.library import Connection
from trueloop.controllers.links.link import not_reached
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.tool_tables.known import tool_table_of
from trueloop.formats.tables.tool_tables.tool_table import ToolRow, Unit

LETTERS: Final = "XZRQ"
GEOMETRY_FROM: Final = 10_000
LENGTH: Final = 8
"""Bytes of ODBTOFS."""


class _Offset(ctypes.Structure):
    """ODBTOFS."""

    _fields_ = (("number", ctypes.c_short), ("kind", ctypes.c_short), ("data", ctypes.c_int32))


def offsets_text(control: Connection, increment: Decimal, unit: Unit) -> bytes:
    """All offsets in force, wear and geometry, as G10 blocks. Raises LNK-REACH, also for what is no lathe."""
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
        raise TrueloopError(
            Code.OFS_ROW,
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
    """What the control counts, by number and kind of offset."""
    table = tool_table_of(Path("OFFSETS"), text, unit)
    return {key: count for row in table.rows for key, count in _row_counts(row, increment)}


def _row_counts(row: ToolRow, increment: Decimal) -> Iterator[tuple[tuple[int, int], int]]:
    geometry = int(row.kind == "geometry")
    for k, number in enumerate((row.x, row.z, row.nose)):
        if number is not None:
            count = number.value / increment
            if count != int(count):
                raise TrueloopError(
                    Code.OFS_NUMBER,
                    f"{number.value} of offset {row.tool} is no whole number of the control's increment {increment}",
                    hint="state the increment that the control shows offsets with, or round the number",
                    values={"text": str(number.value)},
                )
            yield (row.tool, 2 * k + geometry), int(count)
    if row.tip is not None:
        yield (row.tool, 6 + geometry), row.tip
