"""Headless Chromium: what a browser makes of a page that trueloop wrote. No network is used."""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

INSTALL = "apt-get install -y --no-install-recommends chromium"
TIMEOUT_S = 120
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND",  # a page that asks for anything from outside fails to get it
    "--hide-scrollbars",
    "--force-device-scale-factor=1",
    "--virtual-time-budget=10000",  # scripts and their timers have run before the page is looked at
)
CONSOLE_LINE = re.compile(r':CONSOLE[:(]\d+\)?\] "(?P<message>.*?)", source: ', re.DOTALL)


class ChromiumMissingError(Exception):
    """The Debian package is not installed: the tests that need a browser fail and say how to get it."""


def dump_dom(page: Path) -> str:
    """The page's HTML after its scripts have run."""
    return _run(page, "--dump-dom").stdout


def screenshot(page: Path, png: Path, width: int = 1280, height: int = 900) -> None:
    """Write what a window of that size in CSS pixels shows to `png`."""
    _run(page, f"--screenshot={png.resolve()}", f"--window-size={width},{height}")


def console_errors(page: Path) -> list[str]:
    """Every message of the page's console: a page of ours says nothing when all is well.

    A picture or script that failed to load is not among them: look for outside addresses in the page's text.
    """
    log = _run(page, "--dump-dom", "--enable-logging=stderr", "--v=0").stderr
    return [found["message"] for found in CONSOLE_LINE.finditer(log)]


def _run(page: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    program = shutil.which("chromium")
    if program is None:
        raise ChromiumMissingError(f"Chromium is not installed; run as root:  {INSTALL}")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        return subprocess.run(
            [program, *FLAGS, f"--user-data-dir={folder}", *arguments, page.resolve(strict=True).as_uri()],
            env=os.environ | {"HOME": folder},
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
            check=True,
        )
