"""The loop with LinuxCNC as its controller, headless: semi-finish, calibration, probing, corrected finish program."""

import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.support.probing import EXAMPLES
from trueloop.arrays import Array
from trueloop.cli.terminal import ExitStatus
from trueloop.errors import Code, Place, TrueloopError
from trueloop_lab.files.virtual_machine_toml import read_virtual_machine, workshop_and_trial
from trueloop_lab.linuxcnc import session
from trueloop_lab.linuxcnc.session import cut, source
from trueloop_lab.loops.turned import simulate
from trueloop_lab.simulator.machine import Repeatability
from trueloop_lab.simulator.presets import nist

UM = 1e-3
LOOP = EXAMPLES / "loop"


def exact() -> str:
    """The file of a machine whose process and probe repeat: loops then differ by the controller alone."""
    probe = nist().probe
    return f"""preset = "nist"
[process]
[transfer]
[probe]
ball_radius_mm = {probe.ball_radius_mm}
pre_travel_um = {probe.pre_travel_mm / UM}
lobing_um = {probe.lobing_mm / UM}
lobes = {probe.lobes}
lobing_phase_deg = {math.degrees(probe.lobing_phase_rad)}
"""


def test_linuxcnc_closes_the_loop_as_the_simulator_does_beside_one_that_is_interrupted(tmp_path: Path) -> None:
    """At the command line. LinuxCNC's positions cut what the commanded path would to 0.05 µm; touches are latched
    within a servo period of 1 µm; the true residual is within 1.5 µm RMS of that of the simulator's own loop. The loop
    that Ctrl-C ends beside it leaves nothing."""
    machine = tmp_path / "exact.toml"
    machine.write_text(exact())
    with _loop("interrupted", machine) as interrupted, _loop("whole", machine) as whole:
        try:
            _one_ends(interrupted)
            written, errors = whole.communicate(timeout=180)
        finally:
            interrupted.kill()
            whole.kill()
    assert what_still_runs() == ""
    assert whole.returncode == ExitStatus.DONE, errors
    workshop, trial = workshop_and_trial(LOOP / "modbas2.toml", machine)
    made, alone = json.loads(written), simulate(trial, workshop)
    semifinish, probed, finish = (
        np.array([point[name] for point in made["points"]]) * UM
        for name in ("semifinish_truth_um", "probed_um", "finish_truth_um")
    )
    assert np.max(np.abs(semifinish - alone.semifinish_truth_mm)) < 0.05 * UM
    assert np.max(np.abs(probed - semifinish)) < 1.5 * UM
    assert np.sqrt(np.mean((finish - alone.finish_truth_mm) ** 2)) < 1.5 * UM
    assert made["true_residual_rms_um"] < 1.5 < 0.05 * np.sqrt(np.mean(semifinish**2)) / UM
    assert [point["point"] for point in made["points"]] == list(trial.inputs.touches.point)


def test_two_sessions_side_by_side_do_not_meet() -> None:
    """Each gets the positions of its own program, to the digit that it has alone."""
    programs = [b"G21 G18 G8 G90 G94\nG0 X20 Z%d\nG1 X%d F6000\nG1 Z-30\nM2\n" % (k, 10 + k) for k in (1, 2)]
    found: dict[int, Array] = {}

    def run(k: int) -> None:
        found[k] = cut(programs[k])

    threads = [threading.Thread(target=run, args=(k,)) for k in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in (0, 1):
        assert np.allclose(found[k][-1], [11 + k, -30.0], atol=1e-6)
        assert np.allclose(found[k].min(axis=0), [11 + k, -30.0], atol=1e-6)
    assert what_still_runs() == ""


def test_an_interrupted_run_leaves_nothing_behind() -> None:
    """Ctrl-C while the program runs: LinuxCNC and all it started are gone when the exception arrives."""

    def interrupt(line: int, x: float, z: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cut(b"G21 G18 G8 G90 G94\nG1 X20 Z1 F60\nM2\n", progress=interrupt)
    assert what_still_runs() == ""


def test_what_still_writes_when_it_is_interrupted_leaves_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """A session's processes may be many, and busy with its folder: it is removed when the last of them is gone."""
    started = 'echo 1 1 1 > "$1/config/progress.txt"'
    busy = started + '; for k in {1..60}; do (while :; do : > "$1/$RANDOM"; done) & done; wait'
    monkeypatch.setattr(session, "source", lambda name: busy if name == "session.sh" else source(name))

    def interrupt(line: int, x: float, z: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cut(b"M2\n", progress=interrupt)
    assert list(Path(tempfile.gettempdir()).iterdir()) == []


def _one_ends(interrupted: "subprocess.Popen[str]") -> None:
    while not list(Path(tempfile.gettempdir(), "interrupted").glob("*/config/progress.txt")):
        assert interrupted.poll() is None, interrupted.communicate()
        time.sleep(0.1)
    os.killpg(interrupted.pid, signal.SIGINT)
    assert interrupted.wait(timeout=30) == ExitStatus.INTERRUPTED
    assert "interrupted" not in what_still_runs()
    assert list(Path(tempfile.gettempdir(), "interrupted").iterdir()) == []


def _loop(name: str, machine: Path) -> "subprocess.Popen[str]":
    """The loop as a user starts it, its temporary files in a folder of that name."""
    folder = Path(tempfile.gettempdir(), name)
    folder.mkdir()
    trueloop = str(Path(sys.executable).with_name("trueloop"))
    command = [trueloop, "linuxcnc", "loop", str(LOOP / "modbas2.toml"), "--machine", str(machine), "--json"]
    pipe = subprocess.PIPE
    environment = os.environ | {"TMPDIR": str(folder)}
    return subprocess.Popen(command, env=environment, stdout=pipe, stderr=pipe, text=True, start_new_session=True)


@pytest.fixture(autouse=True)
def _folder_of_its_own(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Sessions of this test alone: others may run on the same computer."""
    with tempfile.TemporaryDirectory(prefix="own-") as folder:
        monkeypatch.setattr(tempfile, "tempdir", folder)
        yield


def what_still_runs() -> str:
    """Processes of ours that outlived their session: they would name its folder."""
    found = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True).stdout
    return "\n".join(line for line in found.splitlines() if tempfile.gettempdir() in line)


def test_the_example_machine_is_the_nist_one() -> None:
    assert read_virtual_machine(LOOP / "machine.toml").machine.repeatability == Repeatability(0.0012, 1.0)
    assert Path(LOOP / "probe.toml").exists()


BEFORE = "G21 G18 G8 G90 G94\nG0 X20 Z1\nG1 X19 F600\nG1 Z-20\n"


@pytest.mark.parametrize(
    ("said", "block"),
    [
        ("zero feed rate", "G1 X18 F0"),
        ("positive limit", "G1 X99999"),
        ("radius too small", "G2 X10 Z-40 R1"),
        ("without making contact", "G38.2 Z-25 F100"),
        ("enough", "(ABORT,enough)"),
    ],
)
def test_an_error_is_told_with_the_block_that_linuxcnc_means(said: str, block: str) -> None:
    """LinuxCNC reads ahead: the block that moves when an error comes is an earlier one."""
    with pytest.raises(TrueloopError) as raised:
        cut(f"{BEFORE}{block}\nG1 Z-21\nM2\n".encode())
    assert raised.value.code is Code.CTL_PROGRAM
    assert said in raised.value.message and repr(block) in raised.value.message
    assert raised.value.place == Place(line=5)
