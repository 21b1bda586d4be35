"""The text of a new job file: what was found and stated, with the keys that its owner is likely to want next."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

from trueloop.domain.characteristic import Characteristic
from trueloop.formats.jobs.profile_of_job import part_table_toml, quoted, side_key
from trueloop.geometry.profile import Profile


@dataclass(frozen=True)
class NewTool:
    """An edge that cuts: `number` is that of its offset, which only the one tool of a part may leave open."""

    nose_radius_mm: float
    number: int | None = None
    tip: int | None = None
    name: str = ""


@dataclass(frozen=True)
class NewProgram:
    """A finish program with its tools. Of several set-ups it is that of set-up `name`, with z of the part where its
    Z is 0, and whether the part is turned round. `cut`: keys of its table [programs] that state what cut the part.
    """

    finish: Path
    dialect: str
    tools: Sequence[NewTool]
    unit: Literal["mm", "inch"] | None = None
    lines: tuple[int, int] | None = None
    parameters: Mapping[str, float] = field(default_factory=dict)
    accept_unknown_words: bool = False
    name: str = ""
    zero_at_z_mm: float | None = None
    flipped: bool = False
    cut: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class NewJob:
    """The content of a new job. Paths are as they shall stand in it: relative to the job.

    `profile` is spelled out where there is no `drawing`, whose format `drawing_key` names ("dxf" or "step"); `chosen`
    are keys that say what of it is meant, and `asked` is what it asks for. `stated`: further keys with their values in
    TOML, by table.
    """

    name: str
    profile: Profile
    programs: Sequence[NewProgram]
    measured_key: Literal["readings", "touches"]
    measured_file: str
    notes: Sequence[str] = ()
    asked: Sequence[Characteristic] = ()
    drawing: Path | None = None
    drawing_key: str = ""
    chosen: Mapping[str, int | str] = field(default_factory=dict)
    stated: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


def job_toml(new: NewJob) -> str:
    """The job as TOML."""
    gauging = f"[gauging]\n{new.measured_key} = {quoted(new.measured_file)}\n"
    cuts = _setups(new.programs) if len(new.programs) > 1 else _of_one(new.programs[0])
    lines = "\n".join([_part(new), *cuts, gauging, '[output]\nfolder = "out"', ""]).split("\n")
    for table, keys in new.stated.items():
        added = [f"{key} = {value}" for key, value in keys.items()]
        if f"[{table}]" not in lines:
            lines += [f"[{table}]", *added, ""]
        else:
            at = lines.index(f"[{table}]") + 1
            lines[at:at] = added
    return "\n".join(lines)


def _of_one(of: NewProgram) -> list[str]:
    heading = "[tool]" if len(of.tools) == 1 else "[[tools]]"
    return [*(_tool(heading, tool) for tool in of.tools), _program("[programs]", of)]


def _setups(programs: Iterable[NewProgram]) -> Iterator[str]:
    for of in programs:
        zero = [] if of.zero_at_z_mm is None else [f"zero_at_z_mm = {of.zero_at_z_mm!r}"]
        turned = ["flipped = true"] if of.flipped else []
        yield "\n".join(["[[setups]]", f"name = {quoted(of.name)}", *zero, *turned, ""])
        yield _program("[setups.programs]", of)
        yield from (_tool("[[setups.tools]]", tool) for tool in of.tools)


def _part(new: NewJob) -> str:
    if new.drawing is None:
        return part_table_toml(new.name, new.profile, new.notes) + characteristics_toml(new.asked)
    features = ", ".join(new.profile.names)
    return "\n".join(
        [
            *(f"# {' '.join(note.split())}" for note in new.notes),
            f"# Its features, in order: {features}.",
            "[part]",
            f"name = {quoted(new.name)}",
            f"{new.drawing_key} = {quoted(new.drawing.as_posix())}",
            *(f"{key} = {quoted(one) if isinstance(one, str) else one}" for key, one in new.chosen.items()),
            *side_key(new.profile),
            "",
        ]
    ) + characteristics_toml(new.asked)


def _tool(heading: str, of: NewTool) -> str:
    number = [] if of.number is None else [f"number = {of.number}"]
    tip = [] if of.tip is None else [f"tip = {of.tip}"]
    name = [f"name = {quoted(of.name)}"] if of.name else []
    return "\n".join([heading, f"nose_radius_mm = {of.nose_radius_mm!r}", *number, *tip, *name, ""])


def _program(heading: str, of: NewProgram) -> str:
    given = ", ".join(f"{quoted(name)} = {value!r}" for name, value in of.parameters.items())
    return "\n".join(
        [
            heading,
            *(f"{key} = {quoted(value)}" for key, value in of.cut.items()),
            f"dialect = {quoted(of.dialect)}",
            f"finish = {quoted(of.finish.as_posix())}",
            *([] if of.lines is None else [f"finish_lines = [{of.lines[0]}, {of.lines[1]}]"]),
            *([] if of.unit is None else [f"unit = {quoted(of.unit)}"]),
            *(["accept_unknown_words = true"] if of.accept_unknown_words else []),
            *([] if not given else [f"parameters = {{ {given} }}"]),
            "",
        ]
    )


ROUNDED: Final = 9
"""Decimals of a size: conversions of inches end there."""


def characteristics_toml(characteristics: Sequence[Characteristic]) -> str:
    """A `[[part.characteristic]]` for each, lengths in mm; they follow a `[part]` table in mm. "" for none."""
    return "".join("\n" + "\n".join(_table(characteristic)) + "\n" for characteristic in characteristics)


def _table(characteristic: Characteristic) -> Iterator[str]:
    yield "[[part.characteristic]]"
    yield f"name = {quoted(characteristic.name)}"
    yield f"quantity = {quoted(characteristic.quantity)}"
    yield f"feature = {quoted(characteristic.feature)}"
    if characteristic.other:
        yield f"other = {quoted(characteristic.other)}"
    if characteristic.nominal:
        yield f"nominal = {round(characteristic.nominal, ROUNDED)!r}"
    if characteristic.tolerance:
        yield f"tolerance = {quoted(characteristic.tolerance)}"
        return
    for key, limit in (("lower_limit", characteristic.lower_limit), ("upper_limit", characteristic.upper_limit)):
        if limit is not None:
            yield f"{key} = {round(limit, ROUNDED)!r}"
