"""The component: in LinuxCNC's hardware layer, and beside a played one where a fault has to be made."""

import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.support.hal import SPEED, hardware_layer
from tests.support.realtime_signals import model_of, write_configuration, write_image
from tests.support.signals import until
from trueloop.controllers.linuxcnc.realtime.signals import component
from trueloop.controllers.linuxcnc.realtime.signals.component import NAME
from trueloop.controllers.linuxcnc.realtime.signals.readings import NEVER_S, Intake
from trueloop.jobs.realtime.wired import ImageProgram, prepared

NINE = "50 05 4b 46 7f ff 0c 10 1c"
TRUELOOP = Path(sys.executable).with_name("trueloop")
ONE_WIRE = """
[one_wire.bus]
folder = "."
every_s = 0.05
[signals.T1]
source = "bus"
device = "28-1"
"""
SPINDLE = '[signals.spindle]\nsource = "spindle"\n'


def set_sensor(folder: Path, milli: int) -> None:
    (folder / "28-1").mkdir(exist_ok=True)
    next_one = folder / "28-1" / "next"
    next_one.write_text(f"{NINE} : crc=1c YES\n{NINE} t={milli}\n")
    next_one.replace(folder / "28-1" / "w1_slave")


def test_pins_follow_the_sensors_and_the_end_is_clean(tmp_path: Path) -> None:
    set_sensor(tmp_path, 21500)
    write_image(tmp_path, model_of(("T1", "spindle"), unit=""))
    path = write_configuration(tmp_path, ONE_WIRE + SPINDLE, {"log": '"log.csv"', "every_s": 0.1})
    said = tmp_path / "said.txt"
    with hardware_layer(tmp_path) as hal:
        hal.start("/usr/bin/python3", "-c", SPEED, log=said)
        process = hal.start(TRUELOOP, "realtime", "signals", path, log=said)
        until(lambda: f"{NAME} " in hal.ask("list", "comp") + " ", said.read_text())
        until(lambda: hal.value(f"{NAME}.signal-0") == 21.5)
        assert hal.value(f"{NAME}.age-1") == NEVER_S, "nothing is linked to the spindle's pin"
        hal.ask("net", "speed", "spindle-encoder.speed", f"{NAME}.spindle-speed")
        until(lambda: hal.value(f"{NAME}.signal-1") == 750.0)
        assert hal.value(f"{NAME}.age-0") < 20
        assert hal.value(f"{NAME}.age-5") == NEVER_S
        assert hal.value(f"{NAME}.program") == 0
        before = hal.value(f"{NAME}.heartbeat")
        until(lambda: hal.value(f"{NAME}.heartbeat") > before + 3)
        set_sensor(tmp_path, -3250)
        until(lambda: hal.value(f"{NAME}.signal-0") == -3.25)
        (tmp_path / "28-1" / "w1_slave").unlink()
        until(lambda: hal.value(f"{NAME}.age-0") > 1)
        before = hal.value(f"{NAME}.heartbeat")
        until(lambda: hal.value(f"{NAME}.heartbeat") > before)
        assert hal.value(f"{NAME}.signal-0") == -3.25
        # nsenter waits for the component: the signal has to go to that
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        assert len(children) == 1
        os.kill(int(children[0]), signal.SIGTERM)
        assert process.wait(20) == 0
        assert NAME not in hal.ask("list", "comp")
    assert "Traceback" not in said.read_text()
    assert "rtec-signals: bus: T1: " in said.read_text()
    assert len((tmp_path / "log.csv").read_text().splitlines()) > 2


class PlayedHal:
    """LinuxCNC's module `_hal`, as far as it is used: pins in a dictionary."""

    HAL_FLOAT, HAL_S32, HAL_U32, HAL_OUT, HAL_IN = range(5)
    error = RuntimeError

    def __init__(self) -> None:
        self.pins: dict[str, float] = {}

    def component(self, _name: str) -> Any:
        pins = self.pins

        class Component(dict[str, float]):
            def __setitem__(self, name: str, value: float) -> None:
                pins[name] = value

            def __getitem__(self, name: str) -> float:
                return pins[name]

            def newpin(self, name: str, *_: object) -> None:
                pins[name] = 0

            def ready(self) -> None: ...

            def exit(self) -> None: ...

        return Component()

    def pin_has_writer(self, _name: str) -> bool:
        return False


class NoLinuxcncError(Exception):
    """Its status is not there."""


def _no_status() -> None:
    raise NoLinuxcncError


NO_LINUXCNC = SimpleNamespace(error=NoLinuxcncError, stat=_no_status, MODE_AUTO=2, INTERP_IDLE=1)


def played(folder: Path, change: Callable[[Any], Any] = lambda setup: setup) -> tuple[Any, ...]:
    """A component running on a played hardware layer: pins, lines said, what ends it, its thread, what ended it."""
    given = prepared(write_configuration(folder, ONE_WIRE, {"cycle_hz": 50, "every_s": 0.05}))
    hal, said, stop, ended = PlayedHal(), list[str](), threading.Event(), list[Exception]()

    def run() -> None:
        try:
            component.run(change(given.setup), hal, NO_LINUXCNC, ImageProgram(given), stop, said.append)
        except Exception as error:
            ended.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    until(lambda: hal.pins.get("signal-0") == 21.5)
    return hal.pins, said, stop, thread, ended


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    set_sensor(tmp_path, 21500)
    write_image(tmp_path, model_of(("T1",)))
    return tmp_path


def test_the_heartbeat_stops_when_a_thread_dies(folder: Path) -> None:
    dies = threading.Event()

    def with_another(setup: Any) -> Any:
        class Dying:
            def __call__(self, intake: Intake, stop: threading.Event) -> None:
                dies.wait(30)
                raise KeyError("unforeseen")

        return replace(setup, feeds={**setup.feeds, "other": Dying()})

    pins, said, stop, thread, _ = played(folder, with_another)
    before = pins["heartbeat"]
    until(lambda: pins["heartbeat"] > before + 2)
    dies.set()
    until(lambda: any("unforeseen" in line for line in said))
    time.sleep(0.2)
    before = pins["heartbeat"]
    set_sensor(folder, 22500)
    until(lambda: pins["signal-0"] == 22.5)
    assert pins["heartbeat"] == before, "signals go on, the heartbeat does not"
    stop.set()
    thread.join(20)
    assert not thread.is_alive()


def test_a_source_that_fails_leaves_the_heartbeat_alone(folder: Path) -> None:
    pins, _, stop, thread, _ = played(folder)
    (folder / "28-1" / "w1_slave").unlink()
    age = pins["age-0"]
    until(lambda: pins["age-0"] > age + 0.5)
    before = pins["heartbeat"]
    until(lambda: pins["heartbeat"] > before + 2)
    stop.set()
    thread.join(20)


def test_an_image_of_other_signals_ends_the_component_and_one_that_is_none_does_not(folder: Path) -> None:
    pins, _, stop, thread, ended = played(folder)
    (folder / "lathe.img").write_bytes(b"half of an image")
    before = pins["heartbeat"]
    until(lambda: pins["heartbeat"] > before + 3)
    write_image(folder, model_of(("T1", "T2")))
    until(lambda: not thread.is_alive())
    assert "1 were given, 2 are wanted" in str(ended[0])
    assert stop.is_set()
