"""The virtual lathe: LinuxCNC drives, and what it drove is cut; its probe meets the part that is in the chuck.

LinuxCNC's sampler records the axes while the spindle turns. Until what was cut is known, the input `part ready` is low:
the probing program waits for it, as for a part that is being cleaned, and the probe is out of the way.
"""

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import numpy as np

from scripts.factory_demo.truth import Metal
from scripts.running_lathe import RunningLathe, running_lathe
from trueloop.controllers.linuxcnc.cell.linuxcnc import Task
from trueloop_lab.linuxcnc.session import ProbedPart, virtual_part
from trueloop_lab.simulator.machine import VirtualProbe

PROBE: Final = VirtualProbe(1.5, pre_travel_mm=0.004, lobing_mm=0.0005)
FEED_OVERRIDE: Final = 8.0
WAIT_S: Final = 60.0
PROBING: Final = 5
"""The motion type of G38.2."""
HAL: Final = b"""
loadrt sampler depth=120000 cfg=ff
loadrt flipflop
loadrt not
loadrt constant
loadrt and2
addf sampler.0 servo-thread
addf flipflop.0 servo-thread
addf not.0 servo-thread
addf constant.0 servo-thread
addf and2.0 servo-thread
net x-actual joint.0.pos-fb => sampler.0.pin.0
net z-actual joint.1.pos-fb => sampler.0.pin.1
net spindle-on spindle.0.on => sampler.0.enable flipflop.0.set
net cut flipflop.0.out => not.0.in
net part-ready not.0.out => motion.digital-in-01 and2.0.in1
net contact and2.0.in0
net probe and2.0.out => motion.probe-input
setp constant.0.value 20
"""
TEMPERATURE_PIN: Final = "constant.0.out"
_MODULE: Final = """
import sys
from trueloop.controllers.linuxcnc.realtime.signals.component import linuxcnc_module
linuxcnc = linuxcnc_module("linuxcnc")
command = linuxcnc.command()
"""
_OVERRIDE: Final = _MODULE + f"command.feedrate({FEED_OVERRIDE}); command.wait_complete(5)"
_STOP: Final = _MODULE + "command.abort(); command.wait_complete(5)"


class VirtualLathe:
    """LinuxCNC and the metal in it. `chip`: one lies on the part when it is probed next."""

    def __init__(self, control: RunningLathe, metal: Metal) -> None:
        self.control, self.metal, self.chip = control, metal, False
        self._samples = control.folder / "samples.txt"
        self._sampler = self._sampling()
        self._part_known = False
        self._operator(_OVERRIDE)
        self._clean()

    @property
    def ini(self) -> Path:
        """LinuxCNC's configuration."""
        return self.control.ini

    @property
    def clean(self) -> bool:
        """Whether all that was cut is known."""
        return self._get("flipflop.0.out") == "FALSE"

    @property
    def probing(self) -> bool:
        """Whether the ball moves towards the part now."""
        return self._get("motion.motion-type") == str(PROBING)

    def step(self) -> None:
        """Cuts what was driven, once the spindle has stopped."""
        if self.clean or self._get("spindle.0.on") == "TRUE" or self._get("sampler.0.curr-depth") != "0":
            return
        self.metal = self.metal.cut_along(self._driven())
        self._hal("setp", "constant.0.value", f"{self.metal.spindle_c:.3f}")
        self._clean()

    def exchange(self, blank: Metal) -> Metal:
        """The part that was in the chuck; the next blank is in it then."""
        made, self.metal = self.metal, blank
        return made

    def wiped(self) -> None:
        """Nothing lies on the part any more."""
        self._clean()

    def stop(self) -> None:
        """Somebody presses Stop."""
        self._operator(_STOP)

    def _driven(self) -> np.ndarray:
        self._sampler.terminate()
        self._sampler.wait(WAIT_S)
        lines = self._samples.read_text().splitlines()
        assert self._get("sampler.0.overruns") == "0", "the computer is too busy: servo periods were not recorded"
        self._sampler = self._sampling()
        return np.array([[float(word) for word in line.split()] for line in lines if line != "overrun"])

    def _sampling(self) -> "subprocess.Popen[bytes]":
        return subprocess.Popen(self.control.beside("halsampler", str(self._samples)))

    def _clean(self) -> None:
        """The probe meets the part as it is now; then it is ready."""
        if self.metal.cuts_of_blank:
            surface = self.metal.surface_for_probe_mm(chip=self.chip)
            probed = ProbedPart(surface, PROBE.ball_radius_mm, PROBE.pre_travel_mm, PROBE.lobing_mm, PROBE.lobes)
            (self.control.config / "surface.bin").write_bytes(probed.to_bytes())
            self._probe_meets_it()
        self._hal("setp", "flipflop.0.reset", "1")
        until = time.monotonic() + WAIT_S
        while not self.clean:
            assert time.monotonic() < until, "LinuxCNC's hardware layer does not run"
            time.sleep(0.01)
        self._hal("setp", "flipflop.0.reset", "0")

    def _probe_meets_it(self) -> None:
        """The component reads the part as it is loaded."""
        if self._part_known:
            self._hal("delf", "virtual-part.0", "servo-thread")
            self._hal("unloadrt", "virtual_part")
        self._hal("loadrt", "virtual_part")
        self._hal("addf", "virtual-part.0", "servo-thread")
        for signal, pin in (("x-actual", "x"), ("z-actual", "z"), ("contact", "contact")):
            self._hal("net", signal, f"virtual-part.0.{pin}")
        self._part_known = True

    def _operator(self, program: str) -> None:
        done = self.control.python("-c", program)
        assert done.wait(WAIT_S) == 0, "LinuxCNC does not do as it is told"

    def _get(self, pin: str) -> str:
        return self._hal("getp", pin)

    def _hal(self, *command: str) -> str:
        pid = Task(self.ini, "milltask").pid()
        assert pid is not None, "LinuxCNC does not run"
        user = [] if os.geteuid() == 0 else ["--user", "--preserve-credentials"]
        inside = ["nsenter", f"--target={pid}", "--ipc", "--net", "--mount", *user, "halcmd", *command]
        done = subprocess.run(
            inside, capture_output=True, text=True, check=False, timeout=WAIT_S, env=self.control.environment
        )
        assert done.returncode == 0, f"halcmd {' '.join(command)}: {done.stderr.strip() or done.stdout.strip()}"
        return done.stdout.strip()


@contextmanager
def virtual_lathe(metal: Metal) -> Iterator[VirtualLathe]:
    """One that is on."""
    files, modules = {"extra.hal": HAL}, {"virtual_part.so": virtual_part()}
    with running_lathe(files, modules) as control:
        lathe = VirtualLathe(control, metal)
        try:
            yield lathe
        finally:
            lathe._sampler.terminate()
            lathe._sampler.wait(WAIT_S)
