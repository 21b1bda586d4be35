"""A drilling program's file corrected by errors in the plane."""

from collections.abc import Collection
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from trueloop.domain.limits import Limits
from trueloop.domain.record import sha256_of
from trueloop.formats.outputs import write_all
from trueloop.formats.record_file import record_beside
from trueloop.jobs.user import user_name
from trueloop.loops.machine.points import CorrectedPoints, correct_points, record_of_points
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
    """Writes what `correct_points` makes of the program, the record beside it; nothing where it refuses.

    `inputs` are the program's file and those that the field was read from. Raises OUT errors.
    """
    written, done, changed = correct_points(program, field, provenance, all_words=all_words, limit_mm=limit_mm)
    options = {"all_words": all_words, "limit_mm": limit_mm}
    hashes = {file.name: sha256_of(file.read_bytes()) for file in inputs if str(file) != program.file}
    made = record_of_points(program, done, changed, options, provenance, hashes, datetime.now(UTC))
    files = [(target.name, written), record_beside(target, replace(made, made_by=user_name()))]
    write_all(target.parent, files, inputs=inputs)
    return done
