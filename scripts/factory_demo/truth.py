"""The metal: what the nose really cuts, how the spindle's warmth moves the axes, what does not repeat.

Nothing of it is known to trueloop, and nothing of trueloop's models is in it: worn noses as wear over contact angle, a
thermal error of two numbers, noise, a finish cut that does otherwise, all swept as an envelope by the simulator.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from scripts.factory_demo.parts import ALLOWANCE_MM, NOSE_MM, PartKind
from trueloop.arrays import Array
from trueloop.geometry.offset import nose_centre_path
from trueloop_lab.loops.linuxcnc import paths_near_part, surface_mm
from trueloop_lab.simulator.machine import REFERENCE_C, ErrorTerm, MachineError, Repeatability, Stock, VirtualMachine
from trueloop_lab.simulator.nose import Nose, Transfer, path_along

AT_DEG: Final = (0.0, 18.0, 36.0, 54.0, 72.0, 90.0, 108.0)
CORNERS_UM: Final = {"1": (-2.0, -9.0, -24.0, -31.0, -22.0, -6.0, 2.0), "2": (1.0, 4.0, -3.0, -12.0, -15.0, -9.0, -3.0)}
"""Radius errors of the insert's corners as they are mounted, at AT_DEG of contact angle; negative: worn."""
WEARS_UM: Final = (-0.1, -0.4, -1.0, -1.2, -0.9, -0.3, 0.0)
"""What one part more adds."""
WARMER_C: Final = 7.0
"""How much warmer the spindle gets in the end."""
WARMING_MINUTES: Final = 25.0
"""Its time constant."""
MINUTES_A_CUT: Final = 4.0
"""A cut of the virtual lathe stands for one of a real lathe, without feed override."""
THERMAL: Final = MachineError((ErrorTerm(0, -4e-4, 0, 0, 1), ErrorTerm(1, 9e-4, 0, 0, 1)))
"""The slides move by −0.4 µm/K on the radius and 0.9 µm/K along the spindle."""
OTHERWISE: Final = Transfer(tuple(map(math.radians, (0.0, 45.0, 90.0))), (-0.002, -0.004, -0.0015))
"""What the light finish cut does otherwise than the cut before it."""
NOISE: Final = Repeatability(along_mm=0.0008, correlation_mm=1.0, cut_to_cut_mm=0.0005)
CHIP_MM: Final = 0.040
CHIP_WIDE_MM: Final = 1.2


@dataclass(frozen=True)
class Metal:
    """The lathe with a blank in its chuck: which corner cuts, how many parts it has cut, cuts made since it was cold.

    `cuts` of this blank: the first is the semi-finish cut, the second the finish cut.
    """

    kind: PartKind
    stock: Stock
    corner: str = "1"
    parts_of_corner: int = 0
    cuts: int = 0
    cuts_of_blank: int = 0

    @property
    def spindle_c(self) -> float:
        """How warm it is."""
        return REFERENCE_C + WARMER_C * (1 - math.exp(-self.cuts * MINUTES_A_CUT / WARMING_MINUTES))

    @property
    def nose(self) -> Nose:
        """As it is now."""
        wear = np.add(CORNERS_UM[self.corner], self.parts_of_corner * np.array(WEARS_UM))
        return Nose(NOSE_MM, tuple(np.radians(AT_DEG).tolist()), tuple((1e-3 * wear).tolist()))

    def cut_along(self, driven_mm: Array) -> "Metal":
        """After a cut along the positions of the axes (n, 2) in every servo period."""
        finish = self.cuts_of_blank > 0
        off_mm = NOSE_MM + (0.0 if finish else ALLOWANCE_MM)
        machine = VirtualMachine(self.nose, repeatability=NOISE, error=THERMAL)
        paths = paths_near_part(driven_mm, self.kind.profile, off_mm)
        rng = np.random.default_rng([5, self.cuts])
        more = (OTHERWISE,) if finish else ()
        stock = machine.cut(self.stock, paths, rng, self.spindle_c, *more)
        return replace(self, stock=stock, cuts=self.cuts + 1, cuts_of_blank=self.cuts_of_blank + 1)

    def surface_for_probe_mm(self, *, chip: bool) -> Array:
        """The surface (n, 2) as the control's coordinates have it: the machine errs while it probes as well."""
        allowance_mm = ALLOWANCE_MM if self.cuts_of_blank < 2 else 0.0
        surface = surface_mm(self.kind.profile, NOSE_MM, self.stock, allowance_mm)
        if chip:
            surface = _with_chip(surface, self.kind)
        return np.asarray(surface - THERMAL.error_mm(surface, self.spindle_c))


def blank(kind: PartKind, before: Metal | None = None, corner: str | None = None) -> Metal:
    """A pre-turned blank in the chuck; `corner`: the insert was turned to it."""
    rough = path_along(nose_centre_path(kind.profile, NOSE_MM + 2 * ALLOWANCE_MM).features)
    stock = VirtualMachine(Nose(NOSE_MM)).cut(Stock(), (rough,), np.random.default_rng(0))
    if before is None:
        return Metal(kind, stock, corner or "1")
    parts = 0 if corner else before.parts_of_corner + 1
    return Metal(kind, stock, corner or before.corner, parts, before.cuts)


def _with_chip(surface: Array, kind: PartKind) -> Array:
    """A chip lies where the fourth touch of the dome comes."""
    touches = [one for one in kind.plan.touches if one.feature == kind.profile.features[-1].name]
    touch = touches[min(3, len(touches) - 1)]
    away = np.linalg.norm(surface - touch.contact_mm + kind.plan.stylus.ball_radius_mm * np.array(touch.normal), axis=1)
    on = away < CHIP_WIDE_MM
    return np.asarray(surface + CHIP_MM * on[:, None] * np.array(touch.normal))
