"""Inspection files written in another format."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

from trueloop.domain.inspection import Inspection
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.dmis.results import dmis_results
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, Stated
from trueloop.formats.inspections.qdas.writer import dfq_of
from trueloop.formats.inspections.qif.writer import qif_of
from trueloop.formats.outputs import write_all

WRITERS: Final[Mapping[str, Callable[[Sequence[Inspection], str], bytes]]] = {
    ".qif": lambda inspections, _: qif_of(inspections),
    ".dfq": lambda inspections, _: dfq_of(inspections),
    ".dmo": lambda inspections, stem: dmis_results(inspections, stem).encode(),
}
"""By the ending of a file's name; they are given its stem, which DMIS repeats."""


def convert(path: Path, stated: Stated, target: Path) -> MeasuredFile:
    """Reads an inspection file and writes all its inspections to `target`; gives what was read.

    Raises MSR errors for what cannot be read, MSR-FORMAT for a target of no known ending or for touches, OUT errors.
    """
    writer = WRITERS.get(target.suffix.lower())
    if writer is None:
        raise TrueloopError(
            Code.MSR_FORMAT,
            f"{target.name!r} cannot be written: its ending {target.suffix!r} is not one of {', '.join(WRITERS)}",
            hint="name the output .qif, .dfq or .dmo",
            place=Place(str(target)),
            values={"file": target.name},
        )
    file = read_measured_file(path, stated)
    _require_written(file, target)
    inputs = [path, *([] if stated.mapping is None else [stated.mapping])]
    write_all(target.parent, [(target.name, lambda: writer(file.inspections, target.stem))], inputs)
    return file


def _require_written(file: MeasuredFile, target: Path) -> None:
    """Touches are errors of a plane (x, z): no format of measuring machines has words for them."""
    if touches := sum(len(inspection.touches) for inspection in file.inspections):
        raise TrueloopError(
            Code.MSR_FORMAT,
            f"{target.name!r} cannot hold {touches} touches of a turned part",
            hint="name the file itself in the job: `gauging.touches`",
            place=Place(str(file.path)),
            values={"file": target.name},
        )
