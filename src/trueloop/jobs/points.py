"""A drilling program's file corrected by errors in the plane."""

from collections.abc import Collection
from pathlib import Path

from trueloop.domain.limits import Limits
from trueloop.formats.outputs import write_all
from trueloop.loops.machine.points import CorrectedPoints, correct_points
from trueloop.machine.standards.planar_field import PlanarField
from trueloop.nc.program.program import Program


def write_corrected_points(
    program: Program,
    target: Path,
    field: PlanarField,
    provenance: dict[str, object],
    *,
    all_words: bool = False,
    limit_mm: float = Limits.correction_mm,
    inputs: Collection[Path] = (),
) -> CorrectedPoints:
    """Writes what `correct_points` makes of the program; nothing where it refuses. Raises OUT errors."""
    written, done = correct_points(program, field, provenance, all_words=all_words, limit_mm=limit_mm)
    write_all(target.parent, [(target.name, written)], inputs=inputs)
    return done
