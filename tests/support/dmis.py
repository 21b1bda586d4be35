"""DMIS text read as a file."""

import tempfile
from pathlib import Path
from typing import Final

from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts

NOTHING: Final = StatedFacts()


def read_text(text: str | bytes, stated: StatedFacts = NOTHING, name: str = "part.dmo") -> MeasuredFile:
    """What is read of a file that holds the text."""
    content = text.encode() if isinstance(text, str) else text
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        return read_measured_file(path, stated)


def in_mm(*lines: str) -> MeasuredFile:
    """The same of lines behind `UNITS/MM,ANGDEC`."""
    return read_text("\n".join(["UNITS/MM,ANGDEC", *lines, ""]))


def only_inspection(file: MeasuredFile) -> Inspection:
    """The file's one inspection."""
    (inspection,) = file.inspections
    return inspection


def by_name(file: MeasuredFile) -> dict[str, Reading]:
    """The readings of the file's one inspection by the names of their characteristics."""
    return {reading.characteristic: reading for reading in only_inspection(file).readings}


def only_point(file: MeasuredFile) -> CmmPoint:
    """The one point of the file's one inspection."""
    (point,) = only_inspection(file).points
    return point


def remarks(file: MeasuredFile) -> list[tuple[int | None, str]]:
    """Lines and texts of what was remarked, unless that features have no nominal, as short examples have none."""
    return [(one.line, one.text) for one in file.remarks if "no nominal one" not in one.text]
