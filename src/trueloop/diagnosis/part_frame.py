"""Part coordinate system discrepancy [6876 §3.1, Fig. 6]: CMM and machine do not find the same part frame."""

from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.components import Inspections
from trueloop.statistics import rms

FAINTEST = 1e-6
"""A motion that shifts the points by less than this share of the strongest is not seen by them."""


@dataclass(frozen=True)
class FrameDiscrepancy:
    """A small rigid motion from the machine's part frame to the CMM's: p → p + shift + turn × p.

    `standard_u` are of (shift, turn), NaN for motions that the points do not see (a shaft turned about its axis), which
    are left at 0. `rms_before_mm` and `rms_after_mm` are of the differences along the normals.
    """

    shift_mm: Array
    turn_rad: Array
    standard_u: Array
    rms_before_mm: float
    rms_after_mm: float

    def apply(self, points_mm: Array) -> Array:
        """Points of the machine's frame as the CMM sees them, (n, 3)."""
        moved: Array = points_mm + self.shift_mm + np.cross(self.turn_rad, points_mm)
        return moved

    def undo(self, points_mm: Array) -> Array:
        """Returns the CMM's points in the machine's frame, to first order, (n, 3)."""
        moved: Array = points_mm - self.shift_mm - np.cross(self.turn_rad, points_mm)
        return moved


def fit_frame_discrepancy(seen: Inspections, error_proc_resid_mm: Array) -> FrameDiscrepancy:
    """Returns the rigid motion that best explains, along the normals, CMM minus on-machine errors, by least squares.

    What the machine model left (ERROR_MTG,RESID) and looks like a rigid motion goes into it too: a constant offset of X
    looks like a part set up off centre. Take out the discrepancy only where the two frames were found anew.
    """
    difference = np.einsum("ni,ni->n", seen.normal, seen.cmm_mm - seen.nominal_mm) - error_proc_resid_mm
    size = max(float(np.abs(seen.nominal_mm).max()), 1e-9)
    rows = np.hstack([seen.normal, np.cross(seen.nominal_mm, seen.normal) / size])
    left, strength, right = np.linalg.svd(rows, full_matrices=False)
    seen_by = strength > FAINTEST * strength[0]
    inverse = np.where(seen_by, 1 / np.where(seen_by, strength, 1.0), 0.0)
    solution = right.T @ (inverse * (left.T @ difference))
    rest = difference - rows @ solution
    freedom = max(len(rows) - int(seen_by.sum()), 1)
    variance = float(rest @ rest) / freedom * np.einsum("kj,k->j", right**2, inverse**2)
    unseen = np.einsum("kj,k->j", right**2, ~seen_by) > FAINTEST
    scale = np.array([1.0] * 3 + [1 / size] * 3)
    u = np.where(unseen, np.nan, np.sqrt(variance) * scale)
    solution = solution * scale
    return FrameDiscrepancy(solution[:3], solution[3:], u, rms(difference), rms(rest))


def without_discrepancy(seen: Inspections, found: FrameDiscrepancy) -> Inspections:
    """The inspections with the CMM's points brought into the machine's part frame."""
    return replace(seen, cmm_mm=found.undo(seen.cmm_mm))
