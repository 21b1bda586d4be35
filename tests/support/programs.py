"""Centre paths as program text, in either dialect, the way a shop writes them."""

from collections.abc import Sequence

from trueloop.geometry.feature import Arc, Feature
from trueloop.units import MM_PER_INCH


def linuxcnc_text(paths: Sequence[Feature], decimals: int = 6) -> bytes:
    """Metric, X as a radius, absolute; a rapid move to the start before and one away after."""
    first, last = paths[0].start_mm, paths[-1].end_mm
    blocks = ["G21 G18 G8 G90 G94 F100", f"G0 X{first[0]:.{decimals}f} Z{first[1]:.{decimals}f}"]
    for path in paths:
        to = f"X{path.end_mm[0]:.{decimals}f} Z{path.end_mm[1]:.{decimals}f}"
        if isinstance(path, Arc):
            i, k = (path.centre_mm[axis] - path.start_mm[axis] for axis in (0, 1))
            blocks.append(f"{_arc_word(path)} {to} I{i:.{decimals}f} K{k:.{decimals}f}")
        else:
            blocks.append(f"G1 {to}")
    return "\n".join([*blocks, f"G0 X{last[0] + 50:.{decimals}f}", "M2", ""]).encode()


def ge2000t_text(paths: Sequence[Feature], decimals: int = 7) -> bytes:
    """Inch, X as a diameter, signed I and K."""
    first = paths[0].start_mm
    blocks = ["G70", "G95", f"G00 {_ge2000t_point(first, decimals)}", "G01 F0.005"]
    for path in paths:
        to = _ge2000t_point(path.end_mm, decimals)
        if isinstance(path, Arc):
            i, k = ((path.centre_mm[axis] - path.start_mm[axis]) / MM_PER_INCH for axis in (0, 1))
            blocks.append(f"{_arc_word(path, two_digits=True)} {to} I{i:.{decimals}f} K{k:.{decimals}f}")
        else:
            blocks.append(f"G01 {to}")
    numbered = [f"N{10 * (n + 1):04d} {block}" for n, block in enumerate([*blocks, "G00 X30.0", "M30"])]
    return "\n".join([*numbered, ""]).encode()


def _ge2000t_point(point: tuple[float, float], decimals: int) -> str:
    return f"X{2 * point[0] / MM_PER_INCH:.{decimals}f} Z{point[1] / MM_PER_INCH:.{decimals}f}"


def _arc_word(arc: Arc, two_digits: bool = False) -> str:
    clockwise = arc.sweep_rad > 0
    return ("G02" if clockwise else "G03") if two_digits else ("G2" if clockwise else "G3")
