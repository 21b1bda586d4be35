"""What memory and today's touches together say of the next finish cut."""

from dataclasses import dataclass

from trueloop.arrays import Array, by_content


@by_content
@dataclass(frozen=True)
class Expected:
    """The finish error had nothing been corrected, at n contact angles: E_k given earlier parts and own touches, mm.

    `mean_mm` (n,) is the correction that takes it all out, so it is already divided by `gain`, what the actuator makes
    of a correction of 1, with standard uncertainty `gain_u`. `covariance_mm2` (n, n) is that of one part's error once
    the mean is corrected, scatter of the cut included: predicted error after the correction is 0 ± 1.96 √diag.
    `memory_mm` (n,) is the share of the mean that there would be without a touch of today; `weight` (n,) the share of
    the mean to command (1: all; less until an inspected part confirms the first correction). `own_fit`: correct by the
    fit of today's touches instead of the mean, as for the first part of an edge.

    `parts` is the number of inspected parts behind it; `nearest_rad` (n,) how far the nearest contact angle seen by
    them or by today's touches is. `enough_touches` is the number of today's touches, placed best, that would have given
    standard uncertainties within 10 % of these: advice for the next plan.
    """

    contact_angle_rad: Array
    mean_mm: Array
    covariance_mm2: Array
    memory_mm: Array
    weight: Array
    nearest_rad: Array
    parts: int
    enough_touches: int
    notes: tuple[str, ...] = ()
    gain: float = 1.0
    gain_u: float = 0.0
    own_fit: bool = False
