"""Labels beside what they are linked with: a link is a fact of the store, and a label that contradicts it is refused.

Labels are compared with links and never put in their place. The aliases `1411.559` and `060011` state no fact that
could be compared.
"""

from collections.abc import Iterator
from itertools import chain

from trueloop.domain.labels import Label, NistPart, PartLabel, ProgramLabel, is_written
from trueloop.domain.life import Stage
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, Finding, Place, Severity


def label_of(part: Part, pattern: str) -> PartLabel:
    """The label of a part whose inspection points are that pattern. Raises LAB-FORM where a field cannot be in one."""
    kind = part.part_type
    fields = (kind.drawing or kind.name, kind.material, pattern, part.serial)
    return PartLabel(*(field.upper() for field in fields))


def contradictions(
    label: Label, part_type: PartType | None, serial: str = "", stage: Stage | None = None, place: Place | None = None
) -> tuple[Finding, ...]:
    """What a label says otherwise than what it is linked with: type of part, serial number, stage of the cut.

    Compared is what both state, letters in either case. The label's number is compared with that of the drawing and the
    name of the type, its material with that of the type, where these can stand in a label.
    """
    differing = chain(
        () if part_type is None else _of_type(label, part_type), _of_copy(label, serial), _of_stage(label, stage)
    )
    return tuple(_finding(label, name, here, there, place or Place()) for name, here, there in differing)


def names_part(label: Label, part: Part) -> bool:
    """Whether a label can mean this part: all that it states, the part is.

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
    if numbers and not any(_same(label.number, one) for one in numbers):
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


def _same(one: str, other: str) -> bool:
    return one.upper() == other.upper()


def _finding(label: Label, name: str, here: str, there: str, place: Place) -> Finding:
    return Finding(
        Severity.ERROR,
        Code.LAB_LINK,
        f"the label '{label}' says {name} {here!r}, what it is linked with has {there!r}",
        "correct what is wrong: the name of the file, or the part and stage that it was linked with",
        place,
        values={"label": str(label), "in_label": str(here), "in_link": str(there)},
    )
