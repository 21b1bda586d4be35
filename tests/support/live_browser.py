"""A headless Chromium that stays with a page that changes: what its scripts see at one moment, and how it looks.

Spoken over DevTools' own pipe: messages of JSON, each ended by a zero byte, on file descriptors 3 and 4.
"""

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.support.chromium import FLAGS, INSTALL, ChromiumMissingError

WAIT_S = 60.0
NOT_FOR_LIVE = ("--virtual-time-budget", "--host-resolver-rules")
ONLY_THIS_COMPUTER = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"


class LivePage:
    """One page that is open."""

    def __init__(self, to: int, back: int) -> None:
        self._to, self._back, self._rest, self._number = to, back, b"", 0
        self._session: str | None = None
        self.said: list[str] = []

    def open(self, address: str, width: int, height: int) -> None:
        """Shows it."""
        target = self._ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self._ask("Runtime.enable")
        self._ask("Page.enable")
        screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self._ask("Emulation.setDeviceMetricsOverride", **screen)
        self._ask("Page.navigate", url=address)

    def evaluate(self, expression: str) -> Any:
        """What a script gets, as JSON has it."""
        answer = self._ask("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def until(self, expression: str) -> None:
        """Waits until that is true."""
        end = time.monotonic() + WAIT_S
        while not self.evaluate(expression):
            assert time.monotonic() < end, f"never true within {WAIT_S} s: {expression}"
            time.sleep(0.05)

    def screenshot(self, png: Path) -> None:
        """All of the page."""
        picture = self._ask("Page.captureScreenshot", format="png", captureBeyondViewport=True)
        png.write_bytes(base64.b64decode(picture["data"]))

    def _ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._message()
            if answer.get("method") in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown"):
                self.said.append(json.dumps(answer["params"]))
            if answer.get("id") == self._number:
                assert "error" not in answer, answer["error"]
                result: dict[str, Any] = answer["result"]
                return result

    def _message(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            came = os.read(self._back, 1 << 20)
            assert came, "the browser has ended"
            self._rest += came
        one, _, self._rest = self._rest.partition(b"\0")
        message: dict[str, Any] = json.loads(one)
        return message


@contextmanager
def live_page(address: str, width: int = 1100, height: int = 1500) -> Iterator[LivePage]:
    """A page of this computer in a browser of its own."""
    program = shutil.which("chromium")
    if program is None:
        raise ChromiumMissingError(f"Chromium is not installed; run as root:  {INSTALL}")
    flags = [flag for flag in FLAGS if not flag.startswith(NOT_FOR_LIVE)] + [ONLY_THIS_COMPUTER]
    to_browser, ours_to = os.pipe()
    ours_back, from_browser = os.pipe()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        # the shell gives the pipes the numbers that the browser wants
        command = f'exec 3<&{to_browser} 4>&{from_browser}; exec "$@"'
        process = subprocess.Popen(
            ["bash", "-c", command, "-", program, *flags, "--remote-debugging-pipe", f"--user-data-dir={folder}"],
            env=os.environ | {"HOME": folder},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=(to_browser, from_browser),
        )
        os.close(to_browser)
        os.close(from_browser)
        try:
            page = LivePage(ours_to, ours_back)
            page.open(address, width, height)
            yield page
        finally:
            process.terminate()
            process.wait(WAIT_S)
            os.close(ours_to)
            os.close(ours_back)
