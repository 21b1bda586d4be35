"""The virtual machine's file (TOML): a preset, and whatever differs from it.

A job and the file of a virtual machine or mill, read into the values that a simulation works on.
"""

import math
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final, Literal

import numpy as np
from pydantic import Field, model_validator

from trueloop.errors import Code, Place, in_file
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.toml_tables import Count, Finite, NotNegative, Positive, Table, options_from, read_tables
from trueloop.jobs.surface.job import read_surface, require_one_face
from trueloop.jobs.turned.job import read_job
from trueloop.turned.touches.touches import Gauging
from trueloop.units import MM_PER_M, UM_PER_MM, URAD_PER_RAD
from trueloop_lab.loops.surface import SurfaceTrial, surface_trial
from trueloop_lab.loops.turned import Trial, require_plan_fits, trial_of
from trueloop_lab.simulator.machine import (
    REFERENCE_C,
    Backlash,
    Deflection,
    ErrorTerm,
    MachineError,
    Repeatability,
    SurfaceProcess,
    VirtualMachine,
    VirtualProbe,
    published_process,
)
from trueloop_lab.simulator.mill import VirtualCmm, VirtualMill
from trueloop_lab.simulator.nose import Nose, Transfer
from trueloop_lab.simulator.presets import Workshop, nist

Power = Annotated[int, Field(ge=0, le=6, strict=True)]


class NoseTable(Table):
    """The nose: radius errors over contact angle, negative where it is worn."""

    radius_mm: Positive
    """Of the unworn nose."""
    wear_angle_deg: tuple[Finite, ...] = ()
    """Contact angles at which the wear is given: 0 on a face, 90 on a cylinder."""
    wear_um: tuple[Finite, ...] = ()
    """By how much the radius is larger there; negative where it is worn."""


class ProcessTable(Table):
    """The errors that do not repeat, and by how much the tool is set wrongly (x on the radius)."""

    along_um: NotNegative = 0.0
    """Standard deviation of what varies along the cut."""
    correlation_mm: Positive = 1.0
    """Over which distance it is alike."""
    cut_to_cut_um: NotNegative = 0.0
    """Standard deviation of what moves a whole cut."""
    tool_offset_x_um: Finite = 0.0
    """By how much the tool is set wrongly, on the radius."""
    tool_offset_z_um: Finite = 0.0
    """By how much the tool is set wrongly along z."""


class TransferTable(Table):
    """Difference of the finish cut from the cuts before it: error over contact angle, negative: more taken."""

    contact_angle_deg: tuple[Finite, ...] = ()
    """Contact angles at which it is given; straight between them, constant beyond."""
    error_um: tuple[Finite, ...] = ()
    """Part error that the finish cut has besides; negative: more is taken."""


class DeflectionTable(Table):
    """Compliance of tool and workpiece."""

    specific_force_n_per_mm2: NotNegative = 0.0
    """Normal force by depth and feed; 0: nothing gives way."""
    tool_um_per_n: NotNegative = 0.0
    """Compliance of the tool."""
    chuck_um_per_n: NotNegative = 0.0
    """Compliance of the chuck."""
    part_um_per_n_mm3: NotNegative = 0.0
    """Compliance of the part, times the cube of the distance from `chuck_z_mm`."""
    chuck_z_mm: Finite = 0.0
    """Where the part is clamped."""
    feed_mm_per_rev: Positive = 0.127
    """Where the program does not say."""


class BacklashTable(Table):
    """Play of the axes, x on the radius."""

    x_um: NotNegative = 0.0
    """Play of X, on the radius."""
    z_um: NotNegative = 0.0
    """Play of Z."""


class ErrorTermTable(Table):
    """`um` · (x/100 mm)^i · (z/100 mm)^j · (T − 20 °C)^k, actual less commanded position."""

    axis: Literal["x", "z"]
    """Along which it acts."""
    um: Finite
    """Its size at 100 mm or 1 K."""
    x_power: Power = 0
    """Power of x/100 mm."""
    z_power: Power = 0
    """Power of z/100 mm."""
    temperature_power: Power = 0
    """Power of T − 20 °C."""


class TemperatureTable(Table):
    """How warm the machine is."""

    semifinish_c: Finite = REFERENCE_C
    """Of the machine in the semi-finish cut."""
    probing_c: Finite = REFERENCE_C
    """While it probes."""
    finish_c: Finite = REFERENCE_C
    """In the finish cut."""


class ProbeTable(Table):
    """The virtual probe."""

    ball_radius_mm: Positive
    """Of the stylus tip."""
    pre_travel_um: NotNegative = 0.0
    """By how much it trips late, in all directions alike."""
    lobing_um: NotNegative = 0.0
    """By how much that differs with the direction."""
    lobes: Count = 3
    """Legs of the switch."""
    lobing_phase_deg: Finite = 0.0
    """Direction of a leg."""
    range_x_um: NotNegative = 0.0
    """Range of repeated touches along x."""
    range_z_um: NotNegative = 0.0
    """Range of repeated touches along z."""
    overshoot_um: NotNegative = 0.0
    """By how far the control reads the position late."""
    calibrated_from_deg: Finite | None = None
    """Lowest contact angle of the calibration; left out, what the part asks for, and 45° more."""
    calibrated_to_deg: Finite | None = None
    """Highest contact angle; 90 to 360 above the lowest."""

    @model_validator(mode="after")
    def _one_range(self) -> "ProbeTable":
        if (self.calibrated_from_deg is None) != (self.calibrated_to_deg is None):
            raise ValueError("`calibrated_from_deg` and `calibrated_to_deg` go together")
        if self.calibrated_from_deg is not None and self.calibrated_to_deg is not None:
            span_deg = self.calibrated_to_deg - self.calibrated_from_deg
            if not 90.0 <= span_deg <= 360.0:
                raise ValueError(f"`calibrated_to_deg` is {span_deg:g} above `calibrated_from_deg`, not 90 to 360")
        return self

    @property
    def calibrated_rad(self) -> tuple[float, float] | None:
        """Between which contact angles the probe is calibrated; None: those that the part asks for."""
        if self.calibrated_from_deg is None or self.calibrated_to_deg is None:
            return None
        return math.radians(self.calibrated_from_deg), math.radians(self.calibrated_to_deg)


class CmmTable(Table):
    """The virtual coordinate measuring machine."""

    frame_um: NotNegative = 0.0
    """Standard deviation of its frame's origin."""
    tilt_urad: NotNegative = 0.0
    """Standard deviation of its frame's axis."""
    mpe_um: NotNegative = 0.0
    """Maximum permissible error of length, its constant part."""
    mpe_um_per_m: NotNegative = 0.0
    """Its part that grows with length."""


class VirtualMachineFile(Table):
    """A whole file: a table that is given replaces that of the preset."""

    preset: Literal["nist"] | None = None
    """`"nist"`: the lathe and worn insert of NISTIR 6811 and 6517; a table that is given replaces the preset's."""
    nose: NoseTable | None = None
    process: ProcessTable | None = None
    transfer: TransferTable | None = None
    deflection: DeflectionTable | None = None
    backlash: BacklashTable | None = None
    error: tuple[ErrorTermTable, ...] = ()
    temperature: TemperatureTable = TemperatureTable()
    probe: ProbeTable | None = None
    cmm: CmmTable | None = None

    @model_validator(mode="after")
    def _enough(self) -> "VirtualMachineFile":
        if self.preset is None and (self.nose is None or self.probe is None):
            raise ValueError("without a `preset` the tables [nose] and [probe] are needed")
        return self


def read_virtual_machine(path: Path) -> Workshop:
    """The workshop of a machine file. Raises SIM-FILE and SIM-NOSE."""
    hint = "docs/simulator.md lists every table and key of a machine file"
    file = read_tables(path, VirtualMachineFile, Code.SIM_FILE, hint=hint)
    with in_file(path):
        return workshop_of(file)


def workshop_of(file: VirtualMachineFile) -> Workshop:
    """The tables as values."""
    base = nist() if file.preset == "nist" else None
    machine = VirtualMachine(Nose(1.0)) if base is None else base.machine
    if file.nose is not None:
        angles = tuple(math.radians(angle) for angle in file.nose.wear_angle_deg)
        wear_mm = tuple(wear / UM_PER_MM for wear in file.nose.wear_um)
        machine = replace(machine, nose=Nose(file.nose.radius_mm, angles, wear_mm))
    if file.process is not None:
        machine = _with_process(machine, file.process)
    if file.transfer is not None:
        machine = replace(machine, transfer=_transfer(file.transfer))
    if file.deflection is not None:
        machine = replace(machine, deflection=_deflection(file.deflection))
    if file.backlash is not None:
        play = Backlash(file.backlash.x_um / UM_PER_MM, file.backlash.z_um / UM_PER_MM)
        machine = replace(machine, backlash=play)
    terms = tuple(
        ErrorTerm("xz".index(t.axis), t.um / UM_PER_MM, t.x_power, t.z_power, t.temperature_power) for t in file.error
    )
    warm = file.temperature
    return Workshop(
        machine=replace(machine, error=MachineError(terms)),
        probe=base.probe if base is not None and file.probe is None else _probe(file.probe),
        cmm=base.cmm if base is not None and file.cmm is None else cmm_of(file.cmm or CmmTable()),
        temperatures_c=(warm.semifinish_c, warm.probing_c, warm.finish_c),
    )


def _with_process(machine: VirtualMachine, table: ProcessTable) -> VirtualMachine:
    repeatability = Repeatability(table.along_um / UM_PER_MM, table.correlation_mm, table.cut_to_cut_um / UM_PER_MM)
    offset_mm = (table.tool_offset_x_um / UM_PER_MM, table.tool_offset_z_um / UM_PER_MM)
    return replace(machine, tool_offset_mm=offset_mm, repeatability=repeatability)


def _transfer(table: TransferTable) -> Transfer:
    angles = tuple(math.radians(angle) for angle in table.contact_angle_deg)
    return Transfer(angles, tuple(error / UM_PER_MM for error in table.error_um))


def _deflection(table: DeflectionTable) -> Deflection:
    return Deflection(
        table.specific_force_n_per_mm2,
        table.tool_um_per_n / UM_PER_MM,
        table.chuck_um_per_n / UM_PER_MM,
        table.part_um_per_n_mm3 / UM_PER_MM,
        table.chuck_z_mm,
        table.feed_mm_per_rev,
    )


def _probe(table: ProbeTable | None) -> VirtualProbe:
    assert table is not None  # VirtualMachineFile._enough
    return VirtualProbe(
        table.ball_radius_mm,
        table.pre_travel_um / UM_PER_MM,
        table.lobing_um / UM_PER_MM,
        table.lobes,
        math.radians(table.lobing_phase_deg),
        table.range_x_um / UM_PER_MM,
        table.range_z_um / UM_PER_MM,
        table.overshoot_um / UM_PER_MM,
        table.calibrated_rad,
    )


def cmm_of(table: CmmTable) -> VirtualCmm:
    """The table as values."""
    return VirtualCmm(
        table.frame_um / UM_PER_MM,
        table.tilt_urad / URAD_PER_RAD,
        table.mpe_um / UM_PER_MM,
        table.mpe_um_per_m / UM_PER_MM / MM_PER_M,
    )


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
