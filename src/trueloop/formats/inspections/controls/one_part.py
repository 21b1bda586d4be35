"""The inspection of one part that a control's output holds."""

from collections.abc import Iterable
from pathlib import Path

from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.formats.inspections.controls.meaning import Meaning
from trueloop.formats.inspections.shared.checks import numbered

DEVICE = "probe of the machine tool"


def inspection_of(
    path: Path,
    meaning: Meaning,
    readings: Iterable[Reading] = (),
    points: Iterable[CmmPoint] = (),
    *,
    ball_radius_mm: float = 0.0,
) -> Inspection:
    """Returns the values as an inspection; part and serial number as far as the mapping states them."""
    sizes, touched = numbered(readings), tuple(points)
    return Inspection(
        part=Part(PartType(meaning.part), meaning.serial),
        measured="CMM points" if not sizes else "readings and CMM points" if touched else "readings",
        sha256=sha256_of(path.read_bytes()),
        count=len(sizes) + len(touched),
        values=(*sizes, *touched),
        device=DEVICE,
        ball_radius_mm=ball_radius_mm if touched else 0.0,
    )
