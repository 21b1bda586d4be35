"""The tool tables that are known, and a file read by whichever of them recognises it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final, TypeAlias

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_input
from trueloop.formats.tables.tool_tables import fanuc_g10, haas_ofs, heidenhain_t, linuxcnc_tbl, siemens_toa
from trueloop.formats.tables.tool_tables.tool_table import HINT, ToolTable, Unit

Reader: TypeAlias = Callable[[Path, str, Unit | None], ToolTable]
KNOWN: Final[tuple[tuple[Callable[[Path, bytes], bool], Reader], ...]] = (
    (heidenhain_t.recognises, heidenhain_t.read),
    (haas_ofs.recognises, haas_ofs.read),
    (siemens_toa.recognises, siemens_toa.read),
    (fanuc_g10.recognises, fanuc_g10.read),
    (linuxcnc_tbl.recognises, linuxcnc_tbl.read),
)
"""In the order in which they are asked: how a table is recognised, and its reader."""
NAMES: Final = (linuxcnc_tbl.LINUXCNC, fanuc_g10.FANUC, haas_ofs.HAAS, siemens_toa.SIEMENS, heidenhain_t.HEIDENHAIN)


def read_tool_table(path: Path, unit: Unit | None = None) -> ToolTable:
    """A control's tool table. `unit` is what is stated of it.

    Raises OFS-FILE, OFS-FORMAT, OFS-NUMBER, and OFS-UNIT where the file says another unit than is stated.
    """
    return tool_table_of(path, read_input(path, Code.OFS_FILE, hint=HINT), unit)


def tool_table_of(path: Path, source: bytes, unit: Unit | None = None) -> ToolTable:
    """The same of a table that was read already; `path` names it. Raises what `read_tool_table` does."""
    for recognises, read in KNOWN:
        if recognises(path, source):
            table = read(path, source.decode("latin-1"), unit)
            return replace(table, unit=table.with_unit(unit))
    names = ", ".join(convention.name for convention in NAMES)
    raise TrueloopError(
        Code.OFS_FORMAT,
        f"{path.name!r}, {len(source)} bytes, is none of the {len(NAMES)} kinds of tool table that are read: {names}",
        hint=HINT,
        place=Place(str(path)),
        values={"file": path.name},
    )
