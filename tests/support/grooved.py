"""A shaft that an OD tool and both corners of a groove insert cut: its program by hand, and a model of its cut.

Profile, x a radius: big 25 (z −60 to −40), a groove of 6 mm down to 20, mid 25 (to −20), a face, seat 18, a chamfer of
45° to 15 at z = 0. The OD tool passes over the groove; the groove's floor is cut by the left corner as far as z = −37,
by the right one from there on. Paths are those of the nose's centre, worked out beside each line. Shares no code with
trueloop.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from trueloop.arrays import Array

OD, LEFT, RIGHT = 3, 5, 15
NOSE_MM: Final = {OD: 0.8, LEFT: 0.2, RIGHT: 0.2}
WIDTH_MM: Final = 3.0
"""Of the groove insert: the programmed point jumps by it when the other corner's offset is called."""

FEATURES: Final = """
  { name = "big", to = [25, -40] }, { name = "left-wall", to = [20, -40] }, { name = "floor-left", to = [20, -37] },
  { name = "floor-right", to = [20, -34] }, { name = "right-wall", to = [25, -34] }, { name = "mid", to = [25, -20] },
  { name = "step", to = [18, -20] }, { name = "seat", to = [18, -3] }, { name = "chamfer", to = [15, 0] },
"""

Control = Literal["fanuc-lathe", "linuxcnc", "siemens"]
CALLS: Final[Mapping[Control, Mapping[int, str]]] = {
    "fanuc-lathe": {OD: "T0303", LEFT: "T0505", RIGHT: "T0515"},
    "linuxcnc": {OD: "T3 M6 G43 H3", LEFT: "T5 M6 G43 H5", RIGHT: "G43 H15"},
    "siemens": {OD: "T3 D1", LEFT: "T5 D1", RIGHT: "D2"},
}
HEAD: Final[Mapping[Control, str]] = {
    "fanuc-lathe": "%\nO0042 (GROOVED SHAFT)\nG21 G18 G40 G99\nG96 S180 M03",
    "linuxcnc": "G21 G18 G7 G40 G90 G95\nG97 S800 M3",
    "siemens": "G71 G18 DIAMON G40 G90 G95\nG97 S800 M3",
}
END: Final[Mapping[Control, str]] = {"fanuc-lathe": "M30\n%\n", "linuxcnc": "M2\n", "siemens": "M30\n"}


def _to(word: str, x_mm: float, z_mm: float) -> str:
    return f"{word} X{2 * x_mm:.4f} Z{z_mm:.4f}"


def program(control: Control = "fanuc-lathe") -> str:
    """The finish program: nose centres, X a diameter."""
    r, g, call = NOSE_MM[OD], NOSE_MM[LEFT], CALLS[control]
    lines = [
        HEAD[control],
        call[OD],
        _to("G00", 13.0 + r * np.sqrt(2.0), 2.0),  # the chamfer's centre line is x + z = 15 + r √2
        _to("G01", 18.0 + r, -3.0 + r * (np.sqrt(2.0) - 1.0)) + " F0.1",
        _to("G01", 18.0 + r, -20.0 + r),
        _to("G01", 25.0 + r, -20.0 + r),
        _to("G01", 25.0 + r, -60.0),
        "G00 X80. Z20.",
        call[LEFT],
        _to("G00", 27.0, -40.0 + g),
        _to("G01", 20.0 + g, -40.0 + g) + " F0.05",
        _to("G01", 20.0 + g, -37.0),
        "G00 X60. Z-37.",
        call[RIGHT],
        _to("G00", 27.0, -34.0 - g),
        _to("G01", 20.0 + g, -34.0 - g) + " F0.05",
        _to("G01", 20.0 + g, -37.0),
        "G00 X60. Z-37.",
        "G00 X80. Z20.",
        END[control],
    ]
    return "\n".join(lines)


def tools_toml(control: Control = "fanuc-lathe", more: str = "") -> str:
    """The job's tables [[tools]]."""
    right = "number = 5\ntable_edge = 2" if control == "siemens" else f"number = {RIGHT}"
    return (
        f"[[tools]]\nnumber = {OD}\nnose_radius_mm = {NOSE_MM[OD]}\nname = 'turning'\n"
        f"[[tools]]\nnumber = {LEFT}\nnose_radius_mm = {NOSE_MM[LEFT]}\nname = 'grooving'\ngroove_corner = 'left'\n"
        f"[[tools]]\n{right}\nnose_radius_mm = {NOSE_MM[RIGHT]}\nname = 'grooving'\ngroove_corner = 'right'\n" + more
    )


@dataclass(frozen=True)
class Place:
    """Where the part is touched: a point of the nominal profile (x a radius, z), its normal, the edge that cuts it."""

    feature: str
    x_mm: float
    z_mm: float
    normal: tuple[float, float]
    edge: int


UP, RIGHTWARDS, LEFTWARDS, CHAMFER = (1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.5**0.5, 0.5**0.5)
PLACES: Final = (
    *(Place("big", 25.0, z, UP, OD) for z in (-56.0, -50.0, -44.0)),
    *(Place("left-wall", x, -40.0, RIGHTWARDS, LEFT) for x in (24.0, 22.5, 21.0)),
    *(Place("floor-left", 20.0, z, UP, LEFT) for z in (-39.2, -38.4, -37.6)),
    *(Place("floor-right", 20.0, z, UP, RIGHT) for z in (-36.4, -35.6, -34.8)),
    *(Place("right-wall", x, -34.0, LEFTWARDS, RIGHT) for x in (21.0, 22.5, 24.0)),
    *(Place("mid", 25.0, z, UP, OD) for z in (-31.0, -27.0, -23.0)),
    *(Place("step", x, -20.0, RIGHTWARDS, OD) for x in (23.5, 21.5, 19.5)),
    *(Place("seat", 18.0, z, UP, OD) for z in (-17.0, -11.0, -5.0)),
    *(Place("chamfer", 15.0 + t, -t, CHAMFER, OD) for t in (2.4, 1.5, 0.6)),
)

Wear = Callable[[Array], Array]


@dataclass(frozen=True)
class Cutting:
    """How one edge really cuts: it stands off by (dx, dz) mm, x a radius, and its nose is worn by w(n) mm along n."""

    off_mm: tuple[float, float]
    wear: Callable[[tuple[float, float]], float] = lambda _: 0.0


def surface_mm(centres_mm: Array, nose_radius_mm: float, cutting: Cutting, place: Place) -> float:
    """How far the surface stands off the nominal along the normal at a place, where a nose has run along centres.

    A ray from the place along the normal enters the circle about c at t = n·(c − p) − √(R² − q²), q the distance of c
    from the ray; the material ends at the smallest of these. A worn nose leaves w more.
    """
    normal, point = np.array(place.normal), np.array([place.x_mm, place.z_mm])
    apart = centres_mm + np.array(cutting.off_mm) - point
    along = apart @ normal
    across2 = np.sum(apart**2, axis=1) - along**2
    reached = across2 < nose_radius_mm**2
    entered = along[reached] - np.sqrt(nose_radius_mm**2 - across2[reached])
    return float(np.min(entered)) + cutting.wear(place.normal)


def dense(ends_mm: Sequence[tuple[float, float]], step_mm: float = 0.001) -> Array:
    """Points no further apart than the step along a polygon, (n, 2)."""
    pieces = []
    for start, end in zip(np.array(ends_mm)[:-1], np.array(ends_mm)[1:], strict=True):
        count = max(int(np.linalg.norm(end - start) / step_mm) + 1, 2)
        pieces.append(np.linspace(start, end, count))
    return np.concatenate(pieces)


def measured_um(paths: Mapping[int, Array], cuttings: Mapping[int, Cutting]) -> list[float]:
    """Errors at all places, µm, of a part whose edges ran along these centres."""
    return [
        1e3 * surface_mm(paths[p.edge], NOSE_MM[p.edge], cuttings[p.edge], p)
        for p in PLACES
    ]  # fmt: skip


def job(folder: Path, errors_um: Sequence[float], control: Control = "fanuc-lathe", more: str = "") -> Path:
    """A job in a folder, with these touches."""
    ending = {"fanuc-lathe": "nc", "linuxcnc": "ngc", "siemens": "mpf"}[control]
    (folder / f"finish.{ending}").write_text(program(control))
    rows = [
        f"{k},{p.feature},{p.x_mm},{p.z_mm},{e:.6f}" for k, (p, e) in enumerate(zip(PLACES, errors_um, strict=True), 1)
    ]
    (folder / "touches.csv").write_text("\n".join(["point,feature,nominal_x_mm,nominal_z_mm,error_um", *rows, ""]))
    (folder / "job.toml").write_text(
        f'[part]\nname = "grooved"\nstart = [25, -60]\nfeature = [{FEATURES}]\n{tools_toml(control)}'
        f'[programs]\ndialect = "{control}"\nfinish = "finish.{ending}"\n[gauging]\ntouches = "touches.csv"\n{more}'
    )
    return folder / "job.toml"
