"""A new job from a finish program and perhaps a drawing: the job, and the file in which to note what is measured.

The sheet of what a person measures of a job's part, for paper and as the file to fill in.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from os.path import relpath
from pathlib import Path
from typing import Final, Literal, TypeAlias

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.record import check_uncorrected
from trueloop.errors import Code, Place, in_file
from trueloop.formats.input_file import read_program
from trueloop.formats.inspections.gauge_csv import gauge_sheet_csv, holds_readings
from trueloop.formats.jobs.profile_of_job import characteristics_toml, part_table_toml, side_key
from trueloop.formats.measurements.touches_csv import empty_touches_csv
from trueloop.formats.outputs import write_all
from trueloop.formats.toml_tables import toml_keys
from trueloop.geometry.feature import is_curved
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile, Side
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.turned.characteristics import characteristics_of, toleranced
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.commanded import Run, commanded
from trueloop.nc.program.program import Program, Unit
from trueloop.nc.program.understood import require_understood
from trueloop.nc.program.unit import unit_of_path
from trueloop.probing.probe_plan import MARGIN_MM, GaugingPoints, Spacing, equally_spaced
from trueloop.report.pdf import as_pdf
from trueloop.report.turned.touch_sheet import touch_sheet
from trueloop.turned.readings.sizes import gauge_plan
from trueloop.units import MM_PER_INCH
from trueloop.wording import wording

CAD: Final = {".dxf": "dxf", ".step": "step", ".stp": "step", ".igs": "step", ".iges": "step"}
"""The key of the job by the drawing's ending."""

Zero: TypeAlias = Literal["drawing", "free-end", "chuck-end"]


@dataclass(frozen=True)
class Chosen:
    """Selects in a drawing: a contour by its number (None: the only one), and the z of a DXF that counts as 0."""

    outline: int | None = None
    zero: Zero = "drawing"

    def keys(self, of: str) -> dict[str, int | str]:
        """Returns the choice as keys of a job's table [part]; `of`: `dxf` or `step`."""
        outline = {} if self.outline is None else {f"{of}_outline": self.outline}
        return outline | ({} if self.zero == "drawing" else {f"{of}_zero": self.zero})


AS_DRAWN: Final = Chosen()


@dataclass(frozen=True)
class PartDrawing:
    """The profile, what the drawing asks for, and in words how it was read."""

    profile: Profile
    notes: tuple[str, ...]
    asked: tuple[Characteristic, ...] = ()


def read_drawing(
    path: Path, side: Side = Side.OUTSIDE, unit: Unit | None = None, chosen: Chosen = AS_DRAWN
) -> PartDrawing:
    """Reads the outside or the bore; `unit` is that of a DXF drawing that states none. Raises GEO and SRF errors."""
    if drawing_key(path) == "dxf":
        from trueloop.formats.cad.dxf import read_dxf  # ezdxf takes long to import

        drawn = read_dxf(path, unit=unit, side=side, outline=chosen.outline, zero=chosen.zero)
        with in_file(path):
            return PartDrawing(checked_profile(drawn.features, side=side), drawn.notes)
    from trueloop.formats.cad.step_profile import read_step_profile  # so does the kernel
    from trueloop.formats.cad.step_tolerances import fitting

    solid = read_step_profile(path, side=side, outline=chosen.outline)
    with in_file(path):
        profile = checked_profile(solid.features, side=side)
    asked = fitting(solid.characteristics, profile)
    return PartDrawing(profile, (*solid.notes, *asked.notes), asked.characteristics)


def drawing_key(drawing: Path) -> str:
    """Returns the job's key for a drawing. Raises GEO-DXF for an ending that is not a drawing's."""
    key = CAD.get(drawing.suffix.lower())
    if key is None:
        raise Code.GEO_DXF.refusal(
            f"{drawing.name!r} ends neither in {', '.join(CAD)}",
            hint="give a DXF drawing, or a STEP or IGES file of the solid",
            place=Place(str(drawing)),
        )
    return key


APART_MM: Final = 5.0
FEWEST, MOST = 3, 20
"""Points on an arc: this far apart, but not fewer and not more."""


@dataclass(frozen=True)
class NewTool:
    """An edge that cuts: `number` is that of its offset, which only the one tool of a part may leave open."""

    nose_radius_mm: float
    number: int | None = None
    tip: int | None = None
    name: str = ""


@dataclass(frozen=True)
class WantedProgram:
    """A finish program with its tool, and `tools` that it cuts with besides, each by the number of its offset.

    Of several set-ups: z of the part where its Z is 0, whether the part is turned round. `cut`: keys of the job's table
    [programs] that state what cut the part.
    """

    program: Path
    nose_radius_mm: float
    _: KW_ONLY
    dialect: str | None = None
    unit: Unit | None = None
    tool: int | None = None
    tip: int | None = None
    tool_name: str = ""
    tools: tuple[NewTool, ...] = ()
    lines: tuple[int, int] | None = None
    parameters: Mapping[str, float] = field(default_factory=dict)
    accept_unknown_words: bool = False
    zero_at_z_mm: float | None = None
    flipped: bool = False
    cut: Mapping[str, str] = field(default_factory=dict)

    @property
    def run(self) -> Run:
        """Returns how it is run."""
        unknown = self.accept_unknown_words
        return Run(self.parameters, False, self.lines, tip=self.tip, accept_unknown_words=unknown)

    @property
    def all_tools(self) -> tuple[NewTool, ...]:
        """Returns the tools that it cuts with."""
        return (NewTool(self.nose_radius_mm, self.tool, self.tip, self.tool_name), *self.tools)

    def read(self) -> Program:
        """Reads the program. Raises CMP-TWICE for a corrected one, NC errors for what its dialect does not know."""
        program = read_program(self.program, self.dialect, self.unit)
        with in_file(self.program):
            check_uncorrected(program.source)
            if not self.accept_unknown_words:
                require_understood(program)
        return program


@dataclass(frozen=True)
class Wanted(WantedProgram):
    """The sources of a new job. `measured`: "gauge" for readings of diameters and lengths, "points" for touches.

    `measured_file` holds these already: none to be filled in is written. `stated` are further keys of the job;
    `tolerances` of sizes of the sheet, by name, as a drawing writes them in the program's unit. `then` are the programs
    of the set-ups after the first.
    """

    name: str
    folder: Path
    drawing: Path | None = None
    measured: Literal["gauge", "points"] = "gauge"
    measured_file: Path | None = None
    side: Side = Side.OUTSIDE
    chosen: Chosen = AS_DRAWN
    stated: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    tolerances: Mapping[str, str] = field(default_factory=dict)
    then: tuple[WantedProgram, ...] = ()

    @property
    def by_one_tool(self) -> bool:
        """Returns whether one tool cuts the whole part in one set-up."""
        return not self.tools and not self.then


@dataclass(frozen=True)
class NewFiles:
    """The written files: the job first, then the file to be filled in, with `places` rows; and the part's features."""

    files: tuple[Path, ...]
    places: int
    features: tuple[str, ...]
    notes: tuple[str, ...]


def new_job(wanted: Wanted) -> NewFiles:
    """Writes `job.toml`, and `readings.csv` with `sheet.html` or `touches.csv`; nothing where one is there already.

    The program is run and matched with the part: one that does not cut it is refused here, not at the first correction.
    Raises NC errors, NC-WORD and NC-CODE for what the dialect does not know
    among them, GEO, JOB-EXISTS and OUT errors. Of several tools or set-ups each program is read alone: which features
    they cut is found when the job is read.
    """
    programs = [one.read() for one in (wanted, *wanted.then)]
    program = programs[0]
    drawn = _drawn(wanted, program)
    profile = drawn.profile
    with in_file(wanted.program):
        if wanted.by_one_tool:
            path = commanded(program, None, profile, wanted.nose_radius_mm, 0.0, wanted.run).path
        else:  # the features of each are found when the job is read
            path = wanted.run.of(program)
    inch = unit_of_path(program.unit, path)["unit"] == "inch"
    planned = gauge_plan(profile, drawn.asked)
    limits = toleranced(wanted.tolerances, planned, profile, MM_PER_INCH if inch else 1.0)
    drawn = replace(drawn, asked=(*drawn.asked, *limits))
    measured, places = _to_fill_in(wanted, profile, inch)
    handed = wanted.measured_file
    file = next(iter(measured)) if handed is None else Path(relpath(handed, wanted.folder)).as_posix()
    contents = {"job.toml": _job_toml(wanted, [one.dialect.name for one in programs], drawn, file), **measured}
    for file in contents:
        new_file = wanted.folder / file
        if new_file.exists():
            raise Code.JOB_EXISTS.refusal(
                f"{str(new_file)!r} is there already",
                hint="name another folder with --folder, or another part with --name",
                place=Place(str(new_file)),
                values={"file": str(new_file)},
            )
    inputs = [one.program for one in (wanted, *wanted.then)] + ([] if wanted.drawing is None else [wanted.drawing])
    files = write_all(wanted.folder, [(name, text.encode()) for name, text in contents.items()], inputs)
    return NewFiles(tuple(files), places, profile.names, drawn.notes)


def _drawn(wanted: Wanted, program: Program) -> PartDrawing:
    """The part as it is drawn, or as the program's finish pass has it."""
    if wanted.drawing is not None:
        return read_drawing(wanted.drawing, wanted.side, chosen=wanted.chosen)
    with in_file(wanted.program):
        contour = wanted.run.contour(program, wanted.nose_radius_mm, wanted.side)
    return PartDrawing(contour.profile, tuple(contour.notes))


def _to_fill_in(wanted: Wanted, profile: Profile, inch: bool) -> tuple[dict[str, str], int]:
    """The file to be filled in, of gauges with the sheet, by name, and how many places they have."""
    if wanted.measured_file is not None:
        return {}, 0
    if wanted.measured == "points":
        return _touches(wanted, profile, inch)
    sheet = GaugeSheet(wanted.name, profile, gauge_plan(profile), inch)
    return {"readings.csv": sheet.csv, "sheet.html": sheet.page}, len(sheet.planned)


def _touches(wanted: Wanted, profile: Profile, inch: bool) -> tuple[dict[str, str], int]:
    """Returns the file and count of points that a probe or a measuring machine touches."""
    points = _points(profile, wanted.nose_radius_mm)
    features = [profile.names[i] for i in points.feature_index]
    return {"touches.csv": empty_touches_csv(features, points.nominal_mm, "inch" if inch else "mm")}, len(features)


def _points(profile: Profile, nose_radius_mm: float) -> GaugingPoints:
    """One on a face, two on other lines, some on arcs; on what the nose reaches, where there is room."""
    reachable = nose_centre_path(profile, nose_radius_mm).reachable_mm
    spacings = {}
    for feature, (low, high) in zip(profile.features, reachable, strict=True):
        room, margin = float(high - low), min(MARGIN_MM, 0.2 * float(high - low))
        if room > 0:
            curved = min(MOST, max(FEWEST, math.ceil(room / APART_MM)))
            count = curved if is_curved(feature) else 2 if room > 2 * MARGIN_MM else 1
            spacings[feature.name] = Spacing(count, margin, margin)
    return equally_spaced(profile, spacings, reachable)


def _job_toml(wanted: Wanted, dialects: Sequence[str], drawn: PartDrawing, file: str) -> str:
    """Returns the job as TOML, its paths relative to it. A profile without a drawing is spelled out."""
    cuts = [*zip((wanted, *wanted.then), dialects, strict=True)]
    tables = _setups(cuts, wanted.folder) if wanted.then else _of_one(*cuts[0], wanted.folder)
    gauging = toml_keys({"readings" if wanted.measured == "gauge" else "touches": file})
    lines = [*_part(wanted, drawn), *tables, "[gauging]", *gauging, "", "[output]", 'folder = "out"', ""]
    for table, keys in wanted.stated.items():
        if f"[{table}]" not in lines:
            lines += [f"[{table}]", *toml_keys(keys), ""]
        else:
            at = lines.index(f"[{table}]") + 1
            lines[at:at] = toml_keys(keys)
    return "\n".join(lines)


def _of_one(of: WantedProgram, dialect: str, folder: Path) -> Iterator[str]:
    for tool in of.all_tools:
        yield from _tool("[tool]" if len(of.all_tools) == 1 else "[[tools]]", tool)
    yield from _program("[programs]", of, dialect, folder)


def _setups(cuts: Iterable[tuple[WantedProgram, str]], folder: Path) -> Iterator[str]:
    for k, (of, dialect) in enumerate(cuts, 1):
        keys = {"name": f"side{k}", "zero_at_z_mm": of.zero_at_z_mm, "flipped": of.flipped or None}
        yield from ("[[setups]]", *toml_keys(keys), "")
        yield from _program("[setups.programs]", of, dialect, folder)
        for tool in of.all_tools:
            yield from _tool("[[setups.tools]]", tool)


def _part(wanted: Wanted, drawn: PartDrawing) -> list[str]:
    if wanted.drawing is None:
        spelled = part_table_toml(wanted.name, drawn.profile, drawn.notes)
    else:
        key, side = drawing_key(wanted.drawing), side_key(drawn.profile)
        keys = {"name": wanted.name, key: _path(wanted.drawing, wanted.folder), **wanted.chosen.keys(key), "side": side}
        notes = (*drawn.notes, f"Its features, in order: {', '.join(drawn.profile.names)}.")
        spelled = "\n".join([*(f"# {' '.join(note.split())}" for note in notes), "[part]", *toml_keys(keys), ""])
    return (spelled + characteristics_toml(drawn.asked)).split("\n")


def _path(file: Path, folder: Path) -> str:
    return Path(relpath(file, folder)).as_posix()


def _tool(heading: str, of: NewTool) -> list[str]:
    keys = {"nose_radius_mm": of.nose_radius_mm, "number": of.number, "tip": of.tip, "name": of.name or None}
    return [heading, *toml_keys(keys), ""]


def _program(heading: str, of: WantedProgram, dialect: str, folder: Path) -> list[str]:
    keys = {
        **of.cut,
        "dialect": dialect,
        "finish": _path(of.program, folder),
        "finish_lines": of.lines,
        "unit": of.unit,
        "accept_unknown_words": of.accept_unknown_words or None,
        "parameters": of.parameters or None,
    }
    return [heading, *toml_keys(keys), ""]


@dataclass(frozen=True)
class GaugeSheet:
    """The measurements wanted of a part, in order along the profile; `inch`: lengths are written in inches."""

    part: str
    profile: Profile
    planned: tuple[Characteristic, ...]
    inch: bool
    files: tuple[Path, ...] = ()

    @property
    def csv(self) -> str:
        """Returns the file to fill in, which a job names under `gauging.readings`."""
        return self.filled_in({}, {})

    def filled_in(self, values: Mapping[str, Sequence[str]], stated: Mapping[str, str]) -> str:
        """Returns that file with values by size, and what is stated for all. Raises MSR-FEATURE: no such size."""
        names = [characteristic.name for characteristic in self.planned]
        other = next((name for name in values if name not in names), None)
        if other is not None:
            raise Code.MSR_FEATURE.refusal(
                wording("the sheet has no size {name!r}", name=other),
                hint=wording("its sizes are: {sizes}", sizes=", ".join(names)),
                values={"feature": other},
            )
        return gauge_sheet_csv(self.planned, "inch" if self.inch else "mm", values, stated)

    @property
    def page(self) -> str:
        """Returns the page to print."""
        return touch_sheet(self.part, self.profile, self.planned, self.inch)


def gauge_sheet_of(path: Path) -> GaugeSheet:
    """Makes the sheet of the drawing's and further sizes, in the first program's unit. Raises JOB, GEO, TOL, NC."""
    files = JobFiles.of(path)
    first, *_ = of_setups = files.of_setups
    programs = [setup.finish_program() for setup in of_setups]
    profile = files.profile(programs[0])
    planned = gauge_plan(profile, characteristics_of(files.located, profile))
    inch = unit_of_path(programs[0].unit, first.run.of(programs[0]))["unit"] == "inch"
    return GaugeSheet(files.job.part.name, profile, planned, inch, (path, *files.sources.files))


def write_sheet(sheet: GaugeSheet, target: Path) -> Path:
    """Writes the sheet as a page (.html), on paper (.pdf, by a browser), or to be filled in. Raises OUT errors, also
    where it would be written over one that was filled in.
    """
    ending = target.suffix.lower()
    page, pdf = ending in (".html", ".htm", ".pdf"), ending == ".pdf"
    content = sheet.page if page else sheet.csv
    inputs = sheet.files if page or not holds_readings(target) else (*sheet.files, target)
    (written,) = write_all(target.parent, [(target.name, as_pdf(content) if pdf else content.encode())], inputs)
    return written
