"""The nose-centre path as the finish program commands it, and as it is to be driven."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.composed import check_composed
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.part_on_machine import InMachine
from trueloop.loops.turned.shifts import Shifts, whole_mm
from trueloop.nc.match.tip import CENTRE
from trueloop.turned.compensation.contour import CentrePiece, centre_pieces, shifted_contour
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.compensation.displaced import Constant, Displacement, Then, displaced_pieces
from trueloop.turned.compensation.limits import check_limits, check_nose, check_offset
from trueloop.turned.compensation.shift import Shift


@dataclass(frozen=True)
class Driven:
    """What the control makes of a contour under G41 or G42: the nose radius, and where its centre shall run."""

    nose_radius_mm: float
    pieces: Sequence[CentrePiece]

    def along(self, contour: Sequence[CentrePiece], largest_mm: float) -> list[CentrePiece]:
        """The pieces as far as the nose touches their own feature of the contour, corners of the contour being turned.

        Without the last nose radius at the profile's free ends, where ways in and out have a say, and as much of it as
        a correction of `largest_mm` may move it by.
        """
        pieces = [
            replace(piece, start_mm=max(piece.start_mm, own.start_mm), end_mm=min(piece.end_mm, own.end_mm))
            for piece, own in zip(self.pieces, contour, strict=True)
        ]
        short_mm = self.nose_radius_mm + largest_mm
        pieces[0] = replace(pieces[0], start_mm=pieces[0].start_mm + short_mm)
        pieces[-1] = replace(pieces[-1], end_mm=pieces[-1].end_mm - short_mm)
        return [piece for piece in pieces if piece.end_mm > piece.start_mm]


@dataclass(frozen=True)
class Paths:
    """Paths of the finish pass before and after the correction, one piece a feature.

    `commanded` and `corrected` are of the nose centre, `written` what the program spells for them, before and after:
    the same, or those of the tip that it moves, or, where the control itself keeps the nose off, the contour; then
    `driven` says what it makes of that.
    """

    commanded: tuple[CentrePiece, ...]
    corrected: tuple[CentrePiece, ...]
    written: tuple[tuple[CentrePiece, ...], tuple[CentrePiece, ...]]
    driven: Driven | None


def corrected_paths(
    inputs: Inputs, matched: Commanded, shifts: Shifts, decision: Decision, machine: InMachine | None
) -> Paths:
    """The paths with every feature shifted, then displaced by an offset that the contour carries and, on a known
    machine, by COMP_MTG. An offset that was in force is carried by the contour too, but for what of it stands in the
    control's wear table: that moves the tool anyhow.

    Raises GEO-NOSE where the nose would not fit, CMP-SIZE and CMP-SLOPE for a correction over the limits.
    """
    profile, nose_radius_mm, limits = inputs.profile, inputs.nose_radius_mm, inputs.options.limits

    def pieces(of: Sequence[Shift], nose_mm: float) -> tuple[CentrePiece, ...]:
        return centre_pieces(profile, shifted_contour(profile, of, nose_mm))

    cut, change_mm = inputs.in_force.cut_with, whole_mm(decision)
    offset_mm = (change_mm[0] + cut.offset_mm[0], change_mm[1] + cut.offset_mm[1])
    check_offset(offset_mm, limits)
    before, after = pieces(matched.finish, nose_radius_mm), pieces(shifts.contour, nose_radius_mm)
    check_nose(after)
    check_limits(after, shifts.correction, limits)
    moved: Displacement = Constant((0.0, 0.0) if decision.by_offset else cut.still_to_do(offset_mm))
    if machine is not None:
        moved = Then(moved, machine.comp_mtg)
        check_composed(after, shifts.correction, (machine.comp_mtg, moved), limits)
    undisplaced, after, driven = after, displaced_pieces(after, moved), None
    written = before, after
    if matched.match.on_contour:
        written = pieces(matched.finish, 0.0), displaced_pieces(pieces(shifts.contour, 0.0), moved)
        driven = Driven(nose_radius_mm, after)
    elif matched.tip_mm != CENTRE:
        to_tip = Constant(matched.tip_mm)
        written = displaced_pieces(before, to_tip), displaced_pieces(undisplaced, Then(moved, to_tip))
    return Paths(before, after, written, driven)
