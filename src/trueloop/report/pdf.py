"""A page as PDF, printed by the browser that is there: Chromium, Chrome or Edge."""

import os
import shutil
import signal
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Final

from trueloop.errors import Code, TrueloopError

VARIABLE: Final = "TRUELOOP_BROWSER"
"""Names the browser, by its path or as it is called on the path."""
NAMES: Final = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge",
    "microsoft-edge-stable", "msedge",
)  # fmt: skip
PLACES: Final = (
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
)
"""Where macOS and Windows keep them, off the path."""
INSTALL: Final = "apt-get install chromium"
TIMEOUT_S: Final = 90
FLAGS: Final = (
    "--headless",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND",  # a page of trueloop asks for nothing from outside
    "--no-pdf-header-footer",
)


def find_browser() -> str:
    """Returns the browser's program. Raises OUT-BROWSER where there is none, or none of the environment's name."""
    named = os.environ.get(VARIABLE)
    found = next(filter(None, map(shutil.which, [named] if named else [*NAMES, *PLACES])), None)
    if found is None:
        why = f"{VARIABLE} names {named!r}, which is no program" if named else "no Chromium, Chrome or Edge is found"
        raise Code.OUT_BROWSER.refusal(
            f"a PDF is printed by a browser: {why}",
            hint=f"install one ({INSTALL}), or name it: {VARIABLE}=/path/to/chrome",
            values={"browser": named or ""},
        )
    return found


def as_pdf(page: str) -> bytes:
    """Prints a page of HTML as PDF on A4, by a browser with its own profile. Raises OUT-BROWSER and OUT-PDF."""
    browser = find_browser()
    with tempfile.TemporaryDirectory(prefix="trueloop-", ignore_cleanup_errors=True) as folder:
        source, printed = Path(folder, "page.html"), Path(folder, "page.pdf")
        source.write_text(page, encoding="utf-8")
        profile = f"--user-data-dir={Path(folder, 'profile')}"
        # The sandbox of Chromium does not start for root, whose programs it would shut in.
        sandbox = ["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []
        said = _run([browser, *FLAGS, *sandbox, profile, f"--print-to-pdf={printed}", source.as_uri()], folder)
        pdf = printed.read_bytes() if printed.exists() else b""
    if not pdf.startswith(b"%PDF-") or b"%%EOF" not in pdf[-64:]:
        raise _refusal(browser, f"wrote no whole PDF: {_last_line(said)}")
    return pdf


def _run(command: list[str], home: str) -> str:
    """Runs the browser and returns its output; ends it, with its helpers, if it takes too long."""
    browser = command[0]
    environment = os.environ | {"HOME": home}
    try:
        process = subprocess.Popen(
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
    except OSError as error:
        raise _refusal(browser, f"cannot be started: {error.strerror or error}") from error
    try:
        return process.communicate(timeout=TIMEOUT_S)[1].decode(errors="replace")
    except subprocess.TimeoutExpired as late:
        raise _refusal(browser, f"did not finish within {TIMEOUT_S} s") from late
    finally:
        _end(process)


def _end(process: "subprocess.Popen[bytes]") -> None:
    """The process with its helpers, where it is still there: after a timeout or Ctrl-C."""
    if process.poll() is None:
        with suppress(OSError):
            os.killpg(process.pid, signal.SIGKILL) if hasattr(os, "killpg") else process.kill()
        process.wait()


def _last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return repr(lines[-1][-200:]) if lines else "it said nothing"


def _refusal(browser: str, why: str) -> TrueloopError:
    return Code.OUT_PDF.refusal(
        f"the browser {browser!r} {why}; nothing was written",
        hint=f"name another one: {VARIABLE}=/path/to/chrome; or leave --pdf out and print report.html from a browser",
        values={"browser": browser},
    )
