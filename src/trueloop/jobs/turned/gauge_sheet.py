"""The sheet of what a person measures of a job's part, for paper and as the file to fill in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from trueloop.domain.characteristic import Characteristic
from trueloop.errors import Code
from trueloop.formats.inspections.gauge_csv import gauge_sheet_csv
from trueloop.formats.outputs import write_all
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.nc.program.unit import unit_of_path
from trueloop.report.pdf import as_pdf
from trueloop.report.turned.touch_sheet import touch_sheet
from trueloop.turned.readings.plan import gauge_plan


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
        """Returns that file with values by the names of sizes, and what is stated for all of them.

        Raises MSR-FEATURE for a name that is none of a size of the sheet.
        """
        names = [one.name for one in self.planned]
        other = next((name for name in values if name not in names), None)
        if other is not None:
            raise Code.MSR_FEATURE.refusal(
                f"the sheet has no size {other!r}",
                hint=f"its sizes are: {', '.join(names)}",
                values={"feature": other},
            )
        return gauge_sheet_csv(self.planned, "inch" if self.inch else "mm", values, stated)

    @property
    def page(self) -> str:
        """Returns the page to print."""
        return touch_sheet(self.part, self.profile, self.planned, self.inch)


def gauge_sheet_of(path: Path) -> GaugeSheet:
    """Makes the sheet: what the job's drawing requests, and further diameters and lengths, in the first program's unit.

    Raises JOB, GEO, TOL and NC errors.
    """
    files = JobFiles.of(path)
    first, *_ = of_setups = files.of_setups
    programs = [one.finish_program() for one in of_setups]
    profile = files.profile(programs[0])
    planned = gauge_plan(profile, characteristics_of(files.located, profile))
    inch = unit_of_path(programs[0].unit, first.run.of(programs[0]))["unit"] == "inch"
    return GaugeSheet(files.job.part.name, profile, planned, inch, (path, *files.sources.files))


def write_sheet(sheet: GaugeSheet, target: Path) -> Path:
    """Writes the sheet as a page (.html), as that on paper (.pdf, by a browser), or as the file to fill in.

    Raises OUT errors; the files that it was made from are never written over.
    """
    ending = target.suffix.lower()
    content = sheet.page if ending in (".html", ".htm", ".pdf") else sheet.csv
    pdf = ending == ".pdf"
    (written,) = write_all(target.parent, [(target.name, as_pdf(content) if pdf else content.encode())], sheet.files)
    return written
