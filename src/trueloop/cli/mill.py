"""`trueloop mill`: milled parts, from measured sizes and positions to numbers at the control."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.program_file import (
    AcceptUnknown,
    DialectName,
    ProgramFile,
    Settings,
    UnitAtStart,
    parameters_of,
    tools_of,
)
from trueloop.cli.shared_options import argument, option, positive
from trueloop.cli.terminal import AsJson, Group, busy, print_json, print_lines, print_table
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.jobs.milled import MilledJob
    from trueloop.milled.entries import ExpectedSize, Proposal
    from trueloop.milled.feature import MilledFeature

app = Group("Milled parts: radii, lengths and work offsets to enter. They follow from what was measured.")


@app.command()
def entries(
    job: Annotated[Path, argument("The milled part's job; docs/milled.md explains it.", metavar="JOB.toml")],
    output: Annotated[
        Path | None, option("Folder for the record.  [default: output.folder of the job]", "--output", "-o")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the radii, lengths, work offsets and rotations to enter.

    Each size is listed with its expectation after that. A number is proposed where it is known to more than twice its
    standard uncertainty. The record, entries.json, tells the job of the next part what had been entered.
    """
    from trueloop.formats.outputs import write_all
    from trueloop.jobs.milled import RECORD, entries_for_next_part, entry_lines, proposal_notes, read_milled, record_of

    with busy(f"reading {job}"):
        read = read_milled(job)
        found = entries_for_next_part(read)
    files = write_all(output or read.folder, [(RECORD, record_of(read, found))], read.files)
    if as_json:
        print_json({**_as_dict(read, found), "files": list(map(str, files))})
        return
    print_lines(entry_lines(read, found))
    head = ("size or coordinate", "last part µm", "next, unchanged µm", "P(in)", "next, entered µm", "P(in)")
    print_table(head, (_row(size) for size in found.expected))
    print_table(("feature", "tool", "radius at", "work offset", "direction", "line"), _cuts(read))
    print_lines([*proposal_notes(read, found), *files])


@app.command()
def new(
    program: ProgramFile,
    output: Annotated[Path, option("The job to write.", "--output", "-o")],
    tools: Annotated[
        list[str] | None,
        option("Radius of a cutter or drill in mm, as 2=R5; may be repeated.", "--tool", "-t", metavar="N=R"),
    ] = None,
    wear: Annotated[
        bool, option("D holds wear alone: paths under G41 and G42 are those of the cutter's centre.", "--wear")
    ] = False,
    name: Annotated[str | None, option("Name of the part type.  [default: the program's]")] = None,
    measured: Annotated[
        Path | None, option("The inspection file that the job names.  [default: part-1.dmo beside the job]")
    ] = None,
    dialect: DialectName = None,
    unit: UnitAtStart = None,
    settings: Settings = None,
    accept_unknown_words: AcceptUnknown = False,
    as_json: AsJson = False,
) -> None:
    """Begin a job from a finishing program: features and tools.

    Features are bores, bosses, slots, ribs and faces. Circles and holes of a cutter's centre need its radius. What the
    program leaves open is listed.
    """
    cutters = tools_of(tools)
    if any(cutter.number is None for cutter in cutters):
        raise typer.BadParameter("it needs the tool's number, such as 2=R5", param_hint="--tool")
    from trueloop.jobs.milled_new import new_milled_job

    with busy(f"reading {program}"):
        made = new_milled_job(
            program,
            output,
            reading={
                "dialect": dialect,
                "unit": unit,
                "parameters": parameters_of(settings),
                "accept_unknown_words": accept_unknown_words,
            },
            name=name or program.stem,
            measured=measured or output.parent / "part-1.dmo",
            radius_mm={cutter.number: cutter.radius_mm for cutter in cutters if cutter.number is not None},
            wear=wear,
        )
    if as_json:
        features = [_feature_as_dict(feature) for feature in made.features]
        print_json({"file": str(made.file), "features": features, "notes": list(made.notes)})
        return
    head = ("feature", "x mm", "y mm", "z mm", "size mm", "tool", "radius at", "work offset", "direction")
    print_table(head, (_feature_row(feature) for feature in made.features))
    print_lines([*made.notes, f"written: {made.file}"])


@app.command()
def probe(
    job: Annotated[Path, argument("The milled part's job.", metavar="JOB.toml")],
    output: Annotated[Path, option("The program to write.", "--output", "-o")],
    tool: Annotated[int, option("Number of the probe's tool, and of its length offset.", min=1)],
    ball_mm: Annotated[float, option("Diameter of the probe's ball.", callback=positive)],
    clearance_mm: Annotated[float, option("Height, z of the work offset, over all that stands on the table.")],
    approach_mm: Annotated[
        float, option("Distance at which a measurement begins beside or above a surface.", callback=positive)
    ] = 5.0,
    as_json: AsJson = False,
) -> None:
    """Write a measuring program for a Fanuc or Haas mill.

    It calls Renishaw's Inspection Plus for the features of a job. Prints the table [names] by which the job reads the
    print-out. Run it first in single block, with the rapid override low: it knows the features of the job, and no
    clamps.
    """
    from trueloop.controllers.probing.inspection_plus import MacroProbe
    from trueloop.jobs.milled_new import names_table, write_probing_program

    with busy(f"reading {job}"):
        made, file = write_probing_program(job, output, MacroProbe(tool, ball_mm, clearance_mm, approach_mm))
    if as_json:
        names = {str(n): feature.name for n, feature in enumerate(made.measured, 1)}
        print_json({"file": str(file), "names": names, "left_out": list(made.left_out)})
        return
    print_lines([*(f"not measured: {one}" for one in made.left_out), names_table(made), f"written: {file}"])


def _feature_row(one: "MilledFeature") -> tuple[str, ...]:
    where = "control" if one.radius_at_control else "path"
    numbers = (*one.place_mm, one.size_mm)
    return (one.name, *(f"{value:.3f}" for value in numbers), f"{one.tool}", where, one.work_offset, one.side)


def _feature_as_dict(feature: "MilledFeature") -> dict[str, object]:
    """Returns a feature and what cuts it, JSON-ready."""
    return {
        "name": feature.name,
        "kind": feature.kind,
        "at_mm": list(feature.place_mm),
        "size_mm": feature.size_mm,
        "depth_mm": feature.depth_mm,
        "tool": feature.tool,
        "work_offset": feature.work_offset,
        "side": feature.side,
        "radius": "control" if feature.radius_at_control else "program",
    }


def _row(size: "ExpectedSize") -> tuple[str, ...]:
    measured = "" if size.measured_mm is None else f"{UM_PER_MM * size.measured_mm:+.1f}"
    cells = [size.seen.name, measured]
    for after in (size.unchanged, size.changed):
        deviation = UM_PER_MM * (after.value - size.seen.nominal_mm)
        cells.append(f"{deviation:+.1f} ± {2.0 * UM_PER_MM * after.standard_u:.1f}")
        cells.append("" if after.probability_in is None else f"{100.0 * after.probability_in:.1f} %")
    return tuple(cells)


def _cuts(job: "MilledJob") -> Iterator[tuple[str, ...]]:
    """Yields what cuts each feature, with the line of its last pass, empty where that is stated."""
    for feature in job.cut.features.values():
        name, *_, tool, where, offset, side = _feature_row(feature)
        yield name, tool, where, offset, side, str(job.cut.lines.get(name, ""))


def _as_dict(job: "MilledJob", proposal: "Proposal") -> dict[str, object]:
    return {
        "part_type": job.name,
        "parts": [part.serial for part in job.parts],
        "entries": [
            {
                "register": one.entry.register,
                "of": one.entry.of,
                **(
                    {"change_urad": 1e6 * one.change, "total_urad": 1e6 * one.total, "u_urad": 2e6 * one.standard_u}
                    if one.entry.register == "turn"
                    else {
                        "change_um": UM_PER_MM * one.change,
                        "total_um": UM_PER_MM * one.total,
                        "u_um": 2.0 * UM_PER_MM * one.standard_u,
                    }
                ),
                "at_control": {key: getattr(typed, key) for key in ("name", "holds", "change", "total", "unit")},
            }
            for one, typed in ((one, job.as_entered(one)) for one in proposal.proposed)
        ],
        "rms_um": [UM_PER_MM * value for value in proposal.rms_mm],
        "expected": [
            {
                "name": size.seen.name,
                "measured_um": None if size.measured_mm is None else UM_PER_MM * size.measured_mm,
                "unchanged_um": UM_PER_MM * (size.unchanged.value - size.seen.nominal_mm),
                "entered_um": UM_PER_MM * (size.changed.value - size.seen.nominal_mm),
                "u_um": 2.0 * UM_PER_MM * size.changed.standard_u,
                "probability_in": size.changed.probability_in,
            }
            for size in proposal.expected
        ],
        "features": [
            {**_feature_as_dict(feature), "line": job.cut.lines.get(feature.name)}
            for feature in job.cut.features.values()
        ],
        "unlike": list(proposal.unlike),
        "contradictory": [
            {
                "names": list(one.names),
                "part": one.serial,
                "readings": one.readings,
                "between_um": [UM_PER_MM * value for value in one.between_mm],
            }
            for one in proposal.contradictory
        ],
        "suspected": proposal.suspected,
        "exchanged": [{"names": list(one.names), "part": one.serial} for one in proposal.exchanged],
        "devices": [
            {
                "name": one.name,
                "probability_off": one.probability,
                "off_um": UM_PER_MM * one.off_mm,
                "u_um": 2.0 * UM_PER_MM * one.standard_u_mm,
            }
            for one in proposal.devices
        ],
        "by_one_reading": {entry.words: name for entry, name in proposal.by_one_reading.items()},
        "unused": list(job.unused),
    }
