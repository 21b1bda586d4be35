"""The adapter as a process, told what LinuxCNC says by a stand-in for its Python, heard by an agent written apart."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.support.shdr import connected, fields, model
from tests.support.signals import until
from trueloop.controllers.mtconnect.items import escaped

TRUELOOP = str(Path(sys.executable).with_name("trueloop"))
OPTIONS = (
    *("--device", "lathe", "--temperature", "spindle=rtec-signals.signal-0", "--temperature", "oil=oil.temp"),
    *("--correction", "X=rtec.corr-0", "--part-count", "parts.count"),
)
STATUS: dict[str, Any] = {
    "positions": [280.00004, 0.0, -12.5, *[0.0] * 6],
    "estop": False,
    "on": True,
    "mode": "AUTO",
    "interpreter": "RUNNING",
    "paused": False,
    "program": "/nc/part.ngc",
    "line": 7,
    "velocity_mm_s": 50.0,
    "spindle_rpm": -1200.0,
    "joint_faults": [],
    "joints_at_limit": [],
}
PINS: dict[str, float | None] = {
    "rtec-signals.signal-0": 23.4567,
    "rtec-signals.age-0": 1.0,
    "rtec-signals.heartbeat": 1.0,
    "oil.temp": 40.0,
    "rtec.corr-0": -0.0123456,
    "parts.count": 12.0,
}
STAND_IN = """#!/usr/bin/env python3
import pathlib, sys, time
said = pathlib.Path({said!r})
while True:
    print(said.read_text(), flush=True) if said.exists() else None
    time.sleep(0.02)
"""


@dataclass
class Beside:
    """An adapter, and what its LinuxCNC says."""

    folder: Path
    port: int
    process: "subprocess.Popen[bytes]"
    devices: bytes

    def says(self, status: object = None, pins: object = None) -> None:
        text = json.dumps({"status": STATUS if status is None else status, "pins": pins or PINS})
        (self.folder / "next").write_text(text)
        (self.folder / "next").replace(self.folder / "said")

    def is_silent(self) -> None:
        (self.folder / "said").unlink()

    def told(self) -> str:
        return (self.folder / "stderr").read_text()


@contextmanager
def beside(folder: Path, *more: str) -> Iterator[Beside]:
    python = folder / "python"
    python.write_text(STAND_IN.format(said=str(folder / "said")))
    python.chmod(0o755)
    devices = subprocess.run([TRUELOOP, "mtconnect", "devices", *OPTIONS], capture_output=True, check=True).stdout
    command = [TRUELOOP, "mtconnect", "serve", *OPTIONS, "--port", "0", "--python", str(python), *more]
    with (folder / "stderr").open("wb") as stderr:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=stderr)
    try:
        until(lambda: b":" in (folder / "stderr").read_bytes())
        port = int(re.findall(rb"127\.0\.0\.1:(\d+)", (folder / "stderr").read_bytes())[0])
        yield Beside(folder, port, process, devices)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 0
        assert "Traceback" not in (folder / "stderr").read_text()
    finally:
        process.kill()
        process.wait()


def test_all_keys_are_those_of_the_model_and_nothing_is_known_at_first(tmp_path: Path) -> None:
    with beside(tmp_path) as adapter, connected(adapter.port, adapter.devices) as agent:
        agent.ping()
        assert agent.latest() == dict.fromkeys(model(adapter.devices), "UNAVAILABLE")
        assert agent.pongs == [10_000]


def test_what_linuxcnc_says_in_the_units_of_the_model(tmp_path: Path) -> None:
    (tmp_path / "part").write_text("1411-A2-P1.560\n")
    with beside(tmp_path, "--part-file", str(tmp_path / "part")) as adapter:
        adapter.says()
        with connected(adapter.port, adapter.devices) as agent:
            agent.wait_for("avail", "AVAILABLE")
            assert agent.latest() == {
                "avail": "AVAILABLE",
                "temp_spindle": "23.457",
                "temp_oil": "40.000",
                "Xpos": "280.0000",
                "Xcorr": "-0.012346",
                "Zpos": "-12.5000",
                "S1speed": "-1200.00",
                "estop": "ARMED",
                "system": "NORMAL",
                "execution": "ACTIVE",
                "mode": "AUTOMATIC",
                "program": "part.ngc",
                "line": "7",
                "part_count": "12",
                "part_id": "1411-A2-P1.560",
                "feed": "50.000",
            }
            adapter.says(STATUS | {"paused": True})
            agent.wait_for("execution", "INTERRUPTED")
            adapter.says(STATUS | {"interpreter": "IDLE", "mode": "MDI"})
            agent.wait_for("execution", "READY")
            assert agent.latest()["mode"] == "MANUAL_DATA_INPUT"
            adapter.says(STATUS | {"on": False, "estop": True})
            agent.wait_for("system", "FAULT ESTOP emergency stop")
            assert (agent.latest()["execution"], agent.latest()["estop"]) == ("STOPPED", "TRIGGERED")
            adapter.says(STATUS | {"joint_faults": [1]})
            agent.wait_for("system", "FAULT JOINT_FAULTS joint 1: following error or drive fault")
            faults = [value.split()[0] for _, key, value in agent.seen if key == "system"]
            assert faults[-3:] == ["FAULT", "NORMAL", "FAULT"]  # one fault is cleared before the next stands
            moved = [key for _, key, _ in agent.seen].count("Xpos")
            adapter.says(STATUS | {"positions": [280.5, *STATUS["positions"][1:]]})
            agent.wait_for("Xpos", "280.5000")
            assert [key for _, key, _ in agent.seen].count("Xpos") == moved + 1  # what is the same is said once


def test_a_source_that_is_silent_is_unavailable(tmp_path: Path) -> None:
    with beside(tmp_path, "--silent", "0.5") as adapter, connected(adapter.port, adapter.devices) as agent:
        adapter.says()
        agent.wait_for("temp_spindle", "23.457")
        agent.wait_for("temp_spindle", "UNAVAILABLE")  # its heartbeat stands still
        assert (agent.latest()["temp_oil"], agent.latest()["Xpos"]) == ("40.000", "280.0000")
        adapter.says(pins=PINS | {"rtec-signals.heartbeat": 2.0, "rtec-signals.age-0": 61.0, "oil.temp": None})
        agent.wait_for("temp_oil", "UNAVAILABLE")
        assert agent.latest()["temp_spindle"] == "UNAVAILABLE"  # alive, and too old
        adapter.is_silent()
        agent.wait_for("avail", "UNAVAILABLE")
        until(lambda: set(agent.latest().values()) == {"UNAVAILABLE"})
        until(lambda: "it said nothing for 0.5 s" in adapter.told())
        adapter.says()
        agent.wait_for("avail", "AVAILABLE")  # a child was begun anew


def test_an_agent_that_does_not_read_is_let_go_and_stops_nobody(tmp_path: Path) -> None:
    with beside(tmp_path) as adapter, connected(adapter.port, adapter.devices) as agent, socket.socket() as slow:
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        slow.connect(("127.0.0.1", adapter.port))
        name = f"127.0.0.1:{slow.getsockname()[1]}"
        end, k = time.monotonic() + 60, 0
        while f"agent {name} did not read" not in adapter.told():
            assert time.monotonic() < end
            adapter.says(STATUS | {"program": f"{k}" + "x" * 60_000})
            agent.wait_for("program", f"{k}" + "x" * 60_000)
            k += 1
        agent.ping()
        assert not agent.ended


@pytest.mark.parametrize(
    "name", ["a|b", 'a"b', '"a', "a\nb", "a\\|b", "|", 'x "y" | z', "2026-01-01T00:00:00Z|Xpos|1\nü", "\x00", "\u2028"]
)
def test_no_name_becomes_a_field_or_a_line_of_its_own(name: str) -> None:
    sent = escaped(name)
    assert sent.isprintable()
    (read,) = fields(sent)
    assert read.count("|") == name.count("|")


def test_a_line_without_end_ends_that_agent_alone(tmp_path: Path) -> None:
    with beside(tmp_path) as adapter, connected(adapter.port, adapter.devices) as agent:
        with socket.create_connection(("127.0.0.1", adapter.port), timeout=30) as bad:
            bad.sendall(b"x" * 100_000)
            until(lambda: f":{bad.getsockname()[1]} is gone" in adapter.told())
        agent.ping()


def test_the_adapter_ends_with_its_child(tmp_path: Path) -> None:
    with beside(tmp_path) as adapter:
        children = Path(f"/proc/{adapter.process.pid}/task/{adapter.process.pid}/children")
        until(lambda: children.read_text().split())
        child = int(children.read_text().split()[0])
        adapter.process.send_signal(signal.SIGTERM)
        assert adapter.process.wait(20) == 0
        with pytest.raises(ProcessLookupError):
            os.kill(child, 0)
