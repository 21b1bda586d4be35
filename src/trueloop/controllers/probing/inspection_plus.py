"""Fanuc and Haas machining centres with Renishaw's Inspection Plus: features of a milled part by its macros.

P9832 switches the probe on, P9833 off; P9810 is a protected move, which stops where the stylus meets something. P9814
measures a bore where the ball stands, a boss with Z from above it at R beside it; P9812 the width of two walls along X
or Y in the same ways; P9811 Z a face. [A public post-processor's documentation, and public programs.] W2. begins a
component in the print-out, W1. counts its features on, so that feature n of it is the n-th measured. [Memory; the
program's comments name the features, to be compared.]
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.milled.feature import ALONG, PAIRS, ROUND, MilledFeature
from trueloop.units import MM_PER_INCH

ROOM_MM: Final = 2.0
"""A bore or slot is wider than the ball by this much at least."""
APART_MM: Final = 1.0
"""Faces nearer than this lie one above the other."""


@dataclass(frozen=True)
class MacroProbe:
    """How a machine measures: the probe's tool number, its ball's diameter, the height at which it goes from feature to
    feature, z of the work offset, and the distance at which a measurement begins beside or above a surface; mm.
    """

    tool: int
    ball_mm: float
    clearance_mm: float
    approach_mm: float = 5.0
    inch: bool = False


@dataclass(frozen=True)
class ProbeProgram:
    """The program's text, the features by their numbers in the print-out, and why others are left out."""

    text: str
    measured: tuple[MilledFeature, ...]
    left_out: tuple[str, ...]


def inspection_plus_program(name: str, features: Sequence[MilledFeature], probe: MacroProbe) -> ProbeProgram:
    """Returns the program that measures the features in order. Raises MIL-PROBE: too low, several offsets, none."""
    offsets = sorted({feature.work_offset for feature in features})
    if len(offsets) > 1:
        raise _refusal(f"features are of {len(offsets)} work offsets, {', '.join(offsets)}", "write a job for each")
    top = max(feature.place_mm[2] for feature in features)
    if probe.clearance_mm < top + probe.approach_mm:
        raise _refusal(
            f"the clearance height is z {probe.clearance_mm:g} mm, the highest feature z {top:g} mm",
            f"at least z {top + probe.approach_mm:g} mm, over everything that stands on the table",
        )
    reasons = [(feature, _why_not(feature, features, probe)) for feature in features]
    measured = tuple(feature for feature, why in reasons if not why)
    left_out = tuple(f"{feature.name}: {why}" for feature, why in reasons if why)
    if not measured:
        raise _refusal("no feature can be measured: " + "; ".join(left_out), "a smaller ball, or another machine")
    words = _Words(probe.inch)
    lines = ["%", "O0100", f"({_plain(name)}: PROBING, FEATURES OF THE PRINT-OUT)"]
    lines += [f"({n} = {_plain(feature.name)})" for n, feature in enumerate(measured, 1)]
    lines += [f"{'G20' if probe.inch else 'G21'} G17 G90 G40 G80 G49", f"T{probe.tool} M6", "M5", "G91 G28 Z0.", "G90"]
    x, y, _ = measured[0].place_mm
    lines += [f"{offsets[0]} G0 {words('X', x)} {words('Y', y)}", f"G43 H{probe.tool} {words('Z', probe.clearance_mm)}"]
    lines.append("G65 P9832")
    for n, feature in enumerate(measured, 1):
        lines += [f"({_plain(feature.name)})", *_measure(feature, probe, words, "W2." if n == 1 else "W1.")]
    lines += ["G65 P9833", "G91 G28 Z0.", "G90", "M30", "%"]
    return ProbeProgram("\n".join(lines) + "\n", measured, left_out)


def _measure(feature: MilledFeature, probe: MacroProbe, words: "_Words", count: str) -> list[str]:
    """Returns the way to a feature at the clearance height, its measurement, and the way back up."""
    x, y, top = feature.place_mm
    low = top - 0.5 * feature.depth_mm
    size = words("D" if feature.kind in ROUND else "X" if abs(feature.direction[0]) >= ALONG else "Y", feature.size_mm)
    macro = f"P{9814 if feature.kind in ROUND else 9812}"
    if feature.kind == "face":
        height, cycle = top + probe.approach_mm, f"G65 P9811 {words('Z', top)} {count}"
    elif feature.inward:
        height, cycle = low, f"G65 {macro} {size} {count}"
    else:
        beside = f"{words('Z', low)} {words('R', probe.approach_mm)}"
        height, cycle = top + probe.approach_mm, f"G65 {macro} {size} {beside} {count}"
    feed = words("F", 1000.0)
    return [
        f"G65 P9810 {words('X', x)} {words('Y', y)} {words('F', 3000.0)}",
        f"G65 P9810 {words('Z', height)} {feed}",
        cycle,
        f"G65 P9810 {words('Z', probe.clearance_mm)} {feed}",
    ]


def _why_not(one: MilledFeature, features: Sequence[MilledFeature], probe: MacroProbe) -> str:
    """Returns why a feature is not measured; empty where it is."""
    if one.kind in PAIRS and max(abs(value) for value in one.direction[:2]) < ALONG:
        return "its walls are not along X or Y"
    if one.kind == "face":
        return _why_no_face(one, features, probe)
    if one.inward and one.size_mm < probe.ball_mm + ROOM_MM:
        return f"a ball of {probe.ball_mm:g} mm has less than {ROOM_MM:g} mm of room in it"
    if one.depth_mm < probe.ball_mm:
        return f"its {one.depth_mm:g} mm of depth are less than the ball's diameter: half way down it would not touch"
    others = [other for other in features if other is not one]
    if one.inward:
        inner = next((other for other in others if other.kind in ("boss", "rib") and _inside(other, one)), None)
        return "" if inner is None else f"{inner.name} stands in its middle"
    near = next((other for other in others if _in_the_way(other, one, probe)), None)
    return "" if near is None else f"{near.name} is within {probe.approach_mm:g} mm and a ball beside it"


def _why_no_face(feature: MilledFeature, features: Sequence[MilledFeature], probe: MacroProbe) -> str:
    if feature.direction[2] < ALONG:
        return "it does not look up"
    faces = [other for other in features if other is not feature and other.kind == "face"]
    over = next((other for other in faces if _apart_mm(feature, other) < APART_MM), None)
    if over is not None:
        return f"its place is that of {over.name}: state `at` where it alone lies"
    hidden = next((other for other in features if _covers(other, feature, probe)), None)
    return "" if hidden is None else f"its place is at {hidden.name}: state `at` beside it"


def _apart_mm(feature: MilledFeature, other: MilledFeature) -> float:
    return float(np.hypot(*np.subtract(feature.place_mm[:2], other.place_mm[:2])))


def _across_mm(feature: MilledFeature, other: MilledFeature) -> float:
    """Returns how far the middle of another feature is from one's, across the walls of one where it has two."""
    if feature.kind in ROUND:
        return _apart_mm(feature, other)
    return abs(float(np.subtract(other.place_mm, feature.place_mm) @ np.array(feature.direction)))


def _covers(other: MilledFeature, face: MilledFeature, probe: MacroProbe) -> bool:
    """Returns whether a place of a face is in a bore, or on or beside the wall of a boss."""
    return other.kind in ROUND and _apart_mm(other, face) <= 0.5 * (other.size_mm + probe.ball_mm) + ROOM_MM


def _inside(other: MilledFeature, around: MilledFeature) -> bool:
    """Returns whether what stands up lies where the ball goes down in a bore or slot."""
    return _apart_mm(other, around) <= 0.5 * (other.size_mm + around.size_mm)


def _in_the_way(other: MilledFeature, feature: MilledFeature, probe: MacroProbe) -> bool:
    """Returns whether the ball, going down beside a boss or rib, would meet another feature."""
    reach = 0.5 * feature.size_mm + probe.approach_mm + probe.ball_mm
    if other.kind in ("boss", "rib"):
        return (
            _across_mm(other, feature) < reach + 0.5 * other.size_mm
            and _across_mm(feature, other) < reach + other.size_mm
        )
    within = other.kind in ("bore", "slot") and _across_mm(other, feature) < 0.5 * other.size_mm
    return (
        within
        and _across_mm(other, feature) + reach > 0.5 * other.size_mm
        and _apart_mm(feature, other) < other.size_mm
    )


class _Words:
    """Words of a length, in the program's unit, with the point that makes it one."""

    def __init__(self, inch: bool) -> None:
        self.scale, self.decimals = (1.0 / MM_PER_INCH, 4) if inch else (1.0, 3)

    def __call__(self, letter: str, value_mm: float) -> str:
        text = f"{self.scale * value_mm + 0.0:.{self.decimals}f}".rstrip("0")
        return f"{letter}{'0.' if text in ('-0.', '0.') else text}"


def _plain(text: str) -> str:
    kept = (letter if letter.isascii() and letter.isprintable() and letter not in "()%" else " " for letter in text)
    return "".join(kept).upper()


def _refusal(why: str, hint: str) -> TrueloopError:
    return Code.MIL_PROBE.refusal(f"no probing program: {why}", hint=hint)
