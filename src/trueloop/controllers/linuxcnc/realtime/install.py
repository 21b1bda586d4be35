"""Compiles the component around the object file that comes with trueloop, and installs it for LinuxCNC."""

import os
import re
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Final

from trueloop import _core
from trueloop.errors import Code, Place
from trueloop.formats.outputs import write_all

OBJECT: Final = "trueloop_rtec.o"


def sources() -> dict[str, bytes]:
    """Returns all that is compiled, by file name."""
    return {
        "rtec.comp": source("realtime/rtec.comp").encode(),
        "rtec.h": _core.realtime_header().encode(),
        OBJECT: _core.realtime_library(),
    }


@cache
def component() -> bytes:
    """Compiles rtec.so. Raises RTC-BUILD with the compiler's words, CTL-LINUXCNC where LinuxCNC is missing."""
    return compiled("rtec", sources(), f"-Wl,--gc-sections {{folder}}/{OBJECT}", Code.RTC_BUILD)


MODULE: Final = "rtec.so"
OF_LINUXCNC: Final = "hal_lib.so"
SUPPORTED: Final = ((2, 9),)
FORBIDDEN: Final = re.compile(r"panic|unwind|__rust_(?:alloc|realloc|dealloc)|__rdl_|__rg_")
"""Symbols that must not be there: what panics ends the process of the machine, what allocates has no bound in time."""


@dataclass(frozen=True)
class Installed:
    """Where the module is, or shall go, and the command that is left to do for it."""

    version: str
    module: Path
    sources: Path | None
    command: str | None


def install(to: Path | None = None, keep_sources: Path | None = None) -> Installed:
    """Compiles the component, checks it, and puts it into LinuxCNC's folder of modules, or `to`.

    A folder that this user may not write to stays as it is: the module is left in the current folder, with the command
    that root has to run. Raises CTL-LINUXCNC without LinuxCNC, RTC-BUILD for a version it is not made for, for what the
    compiler refuses, and for a module that holds what may not run in a servo thread.
    """
    require_linuxcnc()
    version = linuxcnc_version()
    check_version(version)
    built = component()
    folder = to or modules_folder()
    if not folder.is_dir():
        raise Code.RTC_BUILD.refusal(
            f"the folder {str(folder)!r} does not exist", hint="name LinuxCNC's folder of modules with --to"
        )
    check_symbols(built)
    if keep_sources is not None:
        write_all(keep_sources, sources().items())
    if os.access(folder, os.W_OK):
        write_all(folder, [(MODULE, built)])
        return Installed(version, folder / MODULE, keep_sources, None)
    write_all(".", [(MODULE, built)])
    command = f"sudo install -m 644 {MODULE} {shlex.quote(str(folder / MODULE))}"
    return Installed(version, folder / MODULE, keep_sources, command)


def linuxcnc_version() -> str:
    """Returns the version that LinuxCNC reports. Raises RTC-BUILD where it is not the one of user space."""
    done = subprocess.run(["linuxcnc_var", "all"], capture_output=True, text=True, check=False)
    told = dict(line.partition("=")[::2] for line in done.stdout.splitlines())
    if told.get("RTS", "uspace") != "uspace":
        raise Code.RTC_BUILD.refusal(
            f"this LinuxCNC runs its real-time modules in the kernel ({told['RTS']}), where no file can be read",
            hint="install linuxcnc-uspace",
        )
    return told.get("LINUXCNCVERSION") or "of no version that linuxcnc_var knows"


def modules_folder() -> Path:
    """Returns LinuxCNC's folder of modules, from halcompile's own makefile. Raises RTC-BUILD where that has none."""
    makefile = subprocess.run(["halcompile", "--print-modinc"], capture_output=True, text=True, check=False)
    for name in makefile.stdout.split():
        named = re.findall(r"^\s*RTLIBDIR\s*:?=\s*(\S+)", Path(name).read_text(errors="replace"), re.MULTILINE)
        for folder in map(Path, named):
            if (folder / OF_LINUXCNC).exists():
                return folder
    raise Code.RTC_BUILD.refusal(
        f"halcompile does not say where modules go: {(makefile.stderr or makefile.stdout).strip()!r}",
        hint="name LinuxCNC's folder of modules with --to",
    )


def check_version(version: str) -> None:
    """Raises RTC-BUILD for a version that the component is not written for."""
    numbers = tuple(int(digits) for digits in re.findall(r"\d+", version)[:2])
    if numbers not in SUPPORTED:
        made_for = " and ".join(".".join(map(str, known)) for known in SUPPORTED)
        raise Code.RTC_BUILD.refusal(
            f"this is LinuxCNC {version}; the component is made for {made_for}",
            hint="docs/realtime-component.md says what differs between versions",
        )


def check_symbols(module: bytes) -> None:
    """Raises RTC-BUILD for a module in which something may panic, or allocate by itself."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, MODULE).write_bytes(module)
        done = subprocess.run(["nm", "-C", MODULE], cwd=folder, capture_output=True, text=True, check=False)
    found = sorted({line.split()[-1] for line in done.stdout.splitlines() if FORBIDDEN.search(line)})
    if done.returncode != 0 or found:
        raise Code.RTC_BUILD.refusal(
            f"the module holds what may not run in a servo thread: {', '.join(found) or done.stderr.strip()}",
            hint="report this: the object file that comes with trueloop is at fault",
            place=Place(MODULE),
        )


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
