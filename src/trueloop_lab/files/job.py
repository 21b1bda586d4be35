"""A job and the file of a virtual machine or mill, read into the values that a simulation works on."""

from dataclasses import replace
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place, in_file
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.option_tables import options_from
from trueloop.jobs.surface.job import read_surface
from trueloop.jobs.turned.job import read_job
from trueloop.turned.touches.touches import Gauging
from trueloop_lab.files.virtual_machine_toml import read_virtual_machine
from trueloop_lab.files.virtual_mill_toml import VirtualMillFile, mill_of, read_virtual_mill
from trueloop_lab.loops.surface import SurfaceTrial, surface_trial
from trueloop_lab.loops.turned import Trial, require_plan_fits, trial_of
from trueloop_lab.simulator.mill import VirtualMill
from trueloop_lab.simulator.presets import Workshop, nist

NOSE_WITHIN_MM: Final = 1e-3


def workshop_and_trial(job: Path, machine: Path | None) -> tuple[Workshop, Trial]:
    """Reads a job and a machine file (None: the NIST machine). Raises JOB, NC, GEO, TCH, SIM and PRB errors."""
    read, z_reference = read_job(job), options_from(Gauging, read_turned_job(job)).z_reference
    workshop = nist() if machine is None else read_virtual_machine(machine)
    if read.inputs.allowance_mm <= 0.0:
        raise Code.SIM_ALLOWANCE.refusal(
            f"the semi-finish cut leaves {read.inputs.allowance_mm} mm: the finish cut would have nothing to cut",
            hint="say `semifinish_allowance_mm` in the job's table [programs]",
            place=Place(str(job)),
            values={"allowance_mm": read.inputs.allowance_mm},
        )
    nose_mm = workshop.machine.nose.radius_mm
    if abs(nose_mm - read.inputs.nose_radius_mm) > NOSE_WITHIN_MM:
        raise Code.SIM_NOSE.refusal(
            f"the machine's nose has a radius of {nose_mm:.4f} mm, the job's {read.inputs.nose_radius_mm:.4f} mm",
            hint="give the machine file a table [nose] with the job's radius; its errors belong into the wear",
            place=Place(str(machine) if machine is not None else str(job)),
        )
    trial = trial_of(replace(read.inputs, inspections=()), z_reference)
    with in_file(job):
        require_plan_fits(trial, workshop.probe)
    return workshop, trial


def mill_and_trial(job: Path, machine: Path | None) -> tuple[VirtualMill, SurfaceTrial]:
    """Reads a surface's job and a mill's file (None: the published process). Raises JOB, NC, SRF and SIM errors."""
    mill = mill_of(VirtualMillFile()) if machine is None else read_virtual_mill(machine)
    read = read_surface(job, measured=False)
    with in_file(job):
        return mill, surface_trial(read.inputs, mill.grid)
