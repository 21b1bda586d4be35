"""Programs mapped in a folder, and the path that a field should make of theirs."""

from pathlib import Path

import numpy as np

from trueloop.domain.option import MapOptions
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.loops.machine.mapped_program import Mapped
from trueloop.nc.field import Field, function_field
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import ToolPath

FREE = MapOptions(limit_mm=np.inf, slope=np.inf)
MIXED = function_field(
    lambda p: np.column_stack([0.03 * np.sin(p[:, 1] / 30), 0.02 * np.cos(p[:, 0] / 25), 1e-4 * p[:, 0]]), "mixed"
)


def mapped(
    folder: Path, text: str, field: Field, dialect: str = "linuxcnc", options: MapOptions = FREE
) -> tuple[str, Mapped]:
    source, target = folder / "program.ngc", folder / "mapped.ngc"
    source.write_bytes(text.encode("latin-1"))
    done = map_program(source, target, field, options, dialect=dialect)
    return target.read_bytes().decode("latin-1"), done


def path_of(text: str, dialect: str = "linuxcnc") -> ToolPath:
    return read_program(text.encode("latin-1"), dialect).run()


def displaced_path(path: ToolPath, field: Field) -> ToolPath:
    """The cuts' points, a hundredth of a degree or 50 µm apart, displaced one by one: no fitting, no rounding."""
    from trueloop.nc.match.difference import _pieces

    pieces = _pieces(path, np.flatnonzero(~path.rapid), 0.05)
    ends = [points + field.displacement_mm(points) for points in (pieces.start_mm, pieces.end_mm)]
    chords = "".join(
        f"G0X{a[0]:.9f}Y{a[1]:.9f}Z{a[2]:.9f}\nG1X{b[0]:.9f}Y{b[1]:.9f}Z{b[2]:.9f}\n"
        for a, b in zip(*ends, strict=True)
    )
    return path_of(f"G21 F1\n{chords}")
