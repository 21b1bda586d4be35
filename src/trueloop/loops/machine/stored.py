"""A program's correction by a machine's errors as it is stored and sent, and the envelope about it."""

from typing import Final

from trueloop.domain import values
from trueloop.domain.correction import Correction
from trueloop.domain.map_options import MapOptions
from trueloop.domain.record import Record
from trueloop.loops.machine.mapped_program import Mapped
from trueloop.loops.machine.points import CorrectedPoints

CODEC: Final = values.CODEC.with_more(Correction, Mapped, CorrectedPoints)


def enveloped(record: Record, done: Mapped, options: MapOptions) -> Correction[Mapped]:
    """A program displaced by a field, in the envelope that all products share."""
    return Correction(record, {"limit_mm": options.limit_mm, "slope": options.slope}, done)


def enveloped_points(record: Record, done: CorrectedPoints, limit_mm: float) -> Correction[CorrectedPoints]:
    """A drilling program corrected by errors in the plane, in the same."""
    return Correction(record, {"limit_mm": limit_mm}, done)
