"""The probing program of a milled part's job, and the names by which the job reads its results."""

from dataclasses import replace
from pathlib import Path
from typing import Final

from trueloop.controllers.probing.inspection_plus import MacroProbe, ProbeProgram, inspection_plus_program
from trueloop.errors import Code, in_file
from trueloop.formats.jobs.milled_job import read_milled_job
from trueloop.formats.jobs.profile_of_job import quoted
from trueloop.formats.outputs import write_all
from trueloop.jobs.milled_features import cut_features

CONTROLS: Final = ("fanuc-mill", "haas-mill")
"""Controls whose probing macros are written."""


def write_probing_program(path: Path, output: Path, probe: MacroProbe) -> tuple[ProbeProgram, Path]:
    """Writes the program that measures a job's features; returns it and its file. Raises JOB, MIL and NC errors."""
    job = read_milled_job(path)
    with in_file(path):
        cut = cut_features(path, job)
        if cut.dialect not in ("", *CONTROLS):
            raise Code.MIL_PROBE.refusal(
                f"no probing program is written for {cut.dialect}",
                hint=f"it is written for {' and '.join(CONTROLS)} with Renishaw's Inspection Plus",
            )
        made = inspection_plus_program(job.name, tuple(cut.features.values()), replace(probe, inch=job.unit == "inch"))
    inputs = [path, *([] if job.program is None else [path.parent / job.program.file])]
    [file] = write_all(output.parent, [(output.name, made.text.encode("ascii"))], inputs)
    return made, file


def names_table(made: ProbeProgram) -> str:
    """Returns the table by which a job reads the print-out: features by their numbers."""
    return "\n".join(["[names]", *(f'"{n}" = {quoted(one.name)}' for n, one in enumerate(made.measured, 1))])
