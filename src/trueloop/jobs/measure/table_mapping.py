"""A mapping of a table's columns: proposed from its headings, written, and the table read by it."""

from dataclasses import dataclass
from pathlib import Path

from trueloop.errors import Code, TrueloopError
from trueloop.formats.input_file import readable
from trueloop.formats.inspections.measured_file import MeasuredFile, Stated, Unit
from trueloop.formats.inspections.tables.mapping import HINT, Mapping, toml_of
from trueloop.formats.inspections.tables.propose import Given, propose
from trueloop.formats.inspections.tables.read import grid_of, read_mapped, settled
from trueloop.formats.outputs import write_all


@dataclass(frozen=True)
class Mapped:
    """A mapping with the file it was written to, and the table as it is read by it, or why it is not."""

    path: Path
    mapping: Mapping
    file: MeasuredFile | TrueloopError


def map_table(
    path: Path, output: Path | None, sheet: str = "", unit: Unit | None = None, given: Given | None = None
) -> Mapped:
    """Proposes, writes and tries a mapping; `given` names columns as `propose` takes them.

    Where the table cannot be read by it, because a unit or a sign is stated nowhere, it is written all the same: there
    it is added. Raises MSR errors where there is no mapping to propose, OUT errors where it cannot be written.
    """
    with readable(path, Code.MSR_FILE, hint=HINT):
        grid = grid_of(path, sheet)
    mapping, stated = propose(grid, given), Stated(unit)
    mapping = mapping.model_copy(update={"unit": unit})
    written = output or path.with_name(f"{path.stem}.map.toml")
    file: MeasuredFile | TrueloopError
    try:
        mapping = settled(grid, mapping, stated)
        file = read_mapped(grid, mapping, stated, written)
    except TrueloopError as error:
        file = error
    text = toml_of(mapping, f"What the columns of {path.name} mean: docs/measurements.md, 'Tables by mapping'")
    write_all(written.parent, [(written.name, text.encode())], [path])
    return Mapped(written, mapping, file)
