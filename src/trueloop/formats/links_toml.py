"""Settings of links to controls: a TOML file, a table for each control."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import AfterValidator, Field

from trueloop.errors import Code, Place
from trueloop.formats.toml_tables import Positive, Table, read_tables
from trueloop.nc.program.dialect import DIALECTS
from trueloop.wording import did_you_mean

HINT: Final = "docs/links.md shows every table and key"

INCREMENTS: Final = (0.01, 0.001, 0.0001, 0.00001)


def _dialect(name: str) -> str:
    if name and name not in DIALECTS:
        raise ValueError(f"no NC dialect; choose one of: {', '.join(DIALECTS)}")
    return name


def _increment(step: float) -> float:
    if step not in INCREMENTS:
        raise ValueError(f"no increment of a control; choose one of: {', '.join(map(str, INCREMENTS))}")
    return step


class LinkTable(Table):
    """Keys of every link."""

    passes: tuple[Literal["capitals", "blanks", "line ends"], ...] = ()
    """Changes that this control makes in a program that it stores; any other difference refuses the transfer."""
    replaced: str = "replaced"
    """The folder into which what is replaced at the control is written first."""
    dialect: Annotated[str, AfterValidator(_dialect)] = ""
    """Dialect of the control's programs, one of [dialects.md](dialects.md); else found from them."""
    tool_table: str = ""
    """The name of the control's tool table among its programs; while any program runs it is not written."""
    table_unit: Literal["mm", "inch"] | None = None
    """The unit of a tool table that does not say its own."""


class FolderTable(LinkTable):
    """A control whose programs are files in a folder. Relative names count from the folder of this file."""

    folder: Annotated[str, Field(min_length=1)]
    """Where the control's programs are."""
    running_file: str = ""
    """A file in whose first line the control writes which program runs, empty while none does."""


class LinuxCncTable(LinkTable):
    """A LinuxCNC of this computer. Relative names count from the folder of this file."""

    ini: Annotated[str, Field(min_length=1)]
    """Its configuration."""
    folder: Annotated[str, Field(min_length=1)]
    """The folder that it loads programs from."""


class FtpTable(LinkTable):
    """A control that is an FTP server."""

    host: Annotated[str, Field(min_length=1)]
    """The control's address."""
    port: Annotated[int, Field(ge=1, le=65535, strict=True)] = 21
    """Its port."""
    user: str = "anonymous"
    """Who signs in."""
    password_env: str = ""
    """The environment variable that holds the password."""
    folder: str = ""
    """Where on the server the programs are."""
    tls: Annotated[bool, Field(strict=True)] = False
    """FTP over TLS."""
    authority: str = ""
    """A file with the certificate (PEM) by which the server's is judged: a control often has one of its own making."""
    timeout_s: Positive = 10.0
    """How long to wait for an answer."""


class FocasTable(LinkTable):
    """A Fanuc control by Fanuc's own FOCAS library. Relative names count from the folder of this file."""

    host: Annotated[str, Field(min_length=1)]
    """The control's address."""
    library: Annotated[str, Field(min_length=1)]
    """Your file of the FOCAS library: libfwlib32.so, Fwlib32.dll, Fwlib64.dll."""
    aside: Annotated[int, Field(ge=1, le=9999, strict=True)]
    """An O number that is used for transfers alone: what has it is deleted."""
    port: Annotated[int, Field(ge=1, le=65535, strict=True)] = 8193
    """Its port."""
    timeout_s: Positive = 10.0
    """How long to wait for an answer."""
    increment: Annotated[float, AfterValidator(_increment)] | None = None
    """The control's increment of offsets, in `table_unit`; offsets are neither read nor written without it."""
    tool_table: Literal["OFFSETS"] = "OFFSETS"
    """The name of its offsets among its programs."""


class SerialTable(LinkTable):
    """A control at a serial line. The settings are those of the control's own page for its port."""

    port: Annotated[str, Field(min_length=1)]
    """/dev/ttyUSB0, COM3."""
    baud: Literal[300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200] = 9600
    """Bits per second."""
    data_bits: Literal[7, 8] = 7
    """Bits of a character."""
    parity: Literal["none", "even", "odd"] = "even"
    """Of a character."""
    stop_bits: Literal[1, 2] = 2
    """After a character."""
    flow: Literal["xon-xoff", "rts-cts", "none"] = "xon-xoff"
    """How the control holds the line: by characters, by wires, not at all."""
    code: Literal["ascii", "iso", "eia"] = "ascii"
    """iso (even) and eia (odd) have a parity of their own: `data_bits` and `parity` are then not looked at."""
    line_end: Literal["lf", "cr-lf", "lf-cr-cr"] = "cr-lf"
    """The end of a line on the wire."""
    after_xoff: Annotated[int, Field(ge=1, le=4096, strict=True)] = 10
    """Characters that the control still takes after it said XOFF."""
    silence_s: Positive = 60.0
    """How long the control may hold the line or say nothing."""
    await_xon: Annotated[bool, Field(strict=True)] = True
    """With xon-xoff: sending starts when the control sends XON."""


AnyLink: TypeAlias = FolderTable | LinuxCncTable | FtpTable | FocasTable | SerialTable


class LinksFile(Table):
    """The controls by name, each name once."""

    folder: dict[str, FolderTable] = Field(default_factory=dict)
    linuxcnc: dict[str, LinuxCncTable] = Field(default_factory=dict)
    ftp: dict[str, FtpTable] = Field(default_factory=dict)
    focas: dict[str, FocasTable] = Field(default_factory=dict)
    serial: dict[str, SerialTable] = Field(default_factory=dict)

    @property
    def by_kind(self) -> Mapping[str, Mapping[str, AnyLink]]:
        """Those of each kind, by name."""
        kinds: tuple[Mapping[str, AnyLink], ...] = (self.folder, self.linuxcnc, self.ftp, self.focas, self.serial)
        return dict(zip(("folder", "linuxcnc", "ftp", "focas", "serial"), kinds, strict=True))


def read_links(path: Path) -> LinksFile:
    """The settings of all controls. Raises LNK-FILE, with the line, for a key that is wrong."""
    return read_tables(path, LinksFile, Code.LNK_FILE, hint=HINT)


def read_link(path: Path, name: str) -> AnyLink:
    """The settings of one control. Raises LNK-FILE, with the line, for a key that is wrong, and for an unknown name."""
    tables = read_links(path).by_kind.values()
    found = [table[name] for table in tables if name in table]
    if len(found) == 1:
        return found[0]
    names = sorted({name for table in tables for name in table})
    raise Code.LNK_FILE.refusal(
        f"{len(found) or 'none'} of the links is called {name!r}: {', '.join(names) or 'there are no links'}",
        hint=(not found and did_you_mean(name, names)) or "name one of them, each by a name of its own",
        place=Place(str(path)),
    )
