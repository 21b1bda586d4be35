"""What a finish cut was expected to leave on the arcs, and what an inspection found there."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.life import Cut
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.made_parts import program_that_ran
from trueloop.loops.turned.outcome import expected_mm
from trueloop.statistics import rms
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop.wording import Um


@dataclass(frozen=True)
class Obtained:
    """Expected against obtained at the inspected places on arcs of one part.

    `predicted_mm` is the RMS that errors have on average whose expected values and standard uncertainties are those of
    the prediction, √mean(e² + u²); `found_mm` that of the errors found. `inside` of `places` errors found differ
    from the expected one by at most U (95 %), in which the uncertainty of the inspection has no part.
    """

    serial: str
    predicted_mm: float
    found_mm: float
    inside: int
    places: int

    @property
    def words(self) -> str:
        """One line."""
        predicted, found = Um(self.predicted_mm), Um(self.found_mm)
        return (
            f"{self.serial}: predicted {predicted} RMS, obtained {found} RMS; {self.inside} of {self.places} inside ±U"
        )

    @property
    def as_dict(self) -> dict[str, object]:
        """For machines, µm."""
        um = {"predicted_rms_um": self.predicted_mm * UM_PER_MM, "obtained_rms_um": self.found_mm * UM_PER_MM}
        return {"serial": self.serial, **um, "inside": self.inside, "places": self.places}


def obtained(correction: Correction, cut: Cut, found: ErrorVectors) -> Obtained | None:
    """What an inspection found against what the correction promised.

    None without a place, and where another program ran than the one that the prediction is of. A place whose
    error is zero by definition, because z was taken from it, is left out. Raises STO-PROGRAM.
    """
    rows = np.flatnonzero(~found.at_reference)
    if len(rows) == 0 or program_that_ran(correction, cut) is not correction.recommended:
        return None
    at = found.chosen(rows)
    expected, standard_u, expanded_u = _promised_mm(correction, at)
    return Obtained(
        cut.part.serial,
        rms(np.hypot(expected, standard_u)),
        rms(at.error_mm),
        int(np.count_nonzero(np.abs(at.error_mm - expected) <= expanded_u)),
        len(rows),
    )


def _promised_mm(correction: Correction, at: ErrorVectors) -> tuple[Array, Array, Array]:
    """Expected error, its standard uncertainty and U at places, each (n,)."""
    promised = np.empty((3, len(at.point)))
    for index in np.unique(at.feature_index):
        rows, s = at.of_feature(index), at.arc_length_mm[at.of_feature(index)]
        budget = correction.next_cut(index, s)
        promised[:, rows] = expected_mm(correction, index, s), budget.standard_u_mm, budget.expanded_u_mm
    return promised[0], promised[1], promised[2]
