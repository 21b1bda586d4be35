"""A job and the file of a virtual machine or mill, read into the values that a simulation works on."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final

import numpy as np
from pydantic import Field

from trueloop.errors import Code, Place, in_file
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.toml_tables import Finite, NotNegative, Table, options_from, read_tables
from trueloop.jobs.surface.job import read_surface, require_one_face
from trueloop.jobs.turned.job import read_job
from trueloop.turned.touches.touches import Gauging
from trueloop.units import UM_PER_MM
from trueloop_lab.files.virtual_machine_toml import CmmTable, cmm_of, read_virtual_machine
from trueloop_lab.loops.surface import SurfaceTrial, surface_trial
from trueloop_lab.loops.turned import Trial, require_plan_fits, trial_of
from trueloop_lab.simulator.mill import VirtualMill
from trueloop_lab.simulator.presets import Workshop, nist
from trueloop_lab.simulator.process import SurfaceProcess, published_process

Side = Annotated[int, Field(ge=8, le=200, strict=True)]


class MilledProcessTable(Table):
    """The errors that repeat, by how much parts differ in the middle and at the edges, and the scatter of a touch."""

    pattern_um: NotNegative = 8.0
    """Size of what repeats on every part."""
    pattern_controls: Annotated[int, Field(ge=4, le=40, strict=True)] = 9
    """Control points of it along each side."""
    pattern_seed: Annotated[int, Field(ge=0, strict=True)] = 0
    """Seed of its form."""
    least_um: NotNegative | None = None
    """By how much parts differ in the middle; left out, as published."""
    most_um: NotNegative | None = None
    """By how much at the edges; left out, as published."""
    noise_um: NotNegative | None = None
    """The scatter of a single touch; left out, as published."""


class WearTable(Table):
    """The cutter: by how much it is larger than programmed, negative where it is worn."""

    radius_error_um: Finite = 0.0
    """By how much the cutter is larger than programmed; negative where it is worn."""


class GridTable(Table):
    """Places that the measuring machine touches, along u and along v."""

    rows: Side = 25
    """Places that the measuring machine touches along u."""
    columns: Side = 25
    """Places that the measuring machine touches along v."""


class VirtualMillFile(Table):
    """A whole file; all of it may be left out."""

    process: MilledProcessTable = MilledProcessTable()
    cutter: WearTable = WearTable()
    cmm: CmmTable = CmmTable()
    grid: GridTable = GridTable()


def read_virtual_mill(path: Path) -> VirtualMill:
    """The mill of a file. Raises SIM-FILE."""
    hint = "docs/simulator.md lists every table and key of a mill's file"
    file = read_tables(path, VirtualMillFile, Code.SIM_FILE, hint=hint)
    with in_file(path):
        return mill_of(file)


def mill_of(file: VirtualMillFile) -> VirtualMill:
    """The tables as values."""
    return VirtualMill(
        _process(file.process),
        file.cutter.radius_error_um / UM_PER_MM,
        cmm_of(file.cmm),
        (file.grid.rows, file.grid.columns),
    )


def _process(table: MilledProcessTable) -> SurfaceProcess:
    rng = np.random.default_rng(table.pattern_seed)
    base = published_process(rng, table.pattern_um / UM_PER_MM, table.pattern_controls)

    def given(um: float | None, published_mm: float) -> float:
        return published_mm if um is None else um / UM_PER_MM

    return SurfaceProcess(
        base.pattern,
        given(table.least_um, base.least_mm),
        given(table.most_um, base.most_mm),
        given(table.noise_um, base.noise_mm),
    )


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
        return mill, surface_trial(require_one_face(read).inputs, mill.grid)
