"""Statements of DMIS that change the coordinate system in which results are counted."""

from collections.abc import Mapping
from typing import Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.dmis.numbers import degrees_of, is_number, number_of
from trueloop.formats.inspections.dmis.settings import Frame, Settings
from trueloop.formats.inspections.dmis.words import Words, key_of, label_in

ORIGINS: Final = {"XORIG": 0, "YORIG": 1, "ZORIG": 2}
TURNED_ABOUT: Final = {"XAXIS": 0, "YAXIS": 1, "ZAXIS": 2}


def moved(
    statement: Words, settings: Settings, known: Mapping[str, Frame], datums: str, *, measured: bool
) -> tuple[str, Frame | None]:
    """Returns datums and frame in force after a statement; the frame is None where it begins anew at other datums.

    `D(…)=TRANS/XORIG,10` puts the origin at x = 10, `D(…)=ROTATE/ZAXIS,30` turns the axes by 30° from x to y (both from
    memory of DMIS 5.2). Before anything was measured every statement is taken as the set-up of the part. Raises
    MSR-FRAME for a change after measured features that the file does not give in numbers.
    """
    if not measured:
        return datums or _text(statement), None
    if statement.word == "DATSET":
        if datums:
            if datums == _text(statement):
                return datums, settings.frame
            raise _refusal(statement, settings)
        return _text(statement), None
    if statement.word == "TRANS":
        return datums, _shifted(statement, settings)
    if statement.word == "ROTATE":
        return datums, _turned(statement, settings)
    label = label_in(statement.fields[0]) if statement.fields else None
    frame = known.get(key_of(label[1])) if label is not None else None
    if frame is None:
        raise _refusal(statement, settings)
    return datums, frame


def _shifted(statement: Words, settings: Settings) -> Frame:
    shift = [0.0, 0.0, 0.0]
    fields = statement.fields
    for name, text in zip(fields[::2], fields[1::2], strict=False):
        if name.upper() not in ORIGINS or not is_number(text):
            raise _refusal(statement, settings)
        value = number_of(text, settings, statement.line) or 0.0
        shift[ORIGINS[name.upper()]] = value * settings.length_factor(statement.line)
    if len(fields) % 2 or not fields:
        raise _refusal(statement, settings)
    return settings.frame.shifted((shift[0], shift[1], shift[2]))


def _turned(statement: Words, settings: Settings) -> Frame:
    fields = statement.fields
    if len(fields) != 2 or fields[0].upper() not in TURNED_ABOUT or not is_number(fields[1]):
        raise _refusal(statement, settings)
    angle_deg = degrees_of(fields[1], settings, statement.line) or 0.0
    return settings.frame.turned(TURNED_ABOUT[fields[0].upper()], angle_deg)


def _text(statement: Words) -> str:
    return ",".join(statement.fields).upper()


def _refusal(statement: Words, settings: Settings) -> TrueloopError:
    text = f"{statement.word}/{','.join(statement.fields)}"
    return TrueloopError(
        Code.MSR_FRAME,
        f"{text!r} changes the coordinate system between measured features, and its size is not in the file",
        hint="report all features of a part in one coordinate system, or each system in a file of its own",
        place=Place(str(settings.path), statement.line),
        values={"statement": text},
    )
