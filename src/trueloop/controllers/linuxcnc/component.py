"""The virtual part, built for LinuxCNC's hardware layer."""

import shutil
import subprocess
import tempfile
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place, TrueloopError

INSTALL: Final = "apt-get install -y --no-install-recommends linuxcnc-uspace linuxcnc-uspace-dev"
NEEDED: Final = ("linuxcnc", "halsampler", "halcompile", "unshare", "/usr/bin/python3")


def require_linuxcnc() -> None:
    """Raises CTL-LINUXCNC with the line to run when a program is missing."""
    missing = [name for name in NEEDED if shutil.which(name) is None]
    if missing:
        raise TrueloopError(
            Code.CTL_LINUXCNC,
            f"{len(missing)} programs of LinuxCNC are missing: {', '.join(missing)}",
            hint=f"on Debian 12 run as root:  {INSTALL}",
        )


def source(name: str) -> str:
    """A file that comes with this package."""
    return (resources.files("trueloop.controllers.linuxcnc") / name).read_text()


@cache
def virtual_part() -> bytes:
    """The component as a shared object, compiled once a run. Raises CTL-LINUXCNC with the compiler's words."""
    require_linuxcnc()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "virtual_part.comp").write_text(source("virtual_part.comp"))
        done = subprocess.run(
            ["halcompile", "--compile", "virtual_part.comp"], cwd=folder, capture_output=True, text=True, check=False
        )
        built = Path(folder, "virtual_part.so")
        if done.returncode != 0 or not built.exists():
            raise TrueloopError(
                Code.CTL_LINUXCNC,
                f"halcompile ended with status {done.returncode}: {(done.stderr or done.stdout).strip()!r}",
                hint=f"on Debian 12 run as root:  {INSTALL} gcc libc6-dev",
                place=Place("virtual_part.comp"),
            )
        return built.read_bytes()
