"""Components built for LinuxCNC's hardware layer."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place

INSTALL: Final = "apt-get install -y --no-install-recommends linuxcnc-uspace linuxcnc-uspace-dev"
NEEDED: Final = ("linuxcnc", "halsampler", "halcompile", "unshare", "/usr/bin/python3")


def require_linuxcnc() -> None:
    """Raises CTL-LINUXCNC with the line to run when a program is missing."""
    missing = [name for name in NEEDED if shutil.which(name) is None]
    if missing:
        raise Code.CTL_LINUXCNC.refusal(
            f"{len(missing)} programs of LinuxCNC are missing: {', '.join(missing)}",
            hint=f"on Debian 12 run as root:  {INSTALL}",
        )


def source(name: str) -> str:
    """Returns the text of a file that comes with this package."""
    return (resources.files("trueloop.controllers.linuxcnc") / name).read_text()


def compiled(name: str, files: Mapping[str, bytes], link: str = "", code: Code = Code.CTL_LINUXCNC) -> bytes:
    """Compiles NAME.comp and what lies beside it to NAME.so, by halcompile.

    `link`: flags of the linker, in which `{folder}` is where the files lie. Raises CTL-LINUXCNC where LinuxCNC is
    missing, `code` with the compiler's words where it fails.
    """
    require_linuxcnc()
    with tempfile.TemporaryDirectory() as folder:
        for file, content in files.items():
            Path(folder, file).write_bytes(content)
        done = subprocess.run(
            ["halcompile", "--compile", f"{name}.comp"],
            cwd=folder,
            env=os.environ | {"LDFLAGS": link.format(folder=folder)},
            capture_output=True,
            text=True,
            check=False,
        )
        built = Path(folder, f"{name}.so")
        if done.returncode != 0 or not built.exists():
            raise code.refusal(
                f"halcompile ended with status {done.returncode}: {(done.stderr or done.stdout).strip()!r}",
                hint=f"on Debian 12 run as root:  {INSTALL} gcc libc6-dev",
                place=Place(f"{name}.comp"),
            )
        return built.read_bytes()
