"""The job file (TOML): one turned part, its tool, its programs, its touches, and how to compensate.

Lengths carry their unit in the key, or, for the profile's coordinates, in `part.unit`. Paths are relative to the job
file. Unknown keys are refused: a mistyped option must not be an option ignored.
"""

import difflib
import re
import tomllib
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text

PositiveFloat = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegativeFloat = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Coordinate = Annotated[float, Field(allow_inf_nan=False)]
Point = tuple[Coordinate, Coordinate]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)


JobKind = TypeVar("JobKind", bound=BaseModel)


class FeatureTable(_Table):
    """One line or arc, from where the feature before it ended to `to` = [x, z]."""

    name: str
    to: Point
    centre: Point | None = None
    radius: PositiveFloat | None = None
    turn: Literal["convex", "concave"] = "convex"
    more_than_half: bool = False

    @model_validator(mode="after")
    def _one_arc_form(self) -> "FeatureTable":
        if self.centre is not None and self.radius is not None:
            raise ValueError("an arc has a centre or a radius, not both")
        return self


class PartTable(_Table):
    """The nominal profile: given here, or read from a DXF drawing, or taken from the finish program."""

    name: str
    unit: Literal["mm", "inch"] = "mm"
    x_is: Literal["radius", "diameter"] = "radius"
    start: Point | None = None
    feature: tuple[FeatureTable, ...] = ()
    dxf: Path | None = None
    dxf_layer: str | None = None
    from_program: bool = False
    junctions: dict[str, Literal["corner", "tangent"]] = {}

    @model_validator(mode="after")
    def _one_source(self) -> "PartTable":
        sources = [bool(self.feature), self.dxf is not None, self.from_program]
        if sum(sources) != 1:
            raise ValueError("the profile comes from exactly one of `feature`, `dxf` and `from_program`")
        if self.feature and self.start is None:
            raise ValueError("`start` = [x, z] of the first feature is missing")
        return self


class ToolTable(_Table):
    """The finishing tool."""

    nose_radius_mm: NonNegativeFloat | None = None
    nose_radius_in: NonNegativeFloat | None = None
    number: int = 1

    @model_validator(mode="after")
    def _one_unit(self) -> "ToolTable":
        if (self.nose_radius_mm is None) == (self.nose_radius_in is None):
            raise ValueError("give the nose radius once: `nose_radius_mm` or `nose_radius_in`")
        return self


class ProgramsTable(_Table):
    """The finish program, and the semi-finish program that the measured surface was cut with."""

    dialect: str
    finish: Path
    finish_lines: tuple[int, int] | None = None
    semifinish: Path | None = None
    semifinish_allowance_mm: NonNegativeFloat | None = None
    parameters: dict[str, float] = {}
    resolution_mm: PositiveFloat | None = None
    offset_x_is: Literal["radius", "diameter"] | None = None
    execute_deleted_blocks: bool = False
    accept_unknown_words: bool = False


class GaugingTable(_Table):
    """The touches and how well the probe repeats ([6811 §4.1]: ranges of 1.5 µm on diameters, 0.5 µm on faces)."""

    touches: Path
    probe: Path | None = None
    points: dict[str, Annotated[int, Field(ge=1)]] = {}
    spacing_mm: PositiveFloat | None = None
    ball_radius_mm: NonNegativeFloat = 0.0
    repeatability_diameter_um: NonNegativeFloat = 1.5
    repeatability_face_um: NonNegativeFloat = 0.5
    z_reference: str | None = None
    measured_allowance_mm: float = 0.0
    measured_at: datetime | None = None
    program_sha256: str | None = None
    finish_touches: Path | None = None


class CompensationTable(_Table):
    """How much of the error to take out, how, and what to refuse."""

    weight: Annotated[float, Field(gt=0, le=1)] = 1.0
    junctions: Literal["part", "path"] = "part"
    knot_every: Annotated[int, Field(ge=1)] | None = None
    nose_from: tuple[Path, ...] = ()
    chord_tolerance_um: PositiveFloat = 0.5
    arcs: Literal["auto", "lines", "arcs"] = "auto"
    max_correction_um: PositiveFloat = 150.0
    max_slope_um_per_mm: PositiveFloat = 40.0
    max_scatter_um: PositiveFloat = 10.0
    max_age_hours: PositiveFloat = 24.0


class OutputTable(_Table):
    """Where the results go."""

    folder: Path = Path("out")


class Job(_Table):
    """A whole job file."""

    part: PartTable
    tool: ToolTable
    programs: ProgramsTable
    gauging: GaugingTable
    compensation: CompensationTable = CompensationTable()
    output: OutputTable = OutputTable()


def read_job(path: Path) -> Job:
    """Reads a job file; raises JOB errors that name the table, the key and the line."""
    return parsed_job(path, Job)


def parsed_job(path: Path, kind: type[JobKind]) -> JobKind:
    """Reads a job file of some kind."""
    text = read_text(
        path, Code.JOB_MISSING, hint="a job file is a text file in UTF-8; `trueloop demo` runs a ready one"
    )
    try:
        return kind.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(path, error) from error
    except ValidationError as error:
        raise _content_error(path, text, kind, error) from error


def _syntax_error(path: Path, error: tomllib.TOMLDecodeError) -> TrueloopError:
    where = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
    line, column = (int(where[1]), int(where[2])) if where else (None, None)
    return TrueloopError(
        Code.JOB_SYNTAX,
        f"not a TOML file: {str(error).split(' (at ')[0]!r}",
        hint="text values stand in quotes, tables in [brackets]: see examples/modbas2/job.toml",
        place=Place(str(path), line, column),
    )


def _content_error(path: Path, text: str, kind: type[BaseModel], error: ValidationError) -> TrueloopError:
    """The first mistake; an unknown key before all others, because it is why another one is missing."""
    mistakes = error.errors()
    first = next((mistake for mistake in mistakes if mistake["type"] == "extra_forbidden"), mistakes[0])
    location = first["loc"]
    key = ".".join(str(part) for part in location)
    hint = "docs/job-file.md lists every table and key with its unit and default"
    if first["type"] == "extra_forbidden":
        message = f"{key!r} is no key of a job"
        near = difflib.get_close_matches(str(location[-1]), _table_at(kind, location).model_fields, n=1)
        hint = f"did you mean {near[0]!r}?" if near else hint
    else:
        given = f", given {first['input']!r}" if not isinstance(first["input"], dict) else ""
        message = f"{key!r}: {first['msg'].removeprefix('Value error, ')}{given}"
    return TrueloopError(Code.JOB_KEY, message, hint=hint, place=Place(str(path), _line_of(text, location)))


def _table_at(kind: type[BaseModel], location: tuple[int | str, ...]) -> type[BaseModel]:
    """The table that a key stands in."""
    if "feature" in location[:-1]:
        return FeatureTable
    table = kind.model_fields[str(location[0])].annotation if len(location) > 1 else kind
    tables = [t for t in (table, *get_args(table)) if isinstance(t, type) and issubclass(t, BaseModel)]
    return tables[0]


def _line_of(text: str, location: tuple[int | str, ...]) -> int | None:
    """The line where the last named key of a location stands, searched from its table's heading on."""
    names = [part for part in location if isinstance(part, str)]
    lines = text.splitlines()
    start = next((i for i, line in enumerate(lines) if names and re.match(rf"\s*\[+{names[0]}\b", line)), None)
    if start is None:
        return None
    key = re.compile(rf"\s*\"?{re.escape(names[-1])}\"?\s*=")
    return next((i + 1 for i in range(start, len(lines)) if key.match(lines[i])), start + 1)
