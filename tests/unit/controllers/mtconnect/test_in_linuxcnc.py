"""The adapter beside a running LinuxCNC: what an agent hears lies on the program's path, in its order."""

import math
from collections.abc import Sequence
from itertools import groupby, pairwise

import pytest

from tests.support.linuxcnc_start import STARTED, STARTER
from tests.support.realtime_signals import image_bytes, model_of
from tests.support.shdr import ShdrAgent, model
from trueloop.controllers.mtconnect.items import Machine, devices_xml
from trueloop_lab.linuxcnc.realtime.session import Setup, drive, home, mdi, on, run, sleep

PLACES = ((290.0, 90.0), (280.0, 80.0), (280.0, 65.0), (292.0, 65.0))
"""X (a radius) and Z in machine coordinates, mm: where the program begins, and the ends of its moves."""
MOVES = "".join(f"G53 G1 X{x} Z{z} F900.\n" for x, z in PLACES[1:])
PROGRAM = f"G21 G18 G8 G90 G94 G61\nG53 G0 X290. Z90.\nG4 P1\n{MOVES}M2\n".encode()
OPTIONS = "--device lathe --temperature room=oil.signal --correction X=rtec.corr-0"
HEARD = """
import socket, time
end = time.monotonic() + 120
while True:
    try:
        connection = socket.create_connection(("127.0.0.1", 7878), 5)
        break
    except OSError:
        if time.monotonic() > end:
            raise
        time.sleep(0.1)
connection.settimeout(240)
for line in connection.makefile("r", encoding="utf-8", newline="\\n"):
    print("SHDR", line, end="", flush=True)
"""
"""Says to LinuxCNC's log what an agent is told: nothing else comes out of its namespaces."""


@pytest.fixture(scope="module")
def heard() -> ShdrAgent:
    setup = Setup(
        image_bytes(model_of(("T1",))),
        {"part.ngc": PROGRAM, "hear.py": HEARD.encode(), **STARTER},
        hal=f"loadusr {STARTED} mtconnect serve {OPTIONS}\nloadusr /usr/bin/python3 hear.py\n",
    )
    driven = drive(setup, (on(), home(), mdi("G53 G0 X290. Z90."), sleep(4.0), run("part.ngc"), sleep(1.0)))
    agent = ShdrAgent(model(devices_xml(Machine("lathe", "XZ", {"room": "oil.signal"}, {"X": "rtec.corr-0"}))), None)  # type: ignore[arg-type]
    for line in driven.log.splitlines():
        if line.startswith("SHDR "):
            agent.take(line.removeprefix("SHDR "))
    assert agent.seen, driven.log
    assert driven.log.count("status is not read") <= 1, driven.log  # at LinuxCNC's end
    return agent


def of(agent: ShdrAgent, key: str) -> list[str]:
    """The values of a key, each once as it changes, but for those of before LinuxCNC was up and after it ended."""
    return [value for _, name, value in agent.seen if name == key and value != "UNAVAILABLE"]


def on_path(x: float, z: float) -> tuple[float, float]:
    """How far along the path the nearest place of it is, and how far from it, mm."""
    along, best = 0.0, (0.0, math.inf)
    for (x0, z0), (x1, z1) in pairwise(PLACES):
        length = math.hypot(x1 - x0, z1 - z0)
        share = min(max(((x - x0) * (x1 - x0) + (z - z0) * (z1 - z0)) / length**2, 0.0), 1.0)
        away = math.hypot(x - x0 - share * (x1 - x0), z - z0 - share * (z1 - z0))
        best = min(best, (along + share * length, away), key=lambda one: one[1])
        along += length
    return best


def places(agent: ShdrAgent) -> Sequence[tuple[float, float]]:
    """Where the machine was while the program ran: what came with one time stamp is of one moment."""
    now, found = dict[str, str](), list[tuple[float, float]]()
    for _, told in groupby(agent.seen, key=lambda one: one[0]):
        now |= {key: value for _, key, value in told}
        if (now["execution"], now["program"]) == ("ACTIVE", "part.ngc"):
            found.append((float(now["Xpos"]), float(now["Zpos"])))
    return found


def test_positions_follow_the_program(heard: ShdrAgent) -> None:
    judged = [on_path(x, z) for x, z in places(heard)]
    assert len(judged) > 10
    assert max(away for _, away in judged) < 0.002
    along = [where for where, _ in judged]
    assert all(later >= earlier - 0.002 for earlier, later in pairwise(along))
    assert (of(heard, "Xpos")[-1], of(heard, "Zpos")[-1]) == ("292.0000", "65.0000")


def test_execution_mode_and_program(heard: ShdrAgent) -> None:
    assert of(heard, "avail") == ["AVAILABLE"]
    assert of(heard, "execution")[-2:] == ["ACTIVE", "READY"]
    assert of(heard, "mode")[-1] == "AUTOMATIC"
    assert of(heard, "program")[-1] == "part.ngc"
    assert {"4", "5", "6"} & set(of(heard, "line"))
    feeds = [float(said) for said in of(heard, "feed") if said != "UNAVAILABLE"]
    assert any(feed == pytest.approx(15.0, abs=0.1) for feed in feeds)  # 900 mm/min; rapids are faster
    assert of(heard, "system")[-1] == "NORMAL"


def test_pins(heard: ShdrAgent) -> None:
    assert of(heard, "Xcorr")[-1] == "0.000000"
    assert not of(heard, "temp_room")  # there is no such pin
