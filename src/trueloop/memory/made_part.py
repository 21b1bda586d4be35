"""One part as the memory of an edge sees it: errors at contact angles before and after its finish cut."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, by_content


@by_content
@dataclass(frozen=True)
class ArcErrors:
    """Errors at n places on arcs, mm, positive = material left on.

    `contact_angle_rad` is that of the outward normal (n_x, n_z) = (sin φ, cos φ): 90° on a cylinder, 0 on a face that
    looks along +z (`geometry.feature.contact_angle_rad`). `feature` and `point` name the places; `standard_u_mm` is
    that of the measurement alone, without what the cut scatters.
    """

    feature: tuple[str, ...]
    point: tuple[str, ...]
    contact_angle_rad: Array
    error_mm: Array
    standard_u_mm: Array

    @classmethod
    def none(cls) -> "ArcErrors":
        """No place at all."""
        return cls((), (), np.empty(0), np.empty(0), np.empty(0))


@by_content
@dataclass(frozen=True)
class MadePart:
    """One part of an edge: S_k, F_k and C_k of the model of `memory.edge`.

    `semifinish` are the touches before the finish cut, less the allowance (S). `finish` is what an inspection found
    after it (F), None while there is none; `correction_mm` (n,) is what the correction took off at the places of
    `finish`, along their normals, positive where material was taken off (C), so that E = F + C is the finish error had
    nothing been corrected. `from_memory_mm` (n,) is the share of C that came from memory and not from own touches.
    `order` counts the parts of this edge as they were cut; `order_in_doubt`: other facts contradict it. `setting` names
    the setting of the tool (one mounting or touch-off), `minutes_in_cut` the edge's age. `depth_of_cut_mm` and
    `feed_mm` are those of the finish cut.
    """

    part_type: str
    serial: str
    setting: str
    order: float
    semifinish: ArcErrors
    finish: ArcErrors | None = None
    correction_mm: Array | None = None
    from_memory_mm: Array | None = None
    minutes_in_cut: float | None = None
    depth_of_cut_mm: float | None = None
    feed_mm: float | None = None
    order_in_doubt: bool = False

    @property
    def uncorrected_mm(self) -> Array | None:
        """E = F + C at the places of `finish`, (n,); None without an inspection."""
        if self.finish is None or self.correction_mm is None:
            return None
        return self.finish.error_mm + self.correction_mm
