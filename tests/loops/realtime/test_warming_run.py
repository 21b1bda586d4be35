"""LinuxCNC with sensors that change while it cuts: every period judged with the values that were in use in it."""

import os
import signal
import struct
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke
from tests.support.cut_thrice import TOOL_OFFSET, image, lathe_model
from trueloop.errors import Code, TrueloopError
from trueloop.realtime.judge import judge
from trueloop.realtime.samples import signal_columns
from trueloop_lab.linuxcnc.realtime.session import Driven
from trueloop_lab.linuxcnc.session import TOO_BUSY
from trueloop_lab.realtime import warming_run as ran_by
from trueloop_lab.realtime.warming_run import Sensors, interruption, warming_run

DWELLING = "G18 G21 G8 G90 G94 G40\n" + 8 * "G1 X290 F6000\nG4 P0.1\nX295\nG4 P0.1\n" + "X300\nM2\n"
"""After every dwell motion is commanded anew."""
RECORDED = "/tmp/linuxcnc.samples"
"""Where a session records, in its own /tmp; how many rows there are is the first number in it."""
PROGRAM = f"""G18 G21 G8 G90 G94 G40 G64 P0.0001 Q0
G43.1 X{TOOL_OFFSET[0]} Z{TOOL_OFFSET[1]}
G0 X40 Z5
G1 Z-60 F3000
G2 X60 Z-80 I0 K-20
G1 Z-20
G4 P0.3
G1 X90 Z-60
G49
M2
"""


def test_a_warming_machine_is_corrected_in_every_period() -> None:
    held, model = image(tables=False), lathe_model()
    time_s = np.arange(0.0, 60.0, 1e-3)
    warmer = np.floor(time_s / 0.1) * 0.1
    sensors = Sensors(time_s, {"T1": 20.0 + 0.6 * warmer % 15.0, "T2": 38.0 - 0.2 * warmer})
    ran = warming_run(held, PROGRAM, sensors, corrected=True)
    assert not ran.samples.count("fault").any()
    assert np.allclose(np.diff(ran.clock_s), 1e-3, atol=1e-9)
    felt = ran.samples.columns[signal_columns([("T1", "°C")])[0]]
    assert np.ptp(felt) > 1.0 and np.abs(felt - np.interp(ran.clock_s, time_s, sensors.values["T1"])).max() < 0.1
    found = judge(ran.driven, model)
    print(f"{found.judged.sum()} periods, {found.rms_nm:.5f} nm RMS, {found.worst_nm:.5f} at most")
    assert found.judged.sum() > 3000 and found.uncorrected_um > 5.0
    assert found.rms_nm < 0.05 and found.within(0.05)


STOPPED_S = 1.3
"""LinuxCNC waits for an answer of its motion for a second."""


def interrupt(done: threading.Event) -> None:
    """Stops the real-time process of the first session of this process, again and again from when it records."""
    first = 0
    while not done.is_set():
        for pid in _descendants("rtapi_app"):
            if pid != (first or pid):
                continue
            with suppress(OSError), Path(f"/proc/{pid}/root{RECORDED}").open("rb") as file:
                if struct.unpack("d", file.read(8))[0] > 0:
                    first = pid
                    os.kill(pid, signal.SIGSTOP)
                    time.sleep(STOPPED_S)
                    os.kill(pid, signal.SIGCONT)
        time.sleep(0.2 if first else 0.005)  # the program begins a tenth of a second after the record


def _descendants(name: str) -> list[int]:
    """Processes of this name below this one."""
    parents, names = {}, {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            head, _, rest = stat.read_text().rpartition(")")
            pid = int(stat.parent.name)
            names[pid], parents[pid] = head.partition("(")[2], int(rest.split()[1])
    own = os.getpid()

    def below(pid: int) -> bool:
        while pid and pid != own:
            pid = parents.get(pid, 0)
        return pid == own

    return [pid for pid, found in names.items() if found.startswith(name[:15]) and below(pid)]


def test_a_run_that_the_computer_interrupts_is_made_once_more() -> None:
    """Motion does not answer for longer than LinuxCNC waits: it ends the program and says so in its log alone."""
    done = threading.Event()
    told: list[str] = []
    beside = threading.Thread(target=interrupt, args=(done,))
    beside.start()
    try:
        ran = warming_run(image(tables=False), DWELLING, still(), corrected=True, tell=told.append)
    finally:
        done.set()
        beside.join()
    assert len(told) == 1 and "the run was interrupted: LinuxCNC " in told[0]
    assert ran.samples.count("line").max() >= len(DWELLING.splitlines()) - 2


def still() -> Sensors:
    """Sensors that always show the same."""
    time_s = np.arange(0.0, 60.0, 1e-3)
    return Sensors(time_s, {"T1": np.full(len(time_s), 25.0), "T2": np.full(len(time_s), 36.0)})


def test_two_interrupted_runs_are_an_error_and_no_result(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    short = made_of([4, 5, 5], [0.0, 0.001, 0.002])
    monkeypatch.setattr(ran_by, "drive", lambda setup, steps: short)
    told: list[str] = []
    with pytest.raises(
        TrueloopError, match="2 of 2 runs were interrupted, the last one: 3 periods end in line 5"
    ) as no:
        warming_run(image(tables=False), DWELLING, still(), corrected=True, tell=told.append)
    assert no.value.code is Code.CTL_LINUXCNC and len(told) == 2
    said = invoke("realtime", "demo", "-o", tmp_path / "out")
    assert said.exit_code not in (0, 70) and "CTL-LINUXCNC" in said.stderr and "interrupted" in said.stderr
    assert not (tmp_path / "out" / "report.html").exists() and not (tmp_path / "out" / "samples.csv").exists()


def made_of(lines: Sequence[float], clock_s: Sequence[float], **given: object) -> Driven:
    """A record of these lines and this clock."""
    known = {"got": {"underruns": 0}, "messages": (), "log": ""} | given
    return Driven(("rtec.line", "streamer.0.pin.0"), np.column_stack([lines, clock_s]), **known)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("driven", "reason"),
    [
        (made_of([4, 5, 6], [0.0, 0.001, 0.002]), ""),
        (made_of([4, 5, 5], [0.0, 0.001, 0.002]), "3 periods end in line 5 of the program, which moves up to line 6"),
        (made_of([4, 5, 6], [0.0, 0.001, 0.003]), "longest step of its clock is 0.002 s"),
        (made_of([4, 5, 6], [0.0, 0.001, 0.001]), "longest step of its clock is 0.001 s"),
        (made_of([4, 5, 6], [0.0, 0.001, 0.002], got={"underruns": 3}), "ran empty 3 times"),
        (made_of([4, 5, 6], [0.0, 0.001, 0.002], messages=("joint 0 following error",)), "joint 0 following error"),
        (made_of([4, 5, 6], [0.0, 0.001, 0.002], log=f"x\n{TOO_BUSY}\n"), "did not answer for a second"),
    ],
)
def test_what_makes_a_run_no_result(driven: Driven, reason: str) -> None:
    found = interruption(driven, "G18 G21\nG43.1 X5 Z2\nG10 L2 P1 X0 Z1\nG0 X40 Z5\nG4 P0.3\nG1 Z-60\nG49\nM2\n")
    assert reason in found and bool(found) == bool(reason)
