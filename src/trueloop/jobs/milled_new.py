"""A new job of a milled part: features that its program shows, checked as the job's own reading finds them again.

The probing program of a milled part's job, and the names by which the job reads its results.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os.path import relpath
from pathlib import Path
from typing import Final

from trueloop.controllers.probing.inspection_plus import MacroProbe, ProbeProgram, inspection_plus_program
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.jobs.job import ProgramTable
from trueloop.formats.jobs.milled_job import MilledProgramTable, read_milled_job
from trueloop.formats.jobs.profile_of_job import quoted
from trueloop.formats.outputs import write_all
from trueloop.jobs.milled_features import cut_features, program_passes
from trueloop.milled.cut_by import CutBy, StatedCut
from trueloop.milled.feature import PAIRS, MilledFeature
from trueloop.milled.proposed import proposed_features
from trueloop.units import MM_PER_INCH


@dataclass(frozen=True)
class ProposedJob:
    """A job that was written, its features with what cuts them, and notes on what the program leaves open."""

    file: Path
    features: tuple[MilledFeature, ...]
    notes: tuple[str, ...]


def new_milled_job(
    program: Path,
    output: Path,
    *,
    reading: Mapping[str, object],
    name: str,
    measured: Path,
    radius_mm: Mapping[int, float],
    wear: bool = False,
) -> ProposedJob:
    """Writes a job with the features of a program, and returns it. `reading`: keys of its table [program].

    Raises NC errors, JOB-EXISTS where the file is there already, MIL-NOT-CUT where the program shows no feature.
    """
    if output.exists():
        raise Code.JOB_EXISTS.refusal(
            f"{str(output)!r} is there already",
            hint="name another file with --output",
            place=Place(str(output)),
            values={"file": str(output)},
        )
    passes, dialect = program_passes(program, ProgramTable.model_validate(dict(reading)))
    proposed, notes = proposed_features(passes, radius_mm, wear)
    found = list[MilledFeature]()
    for one in proposed:
        try:
            [(cut, _)] = CutBy(passes, dialect, radius_mm).resolved([(one, StatedCut())])
            found.append(cut)
        except TrueloopError as refusal:
            notes.append(f"{one.name} left out: {refusal.message}; {refusal.hint}")
    if not found:
        raise Code.MIL_NOT_CUT.refusal(
            f"{program.name!r} shows no feature" + "".join(f"; {note}" for note in notes[:5]),
            hint="features are full circles, drilled holes, parallel walls of contours under G41 and G42, and levels; "
            "state the radii of cutters: --tool 2=R5",
            place=Place(str(program)),
            values={"feature": ""},
        )
    with in_file(program):
        found = [cut for cut, _ in CutBy(passes, dialect, radius_mm).resolved([(one, StatedCut()) for one in found])]
    inch = bool(passes.path.inch[-1])
    scale = 1.0 / MM_PER_INCH if inch else 1.0
    own = MilledProgramTable.model_validate(
        {**reading, "dialect": dialect, "file": Path(relpath(program, output.parent))}
    )
    lines = [
        "# Features as the program cuts them: name them as the measurement does, give the drawing's sizes.",
        f"name = {quoted(name)}",
        f'unit = "{"inch" if inch else "mm"}"',
        "",
        *(line for one in found for line in _feature_lines(one, scale)),
        "[program]",
        f"file = {quoted(own.file.as_posix())}",
        f"dialect = {quoted(dialect)}",
        *([f'unit = "{own.unit}"'] if own.unit else []),
        *(
            [f"parameters = {{ {', '.join(f'{quoted(key)} = {value!r}' for key, value in own.parameters.items())} }}"]
            if own.parameters
            else []
        ),
        *(["accept_unknown_words = true"] if own.accept_unknown_words else []),
        "",
        *_tool_lines(found, {tool: scale * radius for tool, radius in radius_mm.items()}),
        "[[measured]]",
        f"file = {quoted(Path(relpath(measured, output.parent)).as_posix())}",
        "",
    ]
    [file] = write_all(output.parent, [(output.name, "\n".join(lines).encode())], [program])
    return ProposedJob(file, tuple(found), tuple(notes))


def _feature_lines(one: MilledFeature, scale: float) -> list[str]:
    lines = ["[[feature]]", f"name = {quoted(one.name)}", f'kind = "{one.kind}"', f"at = {_list(one.place_mm, scale)}"]
    if one.kind != "face":
        lines += [f"size = {round(scale * one.size_mm, 6)}", f"depth = {round(scale * one.depth_mm, 6)}"]
    if one.kind in PAIRS:
        lines += [f"direction = {_list(one.direction, 1.0)}"]
    register = "its radius at the control" if one.radius_at_control else "its radius in the path"
    return [*lines, f"# tool {one.tool}, {register}, {one.work_offset}{one.side and f', {one.side}'}", ""]


def _tool_lines(features: Sequence[MilledFeature], radius: Mapping[int, float]) -> list[str]:
    used = sorted({one.tool for one in features} & set(radius))
    return [
        line
        for tool in used
        for line in ("[[tool]]", f"number = {tool}", f"cutter_radius = {round(radius[tool], 6)}", "")
    ]


def _list(values: Sequence[float], scale: float) -> str:
    return f"[{', '.join(str(round(scale * value, 6) + 0.0) for value in values)}]"


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
