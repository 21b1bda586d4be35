"""Every way in which the cell refuses."""

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

from trueloop.controllers.linuxcnc.cell.client import Offered, Service, require_own
from trueloop.controllers.linuxcnc.cell.journal import Entry, read
from trueloop.errors import Code
from trueloop.formats.cell_toml import read_cell
from trueloop.nc.witness import witnessed


def _journal() -> object:
    lines = [Entry(k, "fact", {}).line() for k in (1, 2, 3)]
    with TemporaryDirectory() as folder:
        return read(lines[0] + lines[2] + lines[1], Path(folder, "cell.journal"))


def _other_machine() -> None:
    text = witnessed(b"M2\n", "O1.1.0.1")
    require_own(Offered("O1.1.0.1", "mill", "finish", sha256(text).hexdigest(), text, True), "lathe")


def _no_settings() -> object:
    with TemporaryDirectory() as folder:
        file = Path(folder, "cell.toml")
        file.write_text('[cell]\nmachine = "lathe"\nservice = "factory.shop.example"\n[linuxcnc]\nini = "lathe.ini"\n')
        return read_cell(file)


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.CEL_FILE: _no_settings,
    Code.CEL_WITNESS: lambda: witnessed(b"G1 X1\nG0 X9 M30\n", "O1.1.0.1"),
    Code.CEL_JOURNAL: _journal,
    Code.CEL_SERVICE: lambda: Service("http://127.0.0.1:1", "key").next(),
    Code.CEL_OFFER: _other_machine,
}
