"""Every way in which the simulator and controls refuse."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from unittest import mock

import pytest

from tests.support.files import read_as_file
from tests.support.probing import EXAMPLES
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.surface.job import read_surface
from trueloop_lab.files.virtual_machine_toml import read_virtual_machine, workshop_and_trial
from trueloop_lab.linuxcnc import session
from trueloop_lab.loops.linuxcnc import drive_part
from trueloop_lab.loops.surface import surface_trial
from trueloop_lab.simulator.nose import Nose, Transfer

LOOP = EXAMPLES / "loop"


def _machine(text: str) -> object:
    return read_as_file(text, read_virtual_machine)


def _without_linuxcnc() -> None:
    with mock.patch("shutil.which", return_value=None):
        session.cut(b"M2\n")


def _other_dialect() -> None:
    workshop, trial = workshop_and_trial(EXAMPLES / "modbas2" / "job.toml", None)
    drive_part(trial, workshop)


def _no_program_to_mill() -> None:
    inputs = read_surface(EXAMPLES / "surface" / "simulate.toml", measured=False).inputs
    surface_trial(replace(inputs, program=None), (25, 25))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.SIM_FILE: lambda: _machine('preset = "nist"\n[process]\nalong_um = -1\n'),
    Code.SIM_NOSE: lambda: Nose(0.8, (0.0, 0.3, 0.6), (0.0, 0.08, 0.0)),
    Code.SIM_TRANSFER: lambda: Transfer((0.5, 0.2), (0.001, 0.002)),
    Code.SIM_ALLOWANCE: lambda: workshop_and_trial(EXAMPLES / "linuxcnc" / "job.toml", None),
    Code.SIM_MILL: _no_program_to_mill,
    Code.CTL_LINUXCNC: _without_linuxcnc,
    Code.CTL_DIALECT: _other_dialect,
    Code.CTL_PROGRAM: lambda: session.cut(b"G21 G8 G18\nG1 X250\nM2\n"),
}


def test_a_nose_that_is_none_names_its_machine_file(tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    wear = "wear_angle_deg = [0, 20, 40]\nwear_um = [0, 80, 0]"
    file.write_text(f'preset = "nist"\n[nose]\nradius_mm = 0.8\n{wear}\n')
    with pytest.raises(TrueloopError) as refused:
        read_virtual_machine(file)
    assert (refused.value.code, refused.value.place.file) == (Code.SIM_NOSE, str(file))
