"""A new job of a milled part: features that its program shows, checked as the job's own reading finds them again.

The probing program of a milled part's job, and the names by which the job reads its results.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from os.path import relpath
from pathlib import Path
from typing import Final, Literal

from trueloop.controllers.probing.inspection_plus import MacroProbe, ProbeProgram, inspection_plus_program
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_input
from trueloop.formats.jobs.job import ProgramTable
from trueloop.formats.jobs.milled_job import (
    MilledFeatureTable,
    MilledJobFile,
    MilledProgramTable,
    MillToolTable,
    read_milled_job,
)
from trueloop.formats.outputs import write_all
from trueloop.formats.toml_tables import toml_keys
from trueloop.milled.cut_by import CutBy, StatedCut
from trueloop.milled.feature import PAIRS, MilledFeature
from trueloop.milled.passes import Passes
from trueloop.milled.proposed import proposed_features
from trueloop.nc.program.guess import guess_dialect
from trueloop.nc.program.program import read_program
from trueloop.nc.program.understood import require_known_frame, require_sound, require_understood, require_unit
from trueloop.units import MM_PER_INCH
from trueloop.wording import wording

REGISTER_OF: Final[Mapping[str, Literal["radius", "diameter"]]] = {"linuxcnc": "diameter", "heidenhain": "radius"}
"""The quantity that a register of the cutter holds, where all controls of a dialect hold one and the same."""


@dataclass(frozen=True)
class CutFeatures:
    """Features by name, and of tools by their numbers: which registers of the control hold diameters, the words for the
    registers of radius and length that the program calls, the radius of the tightest inside corner that is cut under
    compensation, and the cutter's own; mm.

    `lines`: that of each feature's last pass. `stated`: features that the program does not cut, as the job states them.
    `dialect`: the program's, empty without one. `inch`: its unit at its end, None without one.
    """

    features: dict[str, MilledFeature]
    diameters: frozenset[str]
    radius_words: dict[str, str] = field(default_factory=dict)
    length_words: dict[str, str] = field(default_factory=dict)
    corner_mm: dict[str, float] = field(default_factory=dict)
    cutter_mm: dict[str, float] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)
    stated: tuple[str, ...] = ()
    dialect: str = ""
    inch: bool | None = None

    def require_room(self, tool: str, total_mm: float) -> None:
        """Raises MIL-CORNER: a radius larger by `total_mm` does not fit an inside corner; controls stop or gouge."""
        corner, cutter = self.corner_mm.get(tool), self.cutter_mm.get(tool)
        if corner is None or total_mm <= 0.0:
            return
        room = 0.0 if cutter is None else corner - cutter if corner >= cutter - 1e-6 else corner
        if total_mm > room:
            own = "of a radius that is not stated" if cutter is None else f"of radius {cutter:g} mm"
            asked = "" if cutter is not None else f"state `cutter_radius` of tool {tool} in its [[tool]], or "
            raise Code.MIL_CORNER.refusal(
                wording(
                    "tool {tool}, {own}, would be entered {total_mm:+.3f} mm larger, and its contour has an inside "
                    "corner of radius {corner:g} mm, into which it would not fit",
                    tool=tool,
                    own=own,
                    total_mm=total_mm,
                    corner=corner,
                ),
                hint=f"{asked}give the pocket a larger corner radius or a smaller tool",
                values={"tool": tool, "corner_mm": corner},
            )


def cut_features(path: Path, job: MilledJobFile) -> CutFeatures:
    """Returns a job's features with what cuts them. Raises NC errors of the program, and MIL errors."""
    scale = MM_PER_INCH if job.unit == "inch" else 1.0
    tools = {one.number: one for one in job.tool}
    if job.program is None:
        features = [_feature(one, scale, tools.get(one.tool or 0)) for one in job.feature]
        diameters = frozenset(str(one.number) for one in job.tool if one.register_is == "diameter")
        return CutFeatures({feature.name: feature for feature in features}, diameters)
    file = path.parent / job.program.file
    passes, dialect = program_passes(file, job.program)
    cutters = {one.number: scale * one.cutter_radius for one in job.tool if one.cutter_radius is not None}
    by = CutBy(passes, dialect, cutters)
    asked = [
        (_feature(one, scale, tools.get(one.tool or 0)), StatedCut(one.tool, one.work_offset, one.side or None))
        for one in job.feature
    ]
    with in_file(file):
        found = by.resolved(asked)
        used = {feature.tool for feature, line in found if line is not None}
        registers = {str(tool): by.registers(tool) for tool in sorted(used)}
    apart = [table for table, (_, line) in zip(job.feature, found, strict=True) if line is None]
    for table in apart:
        _require_stated(table, tools.get(table.tool or 0), file)
    for tool in used:
        own = {feature.radius_at_control for feature, line in found if line is not None and feature.tool == tool}
        of_program = tool not in {table.tool for table in apart}  # else the key is about what this program does not cut
        _require_register(tools.get(tool), dialect, own if of_program else {True, False})
    stated = {tool: one.register_is for tool, one in tools.items() if one.register_is is not None}
    register_is = {tool: stated.get(tool, REGISTER_OF.get(dialect, "radius")) for tool in {*used, *tools}}
    corners = {str(tool): passes.tightest_corner_mm(tool) for tool in used}
    return CutFeatures(
        features={feature.name: feature for feature, _ in found},
        diameters=frozenset(str(tool) for tool, holds in register_is.items() if holds == "diameter"),
        radius_words={tool: _words("D", one.radius, dialect) for tool, one in registers.items()},
        length_words={tool: _words("H", one.length, dialect) for tool, one in registers.items()},
        corner_mm={tool: corner for tool, corner in corners.items() if corner is not None},
        cutter_mm={str(tool): radius for tool, radius in by.radius_mm.items()},
        lines={feature.name: line for feature, line in found if line is not None},
        stated=tuple(feature.name for feature, line in found if line is None),
        dialect=dialect,
        inch=bool(passes.path.inch[-1]) if len(passes.path) else None,
    )


def program_passes(file: Path, table: ProgramTable) -> tuple[Passes, str]:
    """Returns the passes of a program and its dialect. Raises NC errors where the machine may go elsewhere."""
    source = read_input(file, Code.NC_FILE, hint="program.file names the finishing program")
    dialect = table.dialect or guess_dialect(source, str(file), 'program.dialect = "{}"')
    program = read_program(source, dialect, str(file), table.unit)
    with in_file(file):
        if not table.accept_unknown_words:
            require_understood(program, "program.accept_unknown_words")
        path = program.run(table.parameters)
        require_unit(path)
        require_sound(path)
        require_known_frame(path)
    return Passes(program, path), dialect


def _feature(table: MilledFeatureTable, scale: float, tool: MillToolTable | None) -> MilledFeature:
    x, y, z = (scale * value for value in table.at)
    length = math.hypot(*table.direction)
    i, j, k = (value / length for value in table.direction)
    return MilledFeature(
        name=table.name,
        kind=table.kind,
        place_mm=(x, y, z),
        tool=table.tool or 0,
        work_offset=table.work_offset or "G54",
        size_mm=scale * table.size,
        direction=(i, j, k),
        depth_mm=scale * table.depth,
        side=table.side,
        radius_at_control=tool is not None and tool.radius == "control",
    )


def _require_stated(table: MilledFeatureTable, tool: MillToolTable | None, program: Path) -> None:
    """Raises MIL-NOT-CUT where the program does not cut a feature, and the job does not state all that cuts it."""
    missing = [] if table.work_offset else ["`work_offset` in its table [[feature]]"]
    if tool is None or tool.radius is None:
        missing.append(f"`radius` of tool {table.tool} in its table [[tool]]")
    if missing:
        raise Code.MIL_NOT_CUT.refusal(
            f"no pass of {program.name!r} cuts {table.name}, and the job states tool {table.tool} of it without "
            + " and ".join(missing),
            hint=f"state {' and '.join(missing)}, or correct the feature's place and size",
            values={"feature": table.name},
        )


def _require_register(table: MillToolTable | None, dialect: str, compensated: set[bool]) -> None:
    """Raises MIL-STATED where a [[tool]] is not as the program runs it on any feature, or as its control holds it."""
    if table is None:
        return
    program = {"control" if one else "program" for one in compensated}
    held = REGISTER_OF.get(dialect)
    for key, stated, known in (
        ("radius", table.radius, program),
        ("register_is", table.register_is, set() if held is None else {held}),
    ):
        if stated is not None and known and stated not in known:
            [only] = known
            raise Code.MIL_STATED.refusal(
                f"`{key}` of tool {table.number} is {stated!r}, and by its {dialect} program it is {only!r}",
                hint=f"leave `{key}` out",
                values={"stated": stated, "program": only},
            )


def _words(letter: str, numbers: tuple[int, ...], dialect: str) -> str:
    """Returns the names of registers, such as `D12`; of a Sinumerik, whose T and D stand in one number, of the edge."""
    if dialect == "heidenhain" or not numbers:
        return ""
    if dialect == "siemens":
        return ", ".join(f"D{number % 1000}" for number in numbers)
    return ", ".join(f"{letter}{number}" for number in numbers)


@dataclass(frozen=True)
class ProposedJob:
    """A written job, its features with what cuts them, and notes; `dialect` and unit (`inch`) are the program's."""

    file: Path
    features: tuple[MilledFeature, ...]
    notes: tuple[str, ...]
    dialect: str
    inch: bool


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
    for feature in proposed:
        try:
            [(cut, _)] = CutBy(passes, dialect, radius_mm).resolved([(feature, StatedCut())])
            found.append(cut)
        except TrueloopError as refusal:
            notes.append(f"{feature.name} left out: {refusal.message}; {refusal.hint}")
    if not found:
        raise Code.MIL_NOT_CUT.refusal(
            f"{program.name!r} shows no feature" + "".join(f"; {note}" for note in notes[:5]),
            hint="features are full circles, drilled holes, parallel walls of contours under G41 and G42, and levels; "
            "state the radii of cutters: --tool 2=R5",
            place=Place(str(program)),
            values={"feature": ""},
        )
    with in_file(program):
        found = [
            cut for cut, _ in CutBy(passes, dialect, radius_mm).resolved([(feature, StatedCut()) for feature in found])
        ]
    inch = bool(passes.path.inch[-1])
    scale = 1.0 / MM_PER_INCH if inch else 1.0
    own = MilledProgramTable.model_validate(
        {**reading, "dialect": dialect, "file": Path(relpath(program, output.parent))}
    )
    lines = [
        "# Features as the program cuts them: name them as the measurement does, give the drawing's sizes.",
        *toml_keys({"name": name, "unit": "inch" if inch else "mm"}),
        "",
        *(line for feature in found for line in _feature_lines(feature, scale)),
        "[program]",
        *toml_keys({"file": own.file.as_posix(), "dialect": dialect, "unit": own.unit}),
        *toml_keys({"parameters": own.parameters or None, "accept_unknown_words": own.accept_unknown_words or None}),
        "",
        *_tool_lines(found, {tool: scale * radius for tool, radius in radius_mm.items()}),
        "[[measured]]",
        *toml_keys({"file": Path(relpath(measured, output.parent)).as_posix()}),
        "",
    ]
    [file] = write_all(output.parent, [(output.name, "\n".join(lines).encode())], [program])
    return ProposedJob(file, tuple(found), tuple(notes), dialect, inch)


def _feature_lines(one: MilledFeature, scale: float) -> list[str]:
    keys: dict[str, object] = {"name": one.name, "kind": one.kind, "at": _rounded(one.place_mm, scale)}
    if one.kind != "face":
        keys |= {"size": round(scale * one.size_mm, 6), "depth": round(scale * one.depth_mm, 6)}
    if one.kind in PAIRS:
        keys["direction"] = _rounded(one.direction, 1.0)
    register = "its radius at the control" if one.radius_at_control else "its radius in the path"
    return [
        "[[feature]]",
        *toml_keys(keys),
        f"# tool {one.tool}, {register}, {one.work_offset}{one.side and f', {one.side}'}",
        "",
    ]


def _tool_lines(features: Sequence[MilledFeature], radius: Mapping[int, float]) -> list[str]:
    used = sorted({feature.tool for feature in features} & set(radius))
    return [
        line
        for tool in used
        for line in ("[[tool]]", *toml_keys({"number": tool, "cutter_radius": round(radius[tool], 6)}), "")
    ]


def _rounded(values: Sequence[float], scale: float) -> list[float]:
    return [round(scale * value, 6) + 0.0 for value in values]


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
    names = {f'"{n}"': feature.name for n, feature in enumerate(made.measured, 1)}
    return "\n".join(["[names]", *toml_keys(names)])
