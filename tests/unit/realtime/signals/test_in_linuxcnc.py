"""The component beside the corrector in a running LinuxCNC: which program runs, and what a killed one leads to."""

import numpy as np
import pytest

from tests.support.linuxcnc_start import STARTED, STARTER
from tests.support.realtime_signals import image_bytes, model_of
from trueloop._core import realtime_names
from trueloop.machine.model.model import State
from trueloop.realtime.image import Block
from trueloop_lab.linuxcnc.realtime.session import (
    Driven,
    Setup,
    drive,
    get,
    home,
    mdi,
    note,
    on,
    put,
    record,
    run,
    wait,
)

PROGRAM = b"G21 G18 G90 G94 G8 G64\nG53 G0 X290. Z90.\nG4 P1\nG53 G1 X280. Z80. F3000.\nM2\n"
CONFIG = b"""image = "image.rtec"
cycle_hz = 50
[replay.log]
file = "log.csv"
[signals.T1]
source = "log"
"""
HAL = f"""
loadusr -Wn rtec-signals {STARTED} realtime signals signals.toml
net t1 rtec-signals.signal-0 => rtec.signal-0
net t1-age rtec-signals.age-0 => rtec.age-0
net signals-alive rtec-signals.heartbeat => rtec.heartbeat
net signals-program rtec-signals.program => rtec.program
setp rtec.watchdog 3
setp rtec.freeze 1
setp rtec.leave 1
"""
KILL = ("hal", "loadusr", "-w", "pkill", "-9", "-f", "[r]ealtime signals signals.toml")
"""In the session's own namespace of processes."""
MODEL = model_of(("T1",))
NUMBERS = {name: number for kind in ("phases", "faults") for number, name, _ in realtime_names()[kind]}
IN_FORCE = NUMBERS["in force"]


@pytest.fixture(scope="module")
def driven() -> Driven:
    table = Block(4, np.array([[290.0, 90.0, 0.0, 0.0], [280.0, 80.0, 0.0, 0.0]]))
    setup = Setup(
        image_bytes(MODEL, PROGRAM, (table,)),
        {
            **STARTER,
            "signals.toml": CONFIG,
            "log.csv": b"time_s,T1_degC\n0,30\n100000,30\n",
            "part.ngc": PROGRAM,
            "other.ngc": PROGRAM.replace(b"X280.", b"X281."),
        },
        record=("rtec-signals.program", "rtec-signals.heartbeat", "rtec.corr-0", "rtec.fault-code"),
        hal=HAL,
    )
    steps = [
        *(on(), home(), put("rtec.enable", 1), wait("rtec.phase", IN_FORCE), record()),
        *(mdi("G53 G0 X295. Z95."), note("ours"), run("part.ngc"), note("first"), run("other.ngc"), note("end")),
        *(wait("rtec.fault", 1), get("other", "rtec.fault-code"), record(False)),
        *(wait("rtec-signals.program", 0), put("rtec.enable", 0), wait("rtec.fault", 0)),
        *(put("rtec.enable", 1), wait("rtec.phase", IN_FORCE)),
        *(KILL, wait("rtec.fault", 1), get("killed", "rtec.fault-code", "rtec.corr-0", "rtec-signals.signal-0")),
    ]
    return drive(setup, steps)


def test_the_correction_follows_the_signal(driven: Driven) -> None:
    position = np.array([[290.0, 90.0]])
    expected = MODEL.comp_mtg_mm(State(position, signals={"T1": 30.0}))[0, 0]
    assert abs(expected) == pytest.approx(0.01)
    assert driven["rtec.corr-0"][0] == pytest.approx(expected, abs=1e-9)


def test_the_pin_says_which_program_runs(driven: Driven) -> None:
    running = driven["rtec-signals.program"]
    ours, other, end = (driven.got[name] for name in ("ours", "first", "end"))
    assert set(running[:ours]) == {0}, "MDI"
    assert set(running[ours:other]) == {0, 1} or set(running[ours:other]) == {1}
    during = running[other:end]
    assert 2 in during
    assert 1 not in during[np.argmax(during == 2) :]


def test_another_program_than_the_tables_is_a_fault(driven: Driven) -> None:
    assert driven.got["other"] == NUMBERS["program"]
    assert set(driven["rtec.fault-code"][: driven.got["first"]]) == {0}


def test_the_heartbeat_counts(driven: Driven) -> None:
    """By one a cycle; on a busy computer the record, too, misses some of what passes."""
    steps = np.diff(driven["rtec-signals.heartbeat"])
    assert steps.min() >= 0 and np.median(steps[steps > 0]) == 1
    assert steps.sum() > 20


def test_a_killed_component_is_noticed_by_the_watchdog(driven: Driven) -> None:
    """Its last values stand on the pins for ever, and look well."""
    fault, correction, signal = driven.got["killed"]
    assert fault == NUMBERS["watchdog"]
    assert signal == 30.0
    assert abs(correction) < 0.01


def test_nothing_was_said_that_a_user_should_not_see(driven: Driven) -> None:
    assert "Traceback" not in driven.log
    assert "rtec-signals: program: stopped" not in driven.log
