"""Touches of a turned part as the CSV that a job's `gauging.touches` names: an inspection like any other."""

from pathlib import Path
from typing import Final

from trueloop.domain.inspection import Inspection
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import TrueloopError, in_file
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Stated
from trueloop.formats.inspections.shared.text import decoded
from trueloop.formats.measurements.touches_csv import X_SUFFIXES, read_touches

NOMINAL: Final = tuple(f"nominal_{suffix}" for suffix in X_SUFFIXES)


def recognises(path: Path, head: bytes) -> bool:
    """A CSV whose header has a point and its nominal x."""
    try:
        text, _ = decoded(head, path)
    except TrueloopError:
        return False
    line = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    separator = next((mark for mark in "\t;" if mark in line), ",")
    names = {name.strip() for name in line.split(separator)}
    return "point" in names and bool(names.intersection(NOMINAL))


def read(path: Path, stated: Stated) -> MeasuredFile:
    """One inspection of a part that the file does not name. Raises TCH errors."""
    del stated  # every column says its unit
    with in_file(path):
        touches = tuple(read_touches(path))
    inspection = Inspection(Part(PartType("")), "touches", sha256_of(path.read_bytes()), len(touches), touches)
    return MeasuredFile(path, FORMAT.name, "utf-8", "mm", (inspection,))


FORMAT: Final = Format("touches as CSV", recognises, read)
