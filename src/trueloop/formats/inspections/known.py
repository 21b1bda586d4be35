"""The inspection files that are known, and a file read by whichever of them recognises it."""

from pathlib import Path
from typing import Final

from trueloop.collector import put_off
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import readable
from trueloop.formats.inspections import calypso, plate, serial_gauge, touches
from trueloop.formats.inspections.controls import heidenhain, log, printout, variables
from trueloop.formats.inspections.dmis import reader as dmis
from trueloop.formats.inspections.gauge_csv import FORMAT as GAUGE_CSV
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Stated
from trueloop.formats.inspections.pc_dmis import reader as pc_dmis
from trueloop.formats.inspections.qdas import reader as qdas
from trueloop.formats.inspections.qif import reader as qif
from trueloop.formats.inspections.shared.text import HINT
from trueloop.formats.inspections.tables import read as tables

KNOWN: Final[tuple[Format, ...]] = (
    calypso.FORMAT,
    pc_dmis.FORMAT,
    serial_gauge.FORMAT,
    plate.FORMAT,
    qif.FORMAT,
    dmis.FORMAT,
    qdas.FORMAT,
    printout.FORMAT,
    heidenhain.FORMAT,
    variables.FORMAT,
    log.FORMAT,
    GAUGE_CSV,
    touches.FORMAT,
    tables.FORMAT,  # last: any CSV is one
)
"""In the order in which they are asked: the first that recognises a file reads it."""
HEAD: Final = 65_536


@put_off()
def read_measured_file(path: Path, stated: Stated) -> MeasuredFile:
    """A file's inspections. Raises MSR errors with their places; MSR-FORMAT where no format is recognised."""
    with readable(path, Code.MSR_FILE, hint=HINT), path.open("rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        why = f"{path.name!r} is empty: it has {path.stat().st_size} bytes"
        raise TrueloopError(Code.MSR_FILE, why, hint="send or export it again", place=Place(str(path)))
    for form in KNOWN:
        if form.recognises(path, head):
            return form.read(path, stated)
    if stated.mapping is not None:  # headings that nobody knows are known to it
        return tables.FORMAT.read(path, stated)
    names = ", ".join(form.name for form in KNOWN)
    raise TrueloopError(
        Code.MSR_FORMAT,
        f"{path.name!r}, {path.stat().st_size} bytes, is none of the {len(KNOWN)} formats that are read: {names}",
        hint=HINT,
        place=Place(str(path)),
        values={"file": path.name},
    )
