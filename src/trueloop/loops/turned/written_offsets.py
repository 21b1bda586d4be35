"""The offset variant of the program, written, read back and compared with what was intended."""

from trueloop.domain.record import ChangedWord
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.written import Writing
from trueloop.nc.edit.changes import changes
from trueloop.nc.edit.edit import Edit
from trueloop.turned.program.offsets import (
    has_local_shift,
    offset_state,
    shift_edits,
    tool_offset_updates,
    update_edits,
)
from trueloop.turned.program.read_back import SAME_MM
from trueloop.turned.program.read_back_offset import require_same_path, require_shift, require_updates
from trueloop.turned.program.shifted_frame import shifted_moves


def write_offsets(
    writing: Writing, offset_mm: tuple[float, float], tool: int, is_diameter: bool | None
) -> tuple[bytes, list[ChangedWord]]:
    """The program with the tool's offset changed by (x as a radius, z), and what changed.

    Raises NC-OFFSET where none can be written around the contour, CMP-READ-BACK if reading it back says so.
    """
    if has_local_shift(writing.program):
        edits = _shifted(writing, offset_mm)
    else:
        edits = _updated(writing, offset_mm, tool, is_diameter)
    return writing.with_edits(edits), changes(writing.program, edits)


def _shifted(writing: Writing, offset_mm: tuple[float, float]) -> list[Edit]:
    program, path, cuts = writing.program, writing.matched.path, _cuts(writing.matched)
    shifted = shifted_moves(program, path, cuts)
    edits = shift_edits(program, path, shifted, offset_mm)
    after = writing.run.of(writing.reread(writing.with_edits(edits)))
    step_mm = program.dialect.step_mm(bool(path.inch[shifted.first]))
    require_shift(program, path, after, shifted, cuts, offset_mm, step_mm / 2 + SAME_MM)
    return edits


def _updated(writing: Writing, offset_mm: tuple[float, float], tool: int, is_diameter: bool | None) -> list[Edit]:
    program, path, lead = writing.program, writing.matched.path, max(_cuts(writing.matched)[0] - 1, 0)
    state = offset_state(path.coordinate_state(lead), is_diameter)
    values_mm = tool_offset_updates(program, state, offset_mm, tool)
    edits = update_edits(program, path, lead, values_mm, tool, is_diameter)
    after = writing.reread(writing.with_edits(edits))
    require_same_path(path, writing.run.of(after))
    require_updates(after, state, values_mm, tool)
    return edits


def _cuts(matched: Commanded) -> tuple[int, int]:
    """First and last move of the contour, those that only lengthen it included."""
    moves = [*(cut.move for cut in matched.cuts), *(move.index for move in matched.match.run_out)]
    return min(moves), max(moves)
