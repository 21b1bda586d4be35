"""The virtual mill's file (TOML): what differs from a process of the published size."""

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from trueloop.errors import Code, in_file
from trueloop.formats.toml_tables import Finite, NotNegative, Table, read_tables
from trueloop.units import UM_PER_MM
from trueloop_lab.files.virtual_machine_toml import CmmTable, cmm_of
from trueloop_lab.simulator.mill import VirtualMill
from trueloop_lab.simulator.process import SurfaceProcess, published_process

Side = Annotated[int, Field(ge=8, le=200, strict=True)]


class MilledProcessTable(Table):
    """The errors that repeat, by how much parts differ in the middle and at the edges, and the scatter of a touch."""

    pattern_um: NotNegative = 8.0
    """Size of what repeats on every part."""
    pattern_controls: Annotated[int, Field(ge=4, le=40, strict=True)] = 9
    """Control points of it along each side."""
    pattern_seed: Annotated[int, Field(ge=0, strict=True)] = 0
    """Seed of its form."""
    least_um: NotNegative | None = None
    """By how much parts differ in the middle; left out, as published."""
    most_um: NotNegative | None = None
    """By how much at the edges; left out, as published."""
    noise_um: NotNegative | None = None
    """The scatter of a single touch; left out, as published."""


class WearTable(Table):
    """The cutter: by how much it is larger than programmed, negative where it is worn."""

    radius_error_um: Finite = 0.0
    """By how much the cutter is larger than programmed; negative where it is worn."""


class GridTable(Table):
    """Places that the measuring machine touches, along u and along v."""

    rows: Side = 25
    """Places that the measuring machine touches along u."""
    columns: Side = 25
    """Places that the measuring machine touches along v."""


class VirtualMillFile(Table):
    """A whole file; all of it may be left out."""

    process: MilledProcessTable = MilledProcessTable()
    cutter: WearTable = WearTable()
    cmm: CmmTable = CmmTable()
    grid: GridTable = GridTable()


def read_virtual_mill(path: Path) -> VirtualMill:
    """The mill of a file. Raises SIM-FILE."""
    hint = "docs/simulator.md lists every table and key of a mill's file"
    file = read_tables(path, VirtualMillFile, Code.SIM_FILE, hint=hint)
    with in_file(path):
        return mill_of(file)


def mill_of(file: VirtualMillFile) -> VirtualMill:
    """The tables as values."""
    return VirtualMill(
        _process(file.process),
        file.cutter.radius_error_um / UM_PER_MM,
        cmm_of(file.cmm),
        (file.grid.rows, file.grid.columns),
    )


def _process(table: MilledProcessTable) -> SurfaceProcess:
    rng = np.random.default_rng(table.pattern_seed)
    base = published_process(rng, table.pattern_um / UM_PER_MM, table.pattern_controls)

    def given(um: float | None, published_mm: float) -> float:
        return published_mm if um is None else um / UM_PER_MM

    return SurfaceProcess(
        base.pattern,
        given(table.least_um, base.least_mm),
        given(table.most_um, base.most_mm),
        given(table.noise_um, base.noise_mm),
    )
