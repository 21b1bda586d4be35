"""A PostgreSQL server of the tests' own: a folder in /tmp, a socket in it and no port, ended with the tests.

PostgreSQL refuses to run as root: then it runs as Debian's user `postgres`.
"""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

INSTALL = "apt-get install -y --no-install-recommends postgresql"
PROGRAMS = Path("/usr/lib/postgresql")
LONGEST_S = 120


class PostgresqlMissingError(Exception):
    """The Debian package is not installed: the tests that need the server fail and say how to get it."""


@dataclass(frozen=True)
class Server:
    """A running server, by the folder of its socket."""

    folder: Path

    def new_database(self, like: str = "template1") -> str:
        """The URL of an empty database, or of a copy of another that nobody is connected to."""
        name = f"t{uuid4().hex}"
        run(self.folder, "createdb", "-h", self.folder, "-U", "postgres", "-T", like, name)
        return f"postgresql://postgres@/{name}?host={self.folder}"

    def start(self) -> None:
        """Starts it, and returns when it takes connections."""
        options = f"-k {self.folder} -c listen_addresses='' -c fsync=off"
        log = ("-l", self.folder / "log")
        run(self.folder, "pg_ctl", "start", "-D", self.folder / "data", "-w", "-t", "60", *log, "-o", options)

    def stop(self) -> None:
        """Stops it at once, as a crash does."""
        run(self.folder, "pg_ctl", "stop", "-D", self.folder / "data", "-m", "immediate", "-w", "-t", "60")


@contextmanager
def running() -> Iterator[Server]:
    """A server while the block runs. Its data are not worth a write to the disk: fsync is off."""
    folder = Path(tempfile.mkdtemp(prefix="trueloop-pg-", dir="/tmp"))
    try:
        folder.chmod(0o755)
        if os.geteuid() == 0:
            shutil.chown(folder, "postgres", "postgres")
        data = folder / "data"
        run(folder, "initdb", "-D", data, "-U", "postgres", "-A", "trust", "-E", "UTF8", "--no-sync", "--locale=C")
        server = Server(folder)
        server.start()
        try:
            yield server
        finally:
            server.stop()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def run(folder: Path, program: str, *arguments: str | Path) -> None:
    """One of PostgreSQL's programs, of the newest version that is installed."""
    found = sorted(PROGRAMS.glob("*/bin"), key=lambda path: float(path.parent.name))
    if not found:
        raise PostgresqlMissingError(f"PostgreSQL is not installed; run as root:  {INSTALL}")
    if os.geteuid() == 0:
        command = ["setpriv", "--reuid=postgres", "--regid=postgres", "--init-groups", str(found[-1] / program)]
    else:
        command = [str(found[-1] / program)]
    done = subprocess.run(
        [*command, *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        cwd=folder,
        timeout=LONGEST_S,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{program} ended with {done.returncode}: {done.stderr.decode(errors='replace')}")
