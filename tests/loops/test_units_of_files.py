"""Every length, angle and switch that a file states arrives inside in millimetres and radians, in its own place."""

import math
import shutil
from pathlib import Path

import pytest

from tests.support.probing import EXAMPLES
from trueloop.domain.option import Limits
from trueloop.formats.jobs.surface_job import SurfaceJobFile
from trueloop.jobs.surface.job import options_of
from trueloop.jobs.turned.job import read_job
from trueloop.surface.options import SurfaceOptions
from trueloop.turned.fit.between_cuts import BetweenCuts
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.options import Options
from trueloop_lab.files.virtual_machine_toml import read_virtual_machine
from trueloop_lab.simulator.machine import Backlash, Deflection, ErrorTerm, Repeatability, VirtualProbe
from trueloop_lab.simulator.mill import VirtualCmm

COMPENSATION = """
[compensation]
weight = 0.6
junctions = "path"
knot_every = 3
chord_tolerance_um = 0.25
arcs = "lines"
errors_follow = "nose"
max_correction_um = 120
max_slope_um_per_mm = 30
max_scatter_um = 8
max_age_hours = 12
cut_to_cut_um = 0.75
cut_to_cut_along_um = 0.5
repeatability_um = 1.25

[compensation.features.dome]
knot_every = 2
start_um = 1
start_slope_um_per_mm = 2
end_um = 3
end_slope_um_per_mm = 4
"""
MACHINE = """
[nose]
radius_mm = 0.8
wear_angle_deg = [0, 90]
wear_um = [-3, 2]
[process]
along_um = 1
correlation_mm = 2
cut_to_cut_um = 3
tool_offset_x_um = 4
tool_offset_z_um = 5
[deflection]
specific_force_n_per_mm2 = 1000
tool_um_per_n = 0.1
chuck_um_per_n = 0.2
part_um_per_n_mm3 = 0.3
chuck_z_mm = -100
feed_mm_per_rev = 0.2
[backlash]
x_um = 6
z_um = 7
[[error]]
axis = "z"
um = 8
x_power = 1
z_power = 2
temperature_power = 3
[temperature]
semifinish_c = 21
probing_c = 22
finish_c = 23
[probe]
ball_radius_mm = 1.5
pre_travel_um = 9
lobing_um = 10
lobes = 4
lobing_phase_deg = 30
range_x_um = 1.1
range_z_um = 1.2
overshoot_um = 1.3
calibrated_from_deg = -45
calibrated_to_deg = 135
[cmm]
frame_um = 1.4
tilt_urad = 15
mpe_um = 1.6
mpe_um_per_m = 2.5
"""


def test_a_turned_part(tmp_path: Path) -> None:
    folder = shutil.copytree(EXAMPLES / "modbas2", tmp_path / "modbas2")
    job = folder / "job.toml"
    job.write_text(job.read_text().replace("\n[output]", COMPENSATION + "\n[output]"))
    assert read_job(job).inputs.options == Options(
        weight=0.6,
        junctions=TangentPolicy.PATH,
        knot_every=3,
        knot_every_on={"dome": 2},
        prescribed={"dome": EndConditions(0.001, 0.002, 0.003, 0.004)},
        repeatability_mm=0.00125,
        between_cuts=BetweenCuts(0.00075, 0.0005, "stated in the job"),
        chord_tolerance_mm=0.00025,
        arcs="lines",
        errors_follow="nose",
        limits=Limits(0.120, 0.030, 0.008, 12.0),
        tool=1,
    )


def test_a_surface() -> None:
    given = {
        "name": "blade",
        "surface": {"file": "surface.step"},
        "gauging": {"points": ["a.csv"], "alignment": "best-fit", "farthest_mm": 0.5, "setup_mm": 0.3},
        "model": {"target_um": 1.5},
        "compensation": {
            "weight": 0.7,
            "tolerance_um": 0.25,
            "max_correction_um": 90,
            "max_slope_um_per_mm": 20,
            "max_scatter_um": 7,
            "max_age_hours": 5,
        },
    }
    assert options_of(SurfaceJobFile.model_validate(given)) == SurfaceOptions(
        best_fit=True,
        farthest_mm=0.5,
        setup_mm=0.3,
        target_mm=0.0015,
        weight=0.7,
        tolerance_mm=0.00025,
        limits=Limits(0.090, 0.020, 0.007, 5.0),
    )


def test_a_virtual_machine(tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE)
    made = read_virtual_machine(file)
    machine = made.machine
    assert machine.nose.radius_mm == 0.8
    assert machine.nose.wear_angle_rad == (0.0, math.pi / 2)
    assert machine.nose.wear_mm == (-0.003, 0.002)
    assert machine.repeatability == Repeatability(0.001, 2.0, 0.003)
    assert machine.tool_offset_mm == (0.004, 0.005)
    assert machine.deflection == Deflection(1000.0, 1e-4, 2e-4, 3e-4, -100.0, 0.2)
    assert machine.backlash == Backlash(0.006, 0.007)
    assert machine.error.terms == (ErrorTerm(1, 0.008, 1, 2, 3),)
    assert made.temperatures_c == (21.0, 22.0, 23.0)
    calibrated = (-math.pi / 4, 3 * math.pi / 4)
    assert made.probe == VirtualProbe(1.5, 0.009, 0.010, 4, math.radians(30), 0.0011, 0.0012, 0.0013, calibrated)
    assert made.cmm == VirtualCmm(0.0014, 15e-6, 0.0016, made.cmm.mpe_per_mm)
    assert made.cmm.mpe_per_mm == pytest.approx(2.5e-6)
