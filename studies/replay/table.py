"""A replay as a table: one row a place of a part's finish inspection."""

import csv
import io
import math
from collections.abc import Iterable, Iterator
from typing import Final

from studies.replay.replay import Replayed
from trueloop.units import UM_PER_MM

COLUMNS: Final = ("part", "point", "phi_deg", "predicted_error_um", "band_um", "touches", "semifinish_um")


def replay_csv(replayed: Iterable[Replayed]) -> str:
    """`predicted_error_um` is the error that the finish cut is expected to have where nothing is corrected, positive
    where material is left on: the correction to command. `band_um` is the half width of its 95 % band, `touches` how
    many of the part's touches were used, `semifinish_um` what was touched there after the semi-finish cut; empty where
    nothing was.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(row for one in replayed for row in _rows(one))
    return text.getvalue()


def _rows(one: Replayed) -> Iterator[tuple[str, ...]]:
    finish, semifinish = one.part.finish, one.part.semifinish
    assert finish is not None
    touched = dict(zip(zip(semifinish.feature, semifinish.point, strict=True), semifinish.error_mm, strict=True))
    for k, place in enumerate(zip(finish.feature, finish.point, strict=True)):
        yield (
            one.part.serial,
            place[1],
            f"{math.degrees(finish.contact_angle_rad[k]):.3f}",
            f"{one.predicted.error_mm[k] * UM_PER_MM:.3f}",
            f"{one.predicted.half_band_mm[k] * UM_PER_MM:.3f}",
            str(one.touches),
            f"{touched[place] * UM_PER_MM:.3f}" if place in touched else "",
        )
