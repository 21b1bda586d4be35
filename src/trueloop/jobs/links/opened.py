"""A link by its name in a file of settings."""

from dataclasses import dataclass
from pathlib import Path

from trueloop.controllers.links.compare import Change
from trueloop.controllers.links.folder import Folder
from trueloop.controllers.links.ftp import Ftp
from trueloop.controllers.links.link import Link
from trueloop.formats.links_toml import FolderTable, FtpTable, read_link


@dataclass(frozen=True)
class Opened:
    """A link, what its control may change in a program, and where what is replaced there is written."""

    name: str
    link: Link
    passes: frozenset[Change]
    replaced: Path


def opened(settings: Path, name: str) -> Opened:
    """The link. Connects to nothing yet. Raises LNK-FILE."""
    table = read_link(settings, name)
    passes = frozenset(Change(one) for one in table.passes)
    return Opened(name, _link(table, settings.parent), passes, settings.parent / table.replaced)


def _link(table: FolderTable | FtpTable, beside: Path) -> Link:
    if isinstance(table, FolderTable):
        return Folder(beside / table.folder, beside / table.running_file if table.running_file else None)
    return Ftp(table.host, table.port, table.user, table.password_env, table.folder, table.tls, table.timeout_s)
