"""How a service is set up: `Settings`; every number that bounds it stands here."""

import json
import sys
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.util import find_spec
from ipaddress import ip_address
from pathlib import Path
from threading import Lock
from typing import Final

from trueloop.errors import Code
from trueloop.extras import install_command

LOOPBACK_NAMES: Final = ("localhost", "127.0.0.1", "[::1]")


def now() -> datetime:
    """Returns the time: whatever reads the clock is given this, so that tests can set it."""
    return datetime.now(UTC)


def is_loopback(host: str) -> bool:
    """Returns whether only this machine can reach what listens there."""
    if host == "localhost":
        return True
    try:
        return ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


@dataclass(frozen=True)
class Limits:
    """Bounds on what one request or client may cost."""

    body_bytes: int = 1 << 20
    upload_bytes: int = 64 << 20
    touches_bytes: int = 16 << 20
    streams: int = 64  # open at once, over all clients
    body_s: float = 120.0  # for a whole body to come in
    read_s: float = 30.0  # for a file that was handed over to be read
    read_bytes: int = 2 << 30  # of memory, for the same


@dataclass(frozen=True)
class Settings:
    """How a service is set up.

    `names`: host names by which it may be asked, besides those of this machine for itself. `tls`: whether browsers
    reach it over TLS, which it or a proxy before it answers; without, only this machine reaches it. `pages`: the folder
    of the built pages; `links`: the file with the settings of links to controls.
    """

    tls: bool = False
    names: tuple[str, ...] = LOOPBACK_NAMES
    pages: Path | None = None
    links: Path | None = None
    limits: Limits = Limits()
    idle_s: float = 3600.0
    session_s: float = 12 * 3600.0
    poll_s: float = 0.5  # how often streams look for news
    heartbeat_s: float = 15.0
    silent_s: float = 60.0  # a machine that cuts and is not heard for so long: its part is held
    workers: int = 1  # threads for slow tasks; 0: another process does them

    @property
    def cookie(self) -> str:
        """Its name: over TLS the browser itself ties `__Host-` to this host and to TLS."""
        return "__Host-session" if self.tls else "session"

    @property
    def scheme(self) -> str:
        """Returns the scheme of its own addresses."""
        return "https" if self.tls else "http"


_ONE: Final = Lock()


def log(what: str, **values: object) -> None:
    """Writes one line. JSON escapes what would end it: nobody writes a line of his own into it."""
    line = json.dumps({"at": datetime.now(UTC).isoformat(timespec="milliseconds"), "what": what, **values}, default=str)
    with _ONE:
        sys.stderr.write(line + "\n")
        sys.stderr.flush()


NEEDED: Final = {
    "argon2": "argon2-cffi",
    "fastapi": "fastapi",
    "joserfc": "joserfc",
    "uvicorn": "uvicorn",
    "zxcvbn": "zxcvbn",
}
"""The imported module, by the name of its package."""


def require_packages() -> None:
    """Raises SRV-PACKAGE for one that is not installed."""
    for module, package in NEEDED.items():
        if find_spec(module) is None:
            raise Code.SRV_PACKAGE.refusal(
                f"the service needs the package {package!r}",
                hint=f"install it: {install_command('service')}",
                values={"package": package},
            )
