"""A lens with its rim, programmed as many short lines and as a macro loop; and what was touched of it.

Everything here is worked out from the equation of ISO 10110-12 by `tests.support.curves.Lens`, not by the package.
"""

from typing import Final

import numpy as np

from tests.support.correction import NOW
from tests.support.curves import LENS, Lens
from trueloop.arrays import Array
from trueloop.domain.part import PartType
from trueloop.geometry.feature import Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.loops.turned.correction import Inputs
from trueloop.nc.program.program import Program, read_program
from trueloop.turned.options import Options
from trueloop.turned.touches.error_vectors import ErrorVectors

NOSE_MM: Final = 0.8
RIM_LENGTH_MM: Final = 15.0


def lens_profile(lens: Lens = LENS) -> Profile:
    """A cylinder at the rim, and the lens."""
    curve = lens.curve()
    x, z = curve.start_mm
    return checked_profile([Line("rim", (x, z - RIM_LENGTH_MM), (x, z)), curve])


def nose_ends(count: int, lens: Lens = LENS) -> tuple[Array, Array]:
    """Heights on the lens (count + 1,), falling to 0, and the nose's centre over them, (count + 1, 2).

    The first is where the centre's path crosses that of the rim, x = 20 + R: beyond the rim, as the equation goes on.
    """
    high = lens.rim_mm
    for _ in range(50):  # x of the centre, h + R n_x(h), is rim + R
        off = high + NOSE_MM * float(lens.normal(np.array(high))[0]) - lens.rim_mm - NOSE_MM
        high -= off / (1.0 + 0.02 * NOSE_MM)
    h = np.linspace(high, 0.0, count + 1)
    return h, lens.point_mm(h) + NOSE_MM * lens.normal(h)


def lines_program(count: int = 400, decimals: int = 6) -> str:
    """In LinuxCNC's words, X a diameter: along the rim, over the lens in short lines to the axis, and away."""
    _, centre = nose_ends(count)
    z = float(LENS.point_mm(np.array(LENS.rim_mm))[1]) - RIM_LENGTH_MM
    x = 2 * (LENS.rim_mm + NOSE_MM)
    head = ["G7 G18 G21 G40 G90 G95 F0.1", "T1 M6", "G97 S1000 M3", f"G0 X60 Z{z:.{decimals}f}"]
    head += [f"G1 X{x:.{decimals}f}", f"G1 Z{centre[0, 1]:.{decimals}f}"]
    lens = [f"G1 X{2 * px + 0.0:.{decimals}f} Z{pz + 0.0:.{decimals}f}" for px, pz in centre[1:]]
    return "\n".join([*head, *lens, "G0 Z5", "G0 X80 Z50", "M5", "M2", ""])


def loop_program(count: int = 400) -> str:
    """The same as a loop of LinuxCNC over h, with the equation, its slope and the nose's offset in expressions."""
    h, centre = nose_ends(count)
    z = float(LENS.point_mm(np.array(LENS.rim_mm))[1]) - RIM_LENGTH_MM
    (_, a4), (_, a6) = LENS.powers
    r2 = LENS.radius_mm**2
    return f"""G7 G18 G21 G40 G90 G95 F0.1
T1 M6 (lens)
G97 S1000 M3
G0 X60 Z{z:.6f}
G1 X{2 * (LENS.rim_mm + NOSE_MM):.6f}
G1 Z{centre[0, 1]:.6f}
#1 = 0 (steps)
o100 while [#1 LT {count}]
  #1 = [#1 + 1]
  #2 = [{float(h[0])!r} * [1 - #1 / {count}]] (h)
  #3 = SQRT[1 - {1 + LENS.conic!r} * #2 * #2 / {r2!r}]
  #4 = [#2 * #2 / [{LENS.radius_mm!r} * [1 + #3]] + {a4:.9f} * #2**4 + {a6:.12f} * #2**6] (sag)
  #5 = [#2 / [{LENS.radius_mm!r} * #3] + {4 * a4:.9f} * #2**3 + {6 * a6:.12f} * #2**5] (slope)
  #6 = [{NOSE_MM!r} / SQRT[1 + #5 * #5]]
  G1 X[2 * [#2 + #5 * #6]] Z[#6 - #4]
o100 endwhile
G0 Z5
G0 X80 Z50
M5
M2
"""


def error_mm(s: Array) -> Array:
    """What the cut errs over the lens: tens of micrometres, as a cubic of arc length."""
    u = s / 20.0
    return np.asarray(0.030 - 0.012 * u + 0.020 * u**2 - 0.010 * u**3)


def lens_touches(profile: Profile, noise_mm: Array | None = None, count: int = 24) -> ErrorVectors:
    """Touches on the rim, where the error is what the lens begins with, and along the lens."""
    rim, lens = profile.features
    places = [(0, s) for s in np.linspace(1.0, rim.length_mm - 1.0, 4)]
    places += [(1, s) for s in np.linspace(0.2, lens.length_mm - 0.2, count)]
    index, s = np.array([i for i, _ in places]), np.array([s for _, s in places])
    error = np.where(index == 0, error_mm(np.zeros_like(s)), error_mm(s))
    nominal = np.array([profile.features[i].point_mm(at) for i, at in places])
    normal = np.array([profile.features[i].outward_normal(at) for i, at in places])
    names = tuple(str(k) for k in range(len(places)))
    noise = np.zeros(len(s)) if noise_mm is None else noise_mm
    return ErrorVectors(names, index, s, error + noise, np.full(len(s), 1e-4), np.zeros(len(s), bool), nominal, normal)


def lens_inputs(source: str, dialect: str = "linuxcnc", options: Options | None = None) -> Inputs:
    """The part with its program and touches."""
    profile, program = lens_profile(), read(source, dialect)
    chosen = Options(weight=1.0) if options is None else options
    return Inputs(PartType("lens"), profile, NOSE_MM, program, lens_touches(profile), chosen, NOW)


def read(source: str, dialect: str) -> Program:
    """A program of that dialect."""
    return read_program(source.encode(), dialect)
