"""Ready machines. The NIST one is fitted to published errors; see the test of it for how well."""

import math
from dataclasses import dataclass, field
from typing import Final

from trueloop.units import UM_PER_MM
from trueloop_lab.simulator.machine import REFERENCE_C, Deflection, Repeatability, VirtualMachine, VirtualProbe
from trueloop_lab.simulator.mill import VirtualCmm
from trueloop_lab.simulator.nose import Nose, Transfer


@dataclass(frozen=True)
class Workshop:
    """Everything a simulated part meets: the machine, its probe, the measuring machine, and how warm it is.

    The temperatures are those of semi-finish cut, probing and finish cut, °C.
    """

    machine: VirtualMachine
    probe: VirtualProbe
    cmm: VirtualCmm = field(default_factory=VirtualCmm)
    temperatures_c: tuple[float, float, float] = (REFERENCE_C, REFERENCE_C, REFERENCE_C)


NOSE_RADIUS_MM: Final = 0.79375
WORN_AT_DEG: Final = (0.0, 18.0, 36.0, 54.0, 72.0, 90.0, 108.0)
WORN_BY_UM: Final = (-3.0, -24.5, -64.0, -77.0, -57.0, -11.0, 9.0)
"""Radius errors of the worn insert, fitted to [6517 Table 1] on condition that the nose stays convex: to 4 µm RMS on
cylinders and dome. The three points nearest the axis (11, 13 and 23 µm off) and the cone (19 µm) do not follow from any
one convex nose."""


TRANSFER_AT_DEG: Final = (7.0, 22.0, 37.0, 52.0, 67.0, 85.0)
TRANSFER_UM: Final = (-3.2, -4.5, -3.4, -4.1, -1.9, -1.3)
NIST_TRANSFER: Final = Transfer(tuple(map(math.radians, TRANSFER_AT_DEG)), tuple(t / UM_PER_MM for t in TRANSFER_UM))
"""The error of the finish cuts of [6811] less that of the semi-finish cuts: they took more. Means over the domes and
knobs of both families within 15 degrees: Tables 9 and 11, the published correction put back, less the curves of Tables
8 and 10 (`scripts/nist_bands.py` has the same errors). Single parts differ from it by 2 to 3 µm."""


TOOL_MM_PER_N: Final = 2e-5


def nist(repeatability: Repeatability | None = None, transfer: Transfer = NIST_TRANSFER) -> Workshop:
    """Models the turning centre of [6811]: worn nose of 0.794 mm, 0.127 mm a revolution, probe ranges 1.5 and 0.5 µm.

    The process repeats to 1.2 µm along the cut: about what is left of Tables 8 and 10 when each part's own offsets are
    taken out. Its finish cut differs by `transfer`. Forces are those of light cuts in aluminium; the
    stiffness of tool and chuck is an assumption (50 and 100 N/µm).
    """
    nose = Nose(NOSE_RADIUS_MM, tuple(map(math.radians, WORN_AT_DEG)), tuple(w / UM_PER_MM for w in WORN_BY_UM))
    return workshop_of(nose, TOOL_MM_PER_N, repeatability, transfer)


def workshop_of(nose: Nose, tool_mm_per_n: float, repeatability: Repeatability | None, transfer: Transfer) -> Workshop:
    """Returns the lathe with a nose and a tool of that compliance, mm/N, its probe and its temperatures."""
    machine = VirtualMachine(
        nose=nose,
        transfer=transfer,
        repeatability=repeatability or Repeatability(along_mm=0.0012, correlation_mm=1.0),
        deflection=Deflection(specific_force_n_per_mm2=400.0, tool_mm_per_n=tool_mm_per_n, chuck_mm_per_n=1e-5),
    )
    probe = VirtualProbe(
        ball_radius_mm=1.5,
        pre_travel_mm=0.004,
        lobing_mm=0.0005,
        range_x_mm=1.5 / UM_PER_MM,
        range_z_mm=0.5 / UM_PER_MM,
    )
    cmm = VirtualCmm(frame_mm=0.0003, tilt_rad=2e-6, mpe_mm=0.0009, mpe_per_mm=0.9e-3 / 350)
    return Workshop(machine, probe, cmm)
