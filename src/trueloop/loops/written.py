"""The corrected program and its offset variant, written, read back and compared with what was intended."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.compensation.contour import CentrePiece
from trueloop.compensation.moves import Move, between
from trueloop.compensation.offsets import offset_edits
from trueloop.compensation.program import Displacements, changes, corrected_source, displacements
from trueloop.compensation.read_back import check_contour, check_rapids, check_rest, require_same_path
from trueloop.compensation.record import MARK, ChangedWord, sha256_of
from trueloop.compensation.targets import Fitting, Replacement, end_shifts, replaced_arcs
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.geometry.feature import Array
from trueloop.geometry.profile import Profile
from trueloop.loops.commanded import Commanded, Run
from trueloop.nc.edit import Edit, apply_edits, insert_blocks_after
from trueloop.nc.program import Program, read_program
from trueloop.nc.tool_path import Motion

ROUNDING_STEPS = 2.0
"""How many steps of the control's resolution rounding may add: half a step on either axis, at both ends of a move."""


@dataclass(frozen=True)
class Writing:
    """What is written into: the finish program as run and matched, and the marks that the result carries."""

    program: Program
    told: Commanded
    run: Run
    record_id: str
    fitting: Fitting

    @property
    def mark(self) -> Edit:
        """The comment block by which a corrected program is known."""
        values = " ".join(f"{name}={value:g}" for name, value in self.run.parameters.items())
        lines = [f"{MARK}: record {self.record_id}", f"source sha256 {sha256_of(self.program.source)}"]
        if values:
            lines.append(f"holds for {values} only")
        return insert_blocks_after(self.program, 0, [self.program.dialect.comment(line) for line in lines])

    def with_edits(self, edits: Sequence[Edit]) -> bytes:
        """The source with edits and mark."""
        return apply_edits(self.program, [self.mark, *edits])

    def reread(self, source: bytes) -> Program:
        """A written program read again, as a control would."""
        return read_program(source, self.program.dialect.name, self.program.file)


def write_contour(
    writing: Writing,
    profile: Profile,
    touches: ErrorVectors,
    before: Sequence[CentrePiece],
    after: Sequence[CentrePiece],
) -> tuple[bytes, list[ChangedWord]]:
    """The program with its contour displaced from `before` to `after`. Raises CMP errors if reading it back says so."""
    targets = _targets(writing, profile, touches, before, after)
    edits = corrected_source(writing.program, writing.told.path, targets)
    source = writing.with_edits(edits)
    path, old = writing.run.of(writing.reread(source)), writing.told.path
    check_rest(old, path, targets.first, targets.last)
    check_rapids(profile, old, path, targets.last)
    span = targets.first + 1, len(path) - 1 - (len(old) - 1 - targets.last)
    check_contour(path, span, after, writing.fitting.tolerance_mm + ROUNDING_STEPS * writing.told.resolution_mm)
    return source, changes(writing.program, edits)


def write_offsets(
    writing: Writing, offset_mm: tuple[float, float], tool: int, is_diameter: bool | None
) -> tuple[bytes, list[ChangedWord]]:
    """The program with tool offsets changed and its path untouched."""
    contour = [cut.move for cut in writing.told.cuts]
    run_out = [move.index for move in writing.told.match.run_out]
    span = min(contour) - 1, max([*contour, *run_out])
    edits = offset_edits(writing.program, writing.told.path, span, offset_mm, tool, is_diameter)
    source = writing.with_edits(edits)
    require_same_path(writing.told.path, writing.run.of(writing.reread(source)))
    return source, changes(writing.program, edits)


def _targets(
    writing: Writing,
    profile: Profile,
    touches: ErrorVectors,
    before: Sequence[CentrePiece],
    after: Sequence[CentrePiece],
) -> Displacements:
    told, cuts = writing.told, writing.told.cuts
    start, shifts = end_shifts(cuts, before, after)
    is_arc = np.flatnonzero(told.path.motion == Motion.ARC)
    touched = [touches.arc_length_mm[touches.of_feature(i)] for i in range(len(profile.features))]
    arcs = replaced_arcs(cuts, list(is_arc), after, touched, writing.fitting)
    targets = displacements(start, shifts, arcs, [move.index for move in told.match.run_out])
    edges = [move.index for move in told.match.between if move.index in is_arc]
    return Displacements(targets.ends, {**targets.arcs, **_edge_arcs(told, edges, targets.ends)})


def _edge_arcs(told: Commanded, edges: Sequence[int], ends: Mapping[int, Array]) -> dict[int, Replacement]:
    """Arcs that turn the nose about an edge, between their neighbours' displaced ends."""
    path = told.path
    replaced: dict[int, Replacement] = {}
    for k in edges:
        x, z = (0, 2)
        old = Move(
            (float(path.start_mm[k, x]), float(path.start_mm[k, z])),
            (float(path.end_mm[k, x]), float(path.end_mm[k, z])),
            (float(path.centre_mm[k, x]), float(path.centre_mm[k, z])),
            float(path.sweep_rad[k]),
        )
        start, end = np.asarray(old.start_mm) + ends[k - 1], np.asarray(old.end_mm) + ends[k]
        moved = between(old, (float(start[0]), float(start[1])), (float(end[0]), float(end[1])))
        replaced[k] = Replacement(k, (moved,))
    return replaced
