"""The loop with LinuxCNC as its controller, headless: semi-finish, calibration, probing, corrected finish program."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.probing import EXAMPLES
from trueloop.arrays import Array
from trueloop.cli.terminal import ExitStatus
from trueloop.controllers.linuxcnc import session
from trueloop.controllers.linuxcnc.component import source
from trueloop.controllers.linuxcnc.loop import drive_part
from trueloop.controllers.linuxcnc.session import cut
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.jobs.virtual_machine_toml import read_virtual_machine
from trueloop.jobs.simulated import workshop_and_trial
from trueloop.loops.simulated.simulated import simulate
from trueloop.simulator.nose import SAME
from trueloop.simulator.presets import Workshop
from trueloop.simulator.process import Repeatability

UM = 1e-3
LOOP = EXAMPLES / "loop"


def exact(workshop: Workshop) -> Workshop:
    """A process and probe that repeat: what differs between the loops is then the controller alone."""
    machine = replace(workshop.machine, repeatability=Repeatability(), transfer=SAME)
    return replace(workshop, machine=machine, probe=replace(workshop.probe, range_x_mm=0.0, range_z_mm=0.0))


def test_linuxcnc_closes_the_loop_as_the_simulator_does() -> None:
    """LinuxCNC's positions cut what the commanded path would to 0.05 µm; touches are latched within a servo period of
    1 µm; the true residual is within 1.5 µm RMS of that of the simulator's own loop."""
    workshop, trial = workshop_and_trial(LOOP / "modbas2.toml", LOOP / "machine.toml")
    workshop, said = exact(workshop), list[str]()
    alone = simulate(trial, workshop)
    driven = drive_part(trial, workshop, say=said.append)
    part = driven.part
    assert np.max(np.abs(part.semifinish_truth_mm - alone.semifinish_truth_mm)) < 0.05 * UM
    assert np.max(np.abs(part.touches.error_mm - part.semifinish_truth_mm)) < 1.5 * UM
    assert np.sqrt(np.mean((part.finish_truth_mm - alone.finish_truth_mm) ** 2)) < 1.5 * UM
    assert part.residual_rms_mm < 1.5 * UM < 0.05 * np.sqrt(np.mean(part.semifinish_truth_mm**2))
    assert len(driven.probe_log.splitlines()) == len(trial.inputs.touches.point)
    assert any("corrected finish program" in words for words in said) and any("line" in words for words in said)
    assert what_still_runs() == ""


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


def test_ctrl_c_ends_one_loop_and_another_beside_it_goes_on() -> None:
    """At the command line: the interrupted one leaves nothing, the other ends with a part as true as alone."""
    with _loop("interrupted") as interrupted, _loop("whole") as whole:
        try:
            _one_ends_the_other_goes_on(interrupted, whole)
        finally:
            interrupted.kill()
            whole.kill()
    assert what_still_runs() == ""


def _one_ends_the_other_goes_on(interrupted: "subprocess.Popen[str]", whole: "subprocess.Popen[str]") -> None:
    while not list(Path(tempfile.gettempdir(), "interrupted").glob("*/config/progress.txt")):
        assert interrupted.poll() is None, interrupted.communicate()
        time.sleep(0.1)
    os.killpg(interrupted.pid, signal.SIGINT)
    assert interrupted.wait(timeout=30) == ExitStatus.INTERRUPTED
    assert "interrupted" not in what_still_runs()
    assert list(Path(tempfile.gettempdir(), "interrupted").iterdir()) == []
    said, errors = whole.communicate(timeout=180)
    assert whole.returncode == ExitStatus.DONE, errors
    assert json.loads(said)["true_residual_rms_um"] < 3.0


def _loop(name: str) -> "subprocess.Popen[str]":
    """The loop as a user starts it, its temporary files in a folder of that name."""
    folder = Path(tempfile.gettempdir(), name)
    folder.mkdir()
    command = [
        str(Path(sys.executable).with_name("trueloop")),
        "linuxcnc",
        "loop",
        str(LOOP / "modbas2.toml"),
        "--machine",
        str(folder.parent / "alike.toml"),
        "--json",
    ]
    alike = (LOOP / "machine.toml").read_text() + "\n[transfer]\n"  # the finish cut does as the semi-finish cut did
    Path(command[-2]).write_text(alike)
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
