"""The inspection files that are known, and a file read by whichever of them recognises it."""

from pathlib import Path
from typing import Final

from trueloop.collector import put_off
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import FilePath, readable
from trueloop.formats.inspections import calypso, pc_dmis, plate, serial_gauge
from trueloop.formats.inspections.controls import heidenhain, log, printout, variables
from trueloop.formats.inspections.dmis import reader as dmis
from trueloop.formats.inspections.gauge_csv import FORMAT as GAUGE_CSV
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, StatedFacts
from trueloop.formats.inspections.qdas import reader as qdas
from trueloop.formats.inspections.qif import reader as qif
from trueloop.formats.inspections.shared.text import HINT, decoded
from trueloop.formats.inspections.tables import read as tables
from trueloop.formats.measurements.touches_csv import X_SUFFIXES, read_touches
from trueloop.units import COARSEST_U_UM, UM_PER_MM
from trueloop.wording import wording

NOMINAL: Final = tuple(f"nominal_{suffix}" for suffix in X_SUFFIXES)


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether the file is a CSV whose header has a point and its nominal x."""
    try:
        text, _ = decoded(head, path)
    except TrueloopError:
        return False
    line = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    separator = next((mark for mark in "\t;" if mark in line), ",")
    names = {name.strip() for name in line.split(separator)}
    return "point" in names and bool(names.intersection(NOMINAL))


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads one inspection of a part that the file does not name. Raises TCH errors."""
    del stated  # every column says its unit
    with in_file(path):
        touches = tuple(read_touches(path))
    inspection = Inspection(Part(PartType("")), "touches", sha256_of(path.read_bytes()), len(touches), touches)
    return MeasuredFile(path, FORMAT.name, "utf-8", "mm", (inspection,))


FORMAT: Final = Format("touches as CSV", recognises, read)


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
    FORMAT,
    tables.FORMAT,  # last: any CSV is one
)
"""The formats in the order in which they are tried: the first that recognises a file reads it."""
HEAD: Final = 65_536


@put_off()
def read_measured_file(path: FilePath, stated: StatedFacts | None = None) -> MeasuredFile:
    """Reads the inspections of a file of a gauge, a measuring machine or a control; lengths are mm.

    `stated`: unit and mapping, where the file does not state them. Raises MSR and TCH errors with their places;
    MSR-FORMAT where no format is recognised.

    >>> file = trueloop.read_measured_file(trueloop.example("series/first-three.csv"))
    >>> [(inspection.part.serial, len(inspection.readings)) for inspection in file.inspections]
    [('101', 4), ('102', 4), ('103', 4)]
    """
    stated = stated or StatedFacts()
    try:
        found = _read(Path(path), stated)
    except TrueloopError as error:
        if error.code is not Code.MSR_UNIT or not stated.unit_key or "--unit" not in error.hint:
            raise
        hint = f'state it in the job: {stated.unit_key} = "mm" or "inch"'
        raise error.code.refusal(error.message, hint=hint, place=error.place, values=error.values) from error
    for reading in (each for inspection in found.inspections for each in inspection.readings):
        u_um = UM_PER_MM * (reading.standard_u or 0.0)
        if reading.quantity is not Quantity.ANGLE and u_um > COARSEST_U_UM:
            raise Code.MSR_UNCERTAINTY.refusal(
                f"{reading.characteristic}: its standard uncertainty is {u_um:g} µm, the limit is {COARSEST_U_UM:g} µm",
                hint="state it in the unit of its heading, half of an expanded one with k = 2; of an estimate by eye "
                "leave the reading out",
                place=Place(str(path), reading.line),
                values={"characteristic": reading.characteristic, "u_um": u_um, "limit_um": COARSEST_U_UM},
            )
    return found


def _read(path: Path, stated: StatedFacts) -> MeasuredFile:
    with readable(path, Code.MSR_FILE, hint=HINT), path.open("rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        why = f"{path.name!r} is empty: it has {path.stat().st_size} bytes"
        raise Code.MSR_FILE.refusal(why, hint="send or export it again", place=Place(str(path)))
    for form in KNOWN:
        if form.recognises(path, head):
            return form.read(path, stated)
    if stated.mapping is not None:  # headings that nobody knows are known to it
        return tables.FORMAT.read(path, stated)
    names = ", ".join(form.name for form in KNOWN)
    raise Code.MSR_FORMAT.refusal(
        wording(
            "{file!r}, {size} bytes, is not one of the {n} formats that are read: {names}",
            file=path.name,
            size=path.stat().st_size,
            n=len(KNOWN),
            names=names,
        ),
        hint=HINT,
        place=Place(str(path)),
    )
