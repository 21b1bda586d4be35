"""A link by its name in a file of settings."""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Final

from trueloop.controllers.links.changes import Change
from trueloop.controllers.links.compare import Difference, differences, in_words
from trueloop.controllers.links.focas.focas import Focas
from trueloop.controllers.links.folder import Folder, named_in
from trueloop.controllers.links.ftp import Ftp
from trueloop.controllers.links.line.framing import framed
from trueloop.controllers.links.line.line import Line
from trueloop.controllers.links.link import Link
from trueloop.controllers.links.linuxcnc import linuxcnc_busy, linuxcnc_reads
from trueloop.controllers.linuxcnc.realtime.signals.hal_pins import linuxcnc_module
from trueloop.formats.links_toml import AnyLink, FocasTable, FolderTable, LinuxCncTable, SerialTable, read_link
from trueloop.formats.tables.tool_tables.tool_table import Unit
from trueloop.jobs.links.table_rows import differing_rows
from trueloop.nc.program.guess import likeliest_dialect

JUDGED: Final = 100_000
"""Bytes of a program by which its dialect is found."""


@dataclass(frozen=True)
class Opened:
    """A link, what its control may change in a program, and where what is replaced there is written.

    `tool_table`: which of its programs is the control's tool table; `table_unit`: of one that does not say it;
    `dialect` of its programs, empty: the one that they look most like.
    """

    name: str
    link: Link | Line
    passes: frozenset[Change]
    replaced: Path
    tool_table: str = ""
    table_unit: Unit | None = None
    dialect: str = ""

    def differences(self, name: str, content: bytes, at_control: bytes) -> list[Difference]:
        """The lines and words that differ, other than by what this control, or its line, changes in every program.

        A tool table that a line or FOCAS carries is made of the numbers that the control took: these are compared.
        """
        if isinstance(self.link, Line | Focas) and name == self.tool_table:
            return differing_rows(name, content, at_control, self.table_unit)
        passes = self.passes
        if isinstance(self.link, Line | Focas):
            content, at_control, passes = framed(content), framed(at_control), passes | {Change.LINE_ENDS}
        found = differences(content, at_control, passes)
        return in_words(found, self.dialect or likeliest_dialect(content[:JUDGED]), passes) if found else []


def opened(settings: Path, name: str, tell: Callable[[str], None] = print) -> Opened:
    """The link. Connects to nothing yet. `tell` says what a person has to do at the control. Raises LNK-FILE."""
    table = read_link(settings, name)
    passes = frozenset(Change(one) for one in table.passes)
    link, replaced = link_of(table, settings.parent, tell), settings.parent / table.replaced
    return Opened(name, link, passes, replaced, table.tool_table, table.table_unit, table.dialect)


def link_of(table: AnyLink, beside: Path, tell: Callable[[str], None]) -> Link | Line:
    """The link of a table; relative names count from `beside`. Connects to nothing."""
    if isinstance(table, FolderTable):
        return Folder(beside / table.folder, named_in(beside / table.running_file) if table.running_file else None)
    if isinstance(table, LinuxCncTable):
        own = beside / table.ini, lambda: linuxcnc_module("linuxcnc")
        reads = linuxcnc_reads(*own, table.tool_table) if table.tool_table else None
        return Folder(beside / table.folder, linuxcnc_busy(*own), reads)
    if isinstance(table, SerialTable):
        line = (table.port, table.baud, table.data_bits, table.parity, table.stop_bits, table.flow)
        return Line(*line, table.code, table.line_end, table.after_xoff, table.silence_s, table.await_xon, tell)
    if isinstance(table, FocasTable):
        increment = None if table.increment is None else Decimal(str(table.increment))
        library = beside / table.library
        return Focas(table.host, library, table.aside, table.port, table.timeout_s, increment, table.table_unit)
    address = (table.host, table.port, table.user, table.password_env, table.folder)
    return Ftp(*address, table.tls, table.timeout_s, beside / table.authority if table.authority else None)
