"""Writes a tool path in plain words of LinuxCNC: its interpreter then judges a program of another control."""

import math

from trueloop.arrays import Array
from trueloop.nc.program.tool_path import Motion, ToolPath

DECIMALS = 9


def plain_program(path: ToolPath) -> bytes:
    """Returns G0, G1, G2 and G3 blocks in absolute millimetres, X a radius, a block a move; arcs by their centre."""
    blocks = ["G21 G90 G91.1 G8 G94 F1", *(_block(path, k) for k in range(len(path))), "M2"]
    return "\n".join([*blocks, ""]).encode()


def _block(path: ToolPath, k: int) -> str:
    end = _words("XYZ", path.end_mm[k])
    if path.motion[k] != Motion.ARC:
        return f"{'G0' if path.rapid[k] else 'G1'} {end}"
    plane, sweep_rad = int(path.plane[k]), float(path.sweep_rad[k])
    centre = _words({17: "IJ ", 18: "I K", 19: " JK"}[plane], path.centre_mm[k] - path.start_mm[k])
    turns = math.ceil(abs(sweep_rad) / math.tau - 1e-6)
    return f"G{plane} {'G2' if sweep_rad > 0 else 'G3'} {end} {centre} P{max(turns, 1)}"


def _words(letters: str, values_mm: Array) -> str:
    pairs = zip(letters, values_mm.tolist(), strict=True)
    return " ".join(f"{letter}{value:.{DECIMALS}f}" for letter, value in pairs if letter != " ")
