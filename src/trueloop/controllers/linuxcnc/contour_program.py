"""A contour as a LinuxCNC program: what a loop cuts before there is a program for it."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Feature, Line, LineOrArc, pieces_within

CHORD_MM: Final = 1e-4
"""How far the chords of a curve deviate from it."""


def contour_program(features: Sequence[Feature], feed_mm_per_rev: float, spindle_rpm: float, clear_mm: float) -> bytes:
    """Features of the nose centre's path in order, chuck end first; mm, radii, straight in from `clear_mm` outside."""
    (x, z), (_, z_end) = features[0].start_mm, features[-1].end_mm
    out_mm = max(feature.start_mm[0] for feature in features) + clear_mm
    lines = ["G18 G21 G8 G90 G40 G54", f"G97 S{spindle_rpm:.0f} M3", f"G0 X{out_mm:.6f}", f"G0 Z{z:.6f}"]
    lines += [f"G95 F{feed_mm_per_rev:.6f}", f"G1 X{x:.6f}"]
    at = features[0].start_mm
    for feature in features:
        lines += _moves(feature, at)
        at = feature.end_mm
    return "\n".join([*lines, f"G0 Z{z_end + clear_mm:.6f}", f"G0 X{out_mm:.6f}", "M5", "M2", ""]).encode()


def _moves(feature: Feature, at: tuple[float, float]) -> list[str]:
    if isinstance(feature, Curve):
        s = np.linspace(0.0, feature.length_mm, pieces_within(feature, CHORD_MM) + 1)[1:]
        return [f"G1 X{x:.6f} Z{z:.6f}" for x, z in feature.point_mm(s)]
    return [_move(feature, at)]


def _move(feature: LineOrArc, at: tuple[float, float]) -> str:
    x, z = feature.end_mm
    end = f"X{x:.6f} Z{z:.6f}"
    if isinstance(feature, Line):
        return f"G1 {end}"
    code = "G2" if feature.sweep_rad > 0 else "G3"
    return f"{code} {end} I{feature.centre_mm[0] - at[0]:.6f} K{feature.centre_mm[1] - at[1]:.6f}"
