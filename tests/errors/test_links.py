"""Every way in which a link to a control refuses."""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from trueloop.controllers.links.focas import Focas
from trueloop.controllers.links.folder import Folder, checked_name, named_in
from trueloop.controllers.links.line import Line, encoded
from trueloop.errors import Code
from trueloop.formats.links_toml import read_link
from trueloop.jobs.links import Opened, send


@contextmanager
def _control(kind: type[Folder] = Folder, running: str = "\n") -> Iterator[Opened]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "control"
        folder.mkdir()
        (folder / "O1.nc").write_bytes(b"M30\n")
        (Path(name) / "running.txt").write_text(running)
        yield Opened("lathe", kind(folder, named_in(Path(name) / "running.txt")), frozenset(), Path(name) / "replaced")


class _Changing(Folder):
    def write_aside(self, name: str, content: bytes) -> str:
        return super().write_aside(name, content.upper())


class _Edited(Folder):
    def write_aside(self, name: str, content: bytes) -> str:
        (self.folder / name).write_bytes(b"M2\n")
        return super().write_aside(name, content)


def _settings() -> None:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "links.toml"
        path.write_text('[folder.lathe]\nfolder = "nc"\npases = []\n')
        read_link(path, "lathe")


def _not_there() -> None:
    Folder(Path("no-such-folder")).listed()


def _another() -> None:
    with _control() as control:
        send(control, b"M0\n", "O1.nc")


def _running() -> None:
    with _control(running="O1.nc\n") as control:
        send(control, b"M0\n", "O1.nc", replace=True)


def _edited() -> None:
    with _control(_Edited) as control:
        send(control, b"M0\n", "O1.nc", replace=True)


def _differing() -> None:
    with _control(_Changing) as control:
        send(control, b"m0\n", "O2.nc")


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.LNK_FILE: _settings,
    Code.LNK_REACH: _not_there,
    Code.LNK_NAME: lambda: checked_name("../O1.nc"),
    Code.LNK_EXISTS: _another,
    Code.LNK_RUNNING: _running,
    Code.LNK_CHANGED: _edited,
    Code.LNK_DIFFERS: _differing,
    Code.LNK_LIBRARY: Focas("127.0.0.1", Path("no-such-library.so"), 9001).listed,
    Code.LNK_LINE: lambda: Line("/dev/no-such-line", tell=lambda _: None).read("O1"),
    Code.LNK_CODE: lambda: encoded(b"G1\nX#1", "eia"),
}
