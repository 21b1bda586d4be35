"""A turned part's job and the files it names, each read when asked for; whatever is refused names its file."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from trueloop.domain.option import Language, LengthUnit, PageOptions
from trueloop.domain.record import check_uncorrected
from trueloop.errors import Code, Place, in_file
from trueloop.formats.called_files import with_called
from trueloop.formats.input_file import FilePath, read_input
from trueloop.formats.jobs.job import Job, locate_turned_job
from trueloop.formats.jobs.profile_of_job import junctions_by_design, profile_of_table
from trueloop.formats.jobs.tool_tables import CutByTable, SetupTable, ToolsTable
from trueloop.formats.jobs.tool_tables import ToolTable as TableOfTool
from trueloop.formats.tables.tool_tables.known import nose_radius_mm, read_tool_table
from trueloop.formats.tables.tool_tables.tool_table import ToolTable
from trueloop.formats.toml_tables import Located, options_from
from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import Profile, Side
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.turned.readings import Sources
from trueloop.jobs.user import user_name
from trueloop.loops.turned.commanded import Run
from trueloop.nc.match.cutters import CuttingEdge
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.understood import require_understood
from trueloop.units import MM_PER_INCH
from trueloop.wording import wording

PROGRAM_HINT: Final = "the job's table [programs] or [setups.programs] names it, relative to the job file"


@dataclass(frozen=True)
class JobFiles:
    """A job, where it was read from, and the files read for it so far."""

    path: Path
    sources: Sources
    located: Located[Job]
    setup: str = ""
    """Name of the set-up that this is of, where the job has several."""
    work_zero_mm: tuple[float, float, float] | None = None
    """Machine coordinates of that set-up's zero, where the job has a table [machine]."""
    made_by: str = field(default_factory=user_name)
    """Who corrects by the job."""

    @property
    def job(self) -> Job:
        """Returns the job."""
        return self.located.model

    @classmethod
    def of(cls, path: Path) -> "JobFiles":
        """Reads the job alone. Raises JOB errors."""
        sources = Sources(path.parent)
        return cls(path, sources, locate_turned_job(sources.file(path.name)))

    def with_serial(self, serial: str | None) -> "JobFiles":
        """Returns the files of the job with another serial number of the part; None: the job's."""
        if serial is None:
            return self
        job = self.job
        part = job.part.model_copy(update={"serial": serial})
        return replace(self, located=replace(self.located, model=job.model_copy(update={"part": part})))

    def with_output(self, folder: FilePath | None) -> "JobFiles":
        """Returns the files of the job with another folder of the outputs, as seen from here; None: the job's."""
        if folder is None:
            return self
        output = self.job.output.model_copy(update={"folder": Path(folder).resolve()})
        return replace(self, located=replace(self.located, model=self.job.model_copy(update={"output": output})))

    @property
    def output_folder(self) -> Path:
        """Returns the folder of the outputs."""
        return self.path.parent / self.job.output.folder

    def page_options(self, language: Language | None = None, unit: LengthUnit | None = None) -> PageOptions:
        """Returns language and unit of the pages: those requested, else the job's."""
        given = options_from(PageOptions, self.job)
        return PageOptions(language or given.language, unit or given.unit)

    @property
    def tool(self) -> TableOfTool:
        """Returns the finishing tool. Raises JOB-TOOLS for a job of several, JOB-SETUPS for one of several set-ups."""
        with in_file(self.path):
            self.job.require_one_setup()
        if self.job.tool is None:
            called = [tool.called.words for tool in self.job.tools]
            raise Code.JOB_TOOLS.refusal(
                f"the job has {len(called)} tools ({', '.join(called)}): this is done for one tool alone",
                hint="`trueloop compensate` (in Python `compensate_part`) and `trueloop nc features` take several; "
                "else give one table [tool]",
                place=Place(str(self.path)),
                values={"tools": called},
            )
        return self.job.tool

    def with_tool(self, tool: ToolsTable) -> "JobFiles":
        """Returns the job as if that were its only tool."""
        between = ("cut_to_cut_um", "cut_to_cut_along_um")
        own = {key: getattr(tool, key) for key in between if getattr(tool, key) is not None}
        compensation = self.job.compensation.model_copy(update=own)
        job = self.job.model_copy(update={"tool": tool, "tools": (), "compensation": compensation})
        return replace(self, located=replace(self.located, model=job))

    def with_setup(self, setup: SetupTable) -> "JobFiles":
        """Returns the job as if that were its only set-up, profile and measurements still in the part's frame."""
        decided = {name: cut for name, cut in self.job.feature.items() if _is_of(setup, cut)}
        gauging = self.job.gauging.model_copy(update={"program_sha256": setup.program_sha256})
        own = {"programs": setup.programs, "tools": setup.tools, "setups": (), "feature": decided, "gauging": gauging}
        located = replace(self.located, model=self.job.model_copy(update=own))
        return replace(self, located=located, setup=setup.name, work_zero_mm=setup.work_zero_mm)

    @property
    def of_setups(self) -> tuple["JobFiles", ...]:
        """Returns the job by set-up, as if that were its only one; itself where it has none."""
        return tuple(self.with_setup(table) for table in self.job.setups) or (self,)

    @property
    def frames(self) -> tuple[SetupFrame, ...]:
        """Returns the frames of the job's set-ups. Raises SET-DATUM for one that does not state where its zero is."""
        frames = []
        for k, setup in enumerate(self.job.setups):
            if setup.zero_at_z_mm is None:
                with self.located.at("setups", k):
                    raise Code.SET_DATUM.refusal(
                        wording(
                            "set-up '{setup}' does not say where its program's Z is 0 on the part", setup=setup.name
                        ),
                        hint="write `zero_at_z_mm` into the set-up's table [[setups]]: z of the part's frame, in mm, "
                        "at which this program's Z is 0; for one whose zero is the end face at z = −80, "
                        "zero_at_z_mm = -80.0",
                        values={"setup": setup.name},
                    )
            frames.append(SetupFrame(setup.name, setup.zero_at_z_mm, setup.flipped, setup.mirrored_z))
        return tuple(frames)

    @property
    def edges(self) -> tuple[CuttingEdge, ...]:
        """Returns the several edges of the job, each with its nose. Raises OFS errors."""
        return tuple(
            CuttingEdge(tool.called, self.with_tool(tool).nose_radius_mm, tool.groove_corner, tool.name, tool.tip or 0)
            for tool in self.job.tools
        )

    def other(self, name: Path) -> "JobFiles":
        """Returns another part's job that this one names; its files are noted with this one's."""
        file = self.sources.file(name)
        return JobFiles(file, self.sources.beside(name), locate_turned_job(file))

    @property
    def nose_radius_mm(self) -> float:
        """Returns the nose radius of the finishing tool, mm."""
        tool = self.tool
        stated_mm = tool.nose_radius_mm if tool.nose_radius_in is None else tool.nose_radius_in * MM_PER_INCH
        if tool.table is None:
            assert stated_mm is not None
            return stated_mm
        assert tool.number is not None
        return nose_radius_mm(
            self.tool_table(tool.table), tool.number, tool.table_edge or 1, tool.table_name, stated_mm
        )

    def tool_table(self, name: Path) -> ToolTable:
        """Reads the control's tool table that the job names. Raises OFS errors."""
        return read_tool_table(self.sources.file(name), self.tool.table_unit)

    @property
    def run(self) -> Run:
        """Returns how the programs are run."""
        given = self.job.own_programs
        tool = self.job.tool
        lines = tool.finish_lines if isinstance(tool, ToolsTable) else None
        tip = None if tool is None else tool.tip
        return Run(given.parameters, given.execute_deleted_blocks, lines or given.finish_lines, tip=tip)

    def require_uncorrected(self) -> None:
        """Raises CMP-TWICE for a finish program that is corrected already."""
        finish = self.path.parent / self.job.own_programs.finish
        source = read_input(finish, Code.NC_FILE, hint=PROGRAM_HINT)
        with in_file(finish):
            check_uncorrected(source)

    def finish_program(self) -> Program:
        """Reads the finish program. Raises NC errors."""
        return self.program(self.job.own_programs.finish)

    def program(self, name: Path) -> Program:
        """Reads a program that the job names. Raises NC errors."""
        file, given = self.sources.file(name), self.job.own_programs
        source = read_input(file, Code.NC_FILE, hint=PROGRAM_HINT)
        if given.folder is not None:
            source, _ = self._with_called(source, given.folder)
        with in_file(self.path):
            program = read_program(source, given.dialect, str(file), given.unit, given.decimals)
            if not given.accept_unknown_words:
                require_understood(program)
            return program

    def _with_called(self, source: bytes, folder: Path) -> tuple[bytes, tuple[tuple[str, int], ...]]:
        """A program with those of the folder that it calls."""

        def read(path: Path) -> bytes:
            return read_input(self.sources.file(folder / path.name), Code.NC_FILE, hint=PROGRAM_HINT)

        with in_file(self.path):
            return with_called(source, self.job.own_programs.dialect, self.path.parent / folder, read)

    @property
    def called_notes(self) -> tuple[str, ...]:
        """Makes a note on subprograms that come from files of their own, with the lines at which they stand."""
        given = self.job.own_programs
        if given.folder is None:
            return ()
        finish = read_input(self.sources.file(given.finish), Code.NC_FILE, hint=PROGRAM_HINT)
        _, called = self._with_called(finish, given.folder)
        if not called:
            return ()
        return (
            wording(
                "Called programs are read from {folder} behind the finish program: {programs}. The corrected program "
                "holds them, too, in place of their files: other programs that call them are corrected with it.",
                folder=given.folder.as_posix(),
                programs=", ".join(f"{name} (from line {line})" for name, line in called),
            ),
        )

    def profile(self, finish: Program | None = None) -> Profile:
        """Returns the nominal profile; `finish`: the finish program, if read already. Raises GEO and NC errors."""
        features = self._features(finish)
        with in_file(self.path):
            if features is None:
                return profile_of_table(self.job.part)
            return checked_profile(
                features, junctions_by_design(self.job.part.junctions), side=Side(self.job.part.side)
            )

    def _features(self, finish: Program | None) -> Sequence[Feature] | None:
        """From the file that the job names; None where the job's own table spells them out."""
        part = self.job.part
        if part.from_program:
            programs = self.job.own_programs
            run = Run(
                programs.parameters,
                programs.execute_deleted_blocks,
                tip=self.tool.tip,
                accept_unknown_words=programs.accept_unknown_words,
            )
            side = Side(part.side)
            return run.contour(finish or self.finish_program(), self.nose_radius_mm, side).profile.features
        if part.dxf is not None:
            # ezdxf takes long to import, and most jobs have no drawing.
            from trueloop.formats.cad.dxf import read_dxf

            unit, file = part.unit if "unit" in part.model_fields_set else None, self.sources.file(part.dxf)
            return read_dxf(
                file,
                layer=part.dxf_layer,
                unit=unit,
                x_is=part.x_is,
                side=Side(part.side),
                outline=part.dxf_outline,
                zero=part.dxf_zero,
            ).features
        if part.step is not None:
            from trueloop.formats.cad.step_profile import read_step_profile  # slow to import

            turned, low_mm, high_mm = part.step_turned_round, part.step_from_z_mm, part.step_to_z_mm
            file = self.sources.file(part.step)
            return read_step_profile(
                file,
                side=Side(part.side),
                outline=part.step_outline,
                turned_round=turned,
                from_z_mm=low_mm,
                to_z_mm=high_mm,
            ).features
        return None


def _is_of(setup: SetupTable, cut: CutByTable) -> bool:
    """Returns True where the decision on a feature belongs to a set-up and one of its tools."""
    return cut.setup in (None, setup.name) and cut.called in [None, *(tool.called for tool in setup.tools)]
