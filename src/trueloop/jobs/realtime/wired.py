"""The lines of HAL for a configuration, its image, and the job that is run with them: refused where they differ.

The signals of a running corrector: from a configuration to the component, or to a check of its sources.
"""

import hashlib
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.controllers.linuxcnc.realtime.configuration import Configuration, read_configuration
from trueloop.controllers.linuxcnc.realtime.hal_checks import mm_per_unit
from trueloop.controllers.linuxcnc.realtime.hal_lines import Wiring, watching, wiring
from trueloop.controllers.linuxcnc.realtime.signals import component
from trueloop.controllers.linuxcnc.realtime.signals.component import linuxcnc_module
from trueloop.controllers.linuxcnc.realtime.signals.setup import Setup, setup_of
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_input
from trueloop.formats.realtime.image_file import read_image
from trueloop.formats.realtime.signals_toml import HINT, SignalsFile, read_signals
from trueloop.formats.tables.model_file import read_model
from trueloop.formats.tables.tool_tables.known import geometry_of, nose_radius_mm, read_tool_table, row_of
from trueloop.formats.tables.tool_tables.tool_table import ToolTable
from trueloop.formats.toml_tables import Located
from trueloop.jobs.turned.job_files import PROGRAM_HINT, JobFiles
from trueloop.machine.model.model import MachineModel
from trueloop.realtime.image import Image, Signal
from trueloop.units import MM_PER_INCH
from trueloop.wording import shell_word

NO_IMAGE: Final = "IMAGE.rtec"


@dataclass(frozen=True)
class Wanted:
    """The purpose of the lines. `serial`: of this machine; `job`: whose program and tool are to run with the image."""

    image: Path | None = None
    serial: str | None = None
    job: Path | None = None
    watch: bool = False


def wired(ini: Path, wanted: Wanted) -> Wiring:
    """Returns the lines to change and to add.

    Raises RTC-HAL for a configuration that the corrector cannot be put into, or that is of another machine than the
    image; RTC-IMAGE for an image of another serial number or program; OFS errors for another tool; JOB errors.
    """
    configuration = read_configuration(ini)
    job = JobFiles.of(wanted.job) if wanted.job is not None else None
    image = _image(wanted, job)
    made = wiring(configuration, image, NO_IMAGE if wanted.image is None else str(wanted.image.resolve()))
    notes = [] if image is None else _compared(configuration, image, wanted, job)
    made = replace(made, remarks=(*made.remarks, *notes))
    if not wanted.watch:
        return made
    signals = len(image.bank.signals) if image and image.bank else 0
    return replace(made, changes=(*made.changes, *watching(configuration, made, signals)))


def _image(wanted: Wanted, job: JobFiles | None) -> Image | None:
    """The image, for this machine and for the job's machine and finish program. Raises RTC-IMAGE, JOB errors."""
    if wanted.image is None:
        return None
    program = None
    if job is not None:
        program = read_input(job.path.parent / job.job.own_programs.finish, Code.NC_FILE, hint=PROGRAM_HINT)
        read_image(wanted.image, serial=_serial(job), program=program)
    return read_image(wanted.image, serial=wanted.serial, program=program)


def _serial(job: JobFiles) -> str | None:
    """The serial number of the job's machine; None where the job does not state it."""
    machine = job.job.machine
    if machine is None:
        return job.job.own_programs.machine_serial or None
    return machine.serial or read_model(job.path.parent / machine.model).machine.serial or None


def _compared(configuration: Configuration, image: Image, wanted: Wanted, job: JobFiles | None) -> list[str]:
    """Compares model and tool of the job; gives what could not be compared, as sentences."""
    notes = []
    if wanted.serial is None and (job is None or _serial(job) is None) and image.identity.serial:
        notes.append(f"The image is for serial number {image.identity.serial}: with --serial it is compared.")
    if job is None:
        table = f"The image's table is for {image.identity.program}: with --job program and tool are compared."
        return [*notes, *([table] if image.blocks else [])]
    _check_model(job, image)
    return [*notes, *_compared_tool(configuration, image, job)]


def _check_model(job: JobFiles, image: Image) -> None:
    """Raises RTC-HAL where the job counts on another model of the machine than the image holds."""
    machine = job.job.machine
    if machine is None:
        return
    found = sha256_of((job.path.parent / machine.model).read_bytes())
    if found != image.identity.model_sha256:
        held = f"sha256 {image.identity.model_sha256[:16]}…" if image.identity.model_sha256 else "no model"
        raise Code.RTC_HAL.refusal(
            f"the job's model {machine.model.name} has sha256 {found[:16]}…, the image holds {held}",
            hint=f"make the image anew: `trueloop realtime image {shell_word(str(job.path))} "
            f"--model {shell_word(str(job.path.parent / machine.model))} --output FILE.img`",
            place=Place(str(job.path)),
        )


def _compared_tool(configuration: Configuration, image: Image, job: JobFiles) -> list[str]:
    """Compares the job's tool with the control's tool table. Raises OFS errors, RTC-HAL for another offset."""
    named, number = configuration.value("EMCIO", "TOOL_TABLE"), job.tool.number
    if not named or number is None:
        why = "the job has no tool.number" if named else "the INI file has no [EMCIO]TOOL_TABLE"
        return [f"The job's tool is not compared with the control's tool table: {why}."]
    unit_mm = mm_per_unit(configuration)
    unit = {1.0: "mm", MM_PER_INCH: "inch"}.get(unit_mm)
    if unit is None:
        return [f"The job's tool is not compared with the control's tool table, whose unit is {unit_mm:g} mm."]
    table = read_tool_table(configuration.ini.parent / named, "mm" if unit == "mm" else "inch")
    nose_radius_mm(table, number, 1, job.tool.table_name, job.nose_radius_mm)
    _check_offset(table, number, unit_mm, image, job)
    return []


def _check_offset(table: ToolTable, number: int, unit_mm: float, image: Image, job: JobFiles) -> None:
    """The tool point of the job is that of the image less the control's offset, to the gate of the image's table.

    Signs: an offset in force is subtracted from the image's tool point, mm, X as a radius. Raises RTC-HAL.
    """
    machine = job.job.machine
    if machine is None or machine.tool_mm is None or image.bank is None or not image.blocks:
        return
    row = geometry_of(table, row_of(table, number, 1, job.tool.table_name))
    offset = [0.0 if cell is None else float(cell.value) * unit_mm for cell in (row.x, row.z)]
    needed = np.subtract(image.bank.tool_mm, machine.tool_mm)[[0, 2]]
    if np.abs(needed - offset).max() > image.limits.gate_mm:
        raise Code.RTC_HAL.refusal(
            f"the offset of T{number} is X {offset[0]:g} mm (radius), Z {offset[1]:g} mm; with the tool "
            f"point {image.bank.tool_mm} of the image and {machine.tool_mm} of the job it has to be X {needed[0]:g} "
            f"and Z {needed[1]:g} mm to the gate of {image.limits.gate_mm:g} mm",
            hint="measure the tool, or make the image anew: `--tool` is the tool point without an offset in force",
            place=table.place(row),
        )


@dataclass(frozen=True)
class PreparedConfiguration:
    """A configuration with what it names."""

    image_file: Path
    image: Image
    setup: Setup


def prepared(path: Path) -> PreparedConfiguration:
    """Reads a configuration, the image and the model. Raises RTC-SOURCE, RTC-IMAGE and as reading a model does."""
    file = read_signals(path)
    with file.at("image"):
        image_file = path.parent / file.model.image
        image = read_image(image_file)
    model = _model(file, image)
    lags, units = (model.lags, model.units) if model else ((), {})
    return PreparedConfiguration(image_file, image, setup_of(file, _wanted(image), lags, units))


def check(path: Path, wait_s: float) -> list[component.CheckedSignal]:
    """Reads every source once. Raises as `prepared`."""
    return component.checked(prepared(path).setup, wait_s, lambda: None)


def run(path: Path, stop: threading.Event, say: Callable[[str], None]) -> None:
    """Runs the component until `stop`. Raises as `prepared`, and RTC-CONNECTION."""
    hal, linuxcnc = linuxcnc_module("_hal"), linuxcnc_module("linuxcnc")
    given = prepared(path)
    component.run(given.setup, hal, linuxcnc, ImageProgram(given), stop, say)


class ImageProgram:
    """The hash of the program that the image's table belongs to, read anew when the image's file changes."""

    def __init__(self, configuration: PreparedConfiguration) -> None:
        self._file, self._image = configuration.image_file, configuration.image
        self._seen = self._identity()

    def __call__(self) -> str:
        """Raises RTC-SOURCE where the image's signals are not those of the pins; the corrector refuses other files."""
        identity = self._identity()
        if identity is not None and identity != self._seen:
            self._seen = identity
            try:
                image = read_image(self._file)
            except TrueloopError:
                return self._image.identity.program_sha256
            self._take(image)
        return self._image.identity.program_sha256

    def _identity(self) -> tuple[int, int, int] | None:
        """None where there is no file: one is being put in its place."""
        try:
            of = self._file.stat()
        except OSError:
            return None
        return of.st_ino, of.st_size, of.st_mtime_ns

    def _take(self, image: Image) -> None:
        if _wanted(image) != _wanted(self._image):
            raise Code.RTC_SOURCE.refusal(
                f"the signals of {str(self._file)!r} have changed: {len(_wanted(self._image))} were given, "
                f"{len(_wanted(image))} are wanted, with their order, ranges and names",
                hint="start LinuxCNC anew, so that component and signals agree on which pin carries which signal",
            )
        self._image = image


def _wanted(image: Image) -> tuple[Signal, ...]:
    return image.bank.signals if image.bank else ()


def _model(file: Located[SignalsFile], image: Image) -> MachineModel | None:
    """The model that the image was made from, for its lags and units. Raises RTC-SOURCE for another one."""
    if not file.model.model:
        return None
    with file.at("model"):
        path = file.path.parent / file.model.model
        found = hashlib.sha256(read_input(path, Code.RTC_SOURCE, hint=HINT)).hexdigest()
        if found != image.identity.model_sha256:
            raise Code.RTC_SOURCE.refusal(
                f"{path.name!r} is not the model that the image was made from: its SHA-256 begins with {found[:12]}, "
                f"that in the image with {image.identity.model_sha256[:12] or 'nothing'}",
                hint="make the image anew with `trueloop realtime image`, or name its model",
            )
        return read_model(path)
