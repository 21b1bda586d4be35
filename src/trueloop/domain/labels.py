"""Labels of parts and of programs, as texts and file names hold them [6811 §4.3].

    part      number-material-pattern[.copy]                          1411-A2-P1.560
    program   number-material-pattern-stage-operation[-direction]     1411-A2-P1-S-D-X

Which facts a label holds is published; the grammar is trueloop's own, for the report refers to a paper that is not at
hand. Letters are written as capitals and read in either case. The labels in the report's own tables and programs,
`1411.559` and `060011`, are read as aliases: they name something and say no more. In particular no number is computed
from another: `3711.164` is the finish inspection that belongs to `3711.162`, and there is no `3711.163`.

>>> read_label("1411-A2-P1.560")
PartLabel(number='1411', material='A2', pattern='P1', copy='560')
>>> str(read_label("1411-a2-p1-s-d-x"))
'1411-A2-P1-S-D-X'
>>> labels_in("1411-A2-P1-F-M.nc")[0].stage
<Stage.FINISH: 'finish'>
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import chain
from typing import Final, NamedTuple, TypeAlias

from trueloop.domain.life import Stage
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError

LETTERS: Final = re.IGNORECASE | re.ASCII
STAGES: Final = {"R": Stage.ROUGH, "S": Stage.SEMIFINISH, "F": Stage.FINISH}


class Operation(StrEnum):
    """The purpose of a program: its value is the letter in the label."""

    MACHINING = "M"
    PROBING = "D"  # dimensional probing, along one axis
    SCANNING = "S"  # scanning of a surface


class _Field(NamedTuple):
    """A field of a label: what separates it from the one before, its pattern, and what it has to be, in words."""

    name: str
    separator: str
    pattern: str
    is_: str


PART: Final = (
    _Field("number", "", "[A-Z]*[0-9][A-Z0-9]*", "a number of letters and digits, with at least one digit"),
    _Field("material", "-", "[A-Z][A-Z0-9]*", "a material of letters and digits that begins with a letter"),
    _Field("pattern", "-", "P[0-9]+", "a pattern of inspection points, P and digits"),
)
COPY: Final = (_Field("copy", ".", "[0-9]+", "a copy of digits"),)
PROGRAM: Final = (
    _Field("stage", "-", "[RSF]", "a stage, R, S or F"),
    _Field("operation", "-", "[MDS]", "an operation, M, D or S"),
)
DIRECTION: Final = (_Field("direction", "-", "[XYZ]", "a direction of probing, X, Y or Z"),)
HINT: Final = "labels are number-material-pattern[.copy] of parts, …-stage-operation[-direction] of programs"


@dataclass(frozen=True)
class PartLabel:
    """`number-material-pattern`, of all parts of a type; with `copy`, of one piece. `copy` is text: 007 is not 7."""

    number: str
    material: str
    pattern: str
    copy: str = ""

    def __post_init__(self) -> None:
        _require_written(self, str(self), (*PART, *(COPY if self.copy else ())))

    def __str__(self) -> str:
        return f"{self.number}-{self.material}-{self.pattern}" + (f".{self.copy}" if self.copy else "")


@dataclass(frozen=True)
class ProgramLabel:
    """The type of part, the stage that the program leaves or inspects, and its operation. Probing has a direction."""

    part: PartLabel
    stage: Stage
    operation: Operation
    direction: str = ""

    def __post_init__(self) -> None:
        probing = self.operation is Operation.PROBING
        if self.part.copy or bool(self.direction) is not probing:
            raise _refused(str(self), len(str(self.part)), "a program of all copies, with a direction where it probes")
        _require_written(self, str(self)[len(str(self.part)) :], (*PROGRAM, *(DIRECTION if probing else ())))

    def __str__(self) -> str:
        letter = next(letter for letter, stage in STAGES.items() if stage is self.stage)
        return f"{self.part}-{letter}-{self.operation}" + (f"-{self.direction}" if self.direction else "")


@dataclass(frozen=True)
class NistPart:
    """`1411.559` of [6811] Tables 2–11: a part's number, and that of one inspection of it."""

    number: str
    inspection: str

    def __str__(self) -> str:
        return f"{self.number}.{self.inspection}"


@dataclass(frozen=True)
class NistProgram:
    """`060011` of [6811] appendix A."""

    number: str

    def __str__(self) -> str:
        return self.number


Label: TypeAlias = PartLabel | ProgramLabel | NistPart | NistProgram
NIST_PART: Final = re.compile(r"([0-9]{4})\.([0-9]{3})")
NIST_PROGRAM: Final = re.compile(r"[0-9]{6}")
IN_NAMES: Final = re.compile(
    r"(?<![A-Z0-9.])(?:"
    + "-".join(field.pattern for field in PART)
    + rf"(?:\.{COPY[0].pattern}|-[RSF]-(?:[MS]|D-{DIRECTION[0].pattern}))?"
    + rf"|{NIST_PART.pattern}|{NIST_PROGRAM.pattern})(?![A-Z0-9])",
    LETTERS,
)
"""A label in a longer text: no letter, digit or point before it, no letter or digit after it."""


def read_label(text: str) -> Label:
    """Reads the label that a text is. Raises LAB-FORM with the place of the first character that fits no label."""
    if alias := _alias(text):
        return alias
    fields, at = _read(text, PART, 0)
    if at < len(text) and text[at] == ".":
        copy, at = _read(text, COPY, at)
        _require_end(text, at)
        return PartLabel(**fields, **copy)
    part = PartLabel(**fields)
    if at == len(text):
        return part
    done, at = _read(text, PROGRAM, at)
    operation = Operation(done["operation"])
    direction, at = _read(text, DIRECTION if operation is Operation.PROBING else (), at)
    _require_end(text, at)
    return ProgramLabel(part, STAGES[done["stage"]], operation, direction.get("direction", ""))


def labels_in(name: str) -> tuple[Label, ...]:
    """Returns the labels that a file's name, or another text, contains, from left to right. None is not a mistake."""
    return tuple(read_label(found[0]) for found in IN_NAMES.finditer(name))


def is_written(field: str, text: str) -> bool:
    """Returns whether a text can be that field of a part's label: a number, a material, a pattern or a copy."""
    return any(one.name == field and re.fullmatch(one.pattern, text, LETTERS) for one in (*PART, *COPY))


def _alias(text: str) -> Label | None:
    if found := NIST_PART.fullmatch(text):
        return NistPart(*found.groups())
    return NistProgram(text) if NIST_PROGRAM.fullmatch(text) else None


def _read(text: str, fields: Sequence[_Field], at: int) -> tuple[dict[str, str], int]:
    """The fields from a place on, as capitals, and where they end."""
    read: dict[str, str] = {}
    for field in fields:
        if not text.startswith(field.separator, at):
            raise _refused(text, at, f"{field.separator!r} and {field.is_}")
        at += len(field.separator)
        end = next((k for k in range(at, len(text)) if text[k] in "-."), len(text))
        if not re.fullmatch(field.pattern, text[at:end], LETTERS):
            raise _refused(text, at, field.is_)
        read[field.name], at = text[at:end].upper(), end
    return read, at


def _require_end(text: str, at: int) -> None:
    if at < len(text):
        raise _refused(text, at, "the end of the label")


def _require_written(label: object, text: str, fields: Sequence[_Field]) -> None:
    """That fields given one by one are those that the text would be read as."""
    read, at = _read(text, fields, 0)
    _require_end(text, at)
    for name, value in read.items():
        if name != "stage" and value != getattr(label, name):
            raise _refused(text, text.upper().find(value), f"{name} {value!r}, as capitals")


def _refused(text: str, at: int, expected: str) -> TrueloopError:
    found = repr(text[at:]) if text[at:] else "the end"
    return Code.LAB_FORM.refusal(
        f"{text!r} is no label: at character {at + 1} there is {found} instead of {expected}",
        hint=HINT,
        values={"label": text, "character": at + 1},
    )


def contradictions(
    label: Label, part_type: PartType | None, serial: str = "", stage: Stage | None = None, place: Place | None = None
) -> tuple[Finding, ...]:
    """Returns where a label differs from what it is linked with: type of part, serial number, stage of the cut.

    Compared is what both state, letters in either case. The label's number is compared with that of the drawing and the
    name of the type, its material with that of the type, where these can stand in a label.
    """
    differing = chain(
        () if part_type is None else _of_type(label, part_type), _of_copy(label, serial), _of_stage(label, stage)
    )
    return tuple(_finding(label, name, here, there, place or Place()) for name, here, there in differing)


def names_part(label: Label, part: Part) -> bool:
    """Returns whether a label can mean this part: all that it states, the part is.

    Of the alias `1411.559` the whole or `1411` is the serial number, or `1411` is the type and `559` the serial number.
    """
    if isinstance(label, NistPart):
        kind = part.part_type
        whole = part.serial in (label.number, str(label))
        return whole or (label.number in (kind.name, kind.drawing) and part.serial == label.inspection)
    if not isinstance(label, PartLabel):
        return False
    stated = any(_same(label.number, one) for one in (part.part_type.drawing, part.part_type.name))
    same_copy = not label.copy or _same(label.copy, part.serial)
    return stated and same_copy and not contradictions(label, part.part_type, part.serial)


def _of_type(label: Label, part_type: PartType) -> Iterator[tuple[str, str, str]]:
    if isinstance(label, ProgramLabel):
        label = label.part
    if not isinstance(label, PartLabel):
        return
    numbers = [one for one in (part_type.drawing, part_type.name) if is_written("number", one)]
    if numbers and not any(_same(label.number, number) for number in numbers):
        yield "number", label.number, numbers[0]
    material = part_type.material
    if is_written("material", material) and not _same(label.material, material):
        yield "material", label.material, material


def _of_copy(label: Label, serial: str) -> Iterator[tuple[str, str, str]]:
    if isinstance(label, PartLabel) and label.copy and serial and not _same(label.copy, serial):
        yield "copy", label.copy, serial


def _of_stage(label: Label, stage: Stage | None) -> Iterator[tuple[str, str, str]]:
    if isinstance(label, ProgramLabel) and stage is not None and label.stage is not stage:
        yield "stage", label.stage, stage


def _same(label: str, other: str) -> bool:
    return label.upper() == other.upper()


def _finding(label: Label, name: str, here: str, there: str, place: Place) -> Finding:
    return Finding(
        Severity.ERROR,
        Code.LAB_LINK,
        f"the label '{label}' says {name} {here!r}, what it is linked with has {there!r}",
        "correct what is wrong: the name of the file, or the part and stage that it was linked with",
        place,
        values={"label": str(label), "in_label": str(here), "in_link": str(there)},
    )
