"""`trueloop new`: a job from a finish program, asking for what the program does not say."""

import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Final, Literal, TypeVar

import typer

from trueloop.cli.program_file import (
    AcceptUnknown,
    DialectName,
    OfSide,
    OfTip,
    ProgramFile,
    Settings,
    UnitAtStart,
    parameters_of,
)
from trueloop.cli.shared_options import not_negative, option
from trueloop.cli.terminal import AsJson, busy, guarded, print_json, print_lines
from trueloop.wording import shell_word

HOW: Final = "Measured with a micrometer, or as points by a probe or measuring machine"
MEASURED: Final[tuple[Literal["gauge", "points"], ...]] = ("gauge", "points")
Choice = TypeVar("Choice", bound=str)


@guarded
def new(
    program: ProgramFile,
    drawing: Annotated[
        Path | None, option("DXF drawing or STEP solid of the part.  [default: as the program cuts it]")
    ] = None,
    nose_radius_mm: Annotated[
        float | None, option("Radius of the finishing tool's nose.  [prompted for]", callback=not_negative)
    ] = None,
    name: Annotated[str | None, option("Name of the part.  [prompted for; default: the program's name]")] = None,
    measured: Annotated[
        Literal["gauge", "points"] | None,
        option(
            "With a micrometer (gauge), or by a probe or measuring machine (points).  [prompted for; default: gauge]"
        ),
    ] = None,
    folder: Annotated[Path | None, option("Where the job goes.  [default: a folder with the part's name]")] = None,
    tool: Annotated[int | None, option("Number of the tool's offset at the control.", min=1)] = None,
    dialect: DialectName = None,
    unit: UnitAtStart = None,
    settings: Settings = None,
    lines: Annotated[tuple[int, int] | None, option("First and last line of the finish pass.")] = None,
    side: OfSide = "outside",
    tip: OfTip = None,
    accept_unknown_words: AcceptUnknown = False,
    outline: Annotated[int | None, option("Which contour of the drawing, where that side has several.", min=1)] = None,
    zero: Annotated[
        Literal["drawing", "free-end", "chuck-end"], option("From where z of a DXF drawing is counted.")
    ] = "drawing",
    as_json: AsJson = False,
) -> None:
    """Begin a job: writes job.toml and a file for the readings.

    The file lists the places to measure; fill the values in. Options that are left out are prompted for at a
    terminal; elsewhere only the nose radius is needed.
    """
    if drawing is None and outline is not None:
        raise typer.BadParameter("it chooses in a drawing: give --drawing", param_hint="--outline")
    if zero != "drawing" and (drawing is None or drawing.suffix.lower() != ".dxf"):
        raise typer.BadParameter("it is for a DXF drawing: give --drawing", param_hint="--zero")
    person = sys.stdin.isatty() and sys.stdout.isatty() and not as_json
    radius = nose_radius_mm
    if radius is None:
        if not person:
            raise typer.BadParameter("the program does not say it: give it", param_hint="--nose-radius-mm")
        radius = typer.prompt("Nose radius of the finishing tool, mm", value_proc=_radius_mm)
    part = name or (typer.prompt("Name of the part", default=program.stem) if person else program.stem)
    how = measured or (_chosen(HOW, MEASURED, "gauge") if person else "gauge")
    if person and dialect is None:
        dialect = _asked_dialect(program)
    with busy(f"reading {program}"):
        from trueloop.geometry.profile import Side
        from trueloop.jobs.turned.new import Chosen, Wanted, new_job

        made = new_job(
            Wanted(
                program=program,
                nose_radius_mm=radius,
                name=part,
                folder=folder or Path(re.sub(r"[^\w.-]+", "-", part).strip("-.") or "job"),
                drawing=drawing,
                dialect=dialect,
                unit=unit,
                tool=tool,
                lines=lines,
                parameters=parameters_of(settings),
                measured=how,
                side=Side(side),
                chosen=Chosen(outline, zero),
                tip=tip,
                accept_unknown_words=accept_unknown_words,
            )
        )
    if as_json:
        print_json({**vars(made), "files": [str(file) for file in made.files]})
        return
    job, to_fill_in, *others = made.files
    print_lines(
        [
            *made.notes,
            f"{len(made.features)} features in order: {', '.join(made.features)}",
            *(f"written: {file}" for file in (job, *others)),
            f"written: {to_fill_in}, with {made.places} places to measure",
            f"next: fill in the values, then  trueloop compensate {shell_word(str(job))}",
        ]
    )


def _radius_mm(answer: str) -> float | None:
    """Returns the number typed, with a decimal point or comma. Raises BadParameter, after which the prompt repeats."""
    try:
        return not_negative(float(answer.replace(",", ".")))
    except ValueError:
        raise typer.BadParameter(f"{answer} is not a number: type it as 0.8 or 0,8") from None


def _asked_dialect(program: Path) -> str | None:
    """The control, where the program could be for several."""
    from trueloop.errors import Code, TrueloopError
    from trueloop.formats.input_file import read_program
    from trueloop.nc.program.dialect import DIALECTS

    try:
        read_program(program)
    except TrueloopError as error:
        if error.code is Code.NC_DIALECT:
            return _chosen("The program may be for several controls; which", tuple(DIALECTS))
    return None


def _chosen(question: str, choices: Sequence[Choice], default: Choice | None = None) -> Choice:
    """One of the choices, asked for until it is one."""
    while True:
        answer = typer.prompt(f"{question} ({', '.join(choices)})", default=default)
        if answer in choices:
            return choices[choices.index(answer)]
