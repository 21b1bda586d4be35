"""One part as recorded in the memory of an edge: errors at places before and after its finish cut."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array, Integers, by_content


@by_content
@dataclass(frozen=True)
class CutErrors:
    """Errors at n places, mm, positive = material left on.

    `contact_angle_rad` is that of the outward normal (n_x, n_z) = (sin φ, cos φ): 90° on a cylinder, 0 on a face that
    looks along +z (`geometry.feature.contact_angle_rad`). `feature` and `point` name the places; `standard_u_mm` is
    that of the measurement alone, without what the cut scatters. `z_mm` counts from the middle of the part, `share`
    along the `group` of features that meet tangentially, named by the first of them; None: of one place in the middle
    of each feature. `reference` is the place that the part's z was taken from, whose error is zero by definition, and
    `z_share` (n,) how much of that place's own error each of the errors lacks; None: z has no reference.
    """

    feature: tuple[str, ...]
    point: tuple[str, ...]
    contact_angle_rad: Array
    error_mm: Array
    standard_u_mm: Array
    z_mm: Array | None = None
    share: Array | None = None
    group: tuple[str, ...] | None = None
    z_share: Array | None = None
    reference: "CutErrors | None" = None

    def __len__(self) -> int:
        return len(self.feature)

    @property
    def groups(self) -> tuple[str, ...]:
        """Returns the group of features of each place; of one without, the feature."""
        return self.feature if self.group is None else self.group

    @classmethod
    def none(cls) -> "CutErrors":
        """Returns errors without any place."""
        return cls((), (), np.empty(0), np.empty(0), np.empty(0))

    @classmethod
    def asked(cls, contact_angle_rad: Array, feature: str = "") -> "CutErrors":
        """Places of one feature without values."""
        n = len(contact_angle_rad)
        return cls((feature,) * n, ("",) * n, contact_angle_rad, np.zeros(n), np.zeros(n))

    def chosen(self, rows: ArrayLike) -> "CutErrors":
        """Returns some of the places, by position."""
        at = np.asarray(rows, dtype=np.intp)

        def names(of: tuple[str, ...]) -> tuple[str, ...]:
            return tuple(of[k] for k in at)

        return CutErrors(
            feature=names(self.feature),
            point=names(self.point),
            contact_angle_rad=self.contact_angle_rad[at],
            error_mm=self.error_mm[at],
            standard_u_mm=self.standard_u_mm[at],
            z_mm=None if self.z_mm is None else self.z_mm[at],
            share=None if self.share is None else self.share[at],
            group=None if self.group is None else names(self.group),
            z_share=None if self.z_share is None else self.z_share[at],
            reference=self.reference,
        )


@by_content
@dataclass(frozen=True)
class MadePart:
    """One part of an edge: S_k, F_k and C_k of the model of `memory.edge`.

    `semifinish` are the touches before the finish cut, less the allowance (S). `finish` is what an inspection found
    after it (F), None while there is none; `correction_mm` (n,) is what the correction took off at the places of
    `finish`, along their normals, positive where material was taken off (C), so that E = F + C is the finish error had
    nothing been corrected. `from_memory_mm` (n,) is the share of C that came from memory and not from own touches.
    `order` counts the parts of this edge as they were cut, those of the tool's edges before it below 0;
    `order_in_doubt`: other facts contradict it. `setting` names the setting of the tool (one mounting or touch-off),
    `edge` the edge in one mounting, `minutes_in_cut` is the edge's age. `depth_of_cut_mm` and
    `feed_mm` are those of the finish cut.
    """

    part_type: str
    serial: str
    setting: str
    order: float
    semifinish: CutErrors
    finish: CutErrors | None = None
    correction_mm: Array | None = None
    from_memory_mm: Array | None = None
    minutes_in_cut: float | None = None
    depth_of_cut_mm: float | None = None
    feed_mm: float | None = None
    order_in_doubt: bool = False
    edge: str = ""

    @property
    def uncorrected_mm(self) -> Array | None:
        """Returns E = F + C at the places of `finish`, (n,); None without an inspection."""
        if self.finish is None or self.correction_mm is None:
            return None
        return self.finish.error_mm + self.correction_mm


@by_content
@dataclass(frozen=True)
class Expected:
    """The finish error had nothing been corrected, at n places: E_k given earlier parts and own touches, mm.

    `mean_mm` (n,) is the correction that takes it all out, so it is already divided by `gain`, what the actuator makes
    of a correction of 1, with standard uncertainty `gain_u`. `covariance_mm2` (n, n) is that of one part's error once
    the mean is corrected, scatter of the cut included: predicted error after the correction is 0 ± 1.96 √diag.
    `memory_mm` (n,) is the share of the mean that there would be without a touch of today; `weight` (n,) the share of
    the mean to command (1: all; less until an inspected part confirms the first correction). `own_fit`: correct by the
    fit of today's touches instead of the mean, as for the first part of an edge. `feature_index` and `arc_length_mm`
    (n,) say where on the profile the places are; None: nowhere in particular.

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
    feature_index: Integers | None = None
    arc_length_mm: Array | None = None

    def rows(self, feature: int) -> Integers:
        """Returns which places lie on a feature, by arc length; none where the prediction is by contact angle alone."""
        return np.flatnonzero(np.array([]) if self.feature_index is None else self.feature_index == feature)

    def along(self, values_mm: Array, feature: int, arc_length_mm: ArrayLike) -> Array:
        """Values at the places, (n,), at arc lengths (k,) of a feature, in straight steps; 0 where it has no place."""
        rows, s = self.rows(feature), np.atleast_1d(np.asarray(arc_length_mm, dtype=np.float64))
        if not len(rows) or self.arc_length_mm is None:
            return np.zeros(len(s))
        return np.asarray(np.interp(s, self.arc_length_mm[rows], values_mm[rows]))
